"""``autobalancer plot``: pictures of a result file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import autobalancer as ab
from autobalancer.cli.terminal.command import Reply, command
from autobalancer.cli.terminal.options import In
from autobalancer.cli.terminal.sheet import speed_sign
from autobalancer.errors import QuestionError, one_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


# Which pictures there are of a result, whatever it is the result of, with what was asked for besides the kind.


Pictures = dict[str, "Callable[[], Figure]"]
KINDS = (
    "run-up, race, orbit, impacts, drive-train; of a deep chamber history, energy, collisions, bearings, reactions, "
    "arrangement; of its study amplitudes, carried, means; of an ensemble shares, distribution, scatter; of a study of runs "
    "study, distribution, rest-positions; of a design design; of a machine file machine; of any result picture, its main one"
)


def drawings(result: xr.Dataset, wishes: dict[str, Any]) -> Pictures:
    """Name of each picture and what draws it, with those of the ``wishes`` that it knows."""
    from autobalancer.machine_kinds import CHAMBERS, machine_kind
    from autobalancer.plots.answer import pictures_of
    from autobalancer.studies.chamber_study import optimal_means

    there, parts = pictures_of(result), ("time", "start", "end")
    part, known = result, {name: one.options for name, one in there.items()}
    if machine_kind(result) is CHAMBERS:
        part = _part(result, wishes.get("start"), wishes.get("end"))
        moment = {"times": [wishes["time"]]} if "time" in wishes else {}
        wishes = {**{name: value for name, value in wishes.items() if name not in parts}, **moment}
    _refuse(wishes, [option for options in known.values() for option in options])

    def draw(name: str) -> Figure:
        own = {option: value for option, value in wishes.items() if option in known[name]}
        return ab.plot.answer(result if "times" in own else part, name, **own)

    pictures: Pictures = {name.replace("_", "-"): partial(draw, name) for name in there}
    if "amplitudes" in there:
        pictures["means"] = lambda: ab.plot.answer(optimal_means(result))
    return pictures


def _part(run: xr.Dataset, start: float | None, end: float | None) -> xr.Dataset:
    part = run.sel(time=slice(start, end))
    if part.sizes["time"] < 2:
        first, last = float(run["time"][0]), float(run["time"][-1])
        raise QuestionError(
            f"--start, --end: fewer than two samples there; the run goes from {first:g} s to {last:g} s"
        )
    return part.load()


def _refuse(wishes: Mapping[str, Any], known: Sequence[str]) -> None:
    for name in wishes:
        if name not in (*known, "speed_unit"):
            raise QuestionError(f"--{name.replace('_', '-')}: has no meaning for the pictures of this; leave it out")


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
    from autobalancer.plots.answer import PICTURES
    from autobalancer.plots.style import FORMATS, save_picture
    from autobalancer.results.run_argument import open_run
    from autobalancer.safe_file import ready_to_write

    one_of("--frame", frame or "space", "space", "rotor")
    one_of("--deflection-unit", deflection_unit or "m", "m", "mm", "um", "nm")
    # one file is one picture, a folder takes all usual ones
    single = bool(out.suffix)
    one_of("--format", format, *FORMATS)
    kind = kind.lower().replace("_", "-")
    all_ = [*(name.replace("_", "-") for name in PICTURES), "machine", "picture", "all"]
    if kind not in ("", *all_):
        near = "".join(f" (did you mean {name}?)" for name in get_close_matches(kind, all_, 1))
        raise QuestionError(f"--kind: given {kind!r}{near}; must be one of {KINDS}; or all")
    if single:
        check_suffix("--out", out, PICTURE)
        ready_to_write(out)
    folder = out.parent if single else out
    new = not folder.exists()
    given = {"deflection_unit": deflection_unit, "log": log, "time": time, "start": start, "end": end}
    given |= {"frame": frame, "place": place}
    wishes = {name: value for name, value in given.items() if value not in (None, "")} | {"speed_unit": speed_sign()}
    if result.suffix == ".toml":
        _refuse(wishes, ())
        draw: Pictures = {"machine": lambda: ab.plot.machine(result)}
    else:
        draw = drawings(open_run(result), wishes)
    if kind not in ("", "all", "picture", *draw):
        raise QuestionError(f"--kind: given {kind!r}; of {result} there are {', '.join(draw)}")
    further = [name.replace("_", "-") for name, one in PICTURES.items() if one.further]
    usual = tuple(name for name in draw if name not in further)
    chosen = {"": usual, "all": tuple(draw), "picture": usual[:1]}.get(kind, (kind,))
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
