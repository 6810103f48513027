"""The arrays behind the measures, out of the labeled data of a run."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.kernels.measures.thresholds import LAST, NOWHERE, RELEASE, RUN_UP, SETTLED, START
from autobalancer.results import time_series

# What a run or one run of a sweep recorded, as plain arrays: all that a measure is computed from.


# Impacts of a run as plain arrays, and what they say of its noise.


class Impacts(NamedTuple):
    """Impacts in the order of time, (I,) each."""

    time: Floats  # s
    speed: Floats  # m/s, at which the bodies approached
    lost: Floats  # J
    impulse: Floats  # N s
    ball: NDArray[np.int64]  # counted from 1
    partner: NDArray[np.int64]  # the other ball, 0 a partition, -1 a wall of the race


VARIABLES = {
    "impact_speed": "speed",
    "impact_loss": "lost",
    "impact_impulse": "impulse",
    "impact_ball": "ball",
    "impact_partner": "partner",
}


def impacts_of(run: xr.Dataset) -> Impacts | None:
    """The impacts that a run noted; None where nothing could touch, or it noted none."""
    if "impact_time" not in run:
        return None
    return Impacts(run["impact_time"].values, **{name: run[kept].values for kept, name in VARIABLES.items()})


# attribute of a run, rad/s: past this critical speed its drive does not take the rotor
HELD_AT = "held_at_critical_speed"
NEVER_ENDED = time_series.ORIGINS[START], time_series.ORIGINS[RUN_UP]  # of a rotor that does not arrive at its speed
SETTLING_FROM = ("run-up", "release")  # whose end settling times count from, the usual one first


class Bins(NamedTuple):
    """The envelope of the deflection at the reference station, (B,): in s, m and rad/s."""

    time: Floats
    width: Floats
    low: Floats
    high: Floats
    speed: Floats  # at the end of the bin
    end: Floats


class Balls(NamedTuple):
    """Motion of the balls in the rotor over time: samples, or the ends of bins. ``start`` (s) is where they begin."""

    start: float
    time: Floats  # (T,) s
    speed: Floats  # (T,) of the rotor, rad/s
    angle: Floats  # (T, n) rad
    rate: Floats  # (T, n) rad/s


class Links(NamedTuple):
    """Samples of the links between rotor and motor, (T, L): twist in rad, torque in N m. Time (s), rotor speed (rad/s), (T,)."""

    time: Floats
    speed: Floats
    twist: Floats
    torque: Floats

    @property
    def worst(self) -> NDArray[np.int64]:
        """The sample with the greatest torque of each link, (L,)."""
        return np.asarray(np.abs(self.torque).argmax(axis=0), np.int64)


class Settled(NamedTuple):
    """Of each ball how long it takes to settle (s) and when it has (s); from where all of them count, and when that was (s)."""

    duration: Floats
    at: Floats
    counted_from: str
    begin: float


@dataclass(frozen=True)
class Recorded:
    """The arrays of one run; None for what it did not record. Places, planes and supports in the last revolutions."""

    end: float  # s
    centered: bool  # nothing can deflect the rotor for good
    whirls: Floats  # (K, 2) critical speeds, rad/s, and gyroscopic shares
    bins: Bins
    balls: Balls | None = None
    jumps: Sequence[float] = ()  # of the unbalance, s
    late: Floats | None = None  # samples: distance of the reference station from its static place at the end, (T,) m
    turns: tuple[Complexes, Complexes, Complexes] | None = (
        None  # x + iy (m), x' + iy' (m/s), (T, places); static part (m)
    )
    forces: tuple[Complexes, Complexes] | None = None  # on the supports x + iy, (T, supports) N, and their static part
    pushes: Complexes | None = None  # forces on the supports in the samples, (T, supports) N
    planes: tuple[Floats, Complexes] | None = (
        None  # unbalance of planes, what balls leave of it in the rotor, (T, P) kg m
    )
    rotor: tuple[Floats, Complexes] | None = (
        None  # unbalance, of several planes the sum, (T,), and what is left, (T, P or 1)
    )
    without_balls: Floats | None = None  # vibration with the balls spread and held, (places,) m
    final_angle: Floats | None = None  # of each ball from the unbalance at the end, (n,) rad
    parts: tuple[Recorded, ...] | None = None  # after each jump of the unbalance
    held: float | None = None  # critical speed past which its drive does not take the rotor, rad/s; nan if it does
    settling_from: str = SETTLING_FROM[0]
    impacts: Impacts | None = None  # of balls on each other, partitions and walls
    links: Links | None = None  # of the drive train
    lifted: tuple[Floats, Floats] | None = (
        None  # of each ball when the floor stops carrying it, (n,) s, and the rotor speed then
    )

    @cached_property
    def of_rotor(self) -> Any:
        """What is measured of the rotor, by name."""
        return rotor_measures(self.bins, self.whirls)

    @cached_property
    def of_places(self) -> Any:
        """The same of all places; asks for ``turns``. At the reference station slow changes in the last twentieth count too."""
        assert self.turns is not None
        found = time_series.place_measures(*self.turns)
        if self.centered:
            found.vibration[0] = max(found.vibration[0], self.residual_vibration)
        return found

    @cached_property
    def of_supports(self) -> Any:
        """The same of the forces on all supports; asks for ``forces``."""
        assert self.forces is not None
        force, static = self.forces
        return time_series.place_measures(force, force, static)

    @cached_property
    def residual_vibration(self) -> float:
        """Vibration at the reference station at the end, m; nan if a static load hides it."""
        if self.centered:
            return time_series.last_deflection(self.bins.time, self.bins.high, self.end - LAST * self.end)
        if self.turns is not None:
            return float(self.of_places.vibration[0])
        return float(self.late.max()) if self.late is not None else np.nan

    @cached_property
    def of_impacts(self) -> Any:
        """The same of the impacts; asks for ``impacts``."""
        assert self.impacts is not None
        series, seen = time_series.compiled(), self.impacts
        row, numbers = np.full(series.WIDTH, np.nan), (seen.time, seen.speed, seen.lost, seen.impulse)
        late = self.end - LAST * self.end
        series.impact_measures(*map(time_series.plain, numbers), seen.time.size, late, self.end, row)
        return series.Column(*row)

    @cached_property
    def of_balls(self) -> Any:
        """The same of each ball; asks for ``balls``."""
        assert self.balls is not None
        series = time_series.compiled()
        found = np.empty((len(series.BALL), self.balls.rate.shape[1]))
        series.ball_measures(*_as_compiled(self.balls), self.stalls, found)
        return series.Ball(*found)

    @cached_property
    def settled(self) -> Settled:
        """How the balls settle; asks for ``balls``."""
        assert self.balls is not None
        held = self.held is not None and bool(np.isfinite(self.held))
        return settling(self.balls, self.whirls, self.jumps, held, self.settling_from)

    @cached_property
    def since(self) -> float:
        """From when the run was left alone, s: the end of the run-up, or the last jump of the unbalance."""
        bins = self.bins
        start = float(bins.end[0] - bins.width[0])
        return time_series.origin_of(
            time_series.end_of_run_up(bins.end, bins.speed, start), RUN_UP, start, self.end, self.jumps
        )[0]

    @cached_property
    def creeps(self) -> bool:
        """Whether a ball that has not settled drifts at the end."""
        balls = self.balls
        if balls is None:
            return False
        numbers = time_series.plain(balls.time), time_series.plain(balls.angle), time_series.plain(self.settled.at)
        return bool(time_series.compiled().creeps(*numbers, self.since, self.end))

    @cached_property
    def stalls(self) -> Floats:
        """Of :func:`stalls_of`; asks for ``balls``."""
        assert self.balls is not None
        return stalls_of(self.balls, self.whirls)

    @cached_property
    def at_rest(self) -> bool:
        """Whether all balls turn with the rotor at the end: none is stalled or goes round in it; true without balls."""
        if self.balls is None:
            return True
        numbers = time_series.plain(self.balls.time), time_series.plain(self.balls.angle)
        return not (np.isfinite(self.stalls[2]).any() or time_series.compiled().goes_round(*numbers, self.end))


def rotor_measures(bins: Bins, whirls: Floats) -> Any:
    """What is measured of the rotor over the bins of an envelope, by name."""
    series, numbers = time_series.compiled(), (bins.time, bins.end, bins.width, bins.high, bins.speed, whirls)
    row = np.full(series.WIDTH, np.nan)
    series.rotor_measures(*map(time_series.plain, numbers), row)
    return series.Column(*row)


def _as_compiled(balls: Balls) -> list[Floats]:
    """Time, rotor speed, angles and rates of balls as compiled loops take them."""
    return [time_series.plain(values) for values in (balls.time, balls.speed, balls.angle, balls.rate)]


def stalls_of(balls: Balls, whirls: Floats) -> Floats:
    """How long each ball is stalled (s), the row, with its fraction, at which it breaks away, and its speed if it is at the end.

    (3, n), by the rule of kernels/measures/record_series.py; nan where it does not break away or is not stalled at the end.
    """
    found = np.empty((3, balls.rate.shape[1]))
    time_series.compiled().stalls(balls.start, *_as_compiled(balls), time_series.plain(whirls), found)
    return found


def settling(
    balls: Balls,
    whirls: Floats,
    jumps: Sequence[float],
    held: bool = False,
    settling_from: str = SETTLING_FROM[0],
    tolerance: float = SETTLED,
) -> Settled:
    """How long each ball takes to stay within ``tolerance`` (rad) of the angle to which it goes, and from where all count.

    From nowhere if the rotor is ``held`` below a critical speed: then its run-up does not end.
    """
    at = time_series.each_ball(
        time_series.compiled().settled_from, balls.time, balls.angle, balls.rate, balls.start, tolerance
    )
    after, cause = time_series.end_of_run_up(balls.time, balls.speed, balls.start), RUN_UP
    if settling_from == SETTLING_FROM[1]:
        released = time_series.greatest_known(time_series.values_at(stalls_of(balls, whirls)[1], balls.time))
        after, cause = (released, RELEASE) if released > balls.start else (after, cause)
    begin, name = time_series.origin_of(after, cause, balls.start, float(balls.time[-1]), jumps)
    if held and name in NEVER_ENDED:
        begin, name = np.nan, time_series.ORIGINS[NOWHERE]
    return Settled(time_series.time_since(begin, at), at, name, begin)


def known_origin(settling_from: str) -> str:
    """The same word if settling times can count from it.

    Raises
    ------
    QuestionError
        If they cannot.
    """
    if settling_from not in SETTLING_FROM:
        allowed = " or ".join(map(repr, SETTLING_FROM))
        raise QuestionError(f"settling_from: given {settling_from!r}; must be {allowed}")
    return settling_from


def recorded_of(run: xr.Dataset, settling_from: str = SETTLING_FROM[0]) -> Recorded:
    """All that a run recorded; settling times count from the end of the run-up, or from the last release.

    Raises
    ------
    QuestionError
        If it kept neither samples nor an envelope.
    """
    known, told = _without_turns(run, settling_from), _of_turns(run)
    late = "x" in run and run["time"].values >= known.end - LAST * known.end
    if not (known.centered or told) and np.any(late):
        told["late"] = away_from_standing(run.isel(time=late))
    if known.balls is not None and "unbalance_angle_in_rotor" in run:
        told["final_angle"] = time_series.wrapped(known.balls.angle[-1] - run["unbalance_angle_in_rotor"].values[-1])
    if "link_torque" in run and run["time"].size:
        told["links"] = Links(*series(run, "time", "speed", "twist", "link_torque"))
    if "support_force_x" in run and run["time"].size and run.sizes["support"]:
        told["pushes"] = _vectors(run, "support_force_", "x", "y")
    if "ball_floor_force" in run:
        time, speed, floor = series(run, "time", "speed", "ball_floor_force")
        told["lifted"] = time_series.lifted_from(time, floor), time_series.lifted_from(speed, floor)
    if known.jumps:
        parts = [part for begin, _, part in parts_between_jumps(run) if begin > 0.0]
        told["parts"] = tuple(_without_turns(part, settling_from) for part in parts)
    held = float(run.attrs.get(HELD_AT, np.nan))
    return replace(known, held=held, impacts=impacts_of(run), **told)


# Balls that are stalled at the end of a run, and a rotor that its drive holds below a critical speed.


@dataclass(frozen=True)
class Stall:
    """Balls stalled at the end (counted from 1), of how many, and the rotor's mean speed over the last twentieth (rad/s).

    Of each its mean speed there, at which it whirls, the critical speed at whose whirl it stays, and that whirl at the speed of
    the rotor, which gyroscopic moments raise (rad/s). ``modes`` are the numbers of these critical speeds, from 1, of
    ``critical_speeds_of_rotor``. ``duration`` (s) is how long the one that was stalled longest has been.
    """

    balls: tuple[int, ...]
    of: int
    speeds: tuple[float, ...]
    critical_speeds: tuple[float, ...]
    whirls: tuple[float, ...]
    modes: tuple[int, ...]
    critical_speeds_of_rotor: int
    rotor_speed: float
    duration: float


@dataclass(frozen=True)
class HeldRotor:
    """A rotor that its drive does not take past a critical speed: its speed at the end, that one (rad/s) and its number."""

    speed: float
    critical_speed: float
    mode: int
    critical_speeds_of_rotor: int


def stall_of(run: xr.Dataset) -> Stall | None:
    """The balls that are stalled at the end of a run; None where none is, or without data."""
    try:
        recorded = recorded_of(run)
    except QuestionError:
        return None
    balls = recorded.balls
    if balls is None or balls.time.size < 3:
        return None
    duration, _, own = recorded.stalls
    there = np.flatnonzero(np.isfinite(own))
    if not there.size:
        return None
    rotor = float(balls.speed[balls.time >= (1.0 - LAST) * balls.time[-1]].mean())
    # each at the nearest whirl: f^2 - g w f = (1 - g) w_c^2 at the rotor speed w, see kernels/measures/record_series.py
    critical, share = recorded.whirls[recorded.whirls[:, 0] < abs(rotor)].T
    whirl = 0.5 * (share * abs(rotor) + np.hypot(share * rotor, 2.0 * np.sqrt(1.0 - share) * critical))
    modes = np.abs(np.log(whirl / np.abs(own[there, None]))).argmin(axis=1)
    named = tuple(int(ball) for ball in run["ball"].values[there])
    speeds, reached, whirls = (tuple(map(float, values)) for values in (own[there], critical[modes], whirl[modes]))
    numbers = tuple(int(mode) + 1 for mode in modes)
    known = len(recorded.whirls)
    return Stall(named, own.size, speeds, reached, whirls, numbers, known, rotor, float(duration[there].max()))


def held_rotor(run: xr.Dataset, critical_speed: float) -> HeldRotor | None:
    """The rotor that its drive does not take past a ``critical_speed`` (rad/s); None of nan."""
    if not np.isfinite(critical_speed):
        return None
    every = np.atleast_1d(run.attrs["critical_speeds"])
    speed = next(run[name].values[-1] for name in ("speed", "envelope_speed") if name in run and run[name].size)
    return HeldRotor(float(speed), critical_speed, int(np.abs(every - critical_speed).argmin()) + 1, every.size)


def stopped(run: xr.Dataset) -> str:
    """That a run did not finish, and why; empty if it did."""
    outcome = run.attrs.get("outcome", "finished")
    return "" if outcome == "finished" else f"the run did not finish: {run.attrs.get('outcome_text', outcome)}"


def bins_of(run: xr.Dataset, count: int = 200) -> Bins:
    """The envelope that the run kept (exact), else that of its samples (with their resolution) in ``count`` parts.

    Raises
    ------
    QuestionError
        If the run kept neither.
    """
    if "envelope_high" in run:
        time, low, high, speed = series(run, *(f"envelope_{name}" for name in ("time", "low", "high", "speed")))
        end = _bin_ends(run)
        return Bins(time, 2.0 * (end - time), low, high, speed, end)
    t, r, w = series(run, "time", "deflection", "speed")
    edges = np.linspace(0, t.size, min(count, t.size) + 1).astype(int)
    pairs = [(a, b) for a, b in pairwise(edges) if b > a]
    return Bins(
        time=np.array([0.5 * (t[a] + t[b - 1]) for a, b in pairs]),
        width=np.array([t[min(b, t.size - 1)] - t[a] for a, b in pairs]),
        low=np.array([r[a:b].min() for a, b in pairs]),
        high=np.array([r[a:b].max() for a, b in pairs]),
        speed=np.array([w[b - 1] for _, b in pairs]),
        end=np.array([t[b - 1] for _, b in pairs]),
    )


def balls_of(run: xr.Dataset) -> Balls | None:
    """Motion of the balls from the samples, else at the ends of the bins; None of a machine without balls."""
    if not run.sizes.get("ball", 0):
        return None
    if "ball_angle_in_rotor" in run:
        time, speed, angle, rate = series(run, "time", "speed", "ball_angle_in_rotor", "ball_speed_in_rotor")
        return Balls(float(time[0]), time, speed, angle, rate)
    middle, speed, angle, rate = series(
        run, *(f"envelope_{name}" for name in ("time", "speed", "ball_angle_in_rotor", "ball_speed_in_rotor"))
    )
    ends = _bin_ends(run)
    return Balls(float(2.0 * middle[0] - ends[0]), ends, speed, angle, rate)


def known_balls(run: xr.Dataset) -> Balls:
    """The same of a machine that must have balls.

    Raises
    ------
    QuestionError
        If it has none.
    """
    balls = balls_of(run)
    if balls is None:
        raise QuestionError("the machine has no balls; there is nothing to measure on them")
    return balls


def whirls_of(run: xr.Dataset) -> Floats:
    """Critical speeds of the machine, rad/s, and their gyroscopic shares, (K, 2); of an earlier version these are zero."""
    speeds = np.atleast_1d(run.attrs["critical_speeds"])
    shares = np.atleast_1d(run.attrs.get("gyroscopic_shares", np.zeros(speeds.size)))
    return np.array([speeds, shares], np.float64).T.copy()


def series(run: xr.Dataset, *names: str) -> list[Floats]:
    """Variables of a run over time or bins.

    Raises
    ------
    QuestionError
        If the run has no such variable, or no entry of it.
    """
    if any(name not in run.variables for name in names):
        raise QuestionError(
            "the run kept neither samples over time nor an envelope; run it with save=Samples() or Envelope()"
        )
    if run[names[0]].size == 0:
        raise QuestionError("the run ended before its first sample; there is nothing to measure")
    return [run[name].values for name in names]


def away_from_standing(samples: xr.Dataset) -> Floats:
    """Distance of the reference station from its static deflection in these samples of a run, m."""
    x, y = series(samples, "x", "y")
    z = (x + 1j * y)[:, None]
    return np.abs(z - time_series.standing_in(samples, z, ""))[:, 0]


def _bin_ends(run: xr.Dataset) -> Floats:
    """Where the speed and the balls of an envelope are from, s; a file of version 0.1 has only the middle of each bin."""
    return np.asarray(run["envelope_end" if "envelope_end" in run else "envelope_time"].values, np.float64)


def _without_turns(part: xr.Dataset, settling_from: str) -> Recorded:
    """What a run, or a part of one between jumps of the unbalance, recorded besides its last revolutions."""
    return Recorded(
        end=float(part.attrs["end_time"]),
        centered=time_series.load_of(part.attrs) == time_series.NONE,
        whirls=whirls_of(part),
        bins=bins_of(part),
        balls=balls_of(part),
        jumps=jump_times(part),
        settling_from=settling_from,
    )


def _of_turns(run: xr.Dataset) -> dict[str, Any]:
    """What the last revolutions say of places, planes and supports; nothing without a whole one."""
    if "turn_rotor_angle" not in run or "turn_place_x" not in run:
        return {}
    turns = time_series.turns_of(run["turn_rotor_angle"].values)
    if turns.start == turns.stop:
        return {}
    last = run.isel(turn=turns)
    z, v = (_vectors(last, "turn_place_", *names) for names in (("x", "y"), ("vx", "vy")))
    told: dict[str, Any] = {"turns": (z, v, time_series.standing_in(last, z))}
    if run.sizes["support"]:
        force = _vectors(last, "turn_support_force_", "x", "y")
        told["forces"] = force, time_series.standing_in(last, force)
    if "plane" in run.coords:
        unbalance, left = last["turn_plane_unbalance"].values, time_series.residual_vectors(last, whole=False)
        told["planes"], told["rotor"] = (unbalance, left), (sum(unbalance.T), left)
        if run.sizes["plane"] == 1:
            told["rotor"] = last["turn_unbalance"].values, time_series.residual_vectors(last, whole=True)
    if "vibration_without_balls" in run:
        told["without_balls"] = run["vibration_without_balls"].values
    return told


def _vectors(last: xr.Dataset, prefix: str, x: str, y: str) -> Any:
    return last[f"{prefix}{x}"].values + 1j * last[f"{prefix}{y}"].values


# Jumps of the unbalance in a run, and the parts of the run between them.


def jump_times(run: xr.Dataset) -> list[float]:
    """Times (s) at which the unbalance jumped, in order; a file keeps a list of one as a number."""
    return [float(time) for time in np.atleast_1d(run.attrs.get("unbalance_jumps", []))]


def parts_between_jumps(run: xr.Dataset) -> list[tuple[float, float, xr.Dataset]]:
    """Begin, end (s) and data over time and bins of each part; one part without jumps.

    A part without any data, such as one that an early end of the run cut off, is left out.
    """
    end = float(run.attrs["end_time"])
    edges = [0.0, *(time for time in jump_times(run) if time < end), end]
    parts = []
    for begin, until in itertools.pairwise(edges):
        inside: dict[str, Any] = {
            dimension: (run[name].values >= begin) & (run[name].values < (until if until < end else np.inf))
            for dimension, name in (("time", "time"), ("bin", "envelope_time"))
            if name in run
        }
        empty = [dimension for dimension, mask in inside.items() if not mask.any()]
        if len(empty) < len(inside):
            rows = {name: np.flatnonzero(mask) for name, mask in inside.items() if name not in empty}
            parts.append((begin, until, run.drop_dims(empty).isel(rows)))
    return parts
