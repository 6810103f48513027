"""The columns of an ensemble: what varies, one number for each member."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.assembly.quantities import parameter_unit
from autobalancer.errors import QuestionError
from autobalancer.files.table import read_table
from autobalancer.kernels.system import Floats, Integers
from autobalancer.machine import Machine
from autobalancer.random_numbers import GREATEST
from autobalancer.studies.variations import listed, refuse_of_all
from autobalancer.units import list_argument
from autobalancer.units.quantity import is_range

SEED = "seed"
STARTS = {"ball_angle": "rad", "ball_speed": "rad/s"}
_START = re.compile(r"(ball_angle|ball_speed)(?:\[(\d+)\])?")
EXAMPLE = "viscosity [mm^2/s], ball_angle[1] [deg]"


@dataclass(frozen=True)
class Columns:
    """What varies; every list has one entry for each of the ``count`` rows."""

    count: int
    parameters: dict[str, Sequence[Any]] = field(default_factory=dict)  # numbers in SI, texts, or whole parts
    starts: dict[str, Floats] = field(default_factory=dict)  # ball_angle[1], ball_speed[2], ball_speed: SI
    seeds: Integers | None = None

    def row(self, number: int) -> tuple[Any, ...]:
        """The parameters of one row."""
        return tuple(values[number] for values in self.parameters.values())


def columns_of(machine: Machine, given: Mapping[str, Any] | str | Path | None) -> Columns:
    """The columns that a user gave, checked as far as that needs no machine for each member.

    Raises
    ------
    QuestionError
        For names that there are not, unequal lengths, seeds or starts that are no numbers.
    """
    if isinstance(given, (str, Path)):
        given = _from_file(machine, Path(given))
    if given is not None and not isinstance(given, Mapping):
        raise QuestionError(
            f"columns: given {type(given).__name__}; must be names with their values, or the path of a table"
        )
    lists = {name: _listed(machine, name, values) for name, values in (given or {}).items()}
    sizes = {name: len(values) for name, values in lists.items()}
    if sizes and min(sizes.values()) == 0:
        raise QuestionError(f"columns: {min(sizes, key=sizes.__getitem__)!r} is empty; give at least one value")
    count = max(sizes.values(), default=1)
    unequal = {name: size for name, size in sizes.items() if size not in (1, count)}
    if unequal:
        raise QuestionError(f"columns: must all have the same length, or a single value; given {sizes}")
    lists = {name: values if len(values) == count else [values[0]] * count for name, values in lists.items()}
    seeds, starts = None, {}
    for name in list(lists):
        if name == SEED:
            seeds = _seeds(lists.pop(name))
        elif kind := _START.fullmatch(name):
            starts[name] = _start(machine, name, kind, lists.pop(name))
        else:
            unit_of_column(machine, name)  # refuses names that are none
    return Columns(count, lists, starts, seeds)


def ball_count(machine: Machine) -> int:
    """All balls of a machine."""
    return sum(race.ball_count for balancer in machine.balancers for race in balancer.races)


def ball_of(name: str) -> tuple[str, int | None]:
    """Kind of a start, and the number of its ball from 0; None: of all balls."""
    found = _START.fullmatch(name)
    assert found is not None
    return found[1], int(found[2]) - 1 if found[2] else None


def _listed(machine: Machine, name: str, values: Any) -> Sequence[Any]:
    """A single value as a list of one, a range as its values."""
    if _START.fullmatch(name) and is_range(values):
        return list_argument(name, values, STARTS[ball_of(name)[0]])
    if name == SEED and is_range(values):
        raise QuestionError(f"columns: 'seed': given {values!r}; give whole numbers, such as range(100)")
    return listed(machine, name, values if not isinstance(values, np.ndarray) else values.tolist())


def _seeds(values: Sequence[Any]) -> Integers:
    for number, value in enumerate(values, start=1):
        if isinstance(value, bool) or not isinstance(value, Integral | float) or not _is_seed(value):
            raise QuestionError(
                f"columns: member {number}, 'seed': given {value!r}; must be a whole number from 0 to {GREATEST}"
            )
    return np.array([int(value) for value in values], np.int64)


def _is_seed(value: Any) -> bool:
    return bool(0 <= value <= GREATEST and value == int(value))


def _start(machine: Machine, name: str, kind: re.Match[str], values: Sequence[Any]) -> Floats:
    balls, all_balls = ball_count(machine), kind[2] is None
    if (all_balls and kind[1] == "ball_angle") or (not all_balls and not 1 <= int(kind[2]) <= balls):
        raise QuestionError(
            f"columns: no start {name!r}; there are ball_angle[1] to ball_angle[{balls}], ball_speed[1] to "
            f"ball_speed[{balls}], and ball_speed for all balls"
        )
    found = np.array(list_argument(name, values, STARTS[kind[1]]), np.float64)
    wrong = np.flatnonzero(~np.isfinite(found))
    if wrong.size:
        raise QuestionError(f"columns: member {wrong[0] + 1}, {name!r}: given {found[wrong[0]]}; must be finite")
    return found


def _from_file(machine: Machine, path: Path) -> dict[str, Any]:
    """Columns of a text file; the head of each is its name and, where it has one, its unit in brackets."""
    table = read_table(path, EXAMPLE, error=QuestionError)
    found: dict[str, Any] = {}
    for name in table.heads:
        written = table.heads[name][1]
        unit = "" if name == SEED else unit_of_column(machine, name)
        texts = table.texts(name)
        if written or (not any(_is_text(text) for text in texts) and not unit):
            found[name] = table.numbers(name, unit)
        elif any(_is_text(text) for text in texts):
            found[name] = texts
        else:
            raise QuestionError(
                f"{path}: column {name!r}: numbers without a unit; write it in the first line, such as {name} [{unit}]"
            )
    return found


def unit_of_column(machine: Machine, name: str) -> str:
    """The SI unit of a column; empty for plain numbers."""
    refuse_of_all(name)
    kind = _START.fullmatch(name)
    return STARTS[kind[1]] if kind else parameter_unit(machine, name)


def _is_text(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return True
    return False


def is_start(name: str) -> bool:
    """Whether a column is a start of a ball, not a parameter of the machine."""
    return _START.fullmatch(name) is not None
