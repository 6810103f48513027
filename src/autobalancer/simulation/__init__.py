"""Run a machine in time: the options that all functions share which do so."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from numbers import Integral
from typing import TYPE_CHECKING, Literal, TypedDict, TypeVar, cast

from autobalancer.errors import QuestionError
from autobalancer.machine_kinds import arguments_of, machine_kind
from autobalancer.units import argument

if TYPE_CHECKING:
    import xarray as xr

    from autobalancer.machine import Machine
    from autobalancer.machine.chamber import ChamberMachine

Method = Literal["auto", "dormand_prince_8", "tsitouras", "exponential_collocation"]
Options = TypeVar("Options", bound=Mapping[str, object])


class RunOptions(TypedDict, total=False):
    """How a run is integrated.

    Parameters
    ----------
    tolerance
        Local error per step, relative to the deflection and absolute in rad for angles.
    method
        ``dormand_prince_8``, the Dormand-Prince pair of order eight; ``tsitouras``, 5(4); ``exponential_collocation``, long steps
        with the pair of order eight where it gets further, refused where they are not possible; ``auto`` chooses, and takes the
        pair for tolerances below 1e-11. Deep chambers have ``verlet`` and ``runge_kutta``.
    max_steps
        Number of steps after which a run stops with the outcome ``budget spent``.
    """

    tolerance: float
    method: Literal[Method, "verlet", "runge_kutta"]
    max_steps: int


class ManyRunOptions(RunOptions, total=False):
    """How many runs are integrated.

    Parameters
    ----------
    seed
        For the start positions of balls that have none.
    workers
        Threads; by default one for each core. The result does not depend on it.
    progress
        Called with (runs done, runs in all).
    keep_on_interrupt
        If true, Ctrl-C returns what is done.
    """

    seed: int
    workers: int | None
    progress: Callable[[int, int], None] | Literal[False] | None
    keep_on_interrupt: bool


class SteppedOptions(ManyRunOptions, total=False):
    """How a machine is measured speed by speed.

    Parameters
    ----------
    without_balls
        Whether all speeds are measured once more with the balls spread evenly and held.
    """

    without_balls: bool


ONE_RUN: RunOptions = {"tolerance": 1e-8, "method": "auto", "max_steps": 100_000_000}
MANY_RUNS: ManyRunOptions = {
    "tolerance": 1e-7,
    "method": "auto",
    "max_steps": 10_000_000,
    "seed": 0,
    "workers": None,
    "progress": None,
    "keep_on_interrupt": False,
}


STEPPED: SteppedOptions = {"without_balls": False}


def run_options(function: str, given: Options, defaults: Options) -> Options:
    """The options of a ``function``: those ``given``, of the others the ``defaults``.

    Raises
    ------
    QuestionError
        For a tolerance outside [1e-13, 1e-2], or steps or workers that are no whole number from 1.
    TypeError
        For an option that there is not.
    """
    for name in given:
        if name not in defaults:
            raise TypeError(
                f"{function}() got an unexpected keyword argument {name!r}; there are {', '.join(defaults)}"
            )
    whole = {**defaults, **given}
    tolerance = whole["tolerance"] = argument("tolerance", whole["tolerance"], "")
    if not 1e-13 <= tolerance <= 1e-2:
        start = f"{defaults['tolerance']:g} is a good start"
        raise QuestionError(f"tolerance: given {tolerance:g}; must be between 1e-13 and 1e-2, {start}")
    refuse_no_counts(max_steps=whole["max_steps"], workers=whole.get("workers"))
    return cast(Options, whole)


def run_duration(machine: Machine, duration: float | str | None) -> float:
    """How long a machine is run (s): ``duration``, by default its own.

    Raises
    ------
    QuestionError
        Without either, or for a time that is not above zero.
    """
    if duration is None:
        if machine.run is None:
            raise QuestionError("duration: the machine has no 'run.duration'; give one here")
        return float(machine.run.duration)
    seconds = argument("duration", duration, "s")
    if not 0.0 < seconds < math.inf:
        raise QuestionError(f"duration: given {duration!r}; must be a time greater than zero, in seconds")
    return seconds


def refuse_no_counts(**numbers: object) -> None:
    """Refuse what is neither ``None`` nor a whole number from 1.

    Raises
    ------
    QuestionError
        With its name.
    """
    for name, number in numbers.items():
        if number is not None and (isinstance(number, bool) or not isinstance(number, Integral) or number < 1):
            raise QuestionError(f"{name}: given {number!r}; must be a whole number from 1")


# The same machine without balancing, beside a run.


def simulated(machine: Machine | ChamberMachine, wished: Mapping[str, object]) -> xr.Dataset:
    """A run of a ``machine`` of any kind, with those of the ``wished`` options that its kind has."""
    simulate = machine_kind(machine)["simulate"]
    known = arguments_of(simulate)
    run: xr.Dataset = simulate(machine, progress=False, **{name: wished[name] for name in wished if name in known})
    return run


def held_run(
    machine: Machine | ChamberMachine, run: xr.Dataset, wished: Mapping[str, object] | None = None
) -> xr.Dataset | None:
    """The run of the same ``machine`` with its balls held, by which a verdict judges the way of a ``run``; ``wished`` as above.

    ``None`` if it has no balls, or did not finish.
    """
    from autobalancer.simulation.record import Envelope, LastRevolutions

    if run.attrs.get("outcome") != "finished" or not run.sizes.get("ball", 0):
        return None
    end = float(run.attrs["end_time"] if "end_time" in run.attrs else run.attrs["duration"])
    save = [Envelope(), LastRevolutions()]
    return simulated(machine, {"save": save, **(wished or {}), "hold_balls": True, "duration": end})
