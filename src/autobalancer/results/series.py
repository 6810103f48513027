"""The numbers behind the measures: functions on plain arrays, so that a sweep can use them a thousand times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]

STALL_MARGIN = 0.02  # a ball can be called stalled only this far (relative) above the critical speed
CONSTANT = 1e-3  # a speed that differs by less (relative) from its last value is constant
REST = 1e-3  # balls that in the mean are slower than this share of the rotor speed rest at the end of a run


def settled_from(time: Floats, angle: Floats, rotor_speed: Floats, tolerance: float) -> Floats:
    """Time from which each ball stays within ``tolerance`` (rad) of its last angle; nan if it still moves.

    ``angle`` is (time, ball), in the rotor. Balls that swing under gravity come to rest in the mean over a revolution.
    """
    result = np.full(angle.shape[1], np.nan)
    end, turn = abs(float(rotor_speed[-1])), 2.0 * np.pi / max(abs(float(rotor_speed[-1])), 1e-300)
    first = min(max(int(np.searchsorted(time, time[-1] - turn, side="right")) - 1, 0), time.size - 2)
    passed = time[-1] - time[first] if time.size > 1 else 1.0
    for i in range(angle.shape[1]):
        if abs(angle[-1, i] - angle[first, i]) > REST * end * passed:
            continue
        away = np.flatnonzero(np.abs(angle[:, i] - angle[-1, i]) > tolerance)
        if away.size == 0:
            result[i] = time[0]
        elif away[-1] + 1 < time.size - 1:
            result[i] = time[away[-1] + 1]
    return result


def released_at(rotor_speed: Floats, ball_speed: Floats, critical_speed: float) -> Floats:
    """Rotor speed at which each stalled ball breaks away; nan if it never stalled or never broke away.

    Arguments and rule as for :func:`release_rows`.
    """
    rows = release_rows(rotor_speed, ball_speed, critical_speed)
    return np.asarray(np.interp(rows, np.arange(rotor_speed.size), rotor_speed), np.float64)


def release_rows(rotor_speed: Floats, ball_speed: Floats, critical_speed: float) -> Floats:
    """Row, with its fraction, at which each stalled ball breaks away; nan if it never stalled or never broke away.

    ``ball_speed`` is (time, ball), in space. A ball is stalled while it is three times nearer to the critical speed than to
    the rotor speed, at least 2 % above the critical speed. A stalled ball hangs just below the critical speed; it is
    released where it passes it for the last time, if it then comes nearer to the rotor speed.
    """
    margin = rotor_speed - critical_speed
    above = margin > STALL_MARGIN * critical_speed
    result = np.full(ball_speed.shape[1], np.nan)
    for i in range(ball_speed.shape[1]):
        excess = ball_speed[:, i] - critical_speed
        stalled = np.flatnonzero(above & (excess < 0.25 * margin))
        if stalled.size < 2 or excess[-1] < 0.5 * margin[-1]:
            continue
        below = np.flatnonzero(above & (excess < 0.0))
        if below.size == 0:  # it hung above the critical speed: take the end of the stall
            below = stalled
        last = min(int(below[-1]), rotor_speed.size - 2)
        rise = excess[last + 1] - excess[last]
        result[i] = last + (min(max(-excess[last] / rise, 0.0), 1.0) if rise > 0.0 else 0.5)
    return result


def lifted_from(values: Floats, floor: Floats) -> Floats:
    """Of values over time that of the first sample from which on the floor carries each ball no more; nan if it does at the end.

    ``floor`` is the force of the floor, (time, ball).
    """
    carried = [np.flatnonzero(force > 0.0) for force in floor.T]
    rows = [int(on[-1]) + 1 if on.size else 0 for on in carried]
    return np.array([values[row] if row < values.size else np.nan for row in rows])


def end_of_run_up(time: Floats, rotor_speed: Floats) -> float:
    """Time from which the rotor speed stays within 0.1 % of its last value; the first time if it does from there on."""
    away = np.flatnonzero(np.abs(rotor_speed - rotor_speed[-1]) > CONSTANT * abs(rotor_speed[-1]))
    return float(time[away[-1] + 1]) if away.size else float(time[0])


def counted(
    settled: Floats, released: Floats, run_up: float, start: float, jumps: Sequence[float] = ()
) -> tuple[Floats, list[str]]:
    """Duration of settling of each ball, and from where it counts: the last of these times that is not after it.

    ``settled`` and ``released`` (s) are (ball,), nan where there is none; ``run_up`` is the end of the run-up, ``jumps`` (s) are
    those of the unbalance. The last of them up to ``start`` counts in its place.
    """
    origin = max([(jump, "jump") for jump in jumps if jump <= start], default=(start, "start"))
    duration, names = np.full(settled.size, np.nan), []
    for i, at in enumerate(settled):
        begins = [origin, (run_up, "end of the run-up"), (float(released[i]), "release")]
        if run_up <= start:
            del begins[1]
        begins += [(jump, "jump") for jump in jumps if jump > start]
        known = [begin for begin in begins if begin[0] <= at]
        begin, name = max(known, key=lambda entry: entry[0]) if known else (np.nan, "")
        duration[i] = at - begin
        names.append(name)
    return duration, names


def wrapped(angle: Floats) -> Floats:
    """The same angle within (-pi, pi]."""
    return np.asarray(np.pi - np.mod(np.pi - angle, 2.0 * np.pi), np.float64)


def last_deflection(time: Floats, high: Floats, begin: float) -> float:
    """The greatest of ``high`` (m) from ``begin`` (s) on, the last one in any case."""
    inside = time >= begin
    inside[-1] = True
    return float(high[inside].max())


def mean_size(z: NDArray[np.complex128]) -> Floats:
    """Mean over time of the size of x + i y, (times, ...)."""
    return np.asarray(np.abs(z).mean(axis=0), np.float64)


def share_of(part: ArrayLike, whole: ArrayLike) -> Floats:
    """``part`` over ``whole``; nan where there is no whole."""
    part, whole = np.asarray(part, np.float64), np.asarray(whole, np.float64)
    return np.asarray(np.divide(part, whole, out=np.full_like(part, np.nan), where=whole > 0.0))


def last_settled(at: Floats) -> int:
    """The ball that settles last, or one that never does; ``at`` (s) is (ball,), nan where it never does."""
    return int(np.argmax(at))  # nan is the greatest


def greatest_known(values: Floats) -> float:
    """The greatest that is not nan; nan if there is none."""
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else np.nan


def time_near_peak(width: Floats, high: Floats) -> float:
    """Time (s) with a deflection above half of the greatest of the run; of bins with their ``width`` (s) and greatest (m)."""
    return float(width[high > 0.5 * high.max()].sum())
