"""``autobalancer map``: the growth rate of the balanced state over two parameters."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def map_(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    x: Annotated[tuple[str, str], typer.Option(help='Name and range: speed "40 rad/s:120 rad/s:400".')],
    y: Annotated[tuple[str, str], typer.Option(help='Name and range: viscosity "0.2 mm^2/s:100 mm^2/s:400:log".')],
    speed: Annotated[str, typer.Option(help="Rotor speed where it is not an axis.")] = "",
    positions: Annotated[str, typer.Option(help="Of more than two balls: worst or best.")] = "worst",
    point: Annotated[
        list[str] | None, typer.Option(help='Operating point "name=x value, y value"; may be repeated.')
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Result file (netCDF).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz, for the picture.")] = "rpm",
) -> None:
    """Draw where the balanced state is stable, with averaged border, exact border, release and capture speed.

    A parameter is speed, viscosity, drag, ball_mass, ball_diameter, count, unbalance, damping, stiffness, temperature,
    plateau, rolling_resistance, or a path.

    Example: autobalancer map examples/machines/discoidal.toml --x speed "50 rad/s:130 rad/s:400"
    --y viscosity "0.2 mm^2/s:100 mm^2/s:400:log" --plot map.png
    """
    from rich.console import Console
    from rich.progress import Progress

    from autobalancer import save_run
    from autobalancer.cli.ranges import axis_range
    from autobalancer.errors import QuestionError
    from autobalancer.plots.save import save_picture
    from autobalancer.plots.stability_map import plot_map
    from autobalancer.stability.maps import stability_map

    if x[0] == y[0]:
        raise QuestionError(f"--y: given {y[0]!r}, which is along --x already; take two different parameters")
    if out is None and plot is None:
        raise QuestionError("map: give --plot for a picture, --out for a result file, or both")
    axes = {name: axis_range(option, name, text) for option, (name, text) in (("--x", x), ("--y", y))}
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("map")
        found = stability_map(
            machine,
            axes,
            speed=speed or None,
            positions=positions,  # type: ignore[arg-type]
            operating_points=dict(_point(text) for text in point or []),
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None:
        save_picture(plot_map(found, speed_unit=speed_unit), plot)
    rates = found["growth_rate"].values
    known = rates[rates == rates]
    stable = f"{100.0 * (known < 0.0).mean():.3g} % of them stable" if known.size else "no balanced state anywhere"
    ignores = f"; ignores {found.attrs['ignores']}" if found.attrs["ignores"] else ""
    typer.echo(f"{rates.size} points, {known.size} with a balanced state, {stable}{ignores}")
    if "held_share" in found:
        held = 100.0 * float((found["held_share"] >= 1.0).mean())
        typer.echo(f"friction: the unbalance alone does not move balls at rest in {held:.3g} % of the map")
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _point(text: str) -> tuple[str, tuple[str, str]]:
    from autobalancer.errors import QuestionError

    name, _, values = text.partition("=")
    pair = [value.strip() for value in values.split(",")]
    if not name.strip() or len(pair) != 2 or not all(pair):
        raise QuestionError(
            f"--point: given {text!r}; write it as \"name=x value, y value\", such as 'measured=64 rad/s, 0.65 mm^2/s'"
        )
    return name.strip(), (pair[0], pair[1])
