"""Rubber from measured points: elastic, viscous, Maxwell and friction elements by non-negative least squares.

K' and K'' are linear in all stiffnesses. The amplitudes of the friction elements are a regular chain, ``spacing`` apart, from one
step below the smallest measured amplitude to ``reach`` times the largest, so that the loss does not run out. Elements beyond the
measured amplitudes act like plain springs there, so their sum is known but not their shares; a weak pull to equal neighbors
spreads it over them. Uncertainties are those of the least squares with this pull, larger where the points scatter more than
they should.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import Friction, RubberLaw
from autobalancer.measurement.rubber.checks import refuse_impossible
from autobalancer.measurement.rubber.file import load_rubber
from autobalancer.results.answers.rubber_fit import RubberFit, element_columns
from autobalancer.results.answers.rubber_points import RubberPoints, joined
from autobalancer.units import list_argument

Floats = NDArray[np.float64]
Measured = RubberPoints | str | Path
SURE, LEAST = 2.0, 1e-4  # standard deviations, and share of the elastic part, by which it must soften
PULL = 0.3  # standard deviations for which an element may differ from its neighbor by the mean of all


def rubber(
    measured: Measured | Sequence[Measured],
    *,
    law: Friction = "elastoplastic",
    spacing: float = 2.0,
    reach: float = 3.0,
    relaxation_times: Sequence[float | str] = (),
    viscous: bool = True,
) -> RubberFit:
    """Fit rubber that softens with amplitude to hysteresis loops and resonances at several amplitudes.

    Parameters
    ----------
    measured
        Points from :func:`~autobalancer.measure.rubber_loops` and :func:`~autobalancer.measure.rubber_resonances`, or tables
        of them, see :func:`~autobalancer.measure.load_rubber`; one, or several that hold for the same rubber.
    law
        Of the friction elements.
    spacing
        Ratio of neighboring breakaway amplitudes. In a circle, above 2 the loss has waves between them.
    reach
        The largest breakaway amplitude over the largest measured one.
    relaxation_times
        Of Maxwell elements, s; without any the stiffness does not depend on the frequency.
    viscous
        Whether there may be a viscous part.

    Returns
    -------
    RubberFit
        The rubber, its uncertainty, and every point with what was fitted.

    Raises
    ------
    QuestionError
        If points are impossible, contradict each other, leave holes, or show no softening; it names them.
    """
    points = _points(measured)
    for name, value, low in (("spacing", spacing, 1.1), ("reach", reach, 1.0)):
        if not low <= value <= 10.0:
            raise QuestionError(f"{name}: given {value:g}; must be from {low:g} to 10")
    refuse_impossible(points)
    times = tuple(sorted(list_argument("relaxation_times", relaxation_times, "s")))
    if any(not time > 0.0 for time in times):
        raise QuestionError("relaxation_times: each must be above zero")
    limits = chain(points, spacing, reach)
    design, values, sure = _equations(points, limits, times, law, viscous)
    solved, covariance, freedom = _solved(design, values, sure, limits.size)
    friction = tuple((float(k), float(a)) for k, a in zip(solved[2 : 2 + limits.size], limits, strict=True) if k > 0.0)
    maxwell = tuple((float(k), tau) for k, tau in zip(solved[2 + limits.size :], times, strict=True) if k > 0.0)
    ends = np.array([points.amplitude.min(), points.amplitude.max()])
    drop = -np.diff(element_columns(np.zeros(2), ends, ["line"] * 2, limits, times, law).real, axis=0)[0]
    if not drop @ solved > max(SURE * float(np.sqrt(drop @ covariance @ drop)), LEAST * solved[0]):
        raise QuestionError(
            "rubber: the points show no softening with the amplitude; a plain stiffness and damping will do"
        )
    found = RubberLaw(float(solved[0]), float(solved[1]), friction, maxwell, law)
    return RubberFit(found, points, tuple(limits.tolist()), times, covariance, freedom)


def chain(points: RubberPoints, spacing: float, reach: float) -> Floats:
    """Breakaway amplitudes, m, ascending."""
    low, high = float(points.amplitude.min()) / spacing, reach * float(points.amplitude.max())
    count = int(np.floor(np.log(high / low) / np.log(spacing) + 1e-9)) + 1
    return np.asarray(high / spacing ** np.arange(count - 1, -1, -1.0))


def _points(measured: Measured | Sequence[Measured]) -> RubberPoints:
    given = [measured] if isinstance(measured, (RubberPoints, str, Path)) else list(measured)
    if not given:
        raise QuestionError("rubber: given no measurements; give points or tables of them")
    return joined([one if isinstance(one, RubberPoints) else load_rubber(one) for one in given])


def _equations(
    points: RubberPoints, limits: Floats, times: Sequence[float], law: Friction, viscous: bool
) -> tuple[Floats, Floats, Floats]:
    """Rows of K', then of K'' where it is known."""
    whole = element_columns(points.frequency, points.amplitude, points.motion, limits, times, law)
    if not viscous:
        whole[:, 1] = 0.0
    known = np.isfinite(points.loss)
    return (
        np.vstack([whole.real, whole[known].imag]),
        np.concatenate([points.stiffness, points.loss[known]]),
        np.concatenate([points.stiffness_uncertainty, points.loss_uncertainty[known]]),
    )


def _solved(design: Floats, values: Floats, sure: Floats, elements: int) -> tuple[Floats, Floats, int]:
    """Unknowns, their covariance (zero where one is at its bound), and points less free unknowns."""
    from scipy.optimize import nnls

    size = float(np.mean(values)) / elements
    pull = np.zeros((elements - 1, design.shape[1]))
    for i in range(elements - 1):
        pull[i, 2 + i], pull[i, 3 + i] = -PULL / size, PULL / size
    rows = np.vstack([design / sure[:, None], pull])
    scale = np.linalg.norm(rows, axis=0)
    scale[scale == 0.0] = 1.0
    found, _ = nnls(rows / scale, np.concatenate([values / sure, np.zeros(elements - 1)]))
    free = found > 0.0
    inverse = np.linalg.pinv((rows / scale)[:, free].T @ (rows / scale)[:, free])
    rest = values.size - int(free.sum())
    miss = float((((design / scale) @ found - values) ** 2 / sure**2).sum())
    more = max(1.0, miss / rest) if rest > 0 else 1.0
    covariance = np.zeros((found.size, found.size))
    covariance[np.ix_(free, free)] = more * inverse / np.outer(scale[free], scale[free])
    return np.asarray(found / scale), covariance, rest
