"""Rubber from measured points: elastic, viscous, Maxwell and friction elements by non-negative least squares.

K' and K'' are linear in all stiffnesses. The amplitudes of the friction elements are a regular chain, ``spacing`` apart, from one
step below the smallest measured amplitude to ``reach`` times the largest, so that the loss does not run out. Elements beyond the
measured amplitudes act like plain springs there, so their sum is known but not their shares; a weak pull to equal neighbors
spreads it over them. Uncertainties are those of the least squares with this pull, larger where the points scatter more than
they should.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError, ResultError
from autobalancer.files.table import Table, read_table
from autobalancer.laws.rubber import Friction, Motion, RubberLaw
from autobalancer.results.answers.rubber_fit import RubberFit, element_columns
from autobalancer.results.answers.rubber_points import RubberPoints, joined
from autobalancer.safe_file import as_path
from autobalancer.units import list_argument, texts_argument

# What was measured of rubber: complex stiffness at frequencies and amplitudes, from loops on a shaker or from
# resonances.


STIFFNESS_SURE, LOSS_SURE = 0.02, 0.05  # relative standard uncertainties where none are given


def rubber_loops(
    frequency: ArrayLike,
    amplitude: ArrayLike,
    stiffness: ArrayLike,
    damping: ArrayLike,
    *,
    stiffness_uncertainty: float = STIFFNESS_SURE,
    loss_uncertainty: float = LOSS_SURE,
    motion: Motion | Sequence[Motion] = "line",
) -> RubberPoints:
    """Points from loops of force over deflection, evaluated as in Spannan (2021), (6.2) to (6.5).

    Parameters
    ----------
    frequency
        Of the motion, rad/s, (n,).
    amplitude
        x of the deflection, m, (n,).
    stiffness
        k = F / x, the amplitude of the force over that of the deflection, N/m, (n,): the absolute value of K.
    damping
        b = W / (2 pi^2 f x^2) with the area W of the loop, N s/m, (n,): K'' = w b.
    stiffness_uncertainty, loss_uncertainty
        Relative standard uncertainties.
    motion
        ``line`` on a shaker, or ``circle``; one, or one of each point.

    Raises
    ------
    QuestionError
        If the lists are of different length, or a number is missing, not finite, or impossible.
    """
    w, x, k, b = _columns(
        "rubber_loops",
        frequency=(frequency, "rad/s"),
        amplitude=(amplitude, "m"),
        stiffness=(stiffness, "N/m"),
        damping=(damping, "N*s/m"),
    )
    names = tuple(f"loop {n} ({_where(*at)})" for n, at in enumerate(zip(w, x, strict=True), 1))
    loss = w * b
    wrong = np.flatnonzero(loss >= k)
    if wrong.size:
        i = int(wrong[0])
        raise QuestionError(
            f"{names[i]}: the loss w b = {loss[i]:.4g} N/m is not below the stiffness {k[i]:.4g} N/m; check the units of both"
        )
    return _measured_points(
        w,
        x,
        np.sqrt(k**2 - loss**2),
        loss,
        (stiffness_uncertainty, loss_uncertainty),
        motion,
        "loop",
        names,
    )


def rubber_resonances(
    mass: ArrayLike | str,
    frequency: ArrayLike,
    amplitude: ArrayLike,
    decay_rate: ArrayLike | None = None,
    *,
    stiffness_uncertainty: float = STIFFNESS_SURE,
    loss_uncertainty: float = LOSS_SURE,
    motion: Motion | Sequence[Motion] = "line",
) -> RubberPoints:
    """Points from resonances of a mass on the rubber at several amplitudes.

    K' = M (w^2 + d^2) and K'' = 2 M d w for a free decay of frequency w and decay rate d; without d K' = M w^2.

    Parameters
    ----------
    mass
        All that moves, kg; one, or one of each point.
    frequency
        Of a free decay, or where the response to unbalance is 90 degrees behind, rad/s, (n,).
    amplitude
        Mean deflection in the part of the decay that was evaluated, or at the resonance, m, (n,).
    decay_rate
        1/s, (n,); nan or nothing where it is not known.
    stiffness_uncertainty, loss_uncertainty
        Relative standard uncertainties.
    motion
        ``line`` after a blow, ``circle`` for unbalance; one, or one of each point.

    Raises
    ------
    QuestionError
        As :func:`rubber_loops`.
    """
    size = np.size(np.asarray(frequency, dtype=object))
    moving = np.asarray(texts_argument("mass", mass, "kg"), dtype=float)
    every = np.full(size, moving) if moving.ndim == 0 else moving
    w, x, m = _columns(
        "rubber_resonances", frequency=(frequency, "rad/s"), amplitude=(amplitude, "m"), mass=(every, "kg")
    )
    given = np.full(w.size, np.nan) if decay_rate is None else texts_argument("decay_rate", decay_rate, "1/s")
    decay = np.atleast_1d(np.asarray(given, dtype=float))
    if decay.shape != w.shape or (decay[~np.isnan(decay)] <= 0.0).any():
        raise QuestionError("decay_rate: give one above zero for each frequency, or nan where it is not known")
    names = tuple(f"resonance {n} ({_where(*at)})" for n, at in enumerate(zip(w, x, strict=True), 1))
    known = np.nan_to_num(decay)
    return _measured_points(
        w,
        x,
        m * (w**2 + known**2),
        2.0 * m * decay * w,
        (stiffness_uncertainty, loss_uncertainty),
        motion,
        "resonance",
        names,
    )


def _measured_points(
    w: Floats, x: Floats, k: Floats, loss: Floats, sure: tuple[float, float], motion: Motion | Sequence[Motion], kind: str,
    names: tuple[str, ...],
) -> RubberPoints:  # fmt: skip
    motions: tuple[Motion, ...] = (motion,) * w.size if isinstance(motion, str) else tuple(motion)
    wrong = [one for one in motions if one not in get_args(Motion)]
    if wrong or len(motions) != w.size:
        raise QuestionError(
            f"motion: given {wrong[0] if wrong else motions!r}; give line or circle, one or one of each point"
        )
    for name, share in zip(("stiffness_uncertainty", "loss_uncertainty"), sure, strict=True):
        if not 0.0 < share < 1.0:
            raise QuestionError(f"{name}: given {share:g}; must be a share between 0 and 1, such as {STIFFNESS_SURE}")
    return RubberPoints(w, x, k, loss, sure[0] * k, sure[1] * loss, motions, (kind,) * w.size, names)


def _columns(owner: str, **given: tuple[ArrayLike, str]) -> list[Floats]:
    found: list[Floats] = []
    for name, (values, unit) in given.items():
        array = np.atleast_1d(np.asarray(texts_argument(name, values, unit), dtype=float))
        if array.ndim != 1 or (found and array.size != found[0].size):
            first = next(iter(given))
            raise QuestionError(
                f"{owner}: {name}: given {array.size} values for {found[0].size if found else 0} of {first!r}; "
                "give one for each"
            )
        bad = np.flatnonzero(~(np.isfinite(array) & (array > 0.0)))
        if bad.size:
            raise QuestionError(
                f"{owner}: {name}: value {bad[0] + 1} is {array[bad[0]]:g}; each must be a number above zero. The table has a "
                "hole there: measure this point, or leave its row out"
            )
        found.append(array)
    return found


def _where(frequency: float, amplitude: float) -> str:
    return f"{frequency / (2.0 * np.pi):.4g} Hz, {1e3 * amplitude:.4g} mm"


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


# Measured points of rubber from a table.


LOOPS = "frequency [Hz], amplitude [mm], stiffness [kN/m], damping [N s/m]"


def load_rubber(
    path: str | Path, *, stiffness_uncertainty: float = STIFFNESS_SURE, loss_uncertainty: float = LOSS_SURE
) -> RubberPoints:
    """Read a table of hysteresis loops or of resonances.

    Parameters
    ----------
    path
        Loops have the columns ``frequency``, ``amplitude``, ``stiffness`` (force over deflection) and ``damping``, as
        :func:`~autobalancer.measure.rubber_loops` explains; resonances ``frequency``, ``amplitude``, ``mass`` and perhaps
        ``decay rate``, as :func:`~autobalancer.measure.rubber_resonances`; both perhaps ``motion``, line or circle.
    stiffness_uncertainty, loss_uncertainty
        Relative standard uncertainties.

    Raises
    ------
    ResultError
        If the file, a column, a unit or a number is missing or cannot be read.
    QuestionError
        If a number is impossible.
    """
    table = read_table(as_path(path), LOOPS)
    motion = _motions(table)
    sure = {"stiffness_uncertainty": stiffness_uncertainty, "loss_uncertainty": loss_uncertainty}
    w, x = table.numbers("frequency", "rad/s"), table.numbers("amplitude", "m")
    if "mass" in table.heads:
        decay = table.numbers("decay rate", "1/s") if "decay rate" in table.heads else None
        points = rubber_resonances(table.numbers("mass", "kg"), w, x, decay, motion=motion, **sure)
    else:
        points = rubber_loops(
            w, x, table.numbers("stiffness", "N/m"), table.numbers("damping", "N*s/m"), motion=motion, **sure
        )
    names = [
        f"line {line} ({name.partition('(')[2]}" for (line, _), name in zip(table.lines, points.names, strict=True)
    ]
    return replace(points, names=tuple(names))


def _motions(table: Table) -> list[Motion]:
    if "motion" not in table.heads:
        return ["line"] * len(table.lines)
    found: list[Motion] = []
    for (line, _), text in zip(table.lines, table.texts("motion"), strict=True):
        if text not in get_args(Motion):
            raise ResultError(f"{table.place}, line {line}: motion: given {text!r}; must be line or circle")
        found.append("circle" if text == "circle" else "line")
    return found


# Tables that cannot be rubber: stiffness that rises with amplitude, holes, and points that contradict each other.


SAME = 1e-3  # relative difference of frequencies and amplitudes that count as one
CHECKS_SURE = 3.0  # standard deviations
WIDEST = 12.0  # ratio of neighboring amplitudes beyond which what lies between is not known


def refuse_impossible(points: RubberPoints) -> None:
    """Refuse what no rubber of this kind can do.

    Raises
    ------
    QuestionError
        It names the points.
    """
    amplitudes = _distinct(points.amplitude)
    if len(amplitudes) < 2:
        raise QuestionError(
            f"rubber: all {len(points)} points have one amplitude, {1e3 * amplitudes[0]:.4g} mm; softening needs at least two, "
            "better four or more"
        )
    for low, high in pairwise(amplitudes):
        if high > WIDEST * low:
            raise QuestionError(
                f"rubber: nothing was measured between {1e3 * low:.4g} and {1e3 * high:.4g} mm, a hole of a factor "
                f"{high / low:.3g}; measure in between, at most a factor {WIDEST:g} apart"
            )
    _refuse_holes(points)
    _refuse_contradictions(points)
    _refuse_rises(points)


def _distinct(values: np.ndarray) -> list[float]:
    found: list[float] = []
    for value in np.sort(values).tolist():
        if not found or value > found[-1] * (1.0 + SAME):
            found.append(value)
    return found


def _refuse_holes(points: RubberPoints) -> None:
    """Loops at several frequencies and amplitudes must have all combinations."""
    loops = [i for i, kind in enumerate(points.kind) if kind == "loop"]
    for motion in sorted({points.motion[i] for i in loops}):
        rows = [i for i in loops if points.motion[i] == motion]
        w, x = _distinct(points.frequency[rows]), _distinct(points.amplitude[rows])
        there = {(_nearest(w, points.frequency[i]), _nearest(x, points.amplitude[i])) for i in rows}
        missing = [(a, b) for a in range(len(w)) for b in range(len(x)) if (a, b) not in there]
        if missing:
            texts = [f"{w[a] / (2.0 * np.pi):.4g} Hz at {1e3 * x[b]:.4g} mm" for a, b in missing]
            more = f" and {len(texts) - 3} more" if len(texts) > 3 else ""
            raise QuestionError(
                f"rubber: the table of loops has holes: {', '.join(texts[:3])}{more}; measure them, or leave out their "
                "frequency or amplitude altogether"
            )


def _nearest(values: list[float], value: float) -> int:
    return int(np.argmin(np.abs(np.log(np.array(values) / value))))


def _refuse_contradictions(points: RubberPoints) -> None:
    for i in range(len(points)):
        for j in range(i + 1, len(points)):
            same = all(
                abs(getattr(points, name)[i] - getattr(points, name)[j]) <= SAME * getattr(points, name)[i]
                for name in ("frequency", "amplitude")
            )
            if not same or points.motion[i] != points.motion[j]:
                continue
            for name in ("stiffness", "loss"):
                one, other = getattr(points, name)[[i, j]]
                spread = float(np.hypot(*getattr(points, f"{name}_uncertainty")[[i, j]]))
                if abs(one - other) > CHECKS_SURE * spread:
                    raise QuestionError(
                        f"rubber: {points.names[i]} and {points.names[j]} contradict each other: {name} {one:.4g} and "
                        f"{other:.4g} N/m at one frequency and amplitude; leave one out, or give a larger uncertainty"
                    )


def _refuse_rises(points: RubberPoints) -> None:
    """Stiffness must not rise with the amplitude, nor fall with the frequency, beyond its uncertainty."""
    for along, other, text in (
        ("amplitude", "frequency", "stiffness rises with the amplitude"),
        ("frequency", "amplitude", "stiffness falls with the frequency"),
    ):
        sign = 1.0 if along == "amplitude" else -1.0
        for i in range(len(points)):
            for j in range(len(points)):
                fixed = getattr(points, other)
                # the frequency of a resonance follows from its amplitude
                alike = abs(fixed[i] - fixed[j]) <= SAME * fixed[i] or (
                    along == "amplitude" and points.kind[i] == points.kind[j] == "resonance"
                )
                if not alike or points.motion[i] != points.motion[j] or points.kind[i] != points.kind[j]:
                    continue
                if getattr(points, along)[j] <= getattr(points, along)[i] * (1.0 + SAME):
                    continue
                spread = float(np.hypot(*points.stiffness_uncertainty[[i, j]]))
                if sign * (points.stiffness[j] - points.stiffness[i]) > CHECKS_SURE * spread:
                    raise QuestionError(
                        f"rubber: the {text}: {points.stiffness[i]:.4g} N/m in {points.names[i]}, "
                        f"{points.stiffness[j]:.4g} N/m in {points.names[j]}; no rubber of these elements does. Check the two, "
                        "or give a larger uncertainty"
                    )
