"""``autobalancer plot``: pictures of a result file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

KINDS = ("run-up", "race", "orbit")


def plot(
    result: Annotated[Path, typer.Argument(help="Result file of a run.")],
    out: Annotated[Path, typer.Option(help="Folder, or one picture: name.png, name.svg or name.pdf.")] = Path("."),
    kind: Annotated[str, typer.Option(help="run-up, race, orbit, or all of them.")] = "all",
    format: Annotated[str, typer.Option(help="png, svg or pdf, if --out is a folder.")] = "png",
    speed_unit: Annotated[str, typer.Option(help="rpm, rad/s or Hz.")] = "rpm",
    deflection_unit: Annotated[str, typer.Option(help="m, mm, um or nm; by default what suits.")] = "",
    log: Annotated[bool, typer.Option("--log", help="Logarithmic deflection in the run-up.")] = False,
    time: Annotated[str, typer.Option(help='Moment of the race, such as "12 s"; by default the end.')] = "",
    start: Annotated[str, typer.Option(help='Begin of run-up and orbit, such as "5 s".')] = "",
    end: Annotated[str, typer.Option(help="End of run-up and orbit.")] = "",
    frame: Annotated[str, typer.Option(help="Axes of the orbit: space or rotor.")] = "space",
) -> None:
    """Draw a result file: the run-up, the race with its balls, the orbit of the rotor.

    Example: autobalancer plot stall.nc --out pictures --format svg
    """
    from autobalancer import load_run, plot_orbit, plot_race, plot_run_up
    from autobalancer.errors import QuestionError
    from autobalancer.plots.save import FORMATS, save_picture

    chosen = _chosen(kind)
    single = bool(out.suffix)
    if single and len(chosen) > 1:
        raise QuestionError(f"--out {out}: a file is one picture; choose --kind {', '.join(KINDS)}, or give a folder")
    if format not in FORMATS:
        raise QuestionError(f"--format: given {format!r}; must be one of {', '.join(FORMATS)}")
    first, last, moment = (_seconds(text) for text in (start, end, time))
    run, unit = load_run(result), deflection_unit or None
    draw: dict[str, Callable[[], Figure]] = {
        "run-up": lambda: plot_run_up(
            run, speed_unit=speed_unit, deflection_unit=unit, log_deflection=log, start=first, end=last
        ),
        "race": lambda: plot_race(run, time=moment, speed_unit=speed_unit),
        "orbit": lambda: plot_orbit(
            run,
            start=first,
            end=last,
            frame=frame,  # type: ignore[arg-type]
            deflection_unit=unit,
            speed_unit=speed_unit,
        ),
    }
    skipped: list[str] = []
    for name in chosen:
        path = out if single else out / f"{result.stem}_{name.replace('-', '_')}.{format}"
        try:
            picture = draw[name]()
        except QuestionError as reason:
            if len(chosen) == 1 or len(skipped) == len(chosen) - 1:
                raise
            skipped.append(name)
            typer.echo(f"no {name}: {reason}", err=True)
            continue
        typer.echo(save_picture(picture, path))


def _chosen(kind: str) -> tuple[str, ...]:
    from autobalancer.errors import QuestionError

    if kind != "all" and kind not in KINDS:
        raise QuestionError(f"--kind: given {kind!r}; must be one of {', '.join(KINDS)}, all")
    return KINDS if kind == "all" else (kind,)


def _seconds(text: str) -> float | None:
    from autobalancer.units import option_to_si

    return float(option_to_si(text, "s")) if text else None
