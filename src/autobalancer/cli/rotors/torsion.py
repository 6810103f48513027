"""``autobalancer torsional-modes`` and ``torsional-response``: how the drive train twists."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, FrequencyUnit, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note

if TYPE_CHECKING:
    import xarray as xr

COUNT = 401  # speeds in a range that gives no count


def torsional_modes(
    machine: MachineFile,
    speed: Annotated[str, typer.Option(help='Rotor speed, such as "1200 rpm"; by default standstill.')] = "",
    harmonic: Annotated[
        list[float] | None,
        typer.Option(help="Cycles per turn of what excites; by default what the machine has. May be repeated."),
    ] = None,
    out: Outs = None,
    speed_unit: Unit = SpeedUnit.RPM,
    frequency_unit: FrequencyUnit = SpeedUnit.HZ,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print the torsional natural frequencies of a drive train, and the speeds at which something excites them.

    Example: autobalancer torsional-modes coupled_drive.toml
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import optional
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.files.machine_file import load_race_machine

    one_form(as_json, as_csv)
    files = Files(out, None)
    described = load_race_machine(machine)
    found = ab.rotor.torsional_modes(described, optional("--speed", speed, "rad/s") or 0.0)
    critical = ab.rotor.torsional_critical_speeds(described, harmonics=harmonic)
    files.save(found)
    if as_json:
        modes = {
            "modes": _rows(found, "mode"),
            "critical_speeds": _rows(critical, "critical"),
            "damped": _rows(critical, "crossing"),
        }
        print_json({"machine": str(machine), "parts": found["part"].values.tolist(), **modes})
        return
    if as_csv:
        print_csv(found.columns(frequency_unit))
        return
    if found.sizes["mode"]:
        print_sheet(found.columns(frequency_unit), found.heading())
    else:
        typer.echo(f"{found.heading()}: none, nothing oscillates")
    print_sheet(critical.columns(speed_unit), "torsional critical speeds, without damping")
    if critical.sizes["crossing"]:
        print_sheet(critical.damped_columns(speed_unit), "with damping: where the frequency of a mode is met")
    if critical.attrs["ignores"]:
        note(f"ignores {critical.attrs['ignores']}")
    files.say()


def torsional_response(
    machine: MachineFile,
    speeds: Annotated[str, typer.Option(help='"from:to" or "from:to:count", such as "100 rpm:5000 rpm:400".')],
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print the greatest torques and twists in a drive train, by unbalance weight, bad alignment and ripples of the torque.

    Example: autobalancer torsional-response coupled_drive.toml \\
      --speeds "100 rpm:5000 rpm:400" --plot torsion.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import speed_range
    from autobalancer.cli.terminal.sheet import print_sheet

    one_form(as_json, as_csv)
    files = Files(out, plot)
    found = ab.rotor.torsional_response(machine, speed_range("--speeds", speeds, COUNT))
    files.save(found, lambda: ab.plot.torsional_response(found, speed_unit=speed_unit))
    if as_json:
        values = {str(name): found[name].values for name in (*found.coords, *found.data_vars)}
        print_json({"machine": str(machine), **values})
        return
    if as_csv:
        print_csv(found.columns(speed_unit))
        return
    print_sheet(found.columns(speed_unit), str(found.attrs["title"]))
    for text in found.remarks():
        note(text)
    files.say()


def _rows(found: xr.Dataset, dim: str) -> list[dict[str, Any]]:
    names = [str(name) for name in found.data_vars if found[name].dims[0] == dim]
    return [{name: found[name].values[i].tolist() if found[name].ndim > 1 else found[name].values[i] for name in names}
            for i in range(found.sizes[dim])]  # fmt: skip
