"""Functions of a run that are asked of something else say what they want."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.machine.part import Part
from autobalancer.results.chamber.shape import is_chamber_run
from autobalancer.units import shortened

Arguments = ParamSpec("Arguments")
Answer = TypeVar("Answer")
RUNS, CHAMBER_RUNS = "simulate", "simulate_chamber"


def of_a_run(
    *, runs: str = RUNS, of_machine: str = "", called: str = ""
) -> Callable[[Callable[Arguments, Answer]], Callable[Arguments, Answer]]:
    """Refuse a first argument that is no run, with a :class:`QuestionError`.

    Parameters
    ----------
    runs
        The function that gives such runs.
    of_machine
        What to call where a machine is given and its own answer is wanted.
    called
        The public function that asks, by default of the same name.
    """

    def checked(function: Callable[Arguments, Answer]) -> Callable[Arguments, Answer]:
        name = called or function.__name__

        @wraps(function)
        def asked(*arguments: Arguments.args, **named: Arguments.kwargs) -> Answer:
            run = arguments[0] if arguments else named.get("run")
            if (arguments or "run" in named) and not isinstance(run, xr.Dataset):
                raise QuestionError(_wanted(name, run, runs, of_machine))
            if isinstance(run, xr.Dataset):
                _refuse_other_kind(name, run, runs)
            return function(*arguments, **named)

        return asked

    return checked


def _refuse_other_kind(name: str, run: xr.Dataset, runs: str) -> None:
    if is_chamber_run(run) != (runs == CHAMBER_RUNS):
        given, wanted = ("deep chambers", "balls in races") if runs == RUNS else ("balls in races", "deep chambers")
        raise QuestionError(f"{name}: given a run of {given}, or a result that is no run; this is for {wanted}")
    if "machine" not in run.attrs:
        raise QuestionError(f"{name}: the run has lost its attributes, such as its machine; give it as it was computed")


def _wanted(name: str, given: object, runs: str, of_machine: str) -> str:
    if isinstance(given, Part):
        of_it = f"; of the machine itself ask {of_machine}" if of_machine else ""
        return f"{name}: given a machine; it measures a run, as in ab.{name}(ab.{runs}(machine)){of_it}"
    if isinstance(given, (str, Path)):
        return f"{name}: given {shortened(str(given))}; it measures a run, as in ab.{name}(ab.load_run('run.nc'))"
    return f"{name}: given a {type(given).__name__}; it measures a run of {runs}, or one from load_run"
