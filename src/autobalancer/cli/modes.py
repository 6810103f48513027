"""``autobalancer modes``: natural frequencies, critical speeds and the Campbell diagram of a rotor."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from autobalancer.cli.check import _finite

if TYPE_CHECKING:
    import xarray as xr


def modes(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    speed: Annotated[str, typer.Option(help='Rotor speed, such as "1200 rpm"; by default standstill.')] = "",
    campbell: Annotated[
        str, typer.Option(help='Speeds of a Campbell diagram, "from:to:count", such as "0 rpm:6000 rpm:121".')
    ] = "",
    balls: Annotated[bool, typer.Option(help="Whether the masses of the balls sit on the rotor.")] = True,
    count: Annotated[int, typer.Option("--modes", help="How many of the lowest modes.")] = 10,
    out: Annotated[Path | None, typer.Option("--out", "--output", help="Result file (netCDF).")] = None,
    plot: Annotated[
        Path | None, typer.Option(help="Picture of the shapes, or of the Campbell diagram: png, svg or pdf.")
    ] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz.")] = "rpm",
    frequency_unit: Annotated[str, typer.Option(help="Hz, rad/s or rpm.")] = "Hz",
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers in SI for a program.")] = False,
) -> None:
    """Print natural frequencies with damping and direction of whirl, and the critical speeds.

    Example: autobalancer modes rig.toml --campbell "0 rpm:6000 rpm:121" --plot campbell.png
    """
    from autobalancer import save_run
    from autobalancer.cli.ranges import axis_range
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_machine
    from autobalancer.plots.axis_units import speed_axis
    from autobalancer.plots.save import save_picture
    from autobalancer.rotordynamics.campbell import campbell as diagram
    from autobalancer.rotordynamics.modes import eigenfrequencies
    from autobalancer.units import option_to_si

    if speed and campbell:
        raise QuestionError("modes: give either --speed or --campbell, not both")
    speed_axis(speed_unit)
    speed_axis(frequency_unit)
    described = load_machine(machine)
    if campbell:
        found = diagram(described, axis_range("--campbell", "speed", campbell), balls=balls, modes=count)
        answer: dict[str, Any] = {
            "branches": _records(found, "branch", ("name",)),
            "intersections": _records(found, "intersection", _CROSSED),
        }
        answer |= {name: found[name].values.tolist() for name in ("speed", "frequency", "damping_ratio", "whirl")}
    else:
        omega = option_to_si(speed, "rad/s") if speed else 0.0
        found = eigenfrequencies(described, omega, balls=balls, modes=count)
        answer = {"speed": float(omega), "modes": _records(found, "mode", _MODE), "critical_speeds": None}
        critical = _critical(described, balls)
        if critical is not None:
            answer["critical_speeds"] = _records(critical, "critical", _CRITICAL)[:count]
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None:
        save_picture(_picture(found, speed_unit, frequency_unit), plot)
    if as_json:
        typer.echo(json.dumps(_finite({"machine": str(machine), **answer})))
        return
    _print(described.name, answer, speed_unit, frequency_unit)
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


_MODE = ("name", "frequency", "undamped_frequency", "damping_ratio", "decay_rate", "whirl")
_CRITICAL = ("critical_speed", "harmonic", "whirl", "name")
_CROSSED = ("intersection_speed", "intersection_branch", "intersection_whirl")


def _critical(machine: Any, balls: bool) -> xr.Dataset | None:
    """Without damping; ``None`` where cross-coupled stiffness leaves none without a range of speeds."""
    from autobalancer.errors import QuestionError
    from autobalancer.rotordynamics.critical import critical_speeds

    try:
        return critical_speeds(machine, balls=balls)
    except QuestionError:
        return None


def _picture(found: xr.Dataset, speed_unit: str, frequency_unit: str) -> Any:
    from autobalancer.plots.campbell import plot_campbell
    from autobalancer.plots.modes import plot_modes

    if "branch" in found.dims:
        return plot_campbell(found, speed_unit=speed_unit, frequency_unit=frequency_unit)
    return plot_modes(found, frequency_unit=frequency_unit)


def _records(found: xr.Dataset, dim: str, names: tuple[str, ...]) -> list[dict[str, Any]]:
    columns = {name: found[name].values.tolist() for name in names}
    return [{name: columns[name][i] for name in names} for i in range(found.sizes[dim])]


def _print(name: str, answer: dict[str, Any], speed_unit: str, frequency_unit: str) -> None:
    from autobalancer.plots.axis_units import speed_axis

    across, up = speed_axis(speed_unit), speed_axis(frequency_unit)
    typer.secho(name, bold=True)
    if "branches" in answer:
        for entry in answer["intersections"]:
            number = entry["intersection_branch"] - 1
            typer.echo(
                f"critical speed {entry['intersection_speed'] * across.factor:.5g} {across.sign}: "
                f"{answer['branches'][number]['name']}, whirl {entry['intersection_whirl']}"
            )
        if not answer["intersections"]:
            typer.echo("no critical speed in this range")
        return
    typer.echo(f"natural frequencies at {answer['speed'] * across.factor:.5g} {across.sign}:")
    width = max((len(entry["name"]) for entry in answer["modes"]), default=0)
    for entry in answer["modes"]:
        typer.echo(
            f"  {entry['name']:<{width}}   {entry['frequency'] * up.factor:9.5g} {up.sign}   "
            f"damping ratio {100.0 * entry['damping_ratio']:.3g} %   whirl {entry['whirl']}"
        )
    if not answer["modes"]:
        typer.echo("  none: nothing oscillates")
    for entry in answer["critical_speeds"] or ():
        typer.echo(
            f"critical speed {entry['critical_speed'] * across.factor:.5g} {across.sign}: "
            f"{entry['name']}, whirl {entry['whirl']}"
        )
