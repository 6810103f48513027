"""The variations of a sweep: machines with other parameters, and how an axis and a message name them."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Event, Lock
from typing import Any, TypeVar

import numpy as np

from autobalancer.assembly.drive_train import unbalance_jumps
from autobalancer.assembly.places import Places, Touch, gauges_of, without_balancing
from autobalancer.assembly.quantities import parameter_range, parameter_unit, si_value, with_parameter, with_value_at
from autobalancer.assembly.system import Assembly
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.kernels.measures.record_series import COLUMN
from autobalancer.kernels.measures.row import judged
from autobalancer.kernels.measures.thresholds import FASTEST, ITERATED
from autobalancer.kernels.measures.workspace import HELD, MeasureInputs
from autobalancer.kernels.system import Floats
from autobalancer.machine import Machine
from autobalancer.machine.part import Part
from autobalancer.machine.path import QUANTITIES, axis_attributes, entry_at, parts_of
from autobalancer.results.time_series import NONE, static_load
from autobalancer.units import argument
from autobalancer.units.quantity import is_range


def with_variation(machine: Machine, variations: Iterable[str], point: tuple[Any, ...]) -> Machine:
    """The machine with the values of ``point`` at the paths or plain names.

    Raises
    ------
    QuestionError
        If there is no such parameter.
    MachineError
        If a value is impossible.
    """
    for path, value in zip(variations, point, strict=True):
        machine = with_parameter(machine, path, float(value) if isinstance(value, np.floating) else value)
    return machine


def listed(machine: Machine, name: str, values: Any) -> Sequence[Any]:
    """A single value of a parameter as a list of one, a range as its values."""
    refuse_of_all(name)
    if is_range(values):
        return [value.item() for value in parameter_range(machine, name, values)]
    return [values] if isinstance(values, str | int | float | Mapping | Part) else values


def refuse_of_all(name: str) -> None:
    """Refuse an entry that is the same for all runs.

    Raises
    ------
    QuestionError
        For the duration.
    """
    if any(part.split(".")[0] == "run" for part in parts_of(name)):
        raise QuestionError(f"{name}: the runs have one duration, which is given beside what varies, as 'duration'")


def variation_text(variations: Iterable[str], point: tuple[Any, ...]) -> str:
    """The begin of a message: ``"variation with rotor.mass = 2, rotor.damping = 10 N*s/m: "``; empty without any."""
    values = ", ".join(f"{path} = {_inner(value)}" for path, value in zip(variations, point, strict=True))
    return f"variation with {values}: " if values else ""


def coordinate(machine: Machine, path: str, values: Sequence[Any]) -> tuple[Any, dict[str, str]]:
    """Values along an axis, with its name and unit: numbers in SI, else texts, of whole parts too."""
    result = [_number(machine, path, value) for value in values]
    if not all(isinstance(value, (int, float, np.number)) for value in result):
        result = [_text(value) for value in result]
    return result, axis_attributes(path) | {"units": _unit(machine, path)}


def _unit(machine: Machine, path: str) -> str:
    """SI unit of a parameter; empty for a name, a number without unit or a whole part."""
    try:
        return parameter_unit(machine, path).replace("*", " ")
    except QuestionError:
        return ""


def _number(machine: Machine, path: str, value: Any) -> Any:
    """The SI number that a text became."""
    if not isinstance(value, str):
        return value
    try:
        if path in QUANTITIES or len(parts_of(path)) > 1:
            return si_value(machine, path, value)
        entry = entry_at(with_value_at(machine, path, value), path)
    except AutobalancerError:  # of a member that is impossible
        return _as_written(machine, path, value)
    return float(entry) if isinstance(entry, float) else entry


def _as_written(machine: Machine, path: str, value: str) -> Any:
    """The SI number that a text would be in a machine where it is possible; else the text."""
    try:
        return argument(path, value, parameter_unit(machine, path))
    except AutobalancerError:
        return value


def _text(value: Any) -> str:
    """A value in one line; a part as ``"law = viscous, damping = 0.001"``."""
    if isinstance(value, Part):
        value = value.model_dump(exclude_unset=True)
    if isinstance(value, Mapping):
        parts = (f"{key} = {_inner(entry)}" for key, entry in value.items())
        return ", ".join(parts)
    if isinstance(value, (list, tuple, np.ndarray)):
        return f"[{', '.join(_inner(entry) for entry in value)}]"
    return f"{value:g}" if isinstance(value, (float, np.floating)) else str(value)


def _inner(value: Any) -> str:
    whole = isinstance(value, (Part, Mapping))
    return f"{{{_text(value)}}}" if whole else _text(value)


# The measures of one run of a sweep, as plain numbers.


def gauges_for(assembly: Assembly, places: Places, end: float, touches: tuple[Touch, ...] = ()) -> MeasureInputs:
    """What the measures of runs of a machine up to ``end`` (s) need; of its ``touches`` those that note impacts."""
    centered = static_load(places.machine) == NONE
    return gauges_of(assembly, places, unbalance_jumps(places.machine, end), touches, centered=centered)


def completed(row: Floats, assembly: Assembly, places: Places, gauges: MeasureInputs) -> Floats:
    """The same row with the vibration without balls of a rotor on softening rubber, which no compiled code finds."""
    known = not np.isnan(row[COLUMN.vibration])
    if gauges.scalars[HELD] == ITERATED and known and abs(row[COLUMN.end_speed]) < FASTEST:
        end, speed = row[COLUMN.end_time], row[COLUMN.end_speed]
        row[COLUMN.vibration_without_balls] = without_balancing(assembly, places, gauges, end, speed)[0].max()
        row[COLUMN.verdict] = judged(row)
    return row


# Many runs at once, their answers in the order of the questions.


Job = TypeVar("Job")
Answer = TypeVar("Answer")


def in_threads(
    work: Callable[[Job], Answer],
    jobs: Sequence[Job],
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    cost: Callable[[Job], float] | None = None,
    stop: Event | None = None,
) -> list[Answer]:
    """Answers of ``work`` to ``jobs``, on ``workers`` threads (by default one for each core).

    ``progress`` is called with (jobs done, jobs in all), by one thread at a time. The jobs of most ``cost`` begin first, so that
    no thread is left with a long one at the end. After an error or Ctrl-C no further job begins, and ``stop`` is set for those
    that run.
    """
    done, told = 0, Lock()

    def one(job: Job) -> Answer:
        nonlocal done
        answer = work(job)
        with told:
            done += 1
            if progress is not None:
                progress(done, len(jobs))
        return answer

    workers = workers if workers is not None else os.cpu_count() or 1
    order = sorted(range(len(jobs)), key=lambda k: -cost(jobs[k])) if cost else range(len(jobs))
    if workers == 1:
        result = {k: one(jobs[k]) for k in order}
        return [result[k] for k in range(len(jobs))]
    with ThreadPoolExecutor(workers) as pool:
        waiting = {k: pool.submit(one, jobs[k]) for k in order}
        try:
            return [waiting[k].result() for k in range(len(jobs))]
        except BaseException:  # Ctrl-C too
            for future in waiting.values():
                future.cancel()
            if stop is not None:
                stop.set()
            raise
