"""``autobalancer response``: the synchronous unbalance response of a rotor."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from autobalancer.cli.check import _finite

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def response(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    speed: Annotated[
        str,
        typer.Option("--speed", "--speeds", help='"from:to:count", such as "600 rpm:5500 rpm:400", or one speed.'),
    ],
    station: Annotated[
        list[str] | None,
        typer.Option(
            help='Name of a station, or a position such as "-20 mm"; several times for several. By default all.'
        ),
    ] = None,
    unbalance: Annotated[
        str, typer.Option(help='In the plane of the first balancer, such as "37 g*mm"; by default that of the machine.')
    ] = "",
    balls: Annotated[bool, typer.Option("--balls", help="Put the masses of the balls on the rotor.")] = False,
    quantity: Annotated[str, typer.Option(help="displacement, velocity or acceleration.")] = "displacement",
    out: Annotated[Path | None, typer.Option("--out", "--output", help="Result file (netCDF).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")] = None,
    kind: Annotated[str, typer.Option(help="Of the picture: bode, polar, or at one speed orbits or axis.")] = "",
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz.")] = "rpm",
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers in SI for a program.")] = False,
) -> None:
    """Print the peaks of the unbalance response over a range of speeds, or the whirl of every station at one speed.

    Example: autobalancer response rig.toml --speed "600 rpm:5500 rpm:400" --station B1
    --station B2 --plot bode.png
    """
    from autobalancer import save_run
    from autobalancer.cli.ranges import speed_range
    from autobalancer.errors import QuestionError
    from autobalancer.files.machine_file import load_machine
    from autobalancer.plots.axis_units import speed_axis
    from autobalancer.plots.save import save_picture
    from autobalancer.rotordynamics.peaks import response_peaks
    from autobalancer.rotordynamics.response import unbalance_response
    from autobalancer.units import option_to_si

    speeds = speed_range(speed)
    allowed = ("bode", "polar") if speeds.size > 1 else ("orbits", "axis")
    chosen = kind or allowed[0]
    if chosen not in allowed:
        many = "a range of speeds" if speeds.size > 1 else "one speed"
        raise QuestionError(f"--kind: given {kind!r}; for {many} it must be {' or '.join(allowed)}")
    speed_axis(speed_unit)
    described = load_machine(machine)
    places = [_place(described, text) for text in station] if station else None
    size = option_to_si(unbalance, "kg*m") if unbalance else None
    found = unbalance_response(described, speeds, places, size, balls=balls, quantity=quantity)  # type: ignore[arg-type]
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None:
        if speeds.size > 1:
            figure = _over_speed(found, chosen, speed_unit)
        else:
            from autobalancer.rotordynamics.orbits import whirl_orbits

            orbits = whirl_orbits(described, float(speeds[0]), places, size, balls=balls)
            figure = _at_speed(orbits, chosen, speed_unit)
        save_picture(figure, plot)
    if as_json:
        names = (*found.coords, *found.data_vars)
        values = {str(name): found[name].values.tolist() for name in names}
        typer.echo(json.dumps(_finite({"machine": str(machine), "quantity": quantity, **values})))
        return
    typer.secho(described.name, bold=True)
    if speeds.size > 1:
        low, high = float(speeds[0]), float(speeds[-1])
        peaks = response_peaks(described, low, high, places, size, balls=balls, quantity=quantity)  # type: ignore[arg-type]
    for line in _peaks(found, peaks, speed_unit) if speeds.size > 1 else _whirl(found):
        typer.echo(line)
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _place(machine: object, text: str) -> str | float:
    """The name of a station, or a position where no station has this name."""
    from autobalancer.machine import Machine
    from autobalancer.units import to_si

    assert isinstance(machine, Machine)
    known = any(station.name == text for station in machine.stations)
    return text if known or text.strip()[:1] not in set("+-.0123456789") else float(to_si(text, "m"))


def _over_speed(found: xr.Dataset, kind: str, speed_unit: str) -> Figure:
    from autobalancer.plots.unbalance_response import plot_polar_response, plot_unbalance_response

    return (plot_unbalance_response if kind == "bode" else plot_polar_response)(found, speed_unit=speed_unit)


def _at_speed(orbits: xr.Dataset, kind: str, speed_unit: str) -> Figure:
    from autobalancer.plots.whirl import plot_whirl_along_axis, plot_whirl_orbits

    return (plot_whirl_orbits if kind == "orbits" else plot_whirl_along_axis)(orbits, speed_unit=speed_unit)


def _peaks(found: xr.Dataset, peaks: xr.Dataset, speed_unit: str) -> list[str]:
    from autobalancer.plots.axis_units import speed_axis

    unit = speed_axis(speed_unit)
    stations = ", ".join(str(name) for name in found["station"].values)
    lines = [f"mean over {stations} of the greatest {found.attrs['quantity']}:"]
    lines += [
        f"  peak at {w * unit.factor:.5g} {unit.sign}: {_amount(a, found)}"
        for w, a in zip(peaks["peak_speed"].values, peaks["peak_amplitude"].values, strict=True)
    ]
    if not peaks.sizes["peak"]:
        lines.append("  no peak in this range")
    last = found.isel(speed=-1)
    level = _amount(last["mean_of_greatest"].item(), found)
    lines.append(f"  at {last['speed'].item() * unit.factor:.5g} {unit.sign}: {level}")
    return lines


def _whirl(found: xr.Dataset) -> list[str]:
    import math

    at = found.isel(speed=0)
    width = max(len(str(name)) for name in at["station"].values)
    return [
        f"{at['station'].values[i]:<{width}}   {at['whirl'].values[i]}, semi-axes "
        f"{_amount(at['semi_major'].values[i], found)} and {_amount(at['semi_minor'].values[i], found)}, "
        f"major one at {math.degrees(at['inclination'].values[i]):.3g}°, "
        f"phase {math.degrees(at['phase'].values[i]):.4g}°"
        for i in range(at.sizes["station"])
    ]


def _amount(value: float, found: xr.Dataset) -> str:
    from autobalancer.plots.axis_units import length_text

    rate = {"displacement": "", "velocity": "/s", "acceleration": "/s^2"}[found.attrs["quantity"]]
    return f"{length_text(float(value))}{rate}"
