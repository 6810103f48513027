"""Runs and results as pictures are given them: in memory, or as the path of a file; and what is said of anything else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import cast

import xarray as xr

from autobalancer.errors import QuestionError, ResultError
from autobalancer.machine.part import Part
from autobalancer.results.archive import Archive, RunFolder
from autobalancer.results.chamber_shape import is_chamber_run
from autobalancer.results.folder_store import has_note
from autobalancer.results.store import load_run
from autobalancer.safe_file import as_path

Given = xr.Dataset | str | Path
OF_CHAMBERS = "plot.chamber_run, chamber_energy, chamber_collisions, chamber_arrangement and chamber_bearing_forces"
TIMES = ("time", "envelope_time", "turn_time")
OF_RACES = "plot.run_up, race, orbit, impacts and drive_train"


def given_race_run(given: Given, asked: str) -> xr.Dataset:
    """The run of balls in races, opened if ``given`` is a path; ``asked`` is the public name of the function.

    Raises
    ------
    QuestionError
        If it is no run, or one of deep chambers.
    ResultError
        If there is no such file, or it cannot be read.
    """
    run = _run(given, asked)
    if is_chamber_run(run):
        raise QuestionError(f"{asked}: given a run of deep chambers; it draws balls in races. There are {OF_CHAMBERS}")
    return run


def given_chamber_run(given: Given, asked: str) -> xr.Dataset:
    """The run of deep chambers, opened if ``given`` is a path; raises as :func:`given_race_run`."""
    run = _run(given, asked)
    if not is_chamber_run(run):
        raise QuestionError(f"{asked}: given a run of balls in races; it draws deep chambers. There are {OF_RACES}")
    return run


def result(given: Given, asked: str, of: str, holds: Callable[[xr.Dataset], bool]) -> xr.Dataset:
    """A result of the function with the public name ``of``, opened if ``given`` is a path.

    Parameters
    ----------
    given
        Dataset, or path of its file.
    asked
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
    found = _opened(given, asked, f"a result of {of}")
    if not holds(found):
        what = "a run" if _is_run(found) else "another result"
        raise QuestionError(f"{asked}: given {what}; this is not a result of {of}, which it draws")
    return found


def refusal(thing: object, asked: str, wanted: str) -> QuestionError:
    """What is said where a picture is given something that it does not draw."""
    what = "a machine" if isinstance(thing, Part) else f"a {type(thing).__name__}"
    return QuestionError(f"{asked}: given {what}; it draws {wanted}")


def _run(given: Given, asked: str) -> xr.Dataset:
    run = _opened(given, asked, f"a run, as in ab.{asked}(ab.simulate(machine))")
    if not _is_run(run):
        raise QuestionError(f"{asked}: given a result that is no run; it draws a run of simulate, or one from load_run")
    return run


def _opened(given: Given, asked: str, wanted: str) -> xr.Dataset:
    if isinstance(given, str | Path):
        return open_run(given)
    thing = cast("object", given)
    if not isinstance(thing, xr.Dataset):
        raise refusal(thing, asked, wanted)
    return thing


def _is_run(found: xr.Dataset) -> bool:
    return "outcome" in found.attrs or any(name in found.coords for name in TIMES)


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
