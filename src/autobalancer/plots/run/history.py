"""What a run says over time, from its samples or, without samples, from its envelope."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.plots.run.places import places
from autobalancer.plots.run.static import static_part
from autobalancer.results.series import end_of_run_up

Floats = NDArray[np.float64]
CALM = 0.05  # of the greatest deflection
SAVE_MORE = "save Samples() or Envelope() with simulate(..., save=...)"


class History(NamedTuple):
    """Columns over ``time`` (s); balls are the second axis. Nothing known is an array without columns or rows."""

    time: Floats
    speed: Floats  # rad/s
    ball_angle_in_rotor: Floats  # rad, not wrapped
    ball_speed_in_space: Floats  # rad/s
    unbalance_angle_in_rotor: Floats  # rad, of each plane; no columns if not known


class CriticalSpeeds(NamedTuple):
    """Critical speeds (rad/s), and of which motions they are where the stiffness depends on the deflection."""

    levels: list[float]
    of: str = ""


class Curve(NamedTuple):
    """Deflection or vibration of a place over time, from samples."""

    name: str
    time: Floats
    value: Floats  # m


class Deflections(NamedTuple):
    """Least and greatest deflection (m) over time (s) of the reference place; the same twice if the run has samples only."""

    time: Floats
    low: Floats
    high: Floats
    is_envelope: bool
    name: str = ""  # of the reference place, if there are others
    static: complex = 0j  # m, about which the place vibrates at the end
    curves: tuple[Curve, ...] = ()  # of other places; with a static deflection the vibration of all
    ends: bool = True  # whether the run ends where they end
    without: Curve | None = None  # the vibration of the same machine with its balls spread and held


def span_of(run: xr.Dataset, start: float | None = None, end: float | None = None) -> tuple[float, float]:
    """The interval asked for, or as much of it as was not said from the run itself.

    Raises
    ------
    QuestionError
        If the run has no times, or the interval is empty or outside the run.
    """
    known = [run[name].values for name in ("time", "envelope_time", "turn_time") if name in run]
    known = [times for times in known if times.size]
    if not known:
        raise QuestionError(f"the run has nothing over time; {SAVE_MORE}")
    begin = min(0.0 if run.attrs.get("end_time") else np.inf, *(float(times[0]) for times in known), np.inf)
    last = max(float(run.attrs.get("end_time", -np.inf)), *(float(times[-1]) for times in known))
    first = begin if start is None else float(start)
    final = last if end is None else float(end)
    if not begin - 1e-9 <= first < final <= last + 1e-9:
        raise QuestionError(
            f"from {first:g} s to {final:g} s: the run has {begin:g} s to {last:g} s; choose an interval within it"
        )
    return first, final


def history_of(run: xr.Dataset, start: float, end: float) -> History | None:
    """Speed and balls within an interval, or ``None`` if the run has neither samples nor an envelope with speed."""
    if "time" in run and "speed" in run:
        time, speed = _column(run, "time"), _column(run, "speed")
        angle = _balls(run, "ball_angle_in_rotor", time.size)
        ball_speed = _balls(run, "ball_speed_in_space", time.size)
        unbalance = _balls(run, "plane_unbalance_angle_in_rotor", time.size)
        if not unbalance.size and "unbalance_angle_in_rotor" in run:
            unbalance = _column(run, "unbalance_angle_in_rotor")[:, None]
    elif "envelope_time" in run and "envelope_speed" in run:
        middle = _column(run, "envelope_time")
        half = middle[:1] if middle.size == 1 else 0.5 * np.diff(middle)
        time = middle + np.append(half, half[-1:])[: middle.size]  # these three are known at the end of a bin
        speed = _column(run, "envelope_speed")
        angle = _balls(run, "envelope_ball_angle_in_rotor", time.size)
        slip = _balls(run, "envelope_ball_speed_in_rotor", time.size)
        ball_speed, unbalance = slip + speed[:, None], np.empty((time.size, 0))
    else:
        return None
    inside = (time >= start - 1e-9) & (time <= end + 1e-9)
    unbalance = np.unwrap(np.nan_to_num(unbalance), axis=0)[inside]  # nan at a critical speed without damping
    return History(time[inside], speed[inside], angle[inside], ball_speed[inside], unbalance)


def deflections_of(run: xr.Dataset, start: float, end: float, held: xr.Dataset | None = None) -> Deflections | None:
    """The envelope within an interval, or the sampled deflection, or ``None`` if there is neither.

    ``held`` is the same machine with its balls held; without it only the vibration at the last speed is known.
    """
    if "envelope_high" in run and "envelope_time" in run:
        time, high = _column(run, "envelope_time"), _column(run, "envelope_high")
        low = _column(run, "envelope_low") if "envelope_low" in run else np.zeros_like(high)
        envelope = True
    elif "deflection" in run and "time" in run:
        time, high = _column(run, "time"), _column(run, "deflection")
        low, envelope = high, False
    else:
        return None
    inside = (time >= start - 1e-9) & (time <= end + 1e-9)
    name, static, curves = places_of(run, start, end)
    without = _at_last_speed(run, start, end) if held is None else _of_held(held, start, end)
    return Deflections(
        time[inside], low[inside], high[inside], envelope, name, static, curves, ends_at(run, end), without
    )


def ends_at(run: xr.Dataset, end: float) -> bool:
    """Whether a run ends at ``end`` (s)."""
    return end >= span_of(run)[1] - 1e-9


def _of_held(held: xr.Dataset, start: float, end: float) -> Curve | None:
    """The vibration of the reference place over the time of another run."""
    found = deflections_of(held, start, end)
    if found is None:
        return None
    return found.curves[0] if found.static else Curve("", found.time, found.high)


def _at_last_speed(run: xr.Dataset, start: float, end: float) -> Curve | None:
    """What the run knows of the machine without balancing: its vibration at the last speed, from when this is reached."""
    if "vibration_without_balls" not in run or "speed" not in run or run["time"].size < 2:
        return None
    level = float(run["vibration_without_balls"].values[0])
    time = run["time"].values
    first = max(end_of_run_up(time, run["speed"].values, float(time[0])), _last_change(run), start)
    first = min(first, float(time[-2]))
    last = min(end, float(run["time"].values[-1]))
    return Curve("", np.array([first, last]), np.full(2, level)) if np.isfinite(level) and first < last else None


def _last_change(run: xr.Dataset) -> float:
    """From when on the unbalance is that of the end, s."""
    time = run["time"].values
    latest = float(time[0])
    for size, side in (
        ("unbalance", "unbalance_angle_in_rotor"),
        ("plane_unbalance", "plane_unbalance_angle_in_rotor"),
    ):
        if size in run and side in run:
            vector = (run[size].values * np.exp(1j * run[side].values)).reshape(time.size, -1)
            other = np.abs(vector - vector[-1]).max(axis=1) > 1e-3 * np.abs(vector[-1]).max(initial=0.0)
            if other.any():
                latest = max(latest, float(time[min(int(np.flatnonzero(other)[-1]) + 1, time.size - 1)]))
    return latest


def places_of(run: xr.Dataset, start: float, end: float) -> tuple[str, complex, tuple[Curve, ...]]:
    """Name and static deflection of the reference place, and the curves of the others, or of all about where they rest."""
    time = _column(run, "time")
    inside = (time >= start - 1e-9) & (time <= end + 1e-9)
    if inside.sum() < 2 or "rotor_angle" not in run or "x" not in run:
        return "", 0j, ()
    angle, found = _column(run, "rotor_angle"), places(run)
    rest = [static_part(run, time, angle, place.deflection, end) for place in found]
    moving = [np.abs(place.deflection - still) for place, still in zip(found, rest, strict=True)]
    aside = abs(rest[0]) > 0.1 * float(moving[0][inside][-1]) and abs(rest[0]) > 1e-9
    curves = []
    for place, values in zip(found, moving, strict=True):
        if aside or place is not found[0]:
            label = place.name if len(found) > 1 else ""
            curves.append(Curve(label, *_greatest(time[inside], values[inside])))
    return found[0].name if len(found) > 1 else "", rest[0] if aside else 0j, tuple(curves)


def quiet(deflections: Deflections) -> bool:
    """Whether the end is so calm, next to the greatest deflection, that a linear axis would not show it."""
    at_end = [deflections.high, *(curve.value for curve in deflections.curves)]
    last = min(float(np.nanmax(values[int(0.97 * values.size) :], initial=0.0)) for values in at_end)
    return last < CALM * float(np.nanmax(deflections.high, initial=0.0))


def _greatest(time: Floats, value: Floats, bins: int = 800) -> tuple[Floats, Floats]:
    """The greatest of some samples at a time where there are more of them than can be told apart in a picture."""
    if time.size <= 2 * bins:
        return time, value
    edges = np.linspace(0, time.size, bins + 1).astype(int)[:-1]
    ends = np.append(edges[1:], time.size) - 1
    return 0.5 * (time[edges] + time[ends]), np.maximum.reduceat(value, edges)


def critical_speeds_of(run: xr.Dataset) -> CriticalSpeeds:
    """``attrs["critical_speeds"]`` (rad/s), if the run says any; a file with one returns a bare number."""
    known = np.atleast_1d(np.asarray(run.attrs.get("critical_speeds", []), np.float64))
    motions = run.attrs.get("critical_speeds_of")
    return CriticalSpeeds([float(speed) for speed in known if np.isfinite(speed)], f" of {motions}" if motions else "")


def passages(time: Floats, speed: Floats, level: float) -> list[float]:
    """Times at which the speed passes ``level``; passages closer than 2 % of the interval count once."""
    above = speed > level
    times: list[float] = []
    for i in np.flatnonzero(above[1:] != above[:-1]):
        part = (level - speed[i]) / (speed[i + 1] - speed[i])
        moment = float(time[i] + part * (time[i + 1] - time[i]))
        if not times or moment - times[-1] > 0.02 * (time[-1] - time[0]):
            times.append(moment)
    return times


def _column(run: xr.Dataset, name: str) -> Floats:
    return np.asarray(run[name].values, np.float64) if name in run else np.empty(0)


def _balls(run: xr.Dataset, name: str, rows: int) -> Floats:
    return np.asarray(run[name].values, np.float64) if name in run else np.empty((rows, 0))
