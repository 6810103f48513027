"""Free parameters: entries of a machine that a fit may change, alone or tied together."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

from autobalancer.assembly.quantities import parameter_of, with_value_at
from autobalancer.errors import QuestionError, UnitError
from autobalancer.machine import Machine
from autobalancer.machine.path import unit_at
from autobalancer.units import shortened
from autobalancer.units.quantity import argument

Tie = Literal["value", "factor", "offset"]
Bounds = tuple[float, float]
DECADE = 10.0  # bounds of one sign further apart than this are searched by equal ratios


@dataclass(frozen=True)
class FreeParameter:
    """One unknown of a fit.

    Parameters
    ----------
    paths
        Path of an entry, as for :func:`~autobalancer.assembly.quantities.with_value_at`, or several tied paths.
    lower, upper
        Bounds in SI, or texts with a unit.
    tie
        What is free: the ``value`` of all entries, a ``factor`` on their values in the machine, or an ``offset`` added
        to them.
    name
        Name in results; by default the first path.
    start
        Start value of the fit; by default that of the machine (the first path), 1 for a factor, 0 for an offset.
    """

    paths: str | Sequence[str]
    lower: float | str = -math.inf
    upper: float | str = math.inf
    tie: Tie = "value"
    name: str = ""
    start: float | str | None = None

    @property
    def first(self) -> str:
        """The first path."""
        return self.paths if isinstance(self.paths, str) else next(iter(self.paths), "")


@dataclass(frozen=True)
class Unknown:
    """A free parameter read against its machine: everything a number, in SI."""

    name: str
    paths: tuple[str, ...]
    tie: Tie
    origins: tuple[float, ...]  # of the entries
    lower: float
    upper: float
    start: float
    scale: float  # of one step of the search variable; 0 where it is a logarithm
    unit: str

    def inner(self, value: float) -> float:
        """The search variable of a value."""
        return math.log(abs(value)) if self.scale == 0.0 else value / self.scale

    def outer(self, variable: float) -> float:
        """The value of a search variable."""
        value = math.copysign(math.exp(variable), self.start) if self.scale == 0.0 else variable * self.scale
        return min(max(value, self.lower), self.upper)

    @property
    def inner_bounds(self) -> tuple[float, float]:
        """Bounds of the search variable, ascending."""
        low, high = sorted((self.inner(self.lower), self.inner(self.upper)))
        return low, high

    def slope(self, value: float) -> float:
        """d value / d variable."""
        return value if self.scale == 0.0 else self.scale

    def applied(self, machine: Machine, value: float) -> Machine:
        """The machine with this value."""
        for path, origin in zip(self.paths, self.origins, strict=True):
            entry = {"value": value, "factor": origin * value, "offset": origin + value}[self.tie]
            machine = with_value_at(machine, path, entry)
        return machine


def unknowns(machine: Machine, free: Any) -> list[Unknown]:
    """Read free parameters: :class:`FreeParameter` entries, or a mapping from paths to (lower, upper).

    Raises
    ------
    QuestionError
        If there is none, a path does not lead to a number, bounds do not ascend or leave out the start, or an entry is
        free twice.
    """
    if isinstance(free, Mapping):
        free = [FreeParameter(path, *bounds) for path, bounds in free.items()]
    unknowns = [_read(machine, entry) for entry in free]
    if not unknowns:
        raise QuestionError("identify: free: given none; name at least one parameter")
    for kind, given in (("name", [u.name for u in unknowns]), ("path", [p for u in unknowns for p in u.paths])):
        twice = sorted({entry for entry in given if given.count(entry) > 1})
        if twice:
            raise QuestionError(f"identify: free: {kind} {twice[0]!r} is given twice; an entry has one unknown only")
    return unknowns


def _read(machine: Machine, free: FreeParameter) -> Unknown:
    single = isinstance(free.paths, str) or not isinstance(free.paths, Iterable)
    paths: tuple[Any, ...] = (free.paths,) if single else tuple(free.paths)
    if not paths:
        raise QuestionError("identify: free: a parameter has no path; give at least one")
    if not all(isinstance(path, str) for path in paths):
        raise QuestionError(
            f"identify: free: paths: given {shortened(list(paths))}; must be texts such as 'rotor.damping'"
        )
    name = free.name or paths[0]
    if free.tie not in get_args(Tie):
        raise QuestionError(f"identify: {name}: tie: given {free.tie!r}; must be one of {', '.join(get_args(Tie))}")
    origins = tuple(parameter_of(machine, path) for path in paths)
    unit = "" if free.tie == "factor" else unit_at(paths[0])
    lower, upper = (_number(value, unit, name) for value in (free.lower, free.upper))
    default = {"value": origins[0], "factor": 1.0, "offset": 0.0}[free.tie]
    start = default if free.start is None else _number(free.start, unit, name)
    if not lower < upper:
        raise QuestionError(f"identify: {name}: bounds: given {lower:g} to {upper:g} {unit}; must ascend")
    if not lower <= start <= upper:
        raise QuestionError(
            f"identify: {name}: the start {start:g} {unit} is outside the bounds {lower:g} to {upper:g}; "
            "widen them, or give another 'start'"
        )
    return Unknown(
        name, paths, free.tie, origins, lower, upper, start, _scale(lower, upper, start, origins[0], name), unit
    )


def _scale(lower: float, upper: float, start: float, origin: float, name: str) -> float:
    near, far = sorted((abs(lower), abs(upper)))
    if lower * upper > 0.0 and math.isfinite(far) and far > DECADE * near:
        return 0.0
    width = upper - lower
    size = abs(start) or (0.5 * width if math.isfinite(width) else abs(origin))
    if size == 0.0:
        raise QuestionError(f"identify: {name}: it starts at zero and has no bounds; give bounds, or a 'start'")
    return min(size, width) if math.isfinite(width) else size


def _number(value: float | str, unit: str, name: str) -> float:
    try:
        number = argument(f"identify: {name}", value, unit)
    except UnitError as reason:
        raise QuestionError(str(reason)) from None
    if math.isnan(number):
        raise QuestionError(f"identify: {name}: given nan; give a number")
    return number
