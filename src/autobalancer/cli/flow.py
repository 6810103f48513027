"""``autobalancer flow``: how the fluid in a race follows the rotor."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Annotated, Any

import typer


def flow(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    speed: Annotated[
        str, typer.Option(help='A constant speed, such as "1200 rpm", in place of the profile of the machine.')
    ] = "",
    initial_speed: Annotated[
        str, typer.Option(help='Speed of the fluid before time zero, such as "0 rpm" for an impulsive start.')
    ] = "",
    duration: Annotated[str, typer.Option(help='Such as "20 s"; by default run.duration of the file.')] = "",
    time: Annotated[list[str] | None, typer.Option(help='Time of a field, such as "0.5 s"; may be repeated.')] = None,
    model: Annotated[str, typer.Option(help="auto, modes, chebyshev or differences.")] = "auto",
    points: Annotated[str, typer.Option(help='Intervals in radial and axial direction, such as "24x32".')] = "",
    error: Annotated[float, typer.Option(help="Of the speed at the orbit over the greatest speed.")] = 1e-3,
    balancer: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    race: Annotated[int, typer.Option(help="Counted from 1.")] = 1,
    out: Annotated[Path | None, typer.Option("--out", "--output", help="Result file (netCDF).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz.")] = "rpm",
    as_json: Annotated[bool, typer.Option("--json", help="Print the numbers in SI for a program.")] = False,
) -> None:
    """Solve the flow in the annulus of a race and tell how far the fluid lags behind the rotor.

    Example: autobalancer flow examples/machines/discoidal.toml --speed "60 rad/s" --initial-speed "0 rpm" --duration "2 s"
    --time "0.1 s" --plot flow.png
    """
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    from autobalancer.flow.question import annulus_flow
    from autobalancer.plots.axis_units import speed_axis
    from autobalancer.plots.flow import plot_flow
    from autobalancer.plots.save import save_picture
    from autobalancer.results.store import save_run
    from autobalancer.units import option_to_si

    unit = speed_axis(speed_unit)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[now]}"), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("flow", total=1.0, now="")
        found = annulus_flow(
            machine,
            option_to_si(speed, "rad/s") if speed else None,
            duration=option_to_si(duration, "s") if duration else None,
            initial_speed=option_to_si(initial_speed, "rad/s") if initial_speed else None,
            times=[option_to_si(text, "s") for text in time or []],
            model=model,  # type: ignore[arg-type]
            points=_points(points),
            error=error,
            balancer=balancer,
            race=race,
            progress=lambda now, end: bar.update(task, completed=now / end, now=f"{now:.4g} s of {end:.4g} s"),
        )
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None:
        save_picture(plot_flow(found, speed_unit=speed_unit), plot)
    if as_json:
        typer.echo(json.dumps({"machine": str(machine), **_numbers(found)}, indent=2))
        return
    a = found.attrs
    lines = [
        ("model", f"{a['model']} ({a['model_reason']})"),
        ("annulus", f"{1e3 * a['inner']:.5g} to {1e3 * a['outer']:.5g} mm, {1e3 * a['height']:.4g} mm high"),
        ("orbit radius", f"{1e3 * a['orbit_radius']:.5g} mm"),
        ("Ekman number at the greatest speed", f"{a['ekman_number']:.3g}"),
        ("greatest lag of the fluid", f"{a['greatest_lag'] * unit.factor:.4g} {unit.sign}"),
        ("lag at the end", f"{float(found['speed'][-1] - found['fluid_speed'][-1]) * unit.factor:.4g} {unit.sign}"),
        ("spin-up time", f"{a['spin_up_time']:.4g} s" if math.isfinite(a["spin_up_time"]) else "not reached"),
    ]
    if a["uncertainty"] != 0.0:
        certain = (
            f"two grids differ by {a['uncertainty']:.1%} of the greatest speed"
            if math.isfinite(a["uncertainty"])
            else "unknown"
        )
        lines.append(("unsteady flow, certainty", certain))
    for name, text in lines:
        typer.echo(f"{name:>36}  {text}")
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _points(text: str) -> tuple[int, int] | None:
    from autobalancer.errors import QuestionError

    if not text:
        return None
    parts = text.lower().split("x")
    if len(parts) != 2 or not all(part.strip().isdigit() for part in parts):
        raise QuestionError(f"--points: given {text!r}; write radial and axial intervals, such as 24x32")
    return int(parts[0]), int(parts[1])


def _numbers(found: Any) -> dict[str, Any]:
    keys = ("model", "model_reason", "ekman_number", "greatest_lag", "points", "steps", "inner", "outer", "height")
    answer = {key: found.attrs[key] for key in keys}
    for key in ("spin_up_time", "uncertainty"):
        answer[key] = found.attrs[key] if math.isfinite(found.attrs[key]) else None
    answer |= {name: found[name].values.tolist() for name in ("time", "speed", "fluid_speed", "diffusion_speed")}
    return answer
