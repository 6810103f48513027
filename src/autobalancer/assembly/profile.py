"""Profiles over time as pieces that the kernels can evaluate."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from autobalancer.errors import MachineError
from autobalancer.kernels.records import HILL, LINEAR
from autobalancer.machine import Constant, Dwell, Hill, Machine, PrescribedSpeed, Ramp, Reduction, Table
from autobalancer.machine.machine import Unbalance

HILL_SAMPLES = 2000  # of an S-shaped run-up
SpeedProfile = Constant | Ramp | Table | Dwell | Hill | Reduction


@dataclass(frozen=True)
class Piece:
    """One piece from ``start`` on: linear (value, rate, 0, 0) or Hill (end, half time, exponent, begin)."""

    start: float
    kind: int
    numbers: tuple[float, float, float, float]

    def at(self, time: float) -> tuple[float, float, float, float]:
        """The numbers of the same curve if the piece began at ``time``."""
        if self.kind == HILL:
            return self.numbers
        return (self.numbers[0] + self.numbers[1] * (time - self.start), self.numbers[1], 0.0, 0.0)


def profile_pieces(profile: SpeedProfile) -> list[Piece]:
    """The pieces of a profile, the first one starting at time 0."""
    if isinstance(profile, Hill):
        numbers = (
            float(profile.end),
            float(profile.half_time),
            float(profile.exponent),
            float(profile.start),
        )
        return [Piece(0.0, HILL, numbers)]
    return _straight(corners(profile))


def corners(profile: SpeedProfile) -> list[tuple[float, float]]:
    """(time, speed) of the corners of a piecewise straight profile."""
    if isinstance(profile, Constant):
        return [(0.0, float(profile.speed))]
    if isinstance(profile, Ramp):
        first, last = float(profile.delay), float(profile.delay + profile.duration)
        return [(first, float(profile.start)), (last, float(profile.end))]
    if isinstance(profile, Table):
        return [(float(t), float(w)) for t, w in zip(profile.time, profile.speed, strict=True)]
    if isinstance(profile, Dwell):
        stops = [(float(speed), float(profile.hold)) for speed in profile.speeds]
        return _staircase(stops, float(profile.acceleration))
    if isinstance(profile, Reduction):
        stops = [
            (float(profile.start), 0.0),
            *([(float(profile.dwell), float(profile.hold_dwell))] if profile.dwell is not None else []),
            (float(profile.peak), float(profile.hold_peak)),
            (float(profile.reduced), float(profile.hold_reduced)),
            (float(profile.end), 0.0),
        ]
        return _staircase(stops, float(profile.acceleration))
    raise MachineError(f"no corners in a profile of kind {profile.kind!r}")


def _staircase(stops: list[tuple[float, float]], acceleration: float) -> list[tuple[float, float]]:
    time, speed = 0.0, stops[0][0]
    points = [(time, speed)]
    for target, hold in stops:
        if target != speed:
            time += abs(target - speed) / acceleration
            points.append((time, target))
        if hold > 0.0:
            time += hold
            points.append((time, target))
        speed = target
    return points


def _straight(points: list[tuple[float, float]]) -> list[Piece]:
    pieces = [Piece(0.0, LINEAR, (points[0][1], 0.0, 0.0, 0.0))] if points[0][0] > 0.0 or len(points) == 1 else []
    for (t0, w0), (t1, w1) in pairwise(points):
        pieces.append(Piece(t0, LINEAR, (w0, (w1 - w0) / (t1 - t0), 0.0, 0.0)))
    if len(points) > 1:
        pieces.append(Piece(points[-1][0], LINEAR, (points[-1][1], 0.0, 0.0, 0.0)))
    return pieces


def highest_prescribed(machine: Machine) -> float | None:
    """The highest speed that the drive prescribes, rad/s; none if the speed follows from a torque."""
    if not isinstance(machine.drive, PrescribedSpeed):
        return None
    pieces = profile_pieces(machine.drive.profile)
    return max(
        float(max(piece.numbers[0], piece.numbers[3]) if piece.kind == HILL else piece.numbers[0]) for piece in pieces
    )


def greatest_rise(machine: Machine, speed: float) -> float | None:
    """Greatest of W' (speed / W)^2 over what the drive prescribes above a speed, rad/s^2; None without such a drive.

    A ball that rests needs W'/W^2 from friction to be taken along, so that this is what counts at ``speed``.
    """
    if not isinstance(machine.drive, PrescribedSpeed):
        return None
    profile = machine.drive.profile
    if isinstance(profile, Hill):
        first, last, n = float(profile.start), float(profile.end), float(profile.exponent)
        shares = [(i + 0.5) / HILL_SAMPLES for i in range(HILL_SAMPLES)]  # of the rise
        rises = [
            (first + (last - first) * s, (last - first) * n * s * (1.0 - s) * (1.0 / s - 1.0) ** (1.0 / n))
            for s in shares
        ]
        greatest_rise = [rise / float(profile.half_time) * (speed / at) ** 2 for at, rise in rises if at >= speed]
    else:
        greatest_rise = [
            (w1 - w0) / (t1 - t0) * (speed / max(w0, speed)) ** 2
            for (t0, w0), (t1, w1) in pairwise(corners(profile))
            if w1 > max(w0, speed) and t1 > t0
        ]
    return float(max([0.0, *greatest_rise]))


def unbalance_jumps(machine: Machine, end: float) -> tuple[float, ...]:
    """Times between zero and ``end`` (s) at which a schedule makes an unbalance jump, in order."""
    unbalance_jumps = set()
    for part in machine.unbalances:
        if part.schedule is not None and part.size + float(part.couple or part.misalignment or 0.0) > 0.0:
            steps = pairwise(zip(part.schedule.time, part.schedule.factor, strict=True))
            unbalance_jumps |= {float(t0) for (t0, f0), (t1, f1) in steps if t0 == t1 and f0 != f1 and 0.0 < t0 < end}
    return tuple(sorted(unbalance_jumps))


def unbalance_vector(machine: Machine, time: float, *, before: bool = False) -> complex:
    """Resultant of the point unbalances in the rotor just after a time, or just before it, kg m; *inf*: after all schedules."""
    return sum((u.vector * unbalance_factor(u, time, before=before) for u in machine.unbalances), 0j)


def largest_unbalance(machine: Machine) -> complex:
    """The greatest resultant of the point unbalances over time, as a vector in the rotor, kg m."""
    vectors = [unbalance_vector(machine, t, before=before) for t in schedule_times(machine) for before in (False, True)]
    return max(vectors, key=abs)


def schedule_times(machine: Machine) -> tuple[float, ...]:
    """Zero and the times of all schedules of unbalances, s, ascending; between two of them all change linearly."""
    return tuple(sorted({0.0, *(t for u in machine.unbalances if u.schedule is not None for t in u.schedule.time)}))


def unbalance_factor(unbalance: Unbalance, time: float, *, before: bool = False) -> float:
    """The schedule's factor just after ``time``, or just before it."""
    schedule = unbalance.schedule
    if schedule is None:
        return 1.0
    times = [float(t) for t in schedule.time]
    factors = [float(f) for f in schedule.factor]
    left = [i for i, t in enumerate(times) if (t < time if before else t <= time)]
    if not left:
        return factors[0]
    i = left[-1]
    if i + 1 == len(times):
        return factors[-1]
    return factors[i] + (time - times[i]) / (times[i + 1] - times[i]) * (factors[i + 1] - factors[i])
