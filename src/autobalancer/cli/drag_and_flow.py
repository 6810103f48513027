"""``autobalancer ball-drag``: the drag of a ball in its race, from the equations of the fluid."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.options import Csv, Json, MachineFile, Outs, Plot, SpeedUnit, Unit
from autobalancer.cli.terminal.sheet import say, speed_number, speed_sign, speed_text

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.tables import Column


SHOWN = ("cd_re", "drag_coefficient", "lift", "through_flow")


def ball_drag(
    machine: MachineFile,
    gap: Annotated[str, typer.Option(help='Between ball and outer wall, such as "1 um": what their roughness leaves.')],
    reynolds: Annotated[
        list[float] | None,
        typer.Option(help="Reynolds number; may be repeated, ascending. 0: no inertia of the fluid."),
    ] = None,
    motion: Annotated[str, typer.Option(help="rolling or sliding.")] = "rolling",
    ball_ahead: Annotated[
        str, typer.Option(help='Distance of an equal ball ahead along the orbit, such as "15 mm".')
    ] = "",
    mesh_gap: Annotated[
        float | None, typer.Option(help="Gap of the mesh in ball radii; by default 0.02, or the gap if wider.")
    ] = None,
    fineness: Annotated[float, typer.Option(help="2 halves all elements.")] = 1.0,
    balancer: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    race: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Compute the drag of a ball in its race by finite elements, and the lines of the machine file that use it.

    Needs pip install "autobalancer\\[drag]". A few seconds for each Reynolds number up to 30, a minute at 100.

    Example: autobalancer ball-drag discoidal.toml --gap "1 um" \\
      --reynolds 0 --reynolds 10 --plot ball.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import optional, quantity
    from autobalancer.cli.terminal.progress_bar import of_time, progress_bar
    from autobalancer.flow.ball_problem import ball_drag as solved

    one_form(as_json, as_csv)
    files = Files(out, plot)
    numbers = {} if reynolds is None else {"reynolds": reynolds}
    with progress_bar("flow") as update:
        found = solved(
            machine,
            **numbers,
            gap=quantity("--gap", gap, "m"),
            motion=motion,
            ball_ahead=optional("--ball-ahead", ball_ahead, "m"),
            mesh_gap=mesh_gap,
            fineness=fineness,
            balancer=balancer,
            race=race,
            progress=of_time(update),
        )
    files.save(found, lambda: ab.plot.ball_drag(found))
    if as_json:
        names = ("reynolds", *(name for name in found.data_vars if found[name].dims == ("reynolds",)))
        print_json(
            {"machine": str(machine), **_numbers(found), **{name: found[name].values.tolist() for name in names}}
        )
    elif as_csv:
        print_csv(_columns(found))
    else:
        _print(found)
        files.say()


def _numbers(found: Any) -> dict[str, Any]:
    return {key: found.attrs[key] for key in ("gap", "mesh_gap", "mesh_error", "elements", "cd_re_per_decade", "drag")}


def _columns(found: Any) -> list[Column]:
    from autobalancer.tables import Column

    heads = {"cd_re": "c_d Re", "drag_coefficient": "c_d", "lift": "lift/(mu r U)", "through_flow": "mean flow/U"}
    first = Column("Re", found["reynolds"].values)
    return [first, *(Column(heads[name], found[name].values) for name in SHOWN)]


def _print(found: Any) -> None:
    from autobalancer.cli.terminal.sheet import print_sheet

    a = found.attrs
    for name, text in (
        ("gap", f"{1e6 * a['gap']:.4g} um; ten times less adds {a['cd_re_per_decade']:.3g} to c_d Re"),
        ("mesh", f"{a['elements']} elements, gap of {a['mesh_gap']:.3g} ball radii"),
        ("error", f"a mesh 1.5 times coarser differs by {100.0 * a['mesh_error']:.2g} %"),
    ):
        say(f"{name:<6}{text}", indent=" " * 6)
    print_sheet(_columns(found))
    say("in the machine file:")
    typer.echo(a["drag"])


# ``autobalancer sheared-drag``: the drag of a ball in a fluid that thins or thickens.


def sheared_drag(
    machine: MachineFile,
    velocity: Annotated[
        list[str], typer.Option(help='Of the ball along its walls, such as "0.5 m/s"; may be repeated, ascending.')
    ],
    mesh_gap: Annotated[float, typer.Option(help="Between ball and outer wall, ball radii.")] = 0.02,
    motion: Annotated[str, typer.Option(help="rolling or sliding.")] = "rolling",
    fineness: Annotated[float, typer.Option(help="2 halves all elements.")] = 1.0,
    balancer: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    race: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    out: Outs = None,
    plot: Plot = None,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Compute the slow drag of a ball in a sheared fluid, and the effective rate of shear at_ball for the machine file.

    Needs pip install "autobalancer\\[drag]". Some seconds for each velocity.

    Example: autobalancer sheared-drag thinning_fluid.toml \\
      --velocity "0.1 m/s" --velocity "1 m/s" --plot drag.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import quantity
    from autobalancer.cli.terminal.progress_bar import of_time, progress_bar
    from autobalancer.cli.terminal.sheet import note, print_facts, print_sheet

    one_form(as_json, as_csv)
    files = Files(out, plot)
    with progress_bar("flow") as update:
        found = ab.flow.sheared_drag(
            machine,
            [quantity("--velocity", text, "m/s") for text in velocity],
            mesh_gap=mesh_gap,
            motion=motion,
            fineness=fineness,
            balancer=balancer,
            race=race,
            progress=of_time(update),
        )
    files.save(found, lambda: ab.plot.sheared_drag(found))
    if as_json:
        values = {str(name): found[name].values for name in (*found.coords, *found.data_vars)}
        numbers = {key: found.attrs[key] for key in ("at_ball", "greatest_error", "mesh_gap", "mesh_error", "elements")}
        print_json({"machine": str(machine), **numbers, **values})
        return
    if as_csv:
        print_csv(found.columns())
        return
    print_facts(found.facts(), str(found.attrs["title"]))
    print_sheet(found.columns())
    for remark in found.remarks():
        note(remark)
    files.say()


# ``autobalancer annulus-flow``: how the fluid in a race follows the rotor.


def flow(
    machine: MachineFile,
    speed: Annotated[
        str, typer.Option(help='A constant speed, such as "1200 rpm", in place of the profile of the machine.')
    ] = "",
    initial_speed: Annotated[
        str, typer.Option(help='Speed of the fluid before time zero, such as "0 rpm" for an impulsive start.')
    ] = "",
    duration: Annotated[str, typer.Option(help='Such as "20 s"; by default run.duration of the file.')] = "",
    time: Annotated[list[str] | None, typer.Option(help='Time of a field, such as "0.5 s"; may be repeated.')] = None,
    model: Annotated[str, typer.Option(help="auto, modes, chebyshev or azimuthal.")] = "auto",
    points: Annotated[str, typer.Option(help='Intervals in radial and axial direction, such as "24x32".')] = "",
    error: Annotated[float, typer.Option(help="Of the speed at the orbit over the greatest speed.")] = 1e-3,
    balancer: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    race: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    out: Outs = None,
    plot: Plot = None,
    speed_unit: Unit = SpeedUnit.RPM,
    as_json: Json = False,
    as_csv: Csv = False,
) -> None:
    """Solve the flow in the annulus of a race and say how far the fluid lags behind the rotor.

    Example: autobalancer annulus-flow discoidal.toml \\
      --speed "60 rad/s" --initial-speed "0 rpm" --duration "2 s" \\
      --time "0.1 s" --plot flow.png
    """
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
    from autobalancer.cli.terminal.options import optional, quantity
    from autobalancer.cli.terminal.progress_bar import of_time, progress_bar
    from autobalancer.flow.annulus_problem import annulus_flow

    one_form(as_json, as_csv)
    files = Files(out, plot)
    with progress_bar("flow") as update:
        found = annulus_flow(
            machine,
            optional("--speed", speed, "rad/s"),
            duration=optional("--duration", duration, "s"),
            initial_speed=optional("--initial-speed", initial_speed, "rad/s"),
            times=[quantity("--time", text, "s") for text in time or []],
            model=model,  # type: ignore[arg-type]
            points=_points(points),
            error=error,
            balancer=balancer,
            race=race,
            progress=of_time(update),
        )
    files.save(found, lambda: ab.plot.flow(found, speed_unit=speed_unit))
    if as_json:
        print_json({"machine": str(machine), **_flow_numbers(found)})
        return
    if as_csv:
        print_csv(_flow_columns(found))
        return
    _flow_print(found)
    files.say()


def _points(text: str) -> tuple[int, int] | None:
    from autobalancer.errors import QuestionError

    if not text:
        return None
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.strip().isdecimal() for part in parts):
        raise QuestionError(f"--points: given {text!r}; write radial and axial intervals, such as 24x32")
    return int(parts[0]), int(parts[1])


def _flow_columns(found: Any) -> list[Column]:
    from autobalancer.tables import Column

    names = {"speed": "rotor", "fluid_speed": "fluid at the orbit", "diffusion_speed": "fluid by diffusion alone"}
    speeds = [
        Column(head, [float(speed_number(w, ".10g")) for w in found[name].values], speed_sign())
        for name, head in names.items()
    ]
    return [Column("time", found["time"].values, "s"), *speeds]


def _flow_print(found: Any) -> None:
    from autobalancer.cli.terminal.sheet import note
    from autobalancer.flow.result import flow_notes

    a = found.attrs
    lag_at_end = float(found["speed"][-1] - found["fluid_speed"][-1])
    for name, text in (
        ("model", f"{a['model']}: {a['model_reason']}"),
        ("annulus", f"{1e3 * a['inner']:.5g} to {1e3 * a['outer']:.5g} mm, {1e3 * a['height']:.4g} mm high"),
        ("orbit radius", f"{1e3 * a['orbit_radius']:.5g} mm"),
        ("Ekman number", f"{a['ekman_number']:.3g}, at the greatest speed"),
        ("greatest lag", speed_text(a["greatest_lag"], ".4g")),
        ("lag at the end", speed_text(lag_at_end, ".4g")),
        ("spin-up time", f"{a['spin_up_time']:.4g} s" if math.isfinite(a["spin_up_time"]) else "not reached"),
    ):
        say(f"{name:<16}{text}", indent=" " * 16)
    for text in flow_notes(found):
        note(text)


def _flow_numbers(found: Any) -> dict[str, Any]:
    keys = ("model", "model_reason", "ekman_number", "greatest_lag", "points", "steps", "inner", "outer", "height")
    answer = {key: found.attrs[key] for key in keys}
    for key in ("spin_up_time", "uncertainty"):
        answer[key] = found.attrs[key] if math.isfinite(found.attrs[key]) else None
    answer |= {name: found[name].values.tolist() for name in ("time", "speed", "fluid_speed", "diffusion_speed")}
    return answer


# ``autobalancer equilibrium-angle``: the equilibrium angle of one ball, and what measured angles say of drag and
# friction.


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
    from autobalancer.cli.terminal.command import Files, one_form, print_csv, print_json
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
        print_json({"machine": str(machine), **_angle_numbers(found)})
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
    from autobalancer.cli.terminal.options import quantity, speed_range
    from autobalancer.measurement.angle import equilibrium_angle

    chosen = speed_range("--speeds", speeds) if speeds else None
    length = quantity("--duration", duration, "s")
    return equilibrium_angle(machine, chosen, simulation=simulate, duration=length)


def _evaluated(machine: Path, table: Path, rolling: float | None, resamples: int, curve: bool) -> xr.Dataset:
    from autobalancer.errors import QuestionError
    from autobalancer.measurement.angle import evaluate_angles, load_angle_series

    if curve:
        raise QuestionError("--measured: evaluates the speeds of the table; leave out --speeds and --simulate")
    return evaluate_angles(machine, load_angle_series(table), rolling=rolling, resamples=resamples)


def _angle_numbers(found: xr.Dataset) -> dict[str, Any]:
    keys = [key for key in found.attrs if key not in ("title", "source", "created")]
    return {key: found.attrs[key] for key in keys} | {str(name): found[name].values for name in found.variables}


def _curve_columns(found: xr.Dataset) -> list[Column]:
    from autobalancer.tables import Column

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
    from autobalancer.tables import Column

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
