"""What a run says over time, from its samples or, without samples, from its envelope."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.colors import to_hex, to_rgb

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.plots.style import BALLS, ball_color
from autobalancer.results.drawn import bodies_of, cubic
from autobalancer.results.time_series import NONE, end_of_run_up, load_of

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
    without = _at_last_speed(run, start, end) if held is None else _locked_ball_vibration(held, start, end)
    return Deflections(
        time[inside], low[inside], high[inside], envelope, name, static, curves, ends_at(run, end), without
    )


def ends_at(run: xr.Dataset, end: float) -> bool:
    """Whether a run ends at ``end`` (s)."""
    return end >= span_of(run)[1] - 1e-9


def _locked_ball_vibration(held: xr.Dataset, start: float, end: float) -> Curve | None:
    """The vibration of the reference place over the time of another run."""
    deflections = deflections_of(held, start, end)
    if deflections is None:
        return None
    return deflections.curves[0] if deflections.static else Curve("", deflections.time, deflections.high)


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
    angle, result = _column(run, "rotor_angle"), places(run)
    rest = [static_part(run, time, angle, place.deflection, end) for place in result]
    moving = [np.abs(place.deflection - still) for place, still in zip(result, rest, strict=True)]
    aside = abs(rest[0]) > 0.1 * float(moving[0][inside][-1]) and abs(rest[0]) > 1e-9
    curves = []
    for place, values in zip(result, moving, strict=True):
        if aside or place is not result[0]:
            label = place.name if len(result) > 1 else ""
            curves.append(Curve(label, *_greatest(time[inside], values[inside])))
    return result[0].name if len(result) > 1 else "", rest[0] if aside else 0j, tuple(curves)


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


# The places on the axis whose deflection a run knows: the planes of its balancers, then its other stations.


class Place(NamedTuple):
    """A place and its motion; ``position`` is m along the axis, nan if not known."""

    name: str
    position: float
    deflection: Complexes  # m, x + i y in space, over time


def places(run: xr.Dataset, prefix: str = "") -> list[Place]:
    """The reference place first; with ``prefix`` "turn_" over the last revolutions.

    A station in the plane of a balancer is named after it once, not twice.
    """
    reference = np.asarray(run[f"{prefix}x"].values + 1j * run[f"{prefix}y"].values)
    places: list[Place] = []
    for kind in ("place",) if f"{prefix}place_x" in run else ("plane", "station"):
        if f"{prefix}{kind}_x" not in run:
            continue
        if kind == "place" and "place_kind" in run:
            run = run.isel(place=np.flatnonzero(run["place_kind"].values != "support"))
        names = planes_of(run).names if kind == "plane" else _renamed(run, kind)
        z = np.asarray(run[f"{prefix}{kind}_x"].values + 1j * run[f"{prefix}{kind}_y"].values)
        where = run[f"{kind}_position"].values if f"{kind}_position" in run else np.full(z.shape[1], np.nan)
        for name, position, column in zip(names, where, z.T, strict=True):
            if not any(np.allclose(column, place.deflection, rtol=1e-9, atol=0.0) for place in places):
                places.append(Place(str(name), float(position), column))
    same = [place for place in places if np.allclose(place.deflection, reference, rtol=1e-9, atol=0.0)]
    if not same:
        return [Place("rotor", float("nan"), reference), *places]
    return [same[0], *(place for place in places if place is not same[0])]


class PlacesInRotor(NamedTuple):
    """Places with a position on the axis, in its order, at some times."""

    names: tuple[str, ...]
    position: Floats  # (places,) m
    deflection: Complexes  # (times, places) m, in the rotor


def places_in_rotor(run: xr.Dataset, times: Floats) -> PlacesInRotor | None:
    """What is known along the axis at ``times`` (s); ``None`` if that are fewer than two places."""
    known = [place for place in places(run) if np.isfinite(place.position)]
    known = sorted(known, key=lambda place: place.position)
    if len({place.position for place in known}) < 2:
        return None
    samples = run["time"].values
    z = np.column_stack([place.deflection for place in known]) * np.exp(-1j * run["rotor_angle"].values)[:, None]
    between = cubic(times, samples, z, np.gradient(z, samples, axis=0))
    return PlacesInRotor(
        tuple(place.name for place in known), np.array([place.position for place in known]), np.asarray(between)
    )


def _renamed(run: xr.Dataset, kind: str) -> list[str]:
    """Names of stations or places; a place that is a plane is called by its balancers, as everywhere in pictures."""
    known = {}
    if "plane" in run:
        known = dict(zip(map(str, run["plane"].values), planes_of(run).names, strict=True))
    return [known.get(str(name), str(name)) if kind == "place" else str(name) for name in run[kind].values]


# What of a deflection stands still in space, and what vibrates about it.


SAMPLES = 60  # that are looked at around a moment
TURNS = 4.0  # of the rotor, at least as many as they span: within less a whirl that grows looks like one about another place
LEAST = 0.1  # of the vibration; a smaller static part cannot be told from one that comes and goes
APART = 30.0  # condition above which samples do not tell a turning vector from a standing one


def static_part(
    run: xr.Dataset, time: Floats, angle: Floats, deflection: Complexes, moment: float, *, samples: int = SAMPLES
) -> complex:
    """The mean place in m, x + i y in space, about which a place moves around a ``moment`` (s).

    Fitted to samples of the deflection in space: a vector that stands, one that turns with the rotor (by ``angle``) and
    one against it. Zero where nothing can deflect the rotor for good, as on a vertical axis without a recorded excitation,
    where samples lie so far apart that they always see the rotor from the same side, and where what these three leave is
    greater than the standing one.
    """
    loaded = load_of({"axis": "horizontal"} | run.attrs) != NONE
    still = not loaded or run.attrs.get("frame_of_integration", "space") == "rotor"
    if still or time.size < 8:
        return 0j
    near = np.argsort(np.abs(time - moment))[:samples]
    if np.ptp(angle[near]) < 2.0 * np.pi * TURNS:
        here = np.interp(moment, time, angle)
        near = np.flatnonzero(np.abs(angle - here) <= 2.0 * np.pi * TURNS)
    turned = np.exp(1j * angle[near])
    columns = np.column_stack([np.ones(near.size), turned, turned.conj()])
    if np.linalg.cond(columns) > APART:
        return 0j
    standing, *turning = result = np.linalg.lstsq(columns, deflection[near], rcond=None)[0]
    rest = float(np.sqrt(np.mean(np.abs(deflection[near] - columns @ result) ** 2)))
    return complex(standing) if abs(standing) > max(LEAST * sum(map(abs, turning)), rest) else 0j


# Colors and legend entries of the balls of a run, names of balancers and planes: the same in every picture.


FEW = len(BALLS)  # so many balls have a color of their own


class BallLook(NamedTuple):
    """How one ball is drawn; label "_" hides an entry of the legend."""

    color: str
    label: str


def ball_looks(run: xr.Dataset) -> list[BallLook]:
    """A color for each of few balls; of more, one for each race, in shades from its first ball to its last."""
    count = run.sizes.get("ball", 0)
    if count <= FEW:
        return [BallLook(ball_color(i), f"{body} {i + 1}") for i, body in enumerate(bodies_of(run))]
    places = list(zip(_ball_column(run, "balancer", count), _ball_column(run, "race", count), strict=True))
    groups = sorted(set(places))
    looks = [BallLook("", "_")] * count
    for number, place in enumerate(groups):
        members = [i for i, where in enumerate(places) if where == place]
        for shade, i in zip(np.linspace(-0.4, 0.4, len(members)), members, strict=True):
            looks[i] = BallLook(shaded(ball_color(number), float(shade)), "_")
        middle = members[len(members) // 2]
        name = group_name(run, place, groups)
        body = bodies_of(run)[members[0]] if len(set(bodies_of(run)[members])) == 1 else "ball"
        first, last = members[0] + 1, members[-1] + 1
        text = f"{body}s {first} to {last}" if len(members) > 1 else f"{body} {first}"
        looks[middle] = looks[middle]._replace(label=f"{text}, {name}" if name else text)
    return looks


def group_name(run: xr.Dataset, place: tuple[int, int], groups: list[tuple[int, int]]) -> str:
    """What tells a race (its balancer and number, from 1) from the others: the name of its balancer, its number, or both."""
    parts = []
    if len({balancer for balancer, _ in groups}) > 1:
        parts.append(balancer_name(run, place[0]))
    if sum(balancer == place[0] for balancer, _ in groups) > 1:
        parts.append(f"race {place[1]}")
    return ", ".join(parts)


def balancer_name(run: xr.Dataset, number: int) -> str:
    """The name of a balancer, counted from 1; its number if the run knows no names."""
    if "balancer_name" in run and "balancer" in run:
        held = run["balancer_name"].values[run["balancer"].values == number]
        if held.size:
            return str(held[0])
    return f"balancer {number}"


class Planes(NamedTuple):
    """The planes of the balancers; a rotor that only moves sideways has one."""

    names: tuple[str, ...]  # of the balancers in each
    position: Floats  # m along the axis; nan if not known


def planes_of(run: xr.Dataset) -> Planes:
    """The planes of a run."""
    count = run.sizes.get("plane", 1)
    if "ball_plane" not in run or (count == 1 and "station" not in run):
        return Planes(("rotor",), np.array([np.nan]))
    where, held = run["ball_plane"].values, _ball_column(run, "balancer", run.sizes["ball"])
    names = []
    for plane in range(1, count + 1):
        balancers = sorted({number for number, place in zip(held, where, strict=True) if place == plane})
        names.append(" and ".join(balancer_name(run, number) for number in balancers) or f"plane {plane}")
    position = run["plane_position"].values if "plane_position" in run else np.full(count, np.nan)
    return Planes(tuple(names), np.asarray(position, np.float64))


def shaded(color: str, share: float) -> str:
    """A color lighter (towards 1: white) or darker (towards -1: black)."""
    rgb = np.array(to_rgb(color))
    red, green, blue = (rgb + (1.0 - rgb) * share if share > 0.0 else rgb * (1.0 + share)).tolist()
    return str(to_hex((red, green, blue)))


def _ball_column(run: xr.Dataset, name: str, count: int) -> list[int]:
    return [int(value) for value in run[name].values] if name in run else [1] * count
