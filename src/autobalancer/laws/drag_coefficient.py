"""Drag coefficient of a ball against its Reynolds number: c_d(Re), continuous over the whole range.

F = 1/2 rho A c_d u |u| with A the cross section of the ball, u its velocity relative to the fluid and Re = |u| d_b / nu
(Spannan 2021, 5.17 and, with the absolute value that is missing there, 5.20). Every law has three ranges: up to
``stokes_end`` c_d Re is a constant and the drag exactly linear, from ``kept_from`` on c_d is a constant, and in between the
law has its shape. ``highest`` is the Reynolds number up to which the law is meant to hold; beyond it c_d keeps its value,
although the drag of a sphere falls to a quarter where its boundary layer turns turbulent.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError, RangeWarning, warn

Floats = NDArray[np.float64]
UNNAMED = "own law"
CRISIS = 2e5
"""Reynolds number from which on the boundary layer of a sphere may turn turbulent (end of Cheng 2009)."""
PER_DECADE = 50
"""Points for each factor of ten of a law that is computed from a function."""
PLANE_PLATEAU = 0.74
"""c_d of a sphere on a plane at high Reynolds numbers (Spannan 2021, 5.21)."""


@dataclass(frozen=True)
class DragLaw:
    """What all laws have in common; the laws there are stand in ``autobalancer/drag``.

    ``cd_re`` is c_d Re in the Stokes range, ``source`` where the law comes from and what was changed.
    """

    name: str
    source: str
    cd_re: float
    stokes_end: float
    kept_from: float
    highest: float

    def product(self, reynolds: ArrayLike) -> Floats:
        """c_d Re, finite at rest too; ``reynolds`` of any shape and either sign."""
        re = np.abs(np.asarray(reynolds, dtype=float))
        between = np.clip(re, self.stokes_end, self.kept_from)
        inside = np.exp(self._log_product(np.log(between))) * (re / between)
        return np.where(re <= self.stokes_end, self.cd_re, inside)

    def coefficient(self, reynolds: ArrayLike) -> Floats:
        """c_d; infinite at rest. Warns once with a ``RangeWarning`` if a Reynolds number is above ``highest``."""
        re = np.abs(np.asarray(reynolds, dtype=float))
        if text := self.outside(float(re.max(initial=0.0))):
            warn(text, RangeWarning)
        with np.errstate(divide="ignore"):
            return np.asarray(self.product(re) / re)

    def log_slope(self, reynolds: ArrayLike) -> Floats:
        """d ln c_d / d ln Re between both ends of the shape, where it is one-sided; -1 below and 0 above."""
        re = np.abs(np.asarray(reynolds, dtype=float))
        slope = self._product_slope(np.log(np.clip(re, self.stokes_end, self.kept_from))) - 1.0
        return np.where(re < self.stokes_end, -1.0, np.where(re > self.kept_from, 0.0, slope))

    def outside(self, reynolds: float) -> str:
        """A sentence if this Reynolds number is above the range of the law, else an empty text."""
        if abs(reynolds) <= self.highest:
            return ""
        return (
            f"the Reynolds number reaches {abs(reynolds):.3g}, but the drag law {self.name!r} holds up to {self.highest:.3g}; "
            "its drag coefficient is kept at the value there"
        )

    def _log_product(self, log_re: Floats) -> Floats:
        raise NotImplementedError

    def _product_slope(self, log_re: Floats) -> Floats:
        raise NotImplementedError


@dataclass(frozen=True)
class CubicLaw(DragLaw):
    """log10 c_d a cubic of log10 Re between both ends, ``coefficients`` from the constant one on."""

    coefficients: tuple[float, float, float, float]

    def _log_product(self, log_re: Floats) -> Floats:
        c, x = self.coefficients, log_re / np.log(10.0)
        return np.asarray(log_re + np.log(10.0) * (c[0] + x * (c[1] + x * (c[2] + x * c[3]))))

    def _product_slope(self, log_re: Floats) -> Floats:
        c, x = self.coefficients, log_re / np.log(10.0)
        return np.asarray(1.0 + c[1] + x * (2.0 * c[2] + x * 3.0 * c[3]))


@dataclass(frozen=True)
class LinearLaw(DragLaw):
    """c_d Re a constant at any Reynolds number."""

    def _log_product(self, log_re: Floats) -> Floats:
        return np.full(np.shape(log_re), np.log(self.cd_re))

    def _product_slope(self, log_re: Floats) -> Floats:
        return np.zeros(np.shape(log_re))


@dataclass(frozen=True)
class TableLaw(DragLaw):
    """Points (Re, c_d), with a monotone cubic (Fritsch and Carlson 1980) of log(c_d Re) over log Re in between."""

    reynolds: tuple[float, ...]
    coefficients: tuple[float, ...]

    def _log_product(self, log_re: Floats) -> Floats:
        return np.asarray(self._curve()(log_re), dtype=float)

    def _product_slope(self, log_re: Floats) -> Floats:
        return np.asarray(self._curve()(log_re, 1), dtype=float)

    def _curve(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(np.log(self.reynolds), np.log(self.reynolds) + np.log(self.coefficients))


@dataclass(frozen=True)
class SampledLaw(TableLaw):
    """Points that were computed, so near to each other that the curve between them is the law."""


def linear_drag_law(cd_re: float, source: str = "given c_d Re") -> LinearLaw:
    """A constant c_d Re: drag linear in the velocity at any Reynolds number.

    Parameters
    ----------
    cd_re
        Drag coefficient times Reynolds number.
    source
        Of the number, kept with the law.

    Returns
    -------
    DragLaw
        Ready for the ``curve`` of a drag law of your own.

    Raises
    ------
    QuestionError
        If it is not positive.
    """
    if not (math.isfinite(cd_re) and cd_re > 0.0):
        raise QuestionError(f"drag law: given c_d Re = {cd_re:g}; must be positive")
    return LinearLaw("linear", source, cd_re, np.inf, np.inf, np.inf)


def joined(cd_re: float, plateau: float, name: str = "cd_re", source: str = "") -> CubicLaw:
    """c_d Re up to Re = 10, a ``plateau`` from 20 000 on, between them the cubic that joins both in value and slope.

    It is the shape of (5.21) and the way in which Spannan (2021) found (6.9).

    Raises
    ------
    QuestionError
        If drag and drag coefficient would not both change monotonically in between.
    """
    x, y = np.log10([10.0, 2e4]), np.log10([cd_re / 10.0, plateau])
    mean = (y[1] - y[0]) / (x[1] - x[0])
    if not -2.0 / 3.0 <= mean <= -1.0 / 3.0:
        low, high = (cd_re / 10.0 * 10.0 ** (share * (x[1] - x[0])) for share in (-2.0 / 3.0, -1.0 / 3.0))
        raise QuestionError(
            f"given a plateau of {plateau:.4g} for c_d Re = {cd_re:.4g}; the drag law joins them smoothly for plateaus from "
            f"{low:.3g} to {high:.3g}; give one of these, or describe the law by a table"
        )
    rows = [[1.0, e, e**2, e**3] for e in x] + [[0.0, 1.0, 2.0 * e, 3.0 * e**2] for e in x]
    coefficients = np.linalg.solve(np.array(rows), np.array([*y, -1.0, 0.0]))
    source = source or "given c_d Re and plateau, joined like Spannan (2021), (6.9)"
    return CubicLaw(name, source, cd_re, 10.0, 2e4, CRISIS, tuple(coefficients.tolist()))


def table(reynolds: ArrayLike, coefficients: ArrayLike, source: str = "given") -> TableLaw:
    """Measured points: linear drag below the first one, c_d kept beyond the last one.

    Raises
    ------
    QuestionError
        If there are fewer than two points, Re does not increase, c_d is not positive, or c_d Re falls anywhere: below the
        drag crisis drag grows at least as the velocity does, and only then a torque belongs to one speed.
    """
    re, cd = np.atleast_1d(np.asarray(reynolds, dtype=float)), np.atleast_1d(np.asarray(coefficients, dtype=float))
    if re.shape != cd.shape or re.ndim != 1 or re.size < 2:
        raise QuestionError(
            f"drag table: given {re.size} Reynolds numbers and {cd.size} drag coefficients; give two or more pairs"
        )
    if not (re[0] > 0.0 and (np.diff(re) > 0.0).all() and (cd > 0.0).all() and np.isfinite(re * cd).all()):
        raise QuestionError("drag table: Reynolds numbers must increase, and they and drag coefficients be positive")
    _refuse_falling("drag table", re, re * cd, "leave out or correct one of these points")
    first, last = float(re[0]), float(re[-1])
    points = tuple(re.tolist()), tuple(cd.tolist())
    return TableLaw("table", source, float(re[0] * cd[0]), first, last, last, *points)


def sampled_drag_law(
    coefficient: Callable[[float], float],
    *,
    name: str = UNNAMED,
    source: str = "own law",
    linear_to: float = 1e-3,
    holds_to: float = CRISIS,
) -> SampledLaw:
    """A drag law of your own from its drag coefficient as a function of the Reynolds number.

    Parameters
    ----------
    coefficient
        c_d of one Reynolds number. It is called at 50 Reynolds numbers for each factor of ten, not in the run.
    name, source
        Of the law, kept with every result; without a name it gets the word of the class whose ``curve`` it is.
    linear_to
        Reynolds number below which c_d Re keeps the value it has there, so that the drag is linear.
    holds_to
        Reynolds number beyond which c_d keeps the value it has there, and a result warns.

    Returns
    -------
    DragLaw
        Ready for ``DragCurve``, for pictures, and for the ``curve`` of a drag law of your own.

    Raises
    ------
    QuestionError
        If the function fails, gives what is no positive number, or if c_d Re falls anywhere; the message says where.
    """
    if not 0.0 < linear_to < holds_to < math.inf:
        raise QuestionError(
            f"drag law {name!r}: given a range from {linear_to:g} to {holds_to:g}; must increase from above 0"
        )
    re = np.geomspace(linear_to, holds_to, math.ceil(PER_DECADE * math.log10(holds_to / linear_to)) + 1)
    cd = np.array([_one(coefficient, one, name) for one in re.tolist()])
    _refuse_falling(f"drag law {name!r}", re, re * cd, "correct the law, or limit it by linear_to and holds_to")
    points = tuple(re.tolist()), tuple(cd.tolist())
    return SampledLaw(name, source, float(re[0] * cd[0]), linear_to, holds_to, holds_to, *points)


def _one(coefficient: Callable[[float], float], reynolds: float, name: str) -> float:
    try:
        value = float(coefficient(reynolds))
    except Exception as reason:  # whatever a law of somebody else may raise
        raise QuestionError(
            f"drag law {name!r}: fails at Re = {reynolds:.4g}: {type(reason).__name__}: {reason}"
        ) from None
    if not (math.isfinite(value) and value > 0.0):
        raise QuestionError(f"drag law {name!r}: gives c_d = {value:g} at Re = {reynolds:.4g}; must be positive")
    return value


def _refuse_falling(what: str, re: Floats, product: Floats, cure: str) -> None:
    """Below the drag crisis drag grows at least as the velocity does, and only then a torque belongs to one speed."""
    falls = np.flatnonzero(np.diff(product) < -1e-9 * product[0])
    if falls.size:
        i = int(falls[0])
        raise QuestionError(
            f"{what}: c_d Re falls from {product[i]:.4g} at Re = {re[i]:.4g} to {product[i + 1]:.4g} at {re[i + 1]:.4g}; "
            f"it must not fall; {cure}"
        )
