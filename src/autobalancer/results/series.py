"""The numbers behind the measures of one run, asked of compiled functions that sweeps use, too.

They are loaded when something is measured, not when measures are named.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from autobalancer.machine import Machine

Floats = NDArray[np.float64]

ORIGINS = (
    "",
    "start",
    "jump",
    "end of the run-up",
    "release",
)  # in the order of kernels/measures/columns_of_measures.py


@cache
def compiled() -> Any:
    """The compiled functions."""
    from autobalancer.kernels.measures import record_series

    return record_series


def plain(values: ArrayLike) -> Floats:
    """Numbers as compiled functions take them."""
    return np.require(values, np.float64, ["C", "W"])


def settled_from(time: Floats, angle: Floats, rate: Floats, start: float, tolerance: float) -> Floats:
    """Time from which each ball stays within ``tolerance`` (rad) of the angle to which it goes; nan if it has not settled.

    ``angle`` and ``rate`` are (time, ball), in the rotor; ``start`` (s) is where the record begins. A ball has settled that has
    been within the tolerance of its last angle for a twentieth of the record, and whose way still to come is not longer.
    """
    found = np.empty(angle.shape[1])
    compiled().settled_from(plain(time), plain(angle), plain(rate), start, tolerance, found)
    return found


def creeps(time: Floats, angle: Floats, settled: Floats, since: float, end: float) -> bool:
    """Whether a ball that has not ``settled`` (nan) drifts in the last fifth of a run of ``end`` seconds, after ``since`` (s)."""
    return bool(compiled().creeps(plain(time), plain(angle), plain(settled), since, end))


def release_rows(rotor_speed: Floats, rate: Floats, critical_speed: float) -> Floats:
    """Row, with its fraction, at which each stalled ball breaks away; nan if it never stalled or never broke away.

    ``rate`` is (time, ball), in the rotor. A ball is stalled while it is three times nearer to the critical speed than to
    the rotor speed, at least 2 % above the critical speed. A stalled ball hangs just below the critical speed; it is
    released where it passes it for the last time, if it then comes nearer to the rotor speed.
    """
    found = np.empty(rate.shape[1])
    compiled().release_rows(plain(rotor_speed), plain(rate), critical_speed, found)
    return found


def values_at(rows: Floats, values: Floats) -> Floats:
    """Values at rows with a fraction; nan where the row is."""
    values = plain(values)
    return np.array([compiled().value_at(row, values) for row in rows], np.float64)


def stalled_times(start: float, time: Floats, rotor_speed: Floats, rate: Floats, critical_speed: float) -> Floats:
    """How long each ball is stalled, s, by the rule of :func:`release_rows`; ``start`` (s) is where the first step begins."""
    found = np.empty(rate.shape[1])
    compiled().stalled_times(start, plain(time), plain(rotor_speed), plain(rate), critical_speed, found)
    return found


def fastest(rotor_speed: Floats, rate: Floats) -> Floats:
    """Greatest speed of each ball in space, rad/s."""
    found = np.empty(rate.shape[1])
    compiled().fastest(plain(rotor_speed), plain(rate), found)
    return found


def lifted_from(values: Floats, floor: Floats) -> Floats:
    """Of values over time that of the first sample from which on the floor carries each ball no more; nan if it does at the end.

    ``floor`` is the force of the floor, (time, ball).
    """
    carried = [np.flatnonzero(force > 0.0) for force in floor.T]
    rows = [int(on[-1]) + 1 if on.size else 0 for on in carried]
    return np.array([values[row] if row < values.size else np.nan for row in rows])


def end_of_run_up(time: Floats, rotor_speed: Floats, start: float) -> float:
    """Time from which the rotor speed stays within 0.1 % of its last value; ``start`` (s) if it always does."""
    return float(compiled().end_of_run_up(plain(time), plain(rotor_speed), start))


def origin_of(after: float, cause: int, start: float, end: float, jumps: Sequence[float] = ()) -> tuple[float, str]:
    """From when (s) settling counts in a run from ``start`` to ``end``, and what happened then.

    That is ``after`` (nan if there is none; ``cause`` is one of those of sweeps) or a jump of the unbalance, if that is later.
    """
    begin, code = compiled().origin_of(after, cause, start, end, plain(list(jumps)))
    return float(begin), ORIGINS[code]


def time_since(begin: float, settled: Floats) -> Floats:
    """How long after ``begin`` (s) balls have settled: zero if they had before, nan if they have not."""
    return np.array([compiled().time_since(begin, at) for at in settled], np.float64)


def wrapped(angle: ArrayLike) -> Floats:
    """The same angle within (-pi, pi]."""
    given = plain(angle)
    found = np.empty_like(given)
    compiled().all_wrapped(given.ravel(), found.ravel())
    return found


def last_deflection(time: Floats, high: Floats, begin: float) -> float:
    """The greatest of ``high`` (m) from ``begin`` (s) on, the last one in any case."""
    return float(compiled().last_deflection(plain(time), plain(high), begin))


def mean(values: Floats) -> float:
    """Mean of some numbers, summed one after the other."""
    return float(compiled().mean(plain(values)))


def means(values: Floats) -> Floats:
    """The same of each column."""
    return np.array([mean(column) for column in values.T], np.float64)


def share_of(part: ArrayLike, whole: ArrayLike) -> Floats:
    """``part`` over ``whole``; nan where there is no whole."""
    part, whole = np.asarray(part, np.float64), np.asarray(whole, np.float64)
    return np.asarray(np.divide(part, whole, out=np.full_like(part, np.nan), where=whole > 0.0))


def crests(time: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Where the greatest of each column of samples (T, L) is in size, s, and its value there, both (L,).

    Between samples it is the vertex of the parabola through the greatest one and its neighbors: of a sine with ten samples in a
    cycle 0.4 % too low at most, where the greatest sample is up to 5 % too low.
    """
    at = np.abs(values).argmax(axis=0)
    columns = np.arange(values.shape[1])
    before, after = np.maximum(at - 1, 0), np.minimum(at + 1, len(time) - 1)
    best, top = np.asarray(time[at], np.float64), values[at, columns]
    inside = (before < at) & (at < after)
    left, right = time[at] - time[before], time[after] - time[at]
    rise, fall = top - values[before, columns], values[after, columns] - top
    with np.errstate(divide="ignore", invalid="ignore"):
        bend = (fall / right - rise / left) / (left + right)
        slope = (rise / left * right + fall / right * left) / (left + right)
        shift = np.where(inside & (bend != 0.0), -0.5 * slope / bend, 0.0)
        more = np.where(inside & (bend != 0.0), 0.5 * slope * shift, 0.0)
    return best + shift, top + more


