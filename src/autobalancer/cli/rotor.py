"""``autobalancer modes``: natural frequencies, critical speeds and the Campbell diagram of a rotor."""

from __future__ import annotations

import math
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, FrequencyUnit, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.sheet import note, say, speed_number, speed_sign, speed_text

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from autobalancer.tables import Column


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
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import optional
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.rotordynamics.campbell import campbell as diagram
    from autobalancer.rotordynamics.campbell import modes
    from autobalancer.units.quantity import range_values

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
    from autobalancer.rotordynamics.campbell import critical_speeds

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
    from autobalancer.cli.terminal.sheet import speed_sign

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


# ``autobalancer response``: the synchronous unbalance response of a rotor.


COUNT = 401  # speeds in a range that gives no count


def response(
    machine: MachineFile,
    speeds: Annotated[
        str, typer.Option(help='"from:to" or "from:to:count", such as "600 rpm:5500 rpm:400", or one speed.')
    ],
    station: Annotated[
        list[str] | None,
        typer.Option(help='Name of a station, or a position such as "-20 mm"; by default all. May be repeated.'),
    ] = None,
    unbalance: Annotated[
        str, typer.Option(help='In the plane of the first balancer, such as "37 g*mm"; by default that of the machine.')
    ] = "",
    balls: Annotated[bool, typer.Option("--balls", help="Put the masses of the balls on the rotor.")] = False,
    quantity: Annotated[str, typer.Option(help="displacement, velocity or acceleration.")] = "displacement",
    out: Outs = None,
    plot: Plot = None,
    kind: Annotated[str, typer.Option(help="Of the picture: bode, polar, or at one speed orbits or axis.")] = "",
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print the peaks of the unbalance response over a range of speeds, or the whirl of every station at one speed.

    Example: autobalancer response two_plane_rotor.toml \\
      --speeds "600 rpm:5500 rpm:400" --plot bode.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import optional, speed_range
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.rotordynamics.response import response_peaks

    one_form(as_json, as_csv)
    files = Files(out, plot)
    chosen = speed_range("--speeds", speeds, COUNT)
    many = chosen.size > 1
    allowed = ("bode", "polar") if many else ("orbits", "axis")
    picture = kind or allowed[0]
    if picture not in allowed:
        what = "a range of speeds" if many else "one speed"
        raise QuestionError(f"--kind: given {kind!r}; for {what} it must be {' or '.join(allowed)}")
    described = load_race_machine(machine)
    places = [_place(described, text) for text in station] if station else None
    size = optional("--unbalance", unbalance, "kg*m")
    how: Any = {"balls": balls, "quantity": quantity}
    found = ab.rotor.response(described, chosen, places, size, **how)

    def draw() -> Figure:
        from autobalancer.rotordynamics.response import whirl_orbits

        if many:
            smooth = ab.rotor.response(described, chosen, places, size, smooth=True, **how)
            return _over_speed(smooth, picture, speed_unit)
        return _at_speed(whirl_orbits(described, float(chosen[0]), places, size, balls=balls), picture, speed_unit)

    files.save(found, draw)
    if as_json:
        values = {str(name): found[name].values for name in (*found.coords, *found.data_vars)}
        print_json({"machine": str(machine), "quantity": quantity, **values})
        return
    if as_csv:
        print_csv(_over(found) if many else _whirl(found))
        return
    typer.secho(described.name, bold=True)
    if many:
        ends = float(chosen[0]), float(chosen[-1])
        peaks = response_peaks(described, *ends, places, size, **how)
        _print_peaks(found, peaks)
    else:
        print_sheet(_whirl(found), f"at {speed_text(float(chosen[0]))}")
    for text in found.remarks():
        note(text)
    files.say()


def _place(machine: object, text: str) -> str | float:
    """The name of a station, or a position where no station has this name."""
    from autobalancer.cli.terminal.options import quantity
    from autobalancer.machine import Machine

    assert isinstance(machine, Machine)
    known = any(station.name == text for station in machine.stations)
    return text if known or text.strip()[:1] not in set("+-.0123456789") else float(quantity("--station", text, "m"))


def _over_speed(found: xr.Dataset, kind: str, speed_unit: str) -> Figure:

    return (ab.plot.response if kind == "bode" else ab.plot.polar_response)(found, speed_unit=speed_unit)


def _at_speed(orbits: xr.Dataset, kind: str, speed_unit: str) -> Figure:

    return (ab.plot.whirl_orbits if kind == "orbits" else ab.plot.whirl_along_axis)(orbits, speed_unit=speed_unit)


def _print_peaks(found: xr.Dataset, peaks: xr.Dataset) -> None:
    stations, what = ", ".join(map(str, found["station"].values)), f"greatest {found.attrs['quantity']}"
    say(f"mean over {stations} of the {what}:" if found.sizes["station"] > 1 else f"{what} at {stations}:", indent="  ")
    for w, a in zip(peaks["peak_speed"].values, peaks["peak_amplitude"].values, strict=True):
        typer.echo(f"  peak at {speed_text(w)}: {_amount(a, found)}")
    if not peaks.sizes["peak"]:
        typer.echo("  no peak in this range")
    last = found.isel(speed=-1)
    typer.echo(f"  at {speed_text(last['speed'].item())}: {_amount(last['mean_of_greatest'].item(), found)}")


def _over(found: xr.Dataset) -> list[Column]:
    from autobalancer.tables import Column

    unit = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}[found.attrs["quantity"]]
    across = [float(speed_number(w, ".10g")) for w in found["speed"].values]
    columns = [Column("speed", across, speed_sign())]
    for name, head in (("semi_major", "greatest"), ("phase", "phase")):
        for station in found["station"].values:
            numbers = found[name].sel(station=station).values
            degrees = name == "phase"
            columns.append(
                Column(f"{head} {station}", numbers * (180.0 / math.pi if degrees else 1.0), "deg" if degrees else unit)
            )
    return columns


