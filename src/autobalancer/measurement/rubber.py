"""Rubber that softens with the amplitude, from hysteresis loops and from resonances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import get_args

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError, ResultError, one_of
from autobalancer.files.text_files import Table, read_table
from autobalancer.laws.rubber import Friction, Motion, RubberLaw
from autobalancer.measurement.load_signals import load_signals
from autobalancer.results.answers.kinds import RubberFit, RubberPoints, element_columns, joined
from autobalancer.roots import least
from autobalancer.safe_file import as_path
from autobalancer.units import argument, list_argument, optional_argument, texts_argument

# Rubber from measured points: elastic, viscous, Maxwell and friction elements by non-negative least squares.
#
# K' and K'' are linear in all stiffnesses. The amplitudes of the friction elements are a regular chain, ``spacing``
# apart, from one step below the smallest measured amplitude to ``reach`` times the largest, so that the loss does not
# run out. Elements beyond the measured amplitudes act like plain springs there, so their sum is known but not their
# shares; a weak pull to equal neighbors spreads it over them. Uncertainties are those of the least squares with this
# pull, larger where the points scatter more than they should.


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
    wrong = [motion for motion in motions if motion not in get_args(Motion)]
    if wrong or len(motions) != w.size:
        raise QuestionError(
            f"motion: given {wrong[0] if wrong else motions!r}; give line or circle, one or one of each point"
        )
    for name, share in zip(("stiffness_uncertainty", "loss_uncertainty"), sure, strict=True):
        if not 0.0 < share < 1.0:
            raise QuestionError(f"{name}: given {share:g}; must be a share between 0 and 1, such as {STIFFNESS_SURE}")
    return RubberPoints(w, x, k, loss, sure[0] * k, sure[1] * loss, motions, (kind,) * w.size, names)


def _columns(owner: str, **arguments: tuple[ArrayLike, str]) -> list[Floats]:
    columns: list[Floats] = []
    for name, (values, unit) in arguments.items():
        array = np.atleast_1d(np.asarray(texts_argument(name, values, unit), dtype=float))
        if array.ndim != 1 or (columns and array.size != columns[0].size):
            first = next(iter(arguments))
            raise QuestionError(
                f"{owner}: {name}: given {array.size} values for {columns[0].size if columns else 0} of {first!r}; "
                "give one for each"
            )
        bad = np.flatnonzero(~(np.isfinite(array) & (array > 0.0)))
        if bad.size:
            raise QuestionError(
                f"{owner}: {name}: value {bad[0] + 1} is {array[bad[0]]:g}; each must be a number above zero. The table has a "
                "hole there: measure this point, or leave its row out"
            )
        columns.append(array)
    return columns


def _where(frequency: float, amplitude: float) -> str:
    return f"{frequency / (2.0 * np.pi):.4g} Hz, {1e3 * amplitude:.4g} mm"


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
    rubber_law = RubberLaw(float(solved[0]), float(solved[1]), friction, maxwell, law)
    return RubberFit(rubber_law, points, tuple(limits.tolist()), times, covariance, freedom)


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
    result, _ = nnls(rows / scale, np.concatenate([values / sure, np.zeros(elements - 1)]))
    free = result > 0.0
    inverse = np.linalg.pinv((rows / scale)[:, free].T @ (rows / scale)[:, free])
    rest = values.size - int(free.sum())
    miss = float((((design / scale) @ result - values) ** 2 / sure**2).sum())
    more = max(1.0, miss / rest) if rest > 0 else 1.0
    covariance = np.zeros((result.size, result.size))
    covariance[np.ix_(free, free)] = more * inverse / np.outer(scale[free], scale[free])
    return np.asarray(result / scale), covariance, rest


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
    motions: list[Motion] = []
    for (line, _), text in zip(table.lines, table.texts("motion"), strict=True):
        if text not in get_args(Motion):
            raise ResultError(f"{table.place}, line {line}: motion: given {text!r}; must be line or circle")
        motions.append("circle" if text == "circle" else "line")
    return motions


# Tables that cannot be rubber: stiffness that rises with amplitude, holes, and points that contradict each other.


SAME = 1e-3  # relative difference of frequencies and amplitudes that count as one
SURE_DEVIATIONS = 3.0  # standard deviations
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
    distinct: list[float] = []
    for value in np.sort(values).tolist():
        if not distinct or value > distinct[-1] * (1.0 + SAME):
            distinct.append(value)
    return distinct


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
                if abs(one - other) > SURE_DEVIATIONS * spread:
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
                if sign * (points.stiffness[j] - points.stiffness[i]) > SURE_DEVIATIONS * spread:
                    raise QuestionError(
                        f"rubber: the {text}: {points.stiffness[i]:.4g} N/m in {points.names[i]}, "
                        f"{points.stiffness[j]:.4g} N/m in {points.names[j]}; no rubber of these elements does. Check the two, "
                        "or give a larger uncertainty"
                    )


# Points of rubber straight from recorded force and deflection, with one or several amplitudes in a record.
#
# Each period is fitted by itself; neighbors of equal amplitude are one loop, whose complex stiffness is the ratio of
# the first harmonics of force and deflection. How much its periods differ says how sure it is.


Record = xr.Dataset | str | Path
ALIKE = 0.05  # relative difference of amplitudes of neighboring periods that are one loop
PERIODS = 4  # of a loop, the first one of which settles and is left out
CALIBRATION = 0.005  # relative standard uncertainty that no scatter shows: of both sensors, and of their phase (rad)
REFINED = 3  # times that the frequency is improved
CLIPPED = 0.05  # share of samples at the same extreme value


def rubber_signals(
    records: Record | Sequence[Record],
    *,
    deflection: str | None = None,
    force: str | None = None,
    frequency: float | str | None = None,
    calibration: float = CALIBRATION,
    motion: Motion = "line",
) -> RubberPoints:
    """Stiffness and loss of rubber at every amplitude and frequency of recorded hysteresis loops.

    Parameters
    ----------
    records
        Signals with a displacement and a force, or their files, see :func:`~autobalancer.measure.load_signals`; one frequency
        in each, and amplitudes in steps of at least four periods.
    deflection, force
        Names of the channels; by default the only displacement and the only force.
    frequency
        Of the motion, rad/s, the same in all records; by default that of the deflection in each.
    calibration
        Relative standard uncertainty of the sensors, and of the phase between them in rad, which no scatter shows.
    motion
        ``"line"`` or ``"circle"``.

    Returns
    -------
    RubberPoints
        For :func:`~autobalancer.measure.rubber`, with standard uncertainties from the scatter of the periods and the calibration.

    Raises
    ------
    QuestionError
        If a channel is missing or clipped, a record has no loop of four periods, or the rubber would give energy; it names the
        time.

    Source: Spannan (2021), (6.2) to (6.5), with K' and K'' in place of k and b.
    """
    w = optional_argument("frequency", frequency, "rad/s")
    if not 0.0 < calibration < 0.5:
        raise QuestionError(
            f"rubber_signals: calibration: given {calibration:g}; must be a share such as {CALIBRATION:g}"
        )
    given = [records] if isinstance(records, (xr.Dataset, str, Path)) else list(records)
    if not given:
        raise QuestionError("rubber_signals: given no records")
    return joined([_points_of_signals(one, deflection, force, w, calibration, motion) for one in given])


def _points_of_signals(
    record: Record,
    deflection: str | None,
    force: str | None,
    frequency: float | None,
    calibration: float,
    motion: Motion,
) -> RubberPoints:
    result = record if isinstance(record, xr.Dataset) else load_signals(record)
    place = str(result.attrs.get("origin") or "signals")
    t = result["time"].values
    x, f = (_channel(result, name, kind, place) for name, kind in ((deflection, "displacement"), (force, "force")))
    w = _frequency(t, x, place) if frequency is None else frequency
    step, period = float(t[1] - t[0]), 2.0 * np.pi / w
    if step > period / FEWEST:
        raise QuestionError(f"{place}: {period / step:.3g} samples in a period; at least {FEWEST} are needed")
    for _ in range(1 if frequency is not None else REFINED):
        starts, moved, pushed = _periods(t, x, f, w)
        loops = _loops(np.abs(moved))
        if frequency is None and loops:
            w += _advance(moved, loops) / (2.0 * np.pi / w)
    if not loops:
        raise QuestionError(
            f"{place}: no {PERIODS} periods of {w / (2.0 * np.pi):.4g} Hz in a row have one amplitude within "
            f"{100.0 * ALIKE:g} %; hold each "
            "amplitude longer, or give the 'frequency'"
        )
    rows = [_loop(w, starts[part], moved[part], pushed[part], calibration, place) for part in loops]
    size, stiff, stiff_sure, loss, loss_sure, names = zip(*rows, strict=True)
    count = len(rows)
    return RubberPoints(
        np.full(count, w), np.array(size), np.array(stiff), np.array(loss), np.array(stiff_sure), np.array(loss_sure),
        (motion,) * count, ("loop",) * count, names,
    )  # fmt: skip


def _channel(dataset: xr.Dataset, name: str | None, kind: str, place: str) -> Floats:
    if name is None:
        fitting = [str(one) for one, entry in dataset.data_vars.items() if entry.attrs.get("quantity") == kind]
        if len(fitting) != 1:
            raise QuestionError(f"{place}: {len(fitting)} channels are a {kind}; name the one to use")
        name = fitting[0]
    one_of(f"{place}: channel", name, *map(str, dataset.data_vars))
    if dataset[name].attrs.get("quantity") != kind:
        raise QuestionError(f"{place}: channel {name!r} is a {dataset[name].attrs.get('quantity')}, not a {kind}")
    values = np.asarray(dataset[name].values, float)
    for extreme in (values.max(), values.min()):
        if np.mean(values == extreme) > CLIPPED and np.ptp(values) > 0.0:
            at = float(dataset["time"].values[int(np.argmax(values == extreme))])
            raise QuestionError(
                f"{place}: channel {name!r} is clipped at {extreme:.4g}, first at {at:.4g} s; take a wider range"
            )
    return values


def _frequency(t: Floats, x: Floats, place: str) -> float:
    """Where the deflection has its greatest line, rad/s."""
    step = float(t[1] - t[0])
    window = np.hanning(t.size) * (x - x.mean())
    size = np.abs(np.fft.rfft(window, 4 * t.size))
    lines = 2.0 * np.pi * np.fft.rfftfreq(4 * t.size, step)
    top = int(np.argmax(size[4:])) + 4  # not the drift
    if not size[top] > 0.0:
        raise QuestionError(f"{place}: the deflection does not move")
    ends = lines[top - 2], lines[min(top + 2, lines.size - 1)]
    return least(lambda w: -abs(np.sum(window * np.exp(-1j * w * t))), *ends)[0]


def _periods(t: Floats, x: Floats, f: Floats, w: float) -> tuple[Floats, Complexes, Complexes]:
    """Start of each whole period, and first harmonics of deflection and force in it, with a mean of their own."""
    period = 2.0 * np.pi / w
    count = int((t[-1] - t[0]) / period * (1.0 + 1e-9))
    starts = t[0] + period * np.arange(count)
    both = np.empty((2, count), complex)
    for n, start in enumerate(starts):
        inside = (t >= start - 1e-9 * period) & (t < start + period * (1.0 - 1e-9))
        at = t[inside]
        rows = np.column_stack([np.cos(w * at), np.sin(w * at), np.ones(at.size)])  # a trend would take harmonics in
        for k, values in enumerate((x, f)):
            c, s, _ = np.linalg.lstsq(rows, values[inside], rcond=None)[0]
            both[k, n] = complex(c, -s)
    return starts, both[0], both[1]


def _advance(moved: Complexes, loops: list[slice]) -> float:
    """How far the deflection gets ahead of the frequency in a period, rad."""
    parts = [moved[part] for part in loops]
    return float(np.angle(sum((part[1:] * part[:-1].conj()).sum() / np.abs(part).mean() ** 2 for part in parts)))


def _loops(size: Floats) -> list[slice]:
    """Neighboring periods of equal amplitude, without the first of each row."""
    loops, first = [], 0
    for n in range(1, size.size + 1):
        if n < size.size and abs(size[n] - np.median(size[first:n])) <= ALIKE * np.median(size[first:n]):
            continue
        if n - first >= PERIODS:
            loops.append(slice(first + 1, n))
        first = n
    return loops


def _loop(
    w: float, starts: Floats, moved: Complexes, pushed: Complexes, calibration: float, place: str
) -> tuple[float, float, float, float, float, str]:
    each = pushed / moved
    mean = complex(pushed @ moved.conj() / (moved @ moved.conj()).real)
    scatter = (each - mean) / np.sqrt(max(1, each.size - 1) * each.size)
    stiff_sure = float(np.hypot(np.linalg.norm(scatter.real), calibration * abs(mean)))
    loss_sure = float(np.hypot(np.linalg.norm(scatter.imag), calibration * abs(mean)))
    amplitude = float(np.sqrt(np.mean(np.abs(moved) ** 2)))
    until, what = starts[-1] + 2.0 * np.pi / w, f"{w / (2.0 * np.pi):.4g} Hz, {1e3 * amplitude:.4g} mm"
    name = f"{place}, {starts[0]:.3g} to {until:.3g} s ({what})"
    if mean.imag < -3.0 * loss_sure or mean.real <= 0.0:
        raise QuestionError(
            f"{name}: stiffness {mean.real:.4g} and loss {mean.imag:.4g} N/m; rubber pushes back and takes energy. Check "
            "the sign of the force, "
            "and the delay between both channels"
        )
    return amplitude, mean.real, stiff_sure, max(mean.imag, 1e-3 * loss_sure), loss_sure, name


# A hysteresis loop from recorded deflection and force.


FEWEST = 20  # samples in a period
FINE = 400  # points of a period between samples


@dataclass(frozen=True)
class HysteresisLoop:
    """What a loop says.

    ``frequency`` (rad/s), ``amplitude`` (m), ``stiffness`` k and ``damping`` b of Spannan (2021), (6.3) and (6.5), N/m and
    N s/m, the ``energy`` W that a period costs (J), and the number of whole ``periods`` used.
    """

    frequency: float
    amplitude: float
    stiffness: float
    damping: float
    energy: float
    periods: int


def hysteresis(time: ArrayLike, deflection: ArrayLike, force: ArrayLike, frequency: float | str) -> HysteresisLoop:
    """Amplitude, stiffness, damping and loss of a loop, from the last whole periods of a record.

    Parameters
    ----------
    time
        Of the samples, s, ascending, (n,).
    deflection, force
        m and N, (n,). Both count with their first harmonic, as the linear k and b do; the energy is the area of the loop.
    frequency
        Of the motion, rad/s.

    Raises
    ------
    QuestionError
        If the record is shorter than a period, or coarser than 20 samples in a period, or has holes.
    """
    w = argument("frequency", frequency, "rad/s")
    t, x, f = (np.asarray(one, dtype=float) for one in (time, deflection, force))
    if t.ndim != 1 or x.shape != t.shape or f.shape != t.shape or not all(np.isfinite(one).all() for one in (t, x, f)):
        raise QuestionError("hysteresis: give as many finite deflections and forces as times, without holes")
    if t.size < 2 or np.any(np.diff(t) <= 0.0) or not w > 0.0:
        raise QuestionError("hysteresis: times must ascend, and the frequency must be above zero")
    period = 2.0 * np.pi / w
    periods = int(np.floor((t[-1] - t[0]) / period * (1.0 + 1e-9)))
    if periods < 1 or np.diff(t).max() > period / FEWEST:
        raise QuestionError(
            f"hysteresis: the record has {(t[-1] - t[0]) / period:.3g} periods and steps up to "
            f"{np.diff(t).max() / period:.3g} of one; give at least one period, sampled at least {FEWEST} times"
        )
    from scipy.interpolate import CubicSpline

    at = t[-1] - period * periods + np.arange(periods * FINE) * period / FINE
    at = np.maximum(at, t[0])
    turned = np.exp(-1j * w * at) * 2.0 / at.size
    x_at, f_at = CubicSpline(t, x)(at), CubicSpline(t, f)(at)
    first_x, first_f = complex((x_at * turned).sum()), complex((f_at * turned).sum())
    if abs(first_x) == 0.0:
        raise QuestionError("hysteresis: the deflection does not move at this frequency")
    energy = float((0.5 * (f_at + np.roll(f_at, -1)) * (np.roll(x_at, -1) - x_at)).sum() / periods)
    amplitude = abs(first_x)
    return HysteresisLoop(w, amplitude, abs(first_f) / amplitude, energy / (np.pi * amplitude**2 * w), energy, periods)