def greatest_at(values: Floats) -> int:
    """Where the greatest is, the first one; nan is greater than all, so that of times it is the one that never comes."""
    return int(compiled().greatest_at(plain(values)))


def greatest_known(values: Floats) -> float:
    """The greatest that is a number; nan if there is none."""
    return float(compiled().greatest_known(plain(values)))


def time_near_peak(width: Floats, high: Floats) -> float:
    """Time (s) with a deflection above half of the greatest of the run; of bins with their ``width`` (s) and greatest (m)."""
    return float(compiled().time_near_peak(plain(width), plain(high)))


def time_at_resonance(time: Floats, rotor_speed: Floats, critical_speed: float) -> float:
    """Time (s) with a rotor speed within a tenth of the critical speed; nan without one."""
    return float(compiled().time_at_resonance(plain(time), plain(rotor_speed), critical_speed))


# What of a motion in space stands still: its mean over whole turns of everything that whirls.


Complexes = NDArray[np.complex128]

WEIGHT, RECORD, NONE = "weight", "recorded excitation", "none"


def static_load(machine: Machine) -> str:
    """What can deflect a rotor for good: ``"weight"``, ``"recorded excitation"`` or ``"none"``.

    Without such a load no direction in space is preferred, on any supports: with every motion its opposite is possible, too.
    """
    if machine.axis == "horizontal":
        return WEIGHT
    recorded = any(part.kind in ("recorded_force", "recorded_base_motion") for part in machine.excitations)
    return RECORD if recorded else NONE


def standing(z: Complexes, rotor: Floats, balls: Floats, load: str) -> Complexes:
    """The part of x + i y that stands still, (columns,); zero without a static ``load``.

    Parameters
    ----------
    z
        (times, columns), at equal steps of the rotor angle over whole turns.
    rotor
        Angle of the rotor, rad, (times,).
    balls
        Angles of the balls in space, rad, (times, balls). Where some of them go round both in space and in the rotor, the
        revolutions of the rotor are not those of the deflection. Then the standing part is fitted together with what whirls
        with the rotor, with the balls, and against them. Weights that vanish at both ends (Hann's) suppress the rest.
    """
    found = np.zeros(z.shape[1], np.complex128)
    if load == NONE:
        return found
    from autobalancer.kernels.measures import record_series

    count, columns = z.shape[0], 1 + 2 * (1 + balls.shape[1])
    work = np.zeros((max(count, columns), columns + z.shape[1] + 1), np.complex128)
    small = np.zeros((columns, columns + z.shape[1]), np.complex128)
    record_series.standing(complexes(z), count, plain(rotor), plain(balls), 0, work, small, found)
    return found


def complexes(values: Any) -> Complexes:
    """x + i y as compiled functions take it."""
    return np.require(values, np.complex128, ["C", "W"])


def calm_mean(values: Complexes | Floats) -> Complexes:
    """Mean over the first axis with weights that vanish at both ends (Hann's), so that parts of turns hardly count.

    What goes round n times adds about 1/n^3 of its size, to the plain mean 1/n.
    """
    steps = len(values)
    weight = np.sin(np.pi * (np.arange(steps) + 0.5) / steps) ** 2
    return np.asarray(np.tensordot(weight / weight.sum(), values, axes=1), np.complex128)


def standing_in(run: xr.Dataset, z: Complexes, prefix: str = "turn_") -> Complexes:
    """The same for the last revolutions of a run, or with ``prefix`` "" for its samples; ``z`` is (times, columns)."""
    rotor = run[f"{prefix}rotor_angle"].values
    name = f"{prefix}ball_angle_in_rotor"
    inside = run[name].values if name in run else np.zeros((rotor.size, 0))
    return standing(z, rotor, rotor[:, None] + inside, load_of(run.attrs))


def load_of(attributes: dict[Any, Any]) -> str:
    """The static load of a run; runs of earlier versions say only how the axis lies."""
    known = WEIGHT if attributes.get("axis", "vertical") == "horizontal" else NONE
    return str(attributes.get("static_load", known))
