"""``autobalancer equilibrium-angle``: the equilibrium angle of one ball, and what measured angles say of drag and friction."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.words import say, speed_number, speed_sign

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.cli.terminal.sheet import Column

LINES = 20  # of a curve, on the screen


def angle(
    machine: MachineFile,
    speeds: Annotated[
        str, typer.Option(help='"from:to:count" or one speed, such as "2 rpm:60 rpm:30"; by default up to 85 deg.')
    ] = "",
    simulate: Annotated[bool, typer.Option("--simulate", help="Simulate a slow run-up as well.")] = False,
    duration: Annotated[str, typer.Option(help="Of the run-up.")] = "300 s",
    measured: Annotated[
        Path | None,
        typer.Option(help="Evaluate this table: fluid, density \\[kg/m^3], ..., speed \\[rpm], angle \\[deg]."),
    ] = None,
    rolling: Annotated[
        float | None, typer.Option(help="With --measured: rolling resistance; by default fitted to overlapping series.")
    ] = None,
    resamples: Annotated[int, typer.Option(help="With --measured: repeated fits for the uncertainty.")] = 100,
    pressure: Annotated[
        bool, typer.Option("--pressure", help="Draw with the pressure force of the turning fluid.")
    ] = False,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """At which angle a single ball stands in a slowly turned race; drag coefficients and friction from measured angles.

    The machine has one ball on a horizontal axis.

    Example: autobalancer equilibrium-angle equilibrium_angle.toml \\
      --measured equilibrium_angles.csv --plot drag.png
    """
    from autobalancer.cli.terminal.output import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.sheet import print_sheet

    one_form(as_json, as_csv)
    files = Files(out, plot)
    if measured is None:
        found = _curve(machine, speeds, simulate, duration)
        files.save(found, lambda: ab.plot.equilibrium_angle(found, speed_unit=speed_unit))
    else:
        found = _evaluated(machine, measured, rolling, resamples, bool(speeds or simulate))
        way = "included" if pressure else "left out"
        files.save(found, lambda: ab.plot.measured_drag(found, pressure_force=way, speed_unit=speed_unit))
    if as_json:
        print_json({"machine": str(machine), **_numbers(found)})
        return
    if as_csv:
        print_csv(_curve_columns(found) if measured is None else _series_columns(found))
        return
    if measured is None:
        count = found.sizes["speed"]
        shown = sorted({round(k * (count - 1) / (LINES - 1)) for k in range(LINES)})
        print_sheet(_curve_columns(found.isel(speed=shown)))
        if len(shown) < count:
            typer.echo(f"{len(shown)} of {count} speeds; --csv and --out have all of them")
        typer.echo(f"drag law {found.attrs['drag_law']}, rolling resistance {found.attrs['rolling_resistance']:g}")
    else:
        print_sheet(_series_columns(found))
        _say_rolling(found)
    files.say()


def _curve(machine: Path, speeds: str, simulate: bool, duration: str) -> xr.Dataset:
    from autobalancer.cli.terminal.quantities import quantity, speed_range
    from autobalancer.measurement.angle.curve import equilibrium_angle

    chosen = speed_range("--speeds", speeds) if speeds else None
    length = quantity("--duration", duration, "s")
    return equilibrium_angle(machine, chosen, simulation=simulate, duration=length)


def _evaluated(machine: Path, table: Path, rolling: float | None, resamples: int, curve: bool) -> xr.Dataset:
    from autobalancer.errors import QuestionError
    from autobalancer.measurement.angle.evaluation import evaluate_angles
    from autobalancer.measurement.angle.file import load_angle_series

    if curve:
        raise QuestionError("--measured: evaluates the speeds of the table; leave out --speeds and --simulate")
    return evaluate_angles(machine, load_angle_series(table), rolling=rolling, resamples=resamples)


def _numbers(found: xr.Dataset) -> dict[str, Any]:
    keys = [key for key in found.attrs if key not in ("title", "source", "created")]
    return {key: found.attrs[key] for key in keys} | {str(name): found[name].values for name in found.variables}


def _curve_columns(found: xr.Dataset) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

    names = {"angle": "statics", "angle_with_pressure": "with pressure", "simulated_angle": "simulated"}
    return [
        Column("speed", [float(speed_number(w, ".10g")) for w in found["speed"].values], speed_sign(), ".4g"),
        Column("Reynolds number", found["reynolds"].values, form=".4g"),
        *(
            Column(text, [math.degrees(value) for value in found[key].values], "deg", ".2f")
            for key, text in names.items()
            if key in found
        ),
    ]


def _series_columns(found: xr.Dataset) -> list[Column]:
    from autobalancer.cli.terminal.sheet import Column

    series = found["series"].values
    names = list(dict.fromkeys(series.tolist()))
    parts = [found.isel({found["series"].dims[0]: series == name}) for name in names]
    reynolds = [part["reynolds"].values for part in parts]
    columns = [
        Column("series", names, wraps=True),
        Column("points", [int(re.size) for re in reynolds]),
        Column("Re from", [float(re.min()) for re in reynolds], form=".3g"),
        Column("Re to", [float(re.max()) for re in reynolds], form=".3g"),
    ]
    for way, text in (("left out", "c_d over law"), ("included", "with pressure")):
        over = [part.sel(pressure_force=way) for part in parts]
        ratios = [(one["drag_coefficient"] / one["law_coefficient"]).values for one in over]
        columns.append(Column(f"{text}, least", [float(ratio.min()) for ratio in ratios], form=".3f"))
        columns.append(Column(f"{text}, most", [float(ratio.max()) for ratio in ratios], form=".3f"))
    return columns


def _say_rolling(found: xr.Dataset) -> None:
    left, included = (found.sel(pressure_force=way) for way in ("left out", "included"))
    for one, text in ((left, "pressure force left out, (6.6)"), (included, "pressure force included")):
        deviation = float(one["rolling_resistance_deviation"])
        sure = f", standard deviation {deviation:.2g}" if math.isfinite(deviation) else ""
        say(f"rolling resistance {float(one['rolling_resistance']):.4g}{sure}: {text}")
    said = {
        "fitted": "fitted to series that overlap",
        "given": "as given",
        "machine": "of the machine, since no series overlap",
    }
    say(f"the coefficient is {said[found.attrs['rolling_resistance_from']]}")
