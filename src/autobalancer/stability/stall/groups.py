"""The balls of a machine that can stall, in groups of equal balls of one station, and what drives and brakes them.

Torques as in :mod:`autobalancer.laws.stall`, here at several stations P. Balls of the group g at the angle psi_g in space,
all at the speed v, load station p with v^2 S_p, S_p = sum n s e^(i psi); with the forward receptance H(v; W) of the rotor
that runs at W the race of a ball whirls with zeta_p = v^2 sum_q H_pq S_q, so that

    T_brake = - s v^2 Im(e^(-i psi) zeta_p),    F_N = s v^2 (1 + Re(e^(-i psi) zeta_p)/eps).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.machine import Machine
from autobalancer.stability.host.planar import Complexes, Floats

EQUAL = 1e-3  # relative difference up to which balls count as equal


@dataclass(frozen=True)
class StalledGroup:
    """``count`` equal balls of one race, in line; ``moment`` is m eps of one of them, kg m."""

    station: int
    count: int
    ball: Ball
    rolling: float
    members: tuple[int, ...] = ()  # numbers of the balls in the machine, from 0

    @cached_property
    def moment(self) -> float:
        """Effective mass times orbit radius of one ball, kg m."""
        return self.ball.moment

    @property
    def plain(self) -> bool:
        """Whether its drag is linear and nothing else resists."""
        return self.ball.drag_curve is None and self.rolling == 0.0

    @property
    def carries(self) -> bool:
        """Whether anything drives it along with the rotor."""
        return self.rolling > 0.0 or self.ball.drag_curve is not None or self.ball.drag > 0.0

    def drag(self, slip: Floats) -> Floats:
        """Torque of the fluid on one ball against its slip (rad/s), N m."""
        if self.ball.drag_curve is None:
            return np.asarray(self.ball.drag * slip)
        return self.ball.drag_curve.torque(slip, self.ball.orbit_radius)

    def carried(self, slip: Floats, whirl: Floats, radial: Floats) -> Floats:
        """Torque that drives one ball: drag and rolling resistance; ``radial`` is Re(e^(-i psi) zeta), m."""
        pressed = self.moment * whirl**2 * (1.0 + radial / self.ball.orbit_radius)
        pressed = np.abs(pressed) if self.ball.body == "pendulum" else np.maximum(pressed, 0.0)
        return np.asarray(self.drag(slip) + self.rolling * self.ball.orbit_radius * pressed)


def stalled_groups(machine: Machine, station: list[int]) -> tuple[StalledGroup, ...]:
    """Groups of balls of one station that are equal to ``EQUAL``; ``station`` of each ball.

    Balls between partitions are carried along and are left out.
    """
    found: list[StalledGroup] = []
    for number, (place, ball) in enumerate(zip(station, resolve(machine), strict=True)):
        if machine.balancers[ball.balancer].races[ball.race].partitions is not None:
            continue
        for g, group in enumerate(found):
            if group.station == place and _equal(group.ball, ball):
                found[g] = replace(group, count=group.count + 1, members=(*group.members, number))
                break
        else:
            found.append(StalledGroup(place, 1, ball, ball.rolling_resistance, (number,)))
    return tuple(found)


def _equal(one: Ball, other: Ball) -> bool:
    """Whether balls stall like equal ones; those of a lot differ by some 1e-4."""
    if (one.drag_curve is None) != (other.drag_curve is None) or one.rolling_resistance != other.rolling_resistance:
        return False
    first, second = ((ball.moment, ball.orbit_radius, ball.drag, ball.inertia) for ball in (one, other))
    return bool(np.allclose(first, second, rtol=EQUAL, atol=0.0))


@dataclass(frozen=True)
class Loads:
    """The groups as arrays over g."""

    groups: tuple[StalledGroup, ...]

    def some(self, chosen: tuple[int, ...]) -> Loads:
        """Of some of the groups."""
        return Loads(tuple(self.groups[g] for g in chosen))

    @cached_property
    def station(self) -> NDArray[np.int64]:
        """Of each group."""
        return np.array([group.station for group in self.groups], np.int64)

    @cached_property
    def count(self) -> Floats:
        """Balls of each group."""
        return np.array([group.count for group in self.groups], float)

    @cached_property
    def moment(self) -> Floats:
        """Of one ball of each group, kg m."""
        return np.array([group.moment for group in self.groups])

    def whirl(self, receptance: Complexes, speed: Floats, phases: Floats) -> Complexes:
        """e^(-i psi) zeta at each group, (n, g), from receptances (n, P, P) at whirl speeds (n,); phases (g,) or (n, g)."""
        turned = np.exp(1j * np.broadcast_to(phases, (speed.size, self.count.size)))
        among = receptance[:, self.station[:, None], self.station]
        answer = (among @ (self.count * self.moment * turned)[:, :, None])[:, :, 0]
        return np.asarray(speed[:, None] ** 2 * answer / turned)

    def braking(self, whirl: Complexes, speed: Floats) -> Floats:
        """Torque that brakes one ball of each group, (n, g)."""
        return np.asarray(-self.moment * speed[:, None] ** 2 * whirl.imag)

    def carried(self, slip: Floats, whirl: Complexes, speed: Floats) -> Floats:
        """Torque that drives one ball of each group at slips (n,), (n, g)."""
        found = np.empty(whirl.shape)
        for g, group in enumerate(self.groups):
            found[:, g] = group.carried(slip, speed, whirl[:, g].real)
        return found
