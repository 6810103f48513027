"""The numbers of a machine as one block of memory, and what a parameter of the machine file changes in them."""

from __future__ import annotations

import itertools
import math
import struct
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from autobalancer.errors import AutobalancerError
from autobalancer.kernels.system import Floats
from autobalancer.machine import Machine
from autobalancer.machine.path import bounds_at, entry_at, label_of_path, parameter_paths, unit_at, with_entry
from autobalancer.results.labels import Variable

WORD, LINE = 8, 64  # bytes of a word, and to whose multiples arrays begin
ROUNDING = 1e-14
ARRAY = 5  # words of an array before its shape: owner, parent, count, bytes of one, address


class Image:
    """Named tuples as one block of memory: words, and which of them are addresses, counted from its begin in bytes."""

    def __init__(self, **parts: Any) -> None:
        self.starts: dict[str, int] = {}  # of each tuple, number or array: the word where it stands
        self.data: dict[str, int] = {}  # of each array: the word where its numbers begin
        self.addresses: list[int] = []
        self.floats: set[int] = set()
        self._words: list[int] = []
        self._plain: list[tuple[int, int]] = []  # begin and count of arrays of floats
        self._arrays: list[tuple[str, int, np.ndarray]] = []
        for name, part in parts.items():
            self._add(name, part)
        known: dict[tuple[int, int], int] = {}  # two memories may share an array
        for name, at, array in self._arrays:
            place = (array.__array_interface__["data"][0], array.nbytes)
            if array.nbytes == 0 or place not in known:
                self._words += [0] * (-len(self._words) % (LINE // WORD))
                known[place] = len(self._words)
                self._copy(array)
            self._words[at], self.data[name] = known[place] * WORD, known[place]
        self.words = np.array(self._words, np.int64)
        # what is rounding, beside the other numbers of an array
        self.noise = np.zeros(self.words.size)
        for begin, count in self._plain:
            numbers = np.abs(self.values[begin : begin + count])
            self.noise[begin : begin + count] = ROUNDING * numbers[np.isfinite(numbers)].max(initial=0.0)

    def _add(self, name: str, value: Any) -> None:
        self.starts[name] = len(self._words)
        if isinstance(value, tuple):
            names = getattr(value, "_fields", range(len(value)))
            for field, part in zip(names, value, strict=True):
                self._add(f"{name}.{field}", part)
        elif isinstance(value, np.ndarray):
            kept = np.ascontiguousarray(value)
            self.addresses.append(len(self._words) + ARRAY - 1)
            self._arrays.append((name, self.addresses[-1], kept))
            self._words += [0, 0, kept.size, kept.itemsize, 0, *kept.shape, *kept.strides]
        elif isinstance(value, float):
            self.floats.add(len(self._words))
            self._words.append(struct.unpack("q", struct.pack("d", value))[0])
        else:
            self._words.append(int(value))

    def _copy(self, array: np.ndarray) -> None:
        """Its numbers as words, and which of them are floats."""
        begin, rows = len(self._words), array.reshape(-1)
        self._words += np.frombuffer(rows.tobytes().ljust(-(-rows.nbytes // WORD) * WORD, b"\0"), np.int64).tolist()
        fields = array.dtype.fields
        if fields is None:
            if array.dtype.kind in "fc":
                self.floats.update(range(begin, len(self._words)))
                self._plain.append((begin, len(self._words) - begin))
            return
        each = array.itemsize // WORD
        for kind, offset, *_ in fields.values():
            first = offset // WORD
            if kind.base.kind == "f":
                places = range(first, first + kind.itemsize // WORD)
                self.floats.update(begin + row * each + place for row in range(rows.size) for place in places)

    @property
    def values(self) -> Floats:
        """All words as if they were floats."""
        return self.words.view(np.float64)


# What a parameter changes in the numbers of a machine.
#
# A word of the block is  w = w0 + sum over groups of A (product of f_p(v / v0) - 1),  with one group for parameters that
# multiply each other, as mass and radius do in m r^2, and f_p(1) = 1. The f_p are polynomials through changed machines: of a low
# degree they hold for any value, of a higher one within RANGE, as of 1 / m. Parameters of which that is not true, or which change
# the kind of the equations, are fixed.


RANGE = (0.8, 1.25)  # of the value in the machine file
LOW, HIGHEST = 3, 12  # degrees
NODES = 14
EXACT = 1e-11  # relative to the word
TOGETHER = 1e-8  # the same where all parameters have changed at once
_MIDDLE, _HALF = 0.5 * (RANGE[0] + RANGE[1]), 0.5 * (RANGE[1] - RANGE[0])
FACTORS = tuple((_MIDDLE + _HALF * np.cos(np.pi * (np.arange(NODES) + 0.5) / NODES)).tolist())
FEW = FACTORS[::3]  # enough for a low degree
# tolerances are those of the machine as it was written; measures of a whole run are not in the library
_NOT_IN_STEPS = (
    "whirls", "mass", "gyroscopic", "model_speeds", "model_damping", "model_stiffness", "held_stiffness", "held_damping",
    "held_loads", "capability", "meetings", "rebounds",
)  # fmt: skip
RANGE_SCALE = 0.25
UNDECIDED = ("memory.absolute", "memory.relative", *(f"inputs.{name}" for name in _NOT_IN_STEPS))


class Term(NamedTuple):
    """What parameters do to a word: amplitude, and for each its number and the coefficients of f_p in v / v0 - 1."""

    word: int
    amplitude: float
    factors: tuple[tuple[int, tuple[float, ...]], ...]


def length_of(image: Image, name: str) -> int:
    """Words of an array."""
    count, size = image.words[image.starts[name] + 2 : image.starts[name] + 4]
    return int(count * size) // WORD


class Known(NamedTuple):
    """Parameters, what they change, and the paths of the numbers that are fixed."""

    parameters: tuple[Variable, ...]
    terms: tuple[Term, ...]
    fixed: tuple[str, ...]


def parameters_of(
    machine: Machine,
    image_of: Callable[[Machine], Image],
    within: tuple[str, ...] = ("",),
    beyond: tuple[str, ...] = (),
) -> Known:
    """Which numbers of a machine may be changed in its block, which ``image_of`` makes.

    Paths begin with one of ``within``, and with none of ``beyond``.
    """
    base = image_of(machine)
    ignored = {
        word
        for name in UNDECIDED
        if name in base.data
        for word in range(base.data[name], base.data[name] + length_of(base, name))
    }

    @cache
    def changed(*values: tuple[str, float]) -> dict[int, float] | None:
        """Words with their changes where these numbers have other values; None if that is another kind of machine."""
        try:
            other = machine
            for path, value in values:
                other = with_entry(other, path, value)
            block = image_of(other)
        except AutobalancerError:
            return None
        if block.words.size != base.words.size or block.addresses != base.addresses:
            return None
        words = np.flatnonzero(block.words != base.words).tolist()
        if any(word not in base.floats and word not in ignored for word in words):
            return None
        return {word: float(block.values[word] - base.values[word]) for word in words if word not in ignored}

    # each by itself
    found: list[tuple[Variable, dict[int, tuple[float, ...]]]] = []
    fixed: list[str] = []
    for path in parameter_paths(machine):
        value = entry_at(machine, path)
        if (
            not path.startswith(within)
            or path.startswith(beyond)
            or not isinstance(value, float)
            or value == 0.0
            or not math.isfinite(value)
        ):
            continue
        shapes: dict[int, tuple[float, ...] | None] = {}
        for factors, highest in ((FEW, LOW), (FACTORS, HIGHEST)):  # most need no more than a few
            moved = [changed((path, value * factor)) for factor in factors]
            kept = [m for m in moved if m is not None]
            words = sorted(set().union(*kept))
            shapes = {
                word: _polynomial(
                    factors, [m.get(word, 0.0) for m in kept], base.values[word], base.noise[word], highest
                )
                for word in (words if len(kept) == len(moved) else [-1])
            }
            if None not in shapes.values() or len(kept) < len(moved):
                break
        if None in shapes.values():
            fixed.append(path)
            continue
        if not shapes:
            continue  # of the run or of a remark, not of the equations
        kept_shapes = {word: shape for word, shape in shapes.items() if shape is not None}
        least, greatest = bounds_at(path)
        if max(map(len, kept_shapes.values())) > LOW:
            low, high = sorted(factor * value for factor in RANGE)
            least, greatest = max(least, low), min(greatest, high)
        about = Variable(path, unit_at(path), label_of_path(path), value, least, greatest)
        found.append((about, kept_shapes))
    # together: those that do not keep to it are fixed, first what changes a word by the highest degree
    while True:
        terms = _terms(found, changed)
        wrong = _wrong(found, terms, base, changed)
        if wrong is None:
            return Known(tuple(about for about, _ in found), terms, tuple(fixed))
        fixed.append(found.pop(wrong)[0].name)


def _polynomial(
    factors: Sequence[float], changes: Sequence[float], value: float, noise: float, highest: int
) -> tuple[float, ...] | None:
    """Coefficients of (v / v0 - 1), its square, ... of the lowest degree that gives these changes; None if none does."""
    if len(changes) < len(factors) or not np.isfinite(changes).all():
        return None
    x, y = (np.array(factors) - 1.0) / RANGE_SCALE, np.array(changes)
    for degree in range(1, highest + 1):
        powers = x[:, None] ** np.arange(1, degree + 1)
        coefficients = np.linalg.lstsq(powers, y, rcond=None)[0]
        if np.abs(powers @ coefficients - y).max() <= max(noise, EXACT * max(abs(value), float(np.abs(y).max()))):
            return tuple((coefficients / RANGE_SCALE ** np.arange(1, degree + 1)).tolist())
    return None


def _terms(found: list[tuple[Variable, dict[int, tuple[float, ...]]]], changed: Any) -> tuple[Term, ...]:
    """All terms: parameters of a word are in one group where both at once change it by more than each alone."""
    groups: dict[int, list[tuple[float, list[int]]]] = {}  # amplitude, parameters
    step = FACTORS[0] - 1.0
    users: dict[int, list[int]] = {}
    for number, (_, shapes) in enumerate(found):
        for word in shapes:
            users.setdefault(word, []).append(number)
    pairs = {pair for numbers in users.values() for pair in itertools.combinations(numbers, 2)}
    mixed = {
        pair: changed(*((found[one][0].name, found[one][0].start * FACTORS[0]) for one in pair)) or {} for pair in pairs
    }

    def alone(number: int, word: int) -> float:
        return float(sum(c * step ** (k + 1) for k, c in enumerate(found[number][1][word])))

    for word, numbers in users.items():
        rest = list(numbers)
        groups[word] = []
        while rest:
            group, amplitude = [rest.pop(0)], 0.0
            for other in list(rest):
                one, two = alone(group[0], word), alone(other, word)
                more = mixed[group[0], other].get(word, 0.0) - one - two
                if abs(more) > 1e-9 * max(abs(one), abs(two)) and abs(more) > 0.0:
                    amplitude = one * two / more
                    group.append(other)
                    rest.remove(other)
            groups[word].append((amplitude or 1.0, group))
    return tuple(
        Term(word, amplitude, tuple((n, tuple(c / amplitude for c in found[n][1][word])) for n in group))
        for word, each in groups.items()
        for amplitude, group in each
    )


def _wrong(
    found: list[tuple[Variable, dict[int, tuple[float, ...]]]], terms: Sequence[Term], base: Image, changed: Any
) -> int | None:
    """The number of a parameter to leave out, if other values of all at once are not what the terms say."""
    draw = np.random.default_rng(0)
    for _ in range(3):
        factors = 1.0 + draw.uniform(-0.05, 0.05, len(found))
        truth = changed(*((about.name, about.start * float(f)) for (about, _), f in zip(found, factors, strict=True)))
        if truth is None:
            return len(found) - 1
        said: dict[int, float] = {}
        for term in terms:
            said[term.word] = said.get(term.word, 0.0) + change_by(term, factors)
        for word in set(truth) | set(said):
            miss = abs(truth.get(word, 0.0) - said.get(word, 0.0))
            if miss > max(base.noise[word], TOGETHER * max(abs(base.values[word]), abs(truth.get(word, 0.0)))):
                return max(
                    (n for n, (_, shapes) in enumerate(found) if word in shapes), key=lambda n: len(found[n][1][word])
                )
    return None


def change_by(term: Term, factors: Sequence[float] | Floats) -> float:
    """By how much a term changes its word where each parameter is its value times a factor."""
    product = 1.0
    for number, coefficients in term.factors:
        x = float(factors[number]) - 1.0
        product *= 1.0 + sum(c * x ** (k + 1) for k, c in enumerate(coefficients))
    return term.amplitude * (product - 1.0)
