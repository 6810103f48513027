"""``autobalancer angle``: the equilibrium angle of one ball, and what measured angles say of drag and friction."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    import xarray as xr


def angle(
    machine: Annotated[Path, typer.Argument(help="Machine file with one ball on a horizontal axis.")],
    speeds: Annotated[
        str, typer.Option(help='"from:to:count" or one speed, such as "2 rpm:60 rpm:30"; by default up to 85 deg.')
    ] = "",
    simulate: Annotated[bool, typer.Option("--simulate", help="Simulate a slow run-up as well.")] = False,
    duration: Annotated[str, typer.Option(help="Of the run-up.")] = "300 s",
    measured: Annotated[
        Path | None, typer.Option(help="Evaluate this table: fluid, density [kg/m^3], ..., speed [rpm], angle [deg].")
    ] = None,
    rolling: Annotated[
        float | None, typer.Option(help="With --measured: rolling resistance; by default fitted to overlapping series.")
    ] = None,
    resamples: Annotated[int, typer.Option(help="With --measured: repeated fits for the uncertainty.")] = 100,
    pressure: Annotated[
        bool, typer.Option("--pressure", help="Draw with the pressure force of the turning fluid.")
    ] = False,
    out: Annotated[Path | None, typer.Option("--out", "--output", help="Result file (netCDF).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz.")] = "rpm",
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers in SI for a program.")] = False,
) -> None:
    """At which angle a single ball stands in a slowly turned race; drag coefficients and friction from measured angles.

    Example: autobalancer angle examples/machines/equilibrium_angle.toml
    --measured examples/measurements/equilibrium_angles.csv --plot drag.png
    """
    from autobalancer.plots.axis_units import speed_axis
    from autobalancer.plots.save import save_picture
    from autobalancer.results.store import save_run

    speed_axis(speed_unit)
    if measured is None:
        from autobalancer.plots.equilibrium_angle import plot_equilibrium_angles

        found = _curve(machine, speeds, simulate, duration)
        figure = plot_equilibrium_angles(found, speed_unit=speed_unit) if plot is not None else None
    else:
        from autobalancer.plots.equilibrium_angle import plot_measured_drag

        found = _evaluated(machine, measured, rolling, resamples, bool(speeds or simulate))
        way = "included" if pressure else "left out"
        figure = plot_measured_drag(found, pressure_force=way, speed_unit=speed_unit) if plot is not None else None
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None and figure is not None:
        save_picture(figure, plot)
    if as_json:
        typer.echo(json.dumps({"machine": str(machine), **_numbers(found)}, indent=2))
        return
    if measured is None:
        _show_curve(found, speed_unit)
    else:
        _show_evaluated(found)
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _curve(machine: Path, speeds: str, simulate: bool, duration: str) -> xr.Dataset:
    from rich.console import Console

    from autobalancer.cli.ranges import speed_range
    from autobalancer.cli.run import _say_if_first
    from autobalancer.measurement.angle_curve import angle_against_speed
    from autobalancer.units import option_to_si

    chosen = speed_range(speeds) if speeds else None
    if simulate:
        _say_if_first(Console(stderr=True))
    return angle_against_speed(machine, chosen, simulation=simulate, duration=option_to_si(duration, "s"))


def _evaluated(machine: Path, table: Path, rolling: float | None, resamples: int, curve: bool) -> xr.Dataset:
    from autobalancer.errors import QuestionError
    from autobalancer.measurement.angle_evaluation import evaluate_angles
    from autobalancer.measurement.angle_file import load_angle_series

    if curve:
        raise QuestionError("--measured: evaluates the speeds of the table; leave out --speeds and --simulate")
    return evaluate_angles(machine, load_angle_series(table), rolling=rolling, resamples=resamples)


def _numbers(found: xr.Dataset) -> dict[str, Any]:
    from autobalancer.cli.stepped import _plain

    keys = [key for key in found.attrs if key not in ("title", "source", "created")]
    return {key: found.attrs[key] for key in keys} | {
        str(name): _plain(found[name].values.tolist()) for name in found.variables
    }


def _show_curve(found: xr.Dataset, speed_unit: str) -> None:
    from autobalancer.plots.axis_units import speed_axis

    unit = speed_axis(speed_unit)
    names = {"angle": "statics", "angle_with_pressure": "with pressure", "simulated_angle": "simulated"}
    names = {key: text for key, text in names.items() if key in found}
    heads = [f"speed ({unit.sign})", "Re", *(f"{text} (deg)" for text in names.values())]
    rows = []
    count = found.sizes["speed"]
    for i in sorted({round(k * (count - 1) / 19) for k in range(20)}):
        one = found.isel(speed=i)
        cells = [_cell(math.degrees(float(one[key])), ".2f") for key in names]
        rows.append([f"{unit.factor * float(one['speed']):.4g}", f"{float(one['reynolds']):.4g}", *cells])
    _print(heads, rows)
    typer.echo(f"drag law {found.attrs['drag_law']}, rolling resistance {found.attrs['rolling_resistance']:g}")


def _show_evaluated(found: xr.Dataset) -> None:
    left, included = (found.sel(pressure_force=way) for way in ("left out", "included"))
    heads = ["series", "points", "Re", "c_d over law", "with pressure"]
    rows = []
    for name in dict.fromkeys(found["series"].values.tolist()):
        here = (found["series"] == name).values
        re = found["reynolds"].values[here]
        ratios = [(one["drag_coefficient"] / one["law_coefficient"]).values[here] for one in (left, included)]
        spread = [f"{ratio.min():.3f} to {ratio.max():.3f}" for ratio in ratios]
        rows.append([str(name), str(here.sum()), f"{re.min():.3g} to {re.max():.3g}", *spread])
    _print(heads, rows)
    for one, text in ((left, "pressure force left out, (6.6)"), (included, "pressure force included")):
        deviation = float(one["rolling_resistance_deviation"])
        sure = f", standard deviation {deviation:.2g}" if math.isfinite(deviation) else ""
        typer.echo(f"rolling resistance {float(one['rolling_resistance']):.4g}{sure}: {text}")
    said = {
        "fitted": "fitted to series that overlap",
        "given": "as given",
        "machine": "of the machine, since no series overlap",
    }
    typer.echo(f"the coefficient is {said[found.attrs['rolling_resistance_from']]}")


def _cell(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else "-"


def _print(heads: list[str], rows: list[list[str]]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table()
    for head in heads:
        table.add_column(head, justify="left" if head == "series" else "right")
    for row in rows:
        table.add_row(*row)
    Console().print(table)
