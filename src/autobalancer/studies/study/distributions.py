"""How a parameter scatters: values from numbers between 0 and 1, so that every plan of samples serves every distribution."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from autobalancer.errors import QuestionError

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
