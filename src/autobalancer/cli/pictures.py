"""``autobalancer plot``: pictures of a result file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import Reply, command
from autobalancer.cli.terminal.options import In
from autobalancer.cli.terminal.sheet import speed_sign
from autobalancer.errors import QuestionError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from autobalancer.results.answers.studied import Studied


# Which pictures there are of a result, whatever it is the result of.


Pictures = dict[str, "Callable[[], Figure]"]

WHERE_ASKED = ("impacts",)  # a cloud of thousands of dots, drawn only where it is asked for
RACES = ("run-up", "race", "orbit", "impacts", "drive-train")
CHAMBER = ("history", "energy", "collisions", "bearings", "reactions", "arrangement")
STUDY = ("amplitudes", "means", "carried")
ENSEMBLE = ("shares", "distribution")
MACHINE = ("machine",)
DESIGN = ("design",)
MANY = ("picture", "distribution", "rest-positions")
ANSWER = ("picture",)  # of any other answer


@dataclass(frozen=True)
class Wishes:
    """What was asked for besides the kind; None, or a default, where nothing was."""

    speed_unit: str
    deflection_unit: str | None
    log: bool | None
    time: float | None
    start: float | None
    end: float | None
    frame: str
    place: str


def pictures_of(result: xr.Dataset, wishes: Wishes) -> Pictures:
    """Name of each picture and what draws it."""
    from autobalancer.machine_kinds import CHAMBERS, machine_kind
    from autobalancer.results.answers.studied import Studied

    if machine_kind(result) is CHAMBERS:
        return _of_chamber(result, wishes)
    if {"place", "stage", "front"} <= set(result.data_vars):
        _refuse(wishes, "of a design", "log", "time", "start", "end", "frame", "place", "deflection_unit")
        return {"design": lambda: ab.plot.design(result)}
    if {"layers", "friction", "balls"} <= set(result.dims):
        return _of_study(result, wishes)
    if isinstance(result, Studied) and "verdict" in result:
        return _study_pictures(result, wishes)
    if draw := _own_picture(result):
        _refuse(wishes, "of this result", "log", "frame", "place", "time", "start", "end", "deflection_unit")
        return {"picture": lambda: draw(result)}
    if "member" in result.dims:
        _refuse(wishes, "of an ensemble", "log", "frame", "place", "time", "start", "end", "deflection_unit")
        return {
            "shares": lambda: ab.plot.ensemble(result, speed_unit=wishes.speed_unit),
            "distribution": lambda: ab.plot.ensemble_distribution(result, speed_unit=wishes.speed_unit),
        }
    return _of_races(result, wishes)


def _own_picture(result: xr.Dataset) -> Callable[[xr.Dataset], Figure] | None:
    """The function that draws an answer which is no run and no ensemble."""
    from autobalancer.results.answers.answer import Answer

    if {"deviation", "correlation", "parameter"} <= set(result.variables):
        return ab.plot.identification
    name = result.form().picture if isinstance(result, Answer) else ""
    return getattr(ab.plot, name) if name not in ("", "run_up", "ensemble") else None


def of_machine(machine: Path, wishes: Wishes) -> Pictures:
    """The drawing of a machine file."""
    _refuse(wishes, "of a machine", "log", "time", "start", "end", "frame", "place", "deflection_unit")
    return {"machine": lambda: ab.plot.machine(machine)}


def _of_races(run: xr.Dataset, wishes: Wishes) -> Pictures:

    both: dict[str, Any] = {
        "speed_unit": wishes.speed_unit,
        "deflection_unit": wishes.deflection_unit,
        "start": wishes.start,
        "end": wishes.end,
    }
    pictures: Pictures = {
        "run-up": lambda: ab.plot.run_up(run, log_deflection=wishes.log, **both),
        "race": lambda: ab.plot.race(run, time=wishes.time, speed_unit=wishes.speed_unit),
        "orbit": lambda: ab.plot.orbit(
            run,
            frame=wishes.frame or "space",  # type: ignore[arg-type]
            place=wishes.place or None,
            **both,
        ),
    }
    part: dict[str, Any] = {"speed_unit": wishes.speed_unit, "start": wishes.start, "end": wishes.end}
    if run.sizes.get("link", 0):
        pictures["drive-train"] = lambda: ab.plot.drive_train(run, **part)
    if run.sizes.get("impact", 0):
        pictures["impacts"] = lambda: ab.plot.impacts(run, **part)
    return pictures


def _of_chamber(run: xr.Dataset, wishes: Wishes) -> Pictures:

    _refuse(wishes, "of a deep chamber", "log", "frame", "place")
    part = run.sel(time=slice(wishes.start, wishes.end))
    if part.sizes["time"] < 2:
        first, last = float(run["time"][0]), float(run["time"][-1])
        raise QuestionError(
            f"--start, --end: fewer than two samples there; the run goes from {first:g} s to {last:g} s"
        )
    part = part.load()
    units: dict[str, Any] = {"speed_unit": wishes.speed_unit, "deflection_unit": wishes.deflection_unit}
    return {
        "history": lambda: ab.plot.chamber_run(part, **units),
        "energy": lambda: ab.plot.chamber_energy(part),
        "collisions": lambda: ab.plot.chamber_collisions(part),
        "bearings": lambda: ab.plot.chamber_bearing_forces(part),
        "reactions": lambda: ab.plot.chamber_reactions(part),
        "arrangement": lambda: ab.plot.chamber_arrangement(
            run if wishes.time else part, [wishes.time] if wishes.time else None
        ),
    }


def _study_pictures(study: Studied, wishes: Wishes) -> Pictures:
    """The pictures of a study of runs."""
    _refuse(wishes, "of a study", "log", "frame", "place", "time", "start", "end", "deflection_unit")
    unit = wishes.speed_unit
    return {
        "picture": lambda: ab.plot.study(study, speed_unit=unit),
        "distribution": lambda: ab.plot.ensemble_distribution(study, speed_unit=unit),
        "rest-positions": lambda: ab.plot.rest_positions(study, speed_unit=unit),
    }


def _of_study(study: xr.Dataset, wishes: Wishes) -> Pictures:
    from autobalancer.studies.chamber_study import optimal_means

    _refuse(wishes, "of a study", "log", "frame", "place", "time", "start", "end", "deflection_unit")
    return {
        "amplitudes": lambda: ab.plot.chamber_amplitudes(study),
        "means": lambda: ab.plot.chamber_optimal_means(optimal_means(study)),
        "carried": lambda: ab.plot.chamber_carried(study),
    }


def _refuse(wishes: Wishes, what: str, *names: str) -> None:
    for name in names:
        if getattr(wishes, name) not in (None, False, ""):
            raise QuestionError(f"--{name.replace('_', '-')}: has no meaning for the pictures {what}; leave it out")


ALL = tuple(dict.fromkeys((*RACES, *CHAMBER, *STUDY, *ENSEMBLE, *MANY, *DESIGN, *MACHINE, *ANSWER)))
KINDS = (
    f"{', '.join(RACES)}; of a deep chamber {', '.join(CHAMBER)}; of its study {', '.join(STUDY)}; "
    f"of an ensemble {', '.join(ENSEMBLE)}; of a study of runs "
    f"{', '.join(MANY)}; of a design {', '.join(DESIGN)}; "
    f"of a machine file {MACHINE[0]}; of other results {ANSWER[0]}"
)


@command(out=None, csv=False, unit="speed", topic="First 4")
def plot(
    result: Annotated[Path, typer.Argument(help="Result file, folder of a run in an archive, or a machine file.")],
    out: Annotated[Path, "Folder, or one picture: .png, .svg or .pdf."] = Path("."),
    kind: Annotated[str, f"{KINDS}; or all of them; by default all but impacts."] = "",
    format: Annotated[str, "png, svg or pdf, if --out is a folder."] = "png",
    deflection_unit: Annotated[str, "m, mm, um or nm; by default what suits."] = "",
    log: Annotated[
        bool | None, typer.Option("--log/--linear", help="Deflection axis of the run-up; by default what suits.")
    ] = None,
    time: Annotated[float | None, In("s"), 'Moment of race or arrangement, such as "12 s"; by default the end.'] = None,
    start: Annotated[float | None, In("s"), 'Begin of what is drawn over time, such as "5 s".'] = None,
    end: Annotated[float | None, In("s"), "End of it."] = None,
    frame: Annotated[str, "Axes of the orbit: space or rotor; by default space."] = "",
    place: Annotated[str, "Balancer or station whose orbit is drawn; by default all of them."] = "",
) -> Reply:
    """Draw a result (run-up, race with its balls, orbit; of deep chambers history, energy and more) or a machine.

    Example: autobalancer plot stall.nc --out pictures --format svg
    """
    from autobalancer.cli.terminal.command import PICTURE, check_suffix
    from autobalancer.cli.terminal.group import MEND
    from autobalancer.errors import ResultError
    from autobalancer.plots.style import FORMATS, save_picture
    from autobalancer.results.run_argument import open_run
    from autobalancer.safe_file import ready_to_write

    if frame not in ("", "space", "rotor"):
        raise QuestionError(f"--frame: given {frame!r}; must be space or rotor")
    if deflection_unit not in ("", "m", "mm", "um", "nm"):
        raise QuestionError(f"--deflection-unit: given {deflection_unit!r}; must be one of m, mm, um, nm")
    # one file is one picture, a folder takes all usual ones
    single = bool(out.suffix)
    if format not in FORMATS:
        raise QuestionError(f"--format: given {format!r}; must be one of {', '.join(FORMATS)}")
    if kind not in ("", *ALL, "all"):
        raise QuestionError(f"--kind: given {kind!r}{_meant(kind)}; must be one of {KINDS}; or all")
    if single:
        check_suffix("--out", out, PICTURE)
        ready_to_write(out)
    folder = out.parent if single else out
    new = not folder.exists()
    wishes = Wishes(speed_sign(), deflection_unit or None, log, time, start, end, frame, place)
    draw = of_machine(result, wishes) if result.suffix == ".toml" else pictures_of(open_run(result), wishes)
    if kind not in ("", "all", *draw):
        raise QuestionError(f"--kind: given {kind!r}; of {result} there are {', '.join(draw)}")
    usual = tuple(name for name in draw if name not in WHERE_ASKED)
    chosen = {"": usual or tuple(draw), "all": tuple(draw)}.get(kind, (kind,))
    if single and len(chosen) > 1:
        raise QuestionError(f"--out {out}: a file is one picture; choose --kind {', '.join(draw)}, or give a folder")
    title = result.name if result.is_dir() else result.stem  # the name of a run may hold a point: deep-n3-mu0.5-s0
    # one picture that cannot be drawn does not keep the others away
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
    lines = [*(f"written: {path}" for path in made), *([f"new folder: {folder}"] if new else [])]
    asked = start is not None or end is not None or time is not None or place
    return Reply(
        None,
        {"pictures": [str(path) for path in made]},
        code="\n".join(lines),
        exit=MEND if skipped and asked else 0,  # what was asked for is not all there
    )


def _meant(kind: str) -> str:
    from difflib import get_close_matches

    near = get_close_matches(
        kind.lower().replace("_", "-"),
        (*RACES, *CHAMBER, *STUDY, *ENSEMBLE, *DESIGN, *MACHINE, *ANSWER, "all"),
        1,
    )
    return f" (did you mean {near[0]}?)" if near else ""


# ``autobalancer animate``: a film of a result file.


@command(out=None, csv=False, unit="speed", topic="First 5")
def animate(
    result: Annotated[Path, typer.Argument(help="Result file, or folder of a run in an archive.")],
    out: Annotated[
        Path | None, "Film: .gif, or .mp4 with autobalancer\\[film]; by default .mp4, named as the result."
    ] = None,
    start: Annotated[float | None, In("s"), 'Begin in the run, such as "5 s".'] = None,
    end: Annotated[float | None, In("s"), "End in the run."] = None,
    seconds: Annotated[Any, In("s"), 'Length of the film, such as "10 s".'] = "10 s",
    fps: Annotated[int, "Frames in a second of film."] = 25,
    frame: Annotated[
        str, "rotor: it stands as under a stroboscope; space: it turns. By default rotor, of a deep chamber space."
    ] = "",
    azimuth: Annotated[
        float | None, "Deep chamber: degrees from the axis where one looks from, level; by default 35."
    ] = None,
    elevation: Annotated[float | None, "Deep chamber: degrees above the level; by default 20."] = None,
    deflection_scale: Annotated[float, "How much larger it is drawn; 0 for what suits."] = 0.0,
    width: Annotated[int, "Pixels."] = 960,
) -> Reply:
    """Make a film of a result: rotor, balls and unbalance beside speeds and deflection; deep chambers in three dimensions.

    Example: autobalancer animate stall.nc --out slow.mp4 \\
      --start "7 s" --end "7.5 s" --frame space
    """
    from autobalancer.cli.terminal.command import check_suffix
    from autobalancer.cli.terminal.progress_bar import progress_bar
    from autobalancer.results.run_argument import open_run
    from autobalancer.safe_file import ready_to_write

    path = out if out is not None else result.with_name(f"{result.stem if result.is_file() else result.name}.mp4")
    check_suffix("--out", path, (".mp4", ".gif"))
    ready_to_write(path)
    run = open_run(result)
    asked = {"frame": frame or None, "azimuth": azimuth, "elevation": elevation}
    view: dict[str, Any] = {name: value for name, value in asked.items() if value is not None}
    with progress_bar(path.name) as update:
        made = ab.animate(
            run,
            path,
            start=start,
            end=end,
            duration=seconds,
            fps=fps,
            deflection_scale=deflection_scale or "auto",
            speed_unit=speed_sign(),
            width=width,
            progress=update,
            **view,
        )
    return Reply(None, {"film": str(made)}, code=f"written: {made}")
