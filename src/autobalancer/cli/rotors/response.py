"""``autobalancer response``: the synchronous unbalance response of a rotor."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import note, say, speed_number, speed_sign, speed_text

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from autobalancer.cli.terminal.sheet import Column


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
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.quantities import optional, speed_range
    from autobalancer.cli.terminal.sheet import print_sheet
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_race_machine
    from autobalancer.rotordynamics.peaks import response_peaks

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
        from autobalancer.rotordynamics.orbits import whirl_orbits

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
    from autobalancer.cli.terminal.quantities import quantity
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
    from autobalancer.cli.terminal.sheet import Column

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
    from autobalancer.cli.terminal.sheet import Column

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
