"""What a study asks: the machine, what varies and how, how many draws, what is wanted, when to stop."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache
from itertools import product
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import bdtr, ndtr, ndtri

from autobalancer.assembly.quantities import with_value_at
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.measures.columns import END, STATUS, VERDICT
from autobalancer.kernels.measures.limits import NO_VERDICT
from autobalancer.machine import Machine
from autobalancer.machine.part import unknown_key
from autobalancer.random_numbers import generator
from autobalancer.results.recorded import SETTLING_FROM
from autobalancer.results.shares import Z, wilson_interval
from autobalancer.results.verdict import BALANCED, WORDS
from autobalancer.studies.ensemble.columns import Columns
from autobalancer.studies.ensemble.execute import Ran, run_groups
from autobalancer.studies.ensemble.layout import Groups
from autobalancer.studies.ensemble.layout import Plan as IntegrationPlan
from autobalancer.studies.ensemble.members import Members
from autobalancer.units import argument, shortened

# How a parameter scatters: values from numbers between 0 and 1, so that every plan of samples serves every
# distribution.


Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Distribution:
    """One parameter that scatters. ``word`` is what a study file calls it."""

    word: ClassVar[str] = ""
    needs: ClassVar[tuple[str, ...]] = ()
    may: ClassVar[tuple[str, ...]] = ()

    def at(self, share: Floats) -> Any:
        """Values below which such shares of all values lie; numbers in SI, or texts.

        Parameters
        ----------
        share
            Numbers between 0 and 1, (draws,).
        """
        raise NotImplementedError

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        return ""

    def __str__(self) -> str:
        """In words, SI: ``normal: mean 12, standard deviation 0.5``."""
        given = [(each.name, getattr(self, each.name)) for each in fields(self)]
        told = [f"{name.replace('_', ' ')} {_told(value)}" for name, value in given if _is_limit(value)]
        return f"{self.word}: {', '.join(told)}"


def _is_limit(value: Any) -> bool:
    """Whether it says anything: neither an infinite bound nor an empty list."""
    return value != () and not (isinstance(value, float) and math.isinf(value))


def _told(value: Any) -> str:
    if isinstance(value, tuple):
        return " / ".join(map(_told, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


@dataclass(frozen=True)
class Normal(Distribution):
    """Normal, between ``low`` and ``high`` where they are given."""

    word = "normal"
    needs = ("mean", "standard_deviation")
    may = ("low", "high")

    mean: float
    standard_deviation: float
    low: float = -math.inf
    high: float = math.inf

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        begin, end = (ndtr((limit - self.mean) / self.standard_deviation) for limit in (self.low, self.high))
        found = self.mean + self.standard_deviation * ndtri(begin + (end - begin) * share)
        return np.asarray(np.clip(found, self.low, self.high))

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        if not self.standard_deviation > 0.0:
            return "standard_deviation must be greater than zero"
        if not self.low < self.high:
            return "low must be below high"
        inside = ndtr((self.high - self.mean) / self.standard_deviation) - ndtr(
            (self.low - self.mean) / self.standard_deviation
        )
        return "" if inside > 1e-9 else "nothing of it lies between low and high"


@dataclass(frozen=True)
class Uniform(Distribution):
    """Every value between ``low`` and ``high`` alike."""

    word = "uniform"
    needs = ("low", "high")

    low: float
    high: float

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        return self.low + (self.high - self.low) * share

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        return "" if self.low < self.high else "low must be below high"


@dataclass(frozen=True)
class LogNormal(Distribution):
    """Normal in its logarithm: 68 % of the values lie between ``median / factor`` and ``median * factor``."""

    word = "log-normal"
    needs = ("median", "factor")
    numbers: ClassVar[tuple[str, ...]] = ("factor",)

    median: float
    factor: float

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        return np.asarray(self.median * np.exp(math.log(self.factor) * ndtri(share)))

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        if not self.median > 0.0:
            return "median must be greater than zero"
        return "" if self.factor > 1.0 else "factor must be greater than 1, such as 1.2"


@dataclass(frozen=True)
class Triangular(Distribution):
    """From ``low`` to ``high``, most often near ``mode``."""

    word = "triangular"
    needs = ("low", "mode", "high")

    low: float
    mode: float
    high: float

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        width, left, right = self.high - self.low, self.mode - self.low, self.high - self.mode
        rising = self.low + np.sqrt(share * width * left)
        return np.where(share * width < left, rising, self.high - np.sqrt((1.0 - share) * width * right))

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        return "" if self.low <= self.mode <= self.high and self.low < self.high else "must have low <= mode <= high"


@dataclass(frozen=True)
class Discrete(Distribution):
    """One of ``values``, as often as its weight says; all alike without ``weights``."""

    word = "discrete"
    needs = ("values",)
    may = ("weights",)

    values: tuple[Any, ...]
    weights: tuple[float, ...] = ()

    def at(self, share: Floats) -> Any:
        """The values, (draws,)."""
        weights = np.array(self.weights or (1.0,) * len(self.values), np.float64)
        place = np.searchsorted(np.cumsum(weights) / weights.sum(), share, side="right")
        known = self.values if isinstance(self.values[0], str) else np.array(self.values, np.float64)
        return np.asarray(known, dtype=object if isinstance(self.values[0], str) else np.float64)[
            np.minimum(place, len(self.values) - 1)
        ]

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        if not self.values:
            return "values is empty; give at least one"
        if self.weights and len(self.weights) != len(self.values):
            return f"{len(self.values)} values and {len(self.weights)} weights; must be as many"
        if self.weights and (min(self.weights) < 0.0 or sum(self.weights) <= 0.0):
            return "weights must not be negative, and one must be greater than zero"
        return ""


SPREADS = 3.0  # standard deviations from the middle to the limits of a tolerance


@dataclass(frozen=True)
class Tolerance(Distribution):
    """A dimension with its limits: normal with the limits at three standard deviations and nothing beyond, or uniform."""

    word = "tolerance"
    needs = ("nominal",)
    may = ("plus", "minus", "plus_minus", "shape")

    nominal: float
    plus: float = 0.0
    minus: float = 0.0
    shape: str = "normal"

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        return self._spread().at(share)

    def _spread(self) -> Normal | Uniform:
        low, high = self.nominal - self.minus, self.nominal + self.plus
        if self.shape == "uniform":
            return Uniform(low, high)
        return Normal(0.5 * (low + high), (high - low) / (2.0 * SPREADS), low, high)

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        if self.shape not in ("normal", "uniform"):
            return f"shape: given {self.shape!r}; must be 'normal' or 'uniform'"
        if min(self.plus, self.minus) < 0.0:
            return "plus and minus are counted from the nominal value; they must not be negative"
        return "" if self.plus + self.minus > 0.0 else "has no width; give plus_minus, or plus and minus"


KINDS: Mapping[str, type[Distribution]] = {
    kind.word: kind for kind in (Normal, Uniform, LogNormal, Triangular, Discrete, Tolerance)
}


def joined(names: Sequence[str], pairs: Mapping[tuple[str, str], float]) -> Floats | None:
    """Correlations of the normal numbers behind the distributions (Gaussian copula) as the factor L of R = L L'.

    Parameters
    ----------
    names
        What scatters, in order.
    pairs
        Correlations, for each pair of names.

    Returns
    -------
    numpy.ndarray or None
        (names, names), lower triangular; ``None`` without pairs.

    Raises
    ------
    QuestionError
        If no numbers can be correlated in this way.
    """
    if not pairs:
        return None
    matrix = np.eye(len(names))
    for (one, other), value in pairs.items():
        matrix[names.index(one), names.index(other)] = matrix[names.index(other), names.index(one)] = value
    try:
        return np.asarray(np.linalg.cholesky(matrix), np.float64)
    except np.linalg.LinAlgError:
        least = float(np.linalg.eigvalsh(matrix)[0])
        raise QuestionError(
            f"correlation: no numbers can be correlated so; the matrix has an eigenvalue of {least:.3g}, which must be "
            "greater than zero. Smaller correlations are possible"
        ) from None


# Plans of samples: numbers between 0 and 1 for every draw, the same whoever asks for them, and in whatever pieces.


Plan = Literal["random", "sobol", "latin_hypercube", "sensitivity"]
PLANS = ("random", "sobol", "latin_hypercube", "sensitivity")
BLOCK = 1024  # draws that come from one generator
LEAST = 2.0**-54  # keeps infinity out of normal distributions
_DRAWS, _AGAIN, _WHOLE = 1, 2, 3  # streams of random numbers


def shares(plan: Plan, seed: int, width: int, draws: NDArray[np.int64], total: int) -> Floats:
    """Numbers between 0 and 1 of some draws.

    Parameters
    ----------
    plan
        How they are placed.
    seed
        Equal seeds, equal numbers.
    width
        How many numbers a draw has.
    draws
        Which draws, counted from 0.
    total
        Draws of the whole plan.

    Returns
    -------
    numpy.ndarray
        (draws, width).
    """
    if width == 0 or draws.size == 0:
        return np.zeros((draws.size, width))
    if plan == "random":
        blocks = draws // BLOCK
        found = np.empty((draws.size, width))
        for block in np.unique(blocks):
            here = blocks == block
            found[here] = _block(seed, int(block), width)[draws[here] % BLOCK]
    elif plan == "sensitivity":
        found = _columns_changed(seed, width, draws, total)
    else:
        found = _whole(plan, seed, width, total)[draws]
    return np.clip(found, LEAST, 1.0 - 2.0**-53)


def drawn_again(seed: int, width: int, draw: int, attempt: int) -> Floats:
    """Numbers for a draw that is to be taken once more, (1, width)."""
    return np.clip(generator(seed, _AGAIN, draw, attempt).random((1, width)), LEAST, 1.0 - 2.0**-53)


def correlated(share: Floats, factor: Floats | None) -> Floats:
    """The same numbers with the correlations of ``factor``, (draws, width)."""
    return share if factor is None else np.asarray(ndtr(ndtri(share) @ factor.T))


@lru_cache(maxsize=8)
def _block(seed: int, block: int, width: int) -> Floats:
    return generator(seed, _DRAWS, block).random((BLOCK, width))


@lru_cache(maxsize=4)
def _whole(plan: str, seed: int, width: int, total: int) -> Floats:
    from scipy.stats import qmc

    source = generator(seed, _WHOLE)
    if plan == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(width, rng=source).random(total))
    return _sobol(source, width, total)


def _sobol(source: Any, width: int, total: int) -> Floats:
    """Sobol' points, scrambled; made as many as a power of 2, of which the first are the same for any total."""
    from scipy.stats import qmc

    return np.asarray(qmc.Sobol(width, rng=source).random_base2(max(total - 1, 1).bit_length())[:total])


