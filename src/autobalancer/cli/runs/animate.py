"""``autobalancer animate``: a film of a result file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.terminal.options import SpeedUnit, Unit


def animate(
    result: Annotated[Path, typer.Argument(help="Result file, or folder of a run in an archive.")],
    out: Annotated[
        Path | None,
        typer.Option(help="Film: .gif, or .mp4 with autobalancer\\[film]; by default .mp4, named as the result."),
    ] = None,
    start: Annotated[str, typer.Option(help='Begin in the run, such as "5 s".')] = "",
    end: Annotated[str, typer.Option(help="End in the run.")] = "",
    seconds: Annotated[str, typer.Option(help='Length of the film, such as "10 s".')] = "10 s",
    fps: Annotated[int, typer.Option(help="Frames in a second of film.")] = 25,
    frame: Annotated[
        str,
        typer.Option(
            help="rotor: it stands as under a stroboscope; space: it turns. By default rotor, of a deep chamber space."
        ),
    ] = "",
    azimuth: Annotated[
        float | None,
        typer.Option(help="Deep chamber: degrees from the axis where one looks from, level; by default 35."),
    ] = None,
    elevation: Annotated[
        float | None, typer.Option(help="Deep chamber: degrees above the level; by default 20.")
    ] = None,
    deflection_scale: Annotated[float, typer.Option(help="How much larger it is drawn; 0 for what suits.")] = 0.0,
    speed_unit: Unit = SpeedUnit.RPM,
    width: Annotated[int, typer.Option(help="Pixels.")] = 960,
    as_json: Annotated[bool, typer.Option("--json", help="Print the name of the film as JSON.")] = False,
) -> None:
    """Make a film of a result: rotor, balls and unbalance beside speeds and deflection; deep chambers in three dimensions.

    Example: autobalancer animate stall.nc --out slow.mp4 \\
      --start "7 s" --end "7.5 s" --frame space
    """
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

    from autobalancer.cli.terminal.output import check_suffix, print_json
    from autobalancer.cli.terminal.progress import progress_bar
    from autobalancer.cli.terminal.quantities import optional, quantity
    from autobalancer.either_kind import animate as make_film
    from autobalancer.errors import QuestionError
    from autobalancer.results.chamber.shape import is_chamber_run
    from autobalancer.results.open_run import open_run
    from autobalancer.safe_file import ready_to_write

    path = out if out is not None else result.with_name(f"{result.stem if result.is_file() else result.name}.mp4")
    check_suffix("--out", path, (".mp4", ".gif"))
    ready_to_write(path)
    length = quantity("--seconds", seconds, "s")
    first, last = optional("--start", start, "s"), optional("--end", end, "s")
    run = open_run(result)
    asked = {"frame": frame or None, "azimuth": azimuth, "elevation": elevation}
    given = {name: value for name, value in asked.items() if value is not None}
    if not is_chamber_run(run) and given.keys() - {"frame"}:
        raise QuestionError("--azimuth, --elevation: films of balls in races are seen along the axis; leave them out")
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("frames"),
        TimeRemainingColumn(),
    )
    with progress_bar(path.name, *columns) as update:
        made = make_film(
            run,
            path,
            start=first,
            end=last,
            duration=length,
            fps=fps,
            deflection_scale=deflection_scale or "auto",
            speed_unit=speed_unit,
            width=width,
            progress=update,
            **given,  # type: ignore[arg-type]  # the function says which frame there is
        )
    if as_json:
        print_json({"result": str(result), "film": str(made)})
    else:
        typer.echo(f"written: {made}")
