"""``autobalancer modes``: natural frequencies, critical speeds and the Campbell diagram of a rotor."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, FrequencyUnit, Json, MachineFile, Outs, SpeedUnit, Unit
from autobalancer.cli.terminal.words import speed_text

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.cli.terminal.sheet import Column


class RubberMotion(StrEnum):
    """How softening rubber moves in a mode."""

    LINE = "line"
    CIRCLE = "circle"
    ELLIPSE = "ellipse"


def modes(
    machine: MachineFile,
    speed: Annotated[str, typer.Option(help='Rotor speed, such as "1200 rpm"; by default standstill.')] = "",
    speeds: Annotated[
        str, typer.Option(help='Campbell diagram over these speeds, "from:to:count", such as "0:6000 rpm:121".')
    ] = "",
    balls: Annotated[bool, typer.Option(help="Whether the masses of the balls sit on the rotor.")] = True,
    count: Annotated[int, typer.Option("--modes", help="How many of the lowest modes.")] = 10,
    rubber_amplitude: Annotated[
        str, typer.Option(help='Deflection of softening rubber in each mode, such as "0.3 mm"; by default small.')
    ] = "",
    rubber_motion: Annotated[
        RubberMotion,
        typer.Option(help="Of this rubber: along a line as after a blow, a circle, or each mode's own ellipse."),
    ] = RubberMotion.LINE,
    out: Outs = None,
    plot: Annotated[
        Path | None, typer.Option(help="Picture of the shapes, or of the Campbell diagram: .png, .svg or .pdf.")
    ] = None,
    speed_unit: Unit = SpeedUnit.RPM,
    frequency_unit: FrequencyUnit = SpeedUnit.HZ,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print natural frequencies with damping and direction of whirl, and the critical speeds.

    Critical speeds are those of the rotor without damping. A Campbell diagram has damping; where its natural frequencies
    meet the speed is listed beside them.

    Example: autobalancer modes rigid_rotor.toml \\
      --speeds "0 rpm:6000 rpm:121" --plot campbell.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import optional
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.rotordynamics.campbell import campbell as diagram
    from autobalancer.rotordynamics.modes import modes
    from autobalancer.units.ranges import range_values

    if rubber_amplitude and speeds:
        raise QuestionError(
            "--rubber-amplitude: a Campbell diagram has the stiffness of small motions; leave out --speeds"
        )
    if speed and speeds:
        raise QuestionError("modes: give either --speed or, for a Campbell diagram, --speeds")
    one_form(as_json, as_csv)
    files = Files(out, plot)
    omega = optional("--speed", speed, "rad/s") or 0.0
    span = range_values("--speeds", speeds, "rad/s") if speeds else None
    described = load_race_machine(machine)
    answer: dict[str, Any]
    found: Any
    if span is not None:
        found = diagram(described, span, balls=balls, modes=count)
        answer = {
            "branches": _records(found, "branch", ("name",)),
            "intersections": _records(found, "intersection", _CROSSED),
        }
        answer |= {name: found[name].values for name in ("speed", "frequency", "damping_ratio", "whirl")}
    else:
        amplitude = optional("--rubber-amplitude", rubber_amplitude, "m")
        found = modes(
            described, omega, balls=balls, modes=count, rubber_amplitude=amplitude, motion=_MOTIONS[rubber_motion]
        )
        answer = {"speed": float(omega), "modes": _records(found, "mode", _MODE)}
    critical = _critical(described, balls)
    answer["critical_speeds"] = None if critical is None else _records(critical, "critical", _CRITICAL)[:count]
    files.save(found, lambda: _picture(found, speed_unit, frequency_unit))
    if as_json:
        print_json({"machine": str(machine), **answer})
        return
    if as_csv:
        print_csv(_columns(found, frequency_unit))
        return
    _print(found, described.name, answer, frequency_unit, None if span is None else float(span[-1]))
    files.say()


_MOTIONS: dict[str, Literal["line", "circle", "ellipse"]] = {"line": "line", "circle": "circle", "ellipse": "ellipse"}
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

    if "branch" in found.dims:
        return ab.plot.campbell(found, speed_unit=speed_unit, frequency_unit=frequency_unit)
    return ab.plot.modes(found, frequency_unit=frequency_unit)


def _records(found: xr.Dataset, dim: str, names: tuple[str, ...]) -> list[dict[str, Any]]:
    columns = {name: found[name].values.tolist() for name in names}
    return [{name: columns[name][i] for name in names} for i in range(found.sizes[dim])]


def _columns(found: Any, frequency_unit: str) -> list[Column]:
    """Modes, or of a Campbell diagram the frequency of each branch over the speed."""
    from autobalancer.cli.terminal.words import speed_sign

    if "branch" not in found.dims:
        return list(found.columns(frequency_unit))
    curves = [found.isel(branch=i) for i in range(found.sizes["branch"])]
    frequencies = [curve.scaled("frequency", str(curve["name"].item()), frequency_unit) for curve in curves]
    return [found.scaled("speed", "speed", speed_sign()), *frequencies]


def _print(found: Any, name: str, answer: dict[str, Any], frequency_unit: str, up_to: float | None) -> None:
    from autobalancer.cli.terminal.sheet import print_sheet

    if "modes" in answer:
        title = f"{name}: natural frequencies at {speed_text(answer['speed'])}"
        if answer["modes"]:
            print_sheet(_columns(found, frequency_unit), title)
        else:
            typer.echo(f"{title}: none, nothing oscillates")
    else:
        typer.secho(name, bold=True)
    if found.attrs.get("ignores"):
        typer.echo(f"ignores {found.attrs['ignores']}")
    listed = [entry for entry in answer["critical_speeds"] or () if entry["critical_speed"] <= (up_to or float("inf"))]
    for entry in listed:
        typer.echo(f"critical speed {speed_text(entry['critical_speed'])}: {entry['name']}, whirl {entry['whirl']}")
    if up_to is not None and not listed:
        typer.echo(
            "no critical speed in this range" if answer["critical_speeds"] is not None else "critical speeds unknown"
        )
    for entry in answer.get("intersections", ()):
        branch = answer["branches"][entry["intersection_branch"] - 1]["name"]
        typer.echo(
            f"speed meets damped frequency {speed_text(entry['intersection_speed'])}: {branch}, "
            f"whirl {entry['intersection_whirl']}"
        )
