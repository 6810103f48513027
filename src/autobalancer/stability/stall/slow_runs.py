"""Slow runs of the equations of motion, where stalled balls have no steady speed and no balance finds them.

Balls of one plane that stall at v while those of another turn at v' feel each other at the frequency v - v'. To first order
in torque over inertia that averages out, and each plane has the balance of its own speed. But v - v' is often only a few
rad/s. Then both swing, and the second order counts: balls that go around in the whirl of others drive it along, which shifts
the end by up to a tenth. Such motions begin where a steady one ends. They are followed by the equations themselves, without
unbalance and in a frame in which they are slow, so that minutes take milliseconds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.system import Assembly, assemble
from autobalancer.kernels.system import BALLS, SPEED
from autobalancer.machine import Balancer, Machine, PrescribedSpeed, Table
from autobalancer.patience import still_time
from autobalancer.simulation.record import record_for
from autobalancer.simulation.sampling import Samples
from autobalancer.simulation.steppers import stepper_for
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.stall.groups import Loads
from autobalancer.stability.stall.ranges import HangingRange

TOLERANCE, STEPS = 1e-6, 400_000  # of a run
SPREAD = 3e-4  # of the masses of equal balls, which would never part
SETTLED = 6.0  # s in which a start settles
QUICK, SLOW = 2e-3, 2e-4  # of the speed by which it changes, 1/s
SAMPLES = 4.0  # a second
NEAR, EARLY = (
    0.97,
    (1.0, 0.9),
)  # of the end of a balance, where a run begins; of its whirl, where balls do not stall there
FURTHER, STRETCHES = 1.1, 6  # how far it goes at once, how often
STALLED, FULL = 0.5, 0.8  # of the greatest slip, from which on a ball stalls, and from which on it does fully
GRADUALLY = 0.01  # of the speed, between these two, from which on balls go over to the rotor gradually
WINDOW, SHORTEST = 8.0 * math.pi, 2.0  # over the slip, and s, over which speeds are averaged
OTHER = 2.0  # angle between planes, rad, from which a run-down begins
AROUND, FALLEN = (
    1.05,
    0.75,
)  # speeds around a balance at which it is slow; share of the slip of balls that have fallen back
JUMP, RISE = 0.03, 1.3  # slip over speed by which balls fall back at once, and how many times the slip before
SOON = 0.012  # of the speed, in which they do
BESIDE = 0.005  # of the last speed, before and after which slips are read


@dataclass(frozen=True)
class Motion:
    """Samples of a run: speed of the rotor (n,) and mean slip of each ball (n, balls), rad/s; the last state."""

    speed: Floats
    slip: Floats
    last: Floats


@dataclass(frozen=True)
class LastSeen:
    """Speed of the rotor at which the last ball leaves, and slip of each group a little before, rad/s; whether gradually."""

    speed: float
    slip: Floats
    gradual: bool


@dataclass(frozen=True)
class Fall:
    """Speed of the rotor at which balls fall back, and of their whirl after it, rad/s; the stations of those that do."""

    speed: float
    whirl: float
    stations: frozenset[int]


class SlowRuns:
    """Runs of a machine without unbalance and without contacts of its balls."""

    def __init__(self, machine: Machine, loads: Loads) -> None:
        self.loads = loads
        plain = {"balancers": tuple(_plain(one) for one in machine.balancers), "tilting_races": "deflection"}
        left_out = {"unbalances": (), "excitations": (), "axis": "vertical", "start": type(machine.start)()}
        self.machine = machine.model_copy(update=plain | left_out)

    @property
    def possible(self) -> bool:
        """Whether they take long steps; else they would take too long."""
        return stepper_for(self._assembled((0.0,), (1.0,), 0.0), 1.0, TOLERANCE).long is not None

    def released(self, one: HangingRange) -> LastSeen | None:
        """Where the last ball leaves in a slow run-up from a balance; none if balls do not stall in it before its end."""
        slip, near = one.end - one.whirl, NEAR * one.end
        for begin in (near, *(min(max(share * one.whirl, 1.02 * one.begin), near) for share in EARLY)):
            start = self._stalled(one, max(slip - (one.end - begin), 0.0))
            path: tuple[float, ...] = (begin, near, FURTHER * near)
            found, w, slips = None, np.zeros(0), np.zeros((0, start.shape[-1]))
            for _ in range(STRETCHES):
                motion = self.run(path, start, slip, SPREAD)
                w, slips = np.append(w, motion.speed), np.concatenate([slips, motion.slip])
                most = slips.max(axis=1)
                greatest = np.maximum.accumulate(np.maximum(most, slip))
                stalled = np.flatnonzero((most > STALLED * greatest) & (w > near))
                if not stalled.size or stalled[0] > np.flatnonzero(w > near)[0]:
                    break
                last, full = (float(w[most > share * greatest[-1]].max(initial=near)) for share in (STALLED, FULL))
                before = slips[
                    np.searchsorted(w, (1.0 - BESIDE) * last), [group.members[0] for group in self.loads.groups]
                ]
                found = LastSeen(last, before, last > (1.0 + GRADUALLY) * full)
                if w[-1] > (1.0 + BESIDE) * last:
                    break
                path, start = (path[-1], FURTHER * path[-1]), motion.last
            if found is not None:
                return found
        return None

    def fell(self, begin: float, near: float, slip: float) -> float:
        """Where a plane falls back to about a ``slip`` in a slow run-down, near a speed (rad/s); nan if none does.

        The balls of each plane are in line by themselves; they settle, in step or not, at the speed ``begin``.
        """
        motion = self._down((begin, min(begin, near * AROUND), near / AROUND), slip)
        fallen = np.flatnonzero(motion.slip.max(axis=1) > FALLEN * slip)
        return float(motion.speed[fallen[0]]) if fallen.size else math.nan

    def falls(self, begin: float, near: float, lowest: float) -> Fall | None:
        """The first fall of balls, in line by plane, in a run-down that is slow from ``near`` on; none if none falls at once."""
        motion = self._down((begin, min(begin, near), lowest), 0.7 * JUMP * near)
        most, w = motion.slip.max(axis=1), motion.speed
        after, later = (np.searchsorted(-w, -share * w) for share in (1.0 - SOON, 1.0 - 2.0 * SOON))
        known = np.flatnonzero(later < w.size)
        old, new, kept = most[known], most[after[known]], most[later[known]]
        fallen = known[(new - old > JUMP * w[known]) & (new > RISE * old) & (kept > 0.5 * (old + new))]
        if not fallen.size:
            return None
        i, end = int(fallen[0]), int(later[fallen[0]]) + 1
        k = i + int(np.argmax(most[i:end] > 0.5 * (most[i] + most[after[i]])))
        deepest = i + int(np.argmax(most[i:end]))
        firsts = [group.members[0] for group in self.loads.groups]
        rise = (motion.slip[deepest] - motion.slip[i])[firsts]
        stations = {group.station for group, own in zip(self.loads.groups, rise, strict=True) if own > 0.5 * rise.max()}
        return Fall(float(w[k]), float(w[deepest] - most[deepest]), frozenset(stations))

    def _down(self, path: tuple[float, ...], slip: float) -> Motion:
        """A slow run-down along these speeds of balls that are in line by plane."""
        angles = np.zeros(sum(len(group.members) for group in self.loads.groups))
        for group in self.loads.groups:
            angles[list(group.members)] = OTHER * group.station
        return self.run(path, np.stack([angles, np.zeros_like(angles)]), slip, 0.0)

    def _stalled(self, one: HangingRange, slip: float) -> Floats:
        """Angles and speeds of all balls in the rotor; those that do not stall are at rest, spread evenly over each race."""
        found = np.zeros((2, sum(len(group.members) for group in self.loads.groups)))
        for g, group in enumerate(self.loads.groups):
            members = list(group.members)
            if g in one.groups:
                found[0, members] = one.state.phases[0, one.groups.index(g)] + 1e-2 * np.arange(len(members))
                found[1, members] = -slip
            else:
                found[0, members] = 2.0 * math.pi * np.arange(len(members)) / len(members)
        return found

    def _assembled(self, times: Sequence[float], speeds: Sequence[float], spread: float) -> Assembly:
        drive = PrescribedSpeed(profile=Table(time=tuple(times), speed=tuple(speeds)))
        return assemble(self.machine.model_copy(update={"drive": drive}), contact=False, mass_spread=spread)

    def run(self, speeds: Sequence[float], start: Floats, slip: float, spread: float) -> Motion:
        """Along speeds of the rotor, slowly to the last of them, from a state or from angles and speeds of the balls."""
        still_time()
        settling = SETTLED * (start.ndim - 1)
        rates = [*[QUICK] * (len(speeds) - 2), SLOW]
        lasting = [abs(math.log(b / a)) / rate for a, b, rate in zip(speeds[:-1], speeds[1:], rates, strict=True)]
        points = [(0.0, speeds[0]), (settling, speeds[0])]
        for time, speed in zip(lasting, speeds[1:], strict=True):
            points.append((points[-1][0] + time, speed))
        points = [point for k, point in enumerate(points) if k == 0 or point[0] > points[k - 1][0]]
        times = [point[0] for point in points]
        assembly = self._assembled(times, [point[1] for point in points], spread)
        count = len(assembly.balls)
        angles = slice(BALLS, BALLS + count)
        if settling:
            assembly.state[BALLS : BALLS + 2 * count] = start.ravel()
        else:
            assembly.state[:] = start
        assembly.state[SPEED] = speeds[0]
        record = record_for((Samples(round(SAMPLES * times[-1]) + 1),), (), assembly, times[-1])
        stepper = stepper_for(assembly, times[-1], TOLERANCE)
        stepper.advance(assembly.system, record, STEPS)
        samples = record.samples[round(SAMPLES * settling) :]
        half = max(round(0.5 * SAMPLES * max(WINDOW / slip, SHORTEST)), 1)
        gone = samples[2 * half :, angles] - samples[: -2 * half, angles]
        return Motion(samples[half:-half, SPEED], -gone * SAMPLES / (2.0 * half), samples[-1].copy())


def slow_runs(machine: Machine, loads: Loads) -> SlowRuns | None:
    """Runs of a machine whose balls may stall at several speeds; none for one group, with friction, or if they take long."""
    if len(loads.groups) < 2 or any(group.rolling > 0.0 for group in loads.groups):
        return None
    runs = SlowRuns(machine, loads)
    return runs if runs.possible else None


def _plain(balancer: Balancer) -> Balancer:
    """With round and concentric races in which balls feel drag and rolling resistance alone, as in the balances."""
    nothing = {"harmonics": (), "roundness": None, "eccentricity": 0.0, "slipstream": False, "resolved": None}
    passing = {"coincidence": True, "contact": None, "forces": ()}
    races = tuple(race.model_copy(update=nothing | passing) for race in balancer.races)
    return balancer.model_copy(update={"races": races})
