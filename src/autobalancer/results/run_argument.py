"""Runs and results as pictures are given them: in memory, or as the path of a file; and what is said of anything else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import cast

import xarray as xr

from autobalancer.errors import QuestionError, ResultError
from autobalancer.machine.part import Part
from autobalancer.machine_kinds import CHAMBERS, RACES, Kind, machine_kind
from autobalancer.results.archive import Archive, RunFolder
from autobalancer.results.folder_store import has_note
from autobalancer.results.store import load_run
from autobalancer.safe_file import as_path

RunArgument = xr.Dataset | str | Path
TIMES = ("time", "envelope_time", "turn_time")
PICTURES = {
    RACES.words: "plot.run_up, race, orbit, impacts and drive_train",
    CHAMBERS.words: "plot.chamber_run, chamber_energy, chamber_collisions, chamber_arrangement and chamber_bearing_forces",
}


def load_race_run(argument: RunArgument, text: str) -> xr.Dataset:
    """The run of balls in races, opened if ``argument`` is a path; ``text`` is the public name of the function.

    Raises
    ------
    QuestionError
        If it is no run, or one of deep chambers.
    ResultError
        If there is no such file, or it cannot be read.
    """
    return _of_kind(_run(argument, text), text, RACES)


def load_chamber_run(argument: RunArgument, text: str) -> xr.Dataset:
    """The run of deep chambers, opened if ``argument`` is a path; raises as :func:`load_race_run`."""
    return _of_kind(_run(argument, text), text, CHAMBERS)


def _of_kind(run: xr.Dataset, text: str, kind: Kind) -> xr.Dataset:
    found = machine_kind(run)
    if found is not kind:
        raise QuestionError(
            f"{text}: given a run of {found.words}; it draws {kind.words}. There are {PICTURES[found.words]}"
        )
    return run


def result(argument: RunArgument, text: str, of: str, holds: Callable[[xr.Dataset], bool]) -> xr.Dataset:
    """A result of the function with the public name ``of``, opened if ``argument`` is a path.

    Parameters
    ----------
    argument
        Dataset, or path of its file.
    text
        Public name of the function that was asked.
    of
        Public name of the function whose results it takes.
    holds
        Whether a dataset is such a result.

    Raises
    ------
    QuestionError
        If it is something else.
    ResultError
        If there is no such file, or it cannot be read.
    """
    opened = _opened(argument, text, f"a result of {of}")
    if not holds(opened):
        what = "a run" if is_run(opened) else "another result"
        raise QuestionError(f"{text}: given {what}; this is not a result of {of}, which it draws")
    return opened


def refusal(thing: object, text: str, wanted: str) -> QuestionError:
    """What is said where a picture is given something that it does not draw."""
    what = "a machine" if isinstance(thing, Part) else f"a {type(thing).__name__}"
    return QuestionError(f"{text}: given {what}; it draws {wanted}")


def _run(argument: RunArgument, text: str) -> xr.Dataset:
    run = _opened(argument, text, f"a run, as in ab.{text}(ab.simulate(machine))")
    if not is_run(run):
        raise QuestionError(f"{text}: given a result that is no run; it draws a run of simulate, or one from load_run")
    return run


def _opened(argument: RunArgument, text: str, wanted: str) -> xr.Dataset:
    if isinstance(argument, str | Path):
        return open_run(argument)
    thing = cast("object", argument)
    if not isinstance(thing, xr.Dataset):
        raise refusal(thing, text, wanted)
    return thing


def is_run(dataset: xr.Dataset) -> bool:
    return "outcome" in dataset.attrs or any(name in dataset.coords for name in TIMES)


# Results wherever they are: a file, or a run in an archive.


def open_run(path: str | Path) -> xr.Dataset:
    """A result file read into memory, or the folder of a run in an archive, whose samples are read when used.

    Raises
    ------
    ResultError
        If there is neither, or it cannot be read. For the folder of a whole archive it names the runs.
    """
    path = as_path(path)
    if not path.is_dir():
        return load_run(path)
    if not has_note(path):
        names = Archive(path).names()
        runs = f"an archive; choose one of its runs: {', '.join(str(path / name) for name in names)}"
        raise ResultError(f"{path}: is {runs if names else 'a folder without a run in it'}")
    return RunFolder(path).samples()