# For Sobol' indices (Saltelli 2002) a base sample is run with its numbers A, with other numbers B, and with A in which one
# number is taken from B: width + 2 runs.


def _columns_changed(seed: int, width: int, draws: NDArray[np.int64], total: int) -> Floats:
    both = _whole_pair(seed, width, total // (width + 2))
    base, which = np.divmod(draws, width + 2)
    found = np.where((which == 1)[:, None], both[base, width:], both[base, :width])
    changed = which >= 2
    column = which[changed] - 2
    found[changed, column] = both[base[changed], width + column]
    return found


@lru_cache(maxsize=4)
def _whole_pair(seed: int, width: int, bases: int) -> Floats:
    return _sobol(generator(seed, _WHOLE), 2 * width, bases)


# When a study knows enough: the interval of a named quantity, looked at after fixed numbers of draws.


FIRST, GROWTH = 100, 1.25  # draws at the first look, and how many more at each further one


@dataclass(frozen=True)
class Stop:
    """Stop as soon as the 95 % interval of ``of`` has at most this half width, at every point of the grid.

    ``statistic`` is ``share`` (of a quantity that is true or false), ``mean``, or ``quantile`` with its level ``at``.
    ``relative`` is the half width over the value.
    """

    of: str
    statistic: str
    half_width: float = math.inf
    relative: float = math.inf
    at: float = 0.5

    def reached(self, values: Any) -> bool:
        """Whether the draws of one point are enough."""
        value, low, high = interval(self.statistic, values, self.at)
        half = 0.5 * (high - low)
        return bool(half <= self.half_width and half <= self.relative * abs(value))


def looks(most: int) -> list[int]:
    """Numbers of draws after which is looked, the last of them all draws."""
    found, draws = [], float(FIRST)
    while draws < most:
        found.append(int(draws))
        draws *= GROWTH
    return [*found, most]


def interval(statistic: str, values: NDArray[Any], at: float = 0.5) -> tuple[float, float, float]:
    """A statistic of independent draws with its 95 % interval.

    Parameters
    ----------
    statistic
        ``"share"`` (Wilson 1927), ``"mean"`` (normal), or ``"quantile"`` (order statistics, for any distribution).
    values
        One for each draw; those without a number do not count.
    at
        Level of the quantile.

    Returns
    -------
    value, low, high
        Infinite bounds where there are too few draws.
    """
    known = np.asarray(values, np.float64)
    known = np.sort(known[np.isfinite(known)])
    count = known.size
    if count == 0:
        return math.nan, -math.inf, math.inf
    if statistic == "share":
        low, high = wilson_interval(np.array([known.sum()]), count)
        return float(known.mean()), float(low[0]), float(high[0])
    if statistic == "mean":
        half = Z * float(known.std(ddof=1)) / math.sqrt(count) if count > 1 else math.inf
        return float(known.mean()), float(known.mean()) - half, float(known.mean()) + half
    below = np.arange(count + 1)
    reach = bdtr(below, count, at)  # that at most so many lie below the quantile
    low_rank, high_rank = int(np.searchsorted(reach, 0.025)), int(np.searchsorted(reach, 0.975)) + 1
    low_value = float(known[low_rank - 1]) if low_rank >= 1 else -math.inf
    return float(np.quantile(known, at)), low_value, float(known[high_rank - 1]) if high_rank <= count else math.inf


# An unbalance that appears at speed: the members at rest in their places first, then the same with the unbalance
# added.
#
# Two runs joined: the state at the end of the first, rotor and balls, is the start of the second. The measures are
# those of the second, so peak and settling count from the moment at which the unbalance appears.


TABLE = "sudden_unbalance"
OF_UNBALANCE = ("moment", "mass", "radius", "couple", "angle", "station")
NEEDED = ("speed", "before", "after")
HELD_SPEED = "drive.profile.speed"
BALANCED_BEFORE = "balanced_before"
NONE_YET = {"time": [0.0], "factor": [0.0]}  # a schedule
EXAMPLE = '{ moment = "200 g*mm", speed = "1200 rpm", before = "20 s", after = "20 s" }'


@dataclass(frozen=True)
class Sudden:
    """When an unbalance of the machine appears: the balls have ``before`` (s) without it and ``after`` (s) with it."""

    place: str  # path of the unbalance that appears
    before: float
    after: float

    def paths(self) -> dict[str, str]:
        """Names of its keys under 'vary', and the paths in the machine for which they stand."""
        return {"speed": HELD_SPEED, **{key: f"{self.place}.{key}" for key in OF_UNBALANCE}}

    def without(self, machine: Machine) -> Machine:
        """The machine as it is before."""
        return with_value_at(machine, f"{self.place}.schedule", NONE_YET)


def with_sudden(machine: Machine, given: Any) -> tuple[Machine, Sudden]:
    """A machine that runs at one speed with one unbalance more, and when that appears, from the table of a study file.

    Raises
    ------
    QuestionError
        With the key at fault.
    MachineError
        If there can be no such unbalance.
    """
    if not isinstance(given, Mapping):
        raise QuestionError(f"{TABLE}: given {shortened(given)}; must be a table, such as {EXAMPLE}")
    for key in given:
        if key not in (*OF_UNBALANCE, *NEEDED):
            raise QuestionError(f"{TABLE}.{key}: {unknown_key(key, [*OF_UNBALANCE, *NEEDED])}")
    for key in NEEDED:
        if key not in given:
            raise QuestionError(f"{TABLE}.{key}: missing; write {TABLE} = {EXAMPLE}")
    times = {key: argument(f"{TABLE}.{key}", given[key], "s") for key in ("before", "after")}
    for key, value in times.items():
        if not (math.isfinite(value) and value > 0.0):
            raise QuestionError(f"{TABLE}.{key}: given {given[key]!r}; must be a time greater than zero")
    profile = {"kind": "constant", "speed": argument(f"{TABLE}.speed", given["speed"], "rad/s")}
    machine = with_value_at(machine, "drive", {"kind": "speed", "profile": profile})
    added = {key: given[key] for key in OF_UNBALANCE if key in given}
    machine = with_value_at(machine, "unbalances", (*machine.unbalances, added))
    return machine, Sudden(f"unbalances[{len(machine.unbalances)}]", **times)


def after_jump(
    members: Members, before: Groups, sudden: Sudden, plan: IntegrationPlan, workers: int | None, progress: Any
) -> tuple[list[Ran], dict[int, str], np.ndarray, float, bool]:
    """Members run to the moment at which the unbalance appears, and on with it.

    Returns
    -------
    ran, reasons, balanced, seconds, interrupted
        What the second runs left; why members have none; which were balanced before, (members,); time of a core in all.
    """
    ran, seconds, interrupted = run_groups(before, workers, None, keep_states=True)
    balanced, reasons, later = np.zeros(members.count, np.bool_), dict[int, str](), Groups(plan)
    with_it = Members(members.machine, members.columns, None, 0, "")
    for one in ran:
        for row, number in enumerate(one.group.numbers):
            state, numbers = one.found.states[row], one.found.rows[row]
            if numbers[END] < sudden.before or not np.isfinite(state).all():
                reasons[number] = f"the run before the unbalance appears ended early ({int(numbers[STATUS])})"
                continue
            word = numbers[VERDICT] if np.isfinite(numbers[VERDICT]) else NO_VERDICT
            balanced[number] = WORDS[int(word)] == BALANCED
            assembly, places = with_it.ready(number, plan)
            later.add(number, replace(assembly, state=state.copy()), places)
    if interrupted:
        return [], reasons, balanced, seconds, True
    ran, more, interrupted = run_groups(later, workers, progress)
    return ran, reasons, balanced, seconds + more, interrupted


START = "start"  # what the random starts of the balls are called where inputs are named
Impossible = Literal["refuse", "truncate", "record"]


@dataclass(frozen=True)
class Study:
    """A study, read and checked; numbers in SI.

    ``grid`` are the parameters whose values are all run with every draw; ``scatter`` those that are drawn. A member is a draw at
    a point of the grid: member ``draw * points + point``, counted from 0.
    """

    machine: Machine
    name: str
    grid: dict[str, list[Any]]
    scatter: dict[str, Distribution]
    correlation: dict[tuple[str, str], float]
    members: int  # draws at each point; base samples with the plan "sensitivity"
    plan: Plan
    seed: int
    random_starts: bool
    duration: float
    tolerance: float
    bins: int
    results: tuple[str, ...]
    impossible: Impossible
    stop: Stop | None = None
    show: tuple[str, ...] = ()  # quantities of the table; none: the usual ones
    base: Machine | None = None  # as it was given, where the study drives it in its own way
    sudden: Sudden | None = None  # with an unbalance of the machine that appears at speed
    settling_from: str = SETTLING_FROM[0]
    written: dict[str, Any] = field(default_factory=dict)  # as the user wrote it

    @property
    def inputs(self) -> list[str]:
        """What is drawn, in order; random starts last."""
        return [*self.scatter, *([START] if self.random_starts else [])]

    @property
    def draws(self) -> int:
        """Draws at each point of the grid, at most."""
        return self.members * (len(self.inputs) + 2) if self.plan == "sensitivity" else self.members

    @property
    def points(self) -> list[tuple[Any, ...]]:
        """Points of the grid; a single empty one without a grid."""
        return list(product(*self.grid.values()))

    @property
    def count(self) -> int:
        """Members in all, at most."""
        return self.draws * math.prod(map(len, self.grid.values()))

    def identity(self) -> dict[str, Any]:
        """What makes it this study and no other, as plain data."""
        return {
            "machine": machine_text(self.machine),
            "grid": {name: [str(value) for value in values] for name, values in self.grid.items()},
            "scatter": {name: [one.word, repr(one), str(one)] for name, one in self.scatter.items()},
            "correlation": [[*pair, value] for pair, value in self.correlation.items()],
            "plan": self.plan,
            "seed": self.seed,
            "starts": "random" if self.random_starts else "machine",
            "duration": self.duration,
            "tolerance": self.tolerance,
            "bins": self.bins,
            "results": list(self.results),
            "impossible": self.impossible,
            "settling_from": self.settling_from,
            **({} if self.sudden is None else {"sudden_unbalance": repr(self.sudden)}),
            **({} if self.plan == "random" else {"members": self.members}),
        }

    def columns(self, first: int, last: int, again: dict[int, int]) -> Columns:
        """What varies in the members from ``first`` to before ``last``.

        Parameters
        ----------
        first, last
            Members, counted from 0.
        again
            Draws that are taken once more, and how often they were.
        """
        draw, point = np.divmod(np.arange(first, last, dtype=np.int64), len(self.points))
        distinct, where = np.unique(draw, return_inverse=True)
        share = self._shares(distinct)
        for number, attempt in again.items():
            share[distinct == number] = drawn_again(self.seed, share.shape[1], number, attempt)
        values: dict[str, Any] = {
            name: one.at(column)[where].tolist()
            for (name, one), column in zip(
                self.scatter.items(), self._correlated(share).T[: len(self.scatter)], strict=True
            )
        }
        at = self.points
        values |= {name: [at[one][place] for one in point] for place, name in enumerate(self.grid)}
        parameters, starts = _sorted(values)
        return Columns(last - first, parameters, starts, self._seeds(draw))

    def _shares(self, draws: NDArray[np.int64]) -> NDArray[np.float64]:
        width = len(self.inputs) if self.plan == "sensitivity" else len(self.scatter)
        return shares(self.plan, self.seed, width, draws, self.draws)

    def _correlated(self, share: NDArray[np.float64]) -> NDArray[np.float64]:
        names = list(self.scatter)
        return correlated(share[:, : len(names)], joined(names, self.correlation))

    def _seeds(self, draw: NDArray[np.int64]) -> NDArray[np.int64]:
        """Seeds of the starts; with the plan "sensitivity" they are one more number of its samples A and B."""
        if not self.random_starts:
            return np.full(draw.size, self.seed, np.int64)
        if self.plan != "sensitivity":
            return self.seed + draw
        base, which = np.divmod(draw, len(self.inputs) + 2)
        other = (which == 1) | (which == 1 + len(self.inputs))
        return np.asarray(self.seed + 2 * base + other, np.int64)


def _sorted(values: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Parameters of the machine, and starts of its balls."""
    from autobalancer.studies.ensemble.columns import is_start

    starts = {name: np.array(entries, np.float64) for name, entries in values.items() if is_start(name)}
    return {name: entries for name, entries in values.items() if name not in starts}, starts