def _whirl(found: xr.Dataset) -> list[Column]:
    from autobalancer.tables import Column

    at = found.isel(speed=0)
    return [
        Column("station", [str(name) for name in at["station"].values]),
        Column("whirl", at["whirl"].values.tolist()),
        Column("semi-major", [_amount(a, found) for a in at["semi_major"].values]),
        Column("semi-minor", [_amount(a, found) for a in at["semi_minor"].values]),
        Column("direction of major", [math.degrees(a) for a in at["inclination"].values], "deg", ".3g"),
        Column("phase", [math.degrees(a) for a in at["phase"].values], "deg", ".4g"),
    ]


def _amount(value: float, found: xr.Dataset) -> str:
    from autobalancer.results.display_units import length_text

    rate = {"displacement": "", "velocity": "/s", "acceleration": "/s^2"}[found.attrs["quantity"]]
    return f"{length_text(float(value))}{rate}"


# ``autobalancer torsional-modes`` and ``torsional-response``: how the drive train twists.


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
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import optional
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
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import speed_range
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


# ``autobalancer liquid-response``: the unbalance response of a rotor with rings partly filled with liquid.


def liquid_response(
    machine: MachineFile,
    speeds: Annotated[str, typer.Option(help='"from:to" or "from:to:count", such as "100 rpm:1000 rpm:400".')],
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Print how far a rotor whose balancers are rings of liquid deflects in a steady whirl, with the liquid and without.

    Example: autobalancer liquid-response liquid_ring.toml \\
      --speeds "100 rpm:1000 rpm:400" --plot liquid.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import speed_range
    from autobalancer.cli.terminal.sheet import print_facts, print_sheet

    one_form(as_json, as_csv)
    files = Files(out, plot)
    found = ab.rotor.liquid_response(machine, speed_range("--speeds", speeds, COUNT))
    files.save(found, lambda: ab.plot.liquid_response(found, speed_unit=speed_unit))
    if as_json:
        values = {str(name): found[name].values for name in (*found.coords, *found.data_vars)}
        numbers = {key: value for key, value in found.attrs.items() if isinstance(value, float)}
        print_json({"machine": str(machine), **numbers, **values})
        return
    if as_csv:
        print_csv(found.columns(speed_unit))
        return
    print_facts(found.rows(speed_text), str(found.attrs["title"]))
    print_sheet(found.columns(speed_unit))
    for remark in found.remarks():
        note(remark)
    files.say()


# ``autobalancer equivalent-planar``: the planar oscillator that replaces a rotor at the plane of its balls.


def equivalent(
    machine: MachineFile,
    station: Annotated[
        str | None, typer.Option(help="Station or position; by default that of the first balancer.")
    ] = None,
    method: Annotated[str, typer.Option(help="modal, or static: stiffness at the race.")] = "modal",
    frequency: Annotated[
        str, typer.Option(help="critical (turning with the rotor) or natural (at rest).")
    ] = "critical",
    out: Annotated[
        list[Path] | None,
        typer.Option(help="The planar machine as .toml, the numbers as .nc, .csv or .json. May be repeated."),
    ] = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Find the planar oscillator that stands for a rotor at the plane of its balls, and say how far it holds.

    Example: autobalancer equivalent-planar rigid_rotor.toml \\
      --out planar.toml
    """
    from autobalancer.cli.terminal.command import MACHINE, RESULT, Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import quantity
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.rotordynamics.equivalent_planar import equivalent_planar

    one_form(as_json, as_csv)
    files = Files(out, plot, (*MACHINE, *RESULT))
    described = load_race_machine(machine)
    names = {entry.name for entry in described.stations}
    place = station if station is None or station in names else float(quantity("--station", station, "m"))
    found = equivalent_planar(described, place, method=method, frequency=frequency)  # type: ignore[arg-type]
    data = found.data
    files.save(data, lambda: ab.plot.equivalent_planar(data), machine=found.machine)
    rows = []
    for way in data["way"].values:
        for direction in data["direction"].values:
            one = data.sel(way=way, direction=direction)
            rows.append({"way": str(way), "direction": str(direction)} | {key: float(one[key]) for key in _KEYS})
    if as_json:
        print_json({"oscillators": rows, "description": found.machine.description})
        return
    if as_csv:
        print_csv(data.columns(speed_sign()))
        return
    print_sheet(data.columns(speed_sign()), f"{described.name}: the planar oscillator in its place")
    for row in rows:
        held = _holds(row)
        if row["way"] == method and not held:
            note(
                f"the {method} oscillator along {row['direction']} does not hold anywhere near its critical speed; "
                f"look at --plot, and at --method {'static' if method == 'modal' else 'modal'}"
            )
        if row["way"] == method and held:
            say(f"{method} along {row['direction']}, the one taken, holds {held}")
    if data.attrs["ignores"]:
        note(f"ignores {data.attrs['ignores']}")
    say(found.machine.description)
    files.say()


_KEYS = ("stiffness", "mass", "damping", "critical_speed", "damping_ratio", "valid_from", "valid_to")


def _holds(row: dict[str, Any]) -> str:
    if math.isnan(row["valid_from"]) or math.isnan(row["valid_to"]):
        return ""
    return f"from {speed_text(row['valid_from'])} to {speed_text(row['valid_to'])}"
