"""What a study asks: the machine, what varies and how, how many draws, what is wanted, when to stop."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import product
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, PlainValidator
from scipy.special import bdtr, ndtr, ndtri

from autobalancer.arrays import Floats
from autobalancer.assembly.quantities import with_value_at
from autobalancer.errors import AutobalancerError, Problem, QuestionError, UnitError
from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.measures.record_series import COLUMN
from autobalancer.kernels.measures.thresholds import NO_VERDICT
from autobalancer.machine import Machine
from autobalancer.machine.part import (
    Amount,
    Angle,
    CoupleMoment,
    Duration,
    Family,
    Label,
    Length,
    Mass,
    Positive,
    Question,
    Speed,
    UnbalanceMoment,
    key,
)
from autobalancer.machine.rotors.body import Place
from autobalancer.random_numbers import Z, generator, wilson_interval
from autobalancer.results.run_arrays import SETTLING_FROM
from autobalancer.results.verdict import BALANCED, WORDS
from autobalancer.studies.ensemble.columns import Columns
from autobalancer.studies.ensemble.layout import Groups, Ran, run_groups
from autobalancer.studies.ensemble.layout import Plan as IntegrationPlan
from autobalancer.studies.ensemble.members import Members
from autobalancer.units import list_argument, shortened, to_si

# How a parameter scatters: values from numbers between 0 and 1, so that every plan of samples serves every
# distribution.


MIDDLES = ("mean", "median", "mode", "nominal")
WIDTHS = ("standard_deviation", "plus_minus", "plus", "minus")


def amount(meaning: str, default: Any = ..., *, value: str = "in the unit of the parameter") -> Any:
    """A key whose unit is that of the parameter."""
    return key(meaning, default, value=value, default_text="that of the machine" if meaning in MIDDLES else "")


def width(meaning: str, default: Any = ...) -> Any:
    """A key with a difference to the middle."""
    return amount(meaning, default, value="in the unit of the parameter, or percent of the middle")


class Distribution(Question):
    """One parameter that scatters; of a machine the middle need not be given."""

    distribution: str

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
        given = [(name, value) for name, value in self if name != "distribution" and value not in (None, ())]
        messages = [f"{name.replace('_', ' ')} {_told(value)}" for name, value in given]
        return f"{self.distribution}: {', '.join(messages)}"

    def settled(self, unit: str, middle: Callable[[str], float]) -> Self:
        """The same with all numbers in SI; ``middle`` gives the one of the machine for a key that is not there.

        Raises
        ------
        QuestionError
            With the key of what is no such number, or makes no distribution.
        """
        entries: dict[str, float] = {}
        center = 0.0
        for name, value in self:
            try:
                if name in MIDDLES:
                    entries[name] = center = middle(name) if value is None else to_si(value, unit)
                elif name in WIDTHS and value is not None:
                    entries[name] = _width(value, unit, center)
                elif name in ("low", "high", "factor") and value is not None:
                    entries[name] = to_si(value, "" if name == "factor" else unit)
            except (QuestionError, UnitError) as error:
                raise QuestionError(str(error), (name,)) from None
        made = self.model_copy(update={name: float(value) for name, value in entries.items()})
        if wrong := made.wrong():
            raise QuestionError(wrong)
        return made


def _width(value: Any, unit: str, middle: float) -> float:
    """A difference in the unit of the parameter, or a percentage of its middle."""
    share = isinstance(value, str) and value.strip().endswith("%")
    if share and unit == "K":
        raise QuestionError(f"given {value!r}; a share of an absolute temperature says little, write it in K")
    if unit == "K" and isinstance(value, str) and "deg" in value:
        raise QuestionError(f"given {value!r}; a difference of temperatures is written in K, such as '3 K'")
    return abs(middle) * to_si(value, "") if share else to_si(value, unit)


def _told(value: Any) -> str:
    if isinstance(value, tuple):
        return " / ".join(map(_told, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


class Normal(Distribution):
    """Normal, between ``low`` and ``high`` where they are given."""

    distribution: Literal["normal"] = "normal"
    mean: Amount | None = amount("mean", None)
    standard_deviation: Amount = width("standard deviation")
    low: Amount | None = amount("no draw is below", None)
    high: Amount | None = amount("no draw is above", None)

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        mean, deviation, low, high = self._numbers()
        begin, end = (ndtr((limit - mean) / deviation) for limit in (low, high))
        return np.asarray(np.clip(mean + deviation * ndtri(begin + (end - begin) * share), low, high))

    def _numbers(self) -> tuple[float, float, float, float]:
        low, high = -math.inf if self.low is None else self.low, math.inf if self.high is None else self.high
        return _known(self.mean), self.standard_deviation, low, high

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        mean, deviation, low, high = self._numbers()
        if not deviation > 0.0:
            return "standard_deviation must be greater than zero"
        if not low < high:
            return "low must be below high"
        inside = ndtr((high - mean) / deviation) - ndtr((low - mean) / deviation)
        return "" if inside > 1e-9 else "nothing of it lies between low and high"


def _known(number: float | None) -> float:
    assert number is not None, "a distribution is settled before it is drawn from"
    return number


class Uniform(Distribution):
    """Every value between ``low`` and ``high`` alike."""

    distribution: Literal["uniform"] = "uniform"
    low: Amount = amount("least value")
    high: Amount = amount("greatest value")

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        return self.low + (self.high - self.low) * share

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        return "" if self.low < self.high else "low must be below high"


class LogNormal(Distribution):
    """Normal in its logarithm: 68 % of the values lie between ``median / factor`` and ``median * factor``."""

    distribution: Literal["log-normal"] = "log-normal"
    median: Amount | None = amount("median", None)
    factor: Amount = amount("68 % lie between the median over this factor and the median times it", value="number, > 1")

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        return np.asarray(_known(self.median) * np.exp(math.log(self.factor) * ndtri(share)))

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        if not _known(self.median) > 0.0:
            return "median must be greater than zero"
        return "" if self.factor > 1.0 else "factor must be greater than 1, such as 1.2"


class Triangular(Distribution):
    """From ``low`` to ``high``, most often near ``mode``."""

    distribution: Literal["triangular"] = "triangular"
    low: Amount = amount("least value")
    mode: Amount | None = amount("mode", None)
    high: Amount = amount("greatest value")

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        mode = _known(self.mode)
        width, left, right = self.high - self.low, mode - self.low, self.high - mode
        rising = self.low + np.sqrt(share * width * left)
        return np.where(share * width < left, rising, self.high - np.sqrt((1.0 - share) * width * right))

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        return (
            ""
            if self.low <= _known(self.mode) <= self.high and self.low < self.high
            else "must have low <= mode <= high"
        )


class Discrete(Distribution):
    """One of ``values``, as often as its weight says; all alike without ``weights``."""

    distribution: Literal["discrete"] = "discrete"
    values: tuple[Any, ...] = key("numbers or words", value="list")
    weights: tuple[float, ...] = key("how often each value is taken; alike unless given", ())

    def settled(self, unit: str, middle: Callable[[str], float]) -> Self:
        """The same with its values in SI."""
        if not unit and all(isinstance(value, str) for value in self.values):
            return self._checked(self.values)
        return self._checked(tuple(list_argument("values", self.values, unit)))

    def _checked(self, values: tuple[Any, ...]) -> Self:
        checked = self.model_copy(update={"values": values})
        if wrong := checked.wrong():
            raise QuestionError(wrong)
        return checked

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


class Tolerance(Distribution):
    """A dimension with its limits: normal with the limits at three standard deviations and nothing beyond, or uniform."""

    distribution: Literal["tolerance"] = "tolerance"
    nominal: Amount | None = amount("nominal", None)
    plus_minus: Amount | None = width("both limits", None)
    plus: Amount | None = width("upper limit above the nominal value", None)
    minus: Amount | None = width("lower limit below the nominal value", None)
    shape: Literal["normal", "uniform"] = key("between the limits", "normal")

    def contradictions(self) -> Iterator[Problem]:
        """Limits given twice."""
        if self.plus_minus is not None and not (self.plus is None and self.minus is None):
            yield ("plus_minus",), "stands alone; give it, or plus and minus"

    def at(self, share: Floats) -> Floats:
        """Values below which such shares of all values lie, SI."""
        return self._spread().at(share)

    def _spread(self) -> Normal | Uniform:
        minus, plus = self._limits()
        low, high = _known(self.nominal) - minus, _known(self.nominal) + plus
        if self.shape == "uniform":
            return Uniform(low=low, high=high)
        return Normal(mean=0.5 * (low + high), standard_deviation=(high - low) / (2.0 * SPREADS), low=low, high=high)

    def _limits(self) -> tuple[float, float]:
        both = self.plus_minus or 0.0
        return self.minus or both, self.plus or both

    def wrong(self) -> str:
        """What is impossible about it; empty if nothing is."""
        if min(self._limits()) < 0.0:
            return "plus and minus are counted from the nominal value; they must not be negative"
        return "" if sum(self._limits()) > 0.0 else "has no width; give plus_minus, or plus and minus"


KINDS: dict[str, type[Distribution]] = {
    str(kind.model_fields["distribution"].default): kind
    for kind in (Normal, Uniform, LogNormal, Triangular, Discrete, Tolerance)
}


def _varied(argument: Any) -> Any:
    """What varies: values, a distribution, or a table of such entries."""
    if not isinstance(argument, Mapping):
        if argument is None:
            raise ValueError(f"given None; {WANTED}")
        return argument
    if "distribution" in argument:
        word = argument["distribution"]
        if not isinstance(word, str) or word not in KINDS:
            raise QuestionError(
                f"given {shortened(word)}; must be one of {', '.join(map(repr, KINDS))}", ("distribution",)
            )
        return KINDS[word](**argument)
    if set(argument) == {"values"}:
        return _varied(argument["values"])
    if not argument or not all(isinstance(entry, (Mapping, list, Distribution)) for entry in argument.values()):
        raise ValueError(f"given {shortened(dict(argument))}; {WANTED}")
    result = {}
    for name, entry in argument.items():
        try:
            result[name] = _varied(entry)
        except AutobalancerError as error:
            raise error.within(name) from None
    return result


WANTED = f"give 'values' = a list or a range, or 'distribution' = one of {', '.join(KINDS)}"
_Entry = Normal | Uniform | LogNormal | Triangular | Discrete | Tolerance | list[float | str] | float | str
Varied = dict[
    str,
    Annotated[
        Any, PlainValidator(_varied, json_schema_input_type=_Entry | dict[str, Any]), Family(tuple(KINDS.values()))
    ],
]


def copula_factor(names: Sequence[str], pairs: Mapping[tuple[str, str], float]) -> Floats | None:
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
        result = np.empty((draws.size, width))
        for block in np.unique(blocks):
            here = blocks == block
            result[here] = _block(seed, int(block), width)[draws[here] % BLOCK]
    elif plan == "sensitivity":
        result = _changed_columns(seed, width, draws, total)
    else:
        result = _all_draws(plan, seed, width, total)[draws]
    return np.clip(result, LEAST, 1.0 - 2.0**-53)


def redraw(seed: int, width: int, draw: int, attempt: int) -> Floats:
    """Numbers for a draw that is to be taken once more, (1, width)."""
    return np.clip(generator(seed, _AGAIN, draw, attempt).random((1, width)), LEAST, 1.0 - 2.0**-53)


def correlated(share: Floats, factor: Floats | None) -> Floats:
    """The same numbers with the correlations of ``factor``, (draws, width)."""
    return share if factor is None else np.asarray(ndtr(ndtri(share) @ factor.T))


@lru_cache(maxsize=8)
def _block(seed: int, block: int, width: int) -> Floats:
    return generator(seed, _DRAWS, block).random((BLOCK, width))


@lru_cache(maxsize=4)
def _all_draws(plan: str, seed: int, width: int, total: int) -> Floats:
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


def _changed_columns(seed: int, width: int, draws: NDArray[np.int64], total: int) -> Floats:
    both = _whole_pair(seed, width, total // (width + 2))
    base, which = np.divmod(draws, width + 2)
    result = np.where((which == 1)[:, None], both[base, width:], both[base, :width])
    changed = which >= 2
    column = which[changed] - 2
    result[changed, column] = both[base[changed], width + column]
    return result


@lru_cache(maxsize=4)
def _whole_pair(seed: int, width: int, bases: int) -> Floats:
    return _sobol(generator(seed, _WHOLE), 2 * width, bases)


# When a study knows enough: the interval of a named quantity, looked at after fixed numbers of draws.


FIRST, GROWTH = 100, 1.25  # draws at the first look, and how many more at each further one


class Stop(Question):
    """Stop as soon as the 95 % interval of a quantity is narrow enough at every point of the grid."""

    of: Label = key("a quantity, such as `balanced` or `peak_deflection`")
    statistic: Literal["share", "mean", "quantile"] | None = key(
        "of the draws; the share of a quantity that is true or false, else the mean unless given", None
    )
    half_width: Amount | None = amount(
        "half of the interval, instead of `relative`", None, value="in the unit of the quantity"
    )
    relative: Positive | None = key("half of the interval over the value", None)
    at: Annotated[float, Field(strict=True, ge=0.0, le=1.0)] = key("level of the quantile", 0.5)

    def settled(self, kind: str, unit: str) -> Stop:
        """The same in SI, of a quantity that is ``"bool"`` or ``"number"``.

        Raises
        ------
        QuestionError
            With the key of what does not fit.
        """
        if (self.half_width is None) == (self.relative is None):
            raise QuestionError(
                "give half_width, in the unit of the quantity, or relative, over its value; one of them"
            )
        statistic = self.statistic or ("share" if kind == "bool" else "mean")
        if (statistic == "share") != (kind == "bool"):
            usual = "'share'" if kind == "bool" else "'mean' or quantile"
            raise QuestionError(f"given {statistic!r}; of {self.of!r} there is {usual}", ("statistic",))
        half = None if self.half_width is None else to_si(self.half_width, "" if statistic == "share" else unit)
        if half is not None and not half > 0.0:
            raise QuestionError(f"given {self.half_width!r}; must be greater than zero", ("half_width",))
        return self.model_copy(update={"statistic": statistic, "half_width": half})

    def reached(self, values: Any) -> bool:
        """Whether the draws of one point are enough."""
        value, low, high = interval(str(self.statistic), values, self.at)
        half = 0.5 * (high - low)
        if self.relative is not None:
            return bool(half <= self.relative * abs(value))
        return bool(half <= _known(self.half_width))


def looks(most: int) -> list[int]:
    """Numbers of draws after which is looked, the last of them all draws."""
    result, draws = [], float(FIRST)
    while draws < most:
        result.append(int(draws))
        draws *= GROWTH
    return [*result, most]


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
HELD_SPEED = "drive.profile.speed"
BALANCED_BEFORE = "balanced_before"
NONE_YET = {"time": [0.0], "factor": [0.0]}  # a schedule


class SuddenUnbalance(Question):
    """An unbalance that appears while the speed is held, with the keys of an unbalance of the machine."""

    speed: Speed = key("at which the machine runs")
    before: Duration = key("time that the balls have before it appears")
    after: Duration = key("time that they have with it")
    moment: UnbalanceMoment | None = key("mass times radius; instead of `mass` and `radius`", None)
    mass: Mass | None = key("a part of the mass of the rotor", None)
    radius: Length | None = key("distance of this mass from the shaft", None)
    couple: CoupleMoment | None = key("product of inertia in place of a point unbalance", None)
    angle: Angle | None = key("in the rotor, from the zero mark", None)
    station: Place | None = key("where on the axis: a position, or the name of a station", None)


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
            if numbers[COLUMN.end_time] < sudden.before or not np.isfinite(state).all():
                reasons[number] = f"the run before the unbalance appears ended early ({int(numbers[COLUMN.status])})"
                continue
            word = numbers[COLUMN.verdict] if np.isfinite(numbers[COLUMN.verdict]) else NO_VERDICT
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
            "scatter": {name: [one.distribution, repr(one), str(one)] for name, one in self.scatter.items()},
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
            share[distinct == number] = redraw(self.seed, share.shape[1], number, attempt)
        share = correlated(share[:, : len(self.scatter)], copula_factor(list(self.scatter), self.correlation))
        values: dict[str, Any] = {
            name: one.at(column)[where].tolist()
            for (name, one), column in zip(self.scatter.items(), share.T, strict=True)
        }
        at = self.points
        values |= {name: [at[one][place] for one in point] for place, name in enumerate(self.grid)}
        parameters, starts = _sorted(values)
        return Columns(last - first, parameters, starts, self._seeds(draw))

    def _shares(self, draws: NDArray[np.int64]) -> NDArray[np.float64]:
        width = len(self.inputs) if self.plan == "sensitivity" else len(self.scatter)
        return shares(self.plan, self.seed, width, draws, self.draws)

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
