"""``autobalancer basin``: which end state follows from which start."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from autobalancer.errors import QuestionError


def basin(
    machine: Annotated[Path, typer.Argument(help="Machine file.")],
    speed: Annotated[str, typer.Option(help='Final rotor speed, such as "1200 rpm".')],
    axis: Annotated[
        list[str] | None,
        typer.Option(help='One or two axes "name=from:to:count", e.g. "ball_angle[1]=-180 deg:180 deg:200".'),
    ] = None,
    random: Annotated[int, typer.Option(help="Instead of axes: number of random starts.")] = 0,
    seed: Annotated[int, typer.Option(help="For random starts.")] = 0,
    hold: Annotated[str, typer.Option(help='Longest time at the final speed, such as "30 s".')] = "",
    out: Annotated[Path | None, typer.Option(help="Result file (netCDF).")] = None,
    plot: Annotated[Path | None, typer.Option(help="Picture: png, svg or pdf.")] = None,
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz, for the picture.")] = "rpm",
    as_json: Annotated[bool, typer.Option("--json", help="Print the shares for a program.")] = False,
) -> None:
    """Run a machine from many starts and tell in percent where it ends.

    Example: autobalancer basin examples/machines/discoidal.toml --speed "1200 rpm" --random 500 --plot basin.png
    """
    from rich.console import Console
    from rich.progress import Progress

    from autobalancer import basin as ask
    from autobalancer import plot_basin, save_run
    from autobalancer.plots.save import save_picture
    from autobalancer.units import option_to_si

    axes = dict(_axis(text) for text in axis or [])
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("runs")
        found = ask(
            machine,
            option_to_si(speed, "rad/s"),
            axes or None,
            random=random,
            seed=seed,
            hold=option_to_si(hold, "s") if hold else None,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    shares = {str(name): float(found["share"].sel(end=name)) for name in found["end"].values}
    if out is not None:
        save_run(found, out, rescue=True)
    if plot is not None:
        save_picture(plot_basin(found, speed_unit=speed_unit), plot)
    if as_json:
        typer.echo(json.dumps({"machine": str(machine), "runs": int(found["state"].size), "share": shares}, indent=2))
        return
    for name, share in shares.items():
        if share > 0.0:
            typer.echo(f"{name:>12}  {100 * share:6.2f} %")
    for path in (out, plot):
        if path is not None:
            typer.echo(f"written: {path}")


def _axis(text: str) -> tuple[str, list[float]]:
    import numpy as np

    from autobalancer.units import option_to_si

    name, _, span = text.partition("=")
    parts = span.split(":")
    unit = "rad" if "angle" in name else "rad/s" if "speed" in name else "rad/s^2"
    if len(parts) != 3 or not parts[2].strip().isdigit() or int(parts[2]) < 1:
        raise QuestionError(
            f"--axis: given {text!r}; write it as name=from:to:count, e.g. 'ball_angle[1]=-180 deg:180 deg:50'"
        )
    low, high = (option_to_si(part, unit) for part in parts[:2])
    return name.strip(), [float(v) for v in np.linspace(low, high, int(parts[2]))]
