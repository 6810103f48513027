"""``autobalancer plot``: pictures of a result file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from autobalancer.cli.runs.pictures import ANSWER, CHAMBER, DESIGN, DESIGNS, ENSEMBLE, MACHINE, MANY, RACES, STUDY
from autobalancer.cli.terminal.options import SpeedUnit, Unit

ALL = tuple(dict.fromkeys((*RACES, *CHAMBER, *STUDY, *DESIGNS, *ENSEMBLE, *MANY, *DESIGN, *MACHINE, *ANSWER)))
KINDS = (
    f"{', '.join(RACES)}; of a deep chamber {', '.join(CHAMBER)}; of its study {', '.join(STUDY)}; "
    f"of its search for designs {', '.join(DESIGNS)}; of an ensemble {', '.join(ENSEMBLE)}; of a study of runs "
    f"{', '.join(MANY)}; of a design {', '.join(DESIGN)}; "
    f"of a machine file {MACHINE[0]}; of other results {ANSWER[0]}"
)


def plot(
    result: Annotated[Path, typer.Argument(help="Result file, folder of a run in an archive, or a machine file.")],
    out: Annotated[Path, typer.Option(help="Folder, or one picture: .png, .svg or .pdf.")] = Path("."),
    kind: Annotated[str, typer.Option(help=f"{KINDS}; or all of them.")] = "all",
    format: Annotated[str, typer.Option(help="png, svg or pdf, if --out is a folder.")] = "png",
    speed_unit: Unit = SpeedUnit.RPM,
    deflection_unit: Annotated[str, typer.Option(help="m, mm, um or nm; by default what suits.")] = "",
    log: Annotated[
        bool | None, typer.Option("--log/--linear", help="Deflection axis of the run-up; by default what suits.")
    ] = None,
    time: Annotated[str, typer.Option(help='Moment of race or arrangement, such as "12 s"; by default the end.')] = "",
    start: Annotated[str, typer.Option(help='Begin of what is drawn over time, such as "5 s".')] = "",
    end: Annotated[str, typer.Option(help="End of it.")] = "",
    frame: Annotated[str, typer.Option(help="Axes of the orbit: space or rotor; by default space.")] = "",
    place: Annotated[str, typer.Option(help="Balancer or station whose orbit is drawn; by default all of them.")] = "",
    as_json: Annotated[bool, typer.Option("--json", help="Print the names of the pictures as JSON.")] = False,
) -> None:
    """Draw a result (run-up, race with its balls, orbit; of deep chambers history, energy and more) or a machine.

    Example: autobalancer plot stall.nc --out pictures --format svg
    """
    from autobalancer.cli.runs.pictures import Wishes, of_machine, pictures_of
    from autobalancer.cli.terminal.exit_codes import MEND
    from autobalancer.cli.terminal.output import PICTURE, check_suffix, print_json
    from autobalancer.cli.terminal.quantities import optional
    from autobalancer.errors import QuestionError, ResultError
    from autobalancer.plots.drawing.save import FORMATS, save_picture
    from autobalancer.results.open_run import open_run
    from autobalancer.safe_file import ready_to_write

    if frame not in ("", "space", "rotor"):
        raise QuestionError(f"--frame: given {frame!r}; must be space or rotor")
    if deflection_unit not in ("", None, "m", "mm", "um", "nm"):
        raise QuestionError(f"--deflection-unit: given {deflection_unit!r}; must be one of m, mm, um, nm")
    single = bool(out.suffix)
    if format not in FORMATS:
        raise QuestionError(f"--format: given {format!r}; must be one of {', '.join(FORMATS)}")
    if kind not in (*ALL, "all"):
        raise QuestionError(f"--kind: given {kind!r}{_meant(kind)}; must be one of {KINDS}; or all")
    if single:
        check_suffix("--out", out, PICTURE)
        ready_to_write(out)
    new = not (out.parent if single else out).exists()
    first, last, moment = (
        optional(f"--{name}", text, "s") for name, text in (("start", start), ("end", end), ("time", time))
    )
    wishes = Wishes(speed_unit, deflection_unit or None, log, moment, first, last, frame, place)
    draw = of_machine(result, wishes) if result.suffix == ".toml" else pictures_of(open_run(result), wishes)
    if kind != "all" and kind not in draw:
        raise QuestionError(f"--kind: given {kind!r}; of {result} there are {', '.join(draw)}")
    chosen = tuple(draw) if kind == "all" else (kind,)
    if single and len(chosen) > 1:
        raise QuestionError(f"--out {out}: a file is one picture; choose --kind {', '.join(draw)}, or give a folder")
    title = result.name if result.is_dir() else result.stem  # the name of a run may hold a point: deep-n3-mu0.5-s0
    skipped: list[str] = []
    made: list[Path] = []
    for name in chosen:
        path = out if single else out / f"{title}_{name.replace('-', '_')}.{format}"
        try:
            picture = draw[name]()
        except QuestionError as reason:
            if len(chosen) == 1 or len(skipped) == len(chosen) - 1:
                raise
            skipped.append(name)
            typer.echo(f"no {name}: {reason}", err=True)
            continue
        except (ValueError, OverflowError, TypeError) as reason:
            raise ResultError(f"{result}: cannot be drawn; is it damaged? {type(reason).__name__}: {reason}") from None
        made.append(save_picture(picture, path))
        if not as_json:
            typer.echo(f"written: {made[-1]}")
    if as_json:
        print_json({"result": str(result), "pictures": [str(path) for path in made]})
    elif new:
        typer.echo(f"new folder: {out.parent if single else out}")
    if skipped and (start or end or time or place):  # what was asked for is not all there
        raise typer.Exit(MEND)


def _meant(kind: str) -> str:
    from difflib import get_close_matches

    near = get_close_matches(
        kind.lower().replace("_", "-"),
        (*RACES, *CHAMBER, *STUDY, *DESIGNS, *ENSEMBLE, *DESIGN, *MACHINE, *ANSWER, "all"),
        1,
    )
    return f" (did you mean {near[0]}?)" if near else ""
