"""Walls and partitions of races with contact-resolved balls: room, stiffness, shape."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np

from autobalancer.assembly.contact.meetings import meeting_table, restitution, sector
from autobalancer.assembly.contact.rebound import Tables
from autobalancer.assembly.profile import highest_prescribed
from autobalancer.assembly.waves import race_harmonics
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels.system import Floats
from autobalancer.laws.hertz import hertz_stiffness
from autobalancer.laws.rebound import damping_ratio, hertz_damping_ratio
from autobalancer.machine import Machine, Race
from autobalancer.machine.balancer.resolved import ResolvedContact
from autobalancer.machine.rebound import Rebound

DEEPEST = 0.1  # of the ball radius, by which a wall may give way under centrifugal force
ROUNDING = 1.0 + 1e-9  # a ball may start on the inner wall, however its distance was rounded


def room(race: Race, ball: Ball) -> float:
    """What the ball center can move between outer and inner wall, m; infinite without an inner wall."""
    assert race.resolved is not None
    gap, start = math.inf, float(race.resolved.start_gap)
    if race.width is not None:
        gap = float(race.width) - ball.diameter
        outer = ball.orbit_radius + ball.radius
        if race.width >= outer:
            raise MachineError(
                f"{_name(ball)}.width: given {1e3 * race.width:.4g} mm; must be less than the radius of the wall, "
                f"{1e3 * outer:.4g} mm; leave it out where there is no inner wall"
            )
    most = min(gap, ball.orbit_radius)
    if start > most * ROUNDING:
        raise MachineError(
            f"{_name(ball)}.resolved.start_gap: given {1e3 * start:.4g} mm; a ball has {1e3 * most:.4g} mm at most"
        )
    return gap


def _name(ball: Ball) -> str:
    return f"balancers[{ball.balancer + 1}].races[{ball.race + 1}]"


def refuse_soft_wall(machine: Machine, ball: Ball, stiffness: float, hertz: bool) -> None:
    """Refuse a wall that centrifugal force at the greatest known speed pushes in by more than a tenth of the ball radius."""
    highest = highest_prescribed(machine)
    if highest is None:
        return
    force = ball.effective_mass * highest**2 * ball.orbit_radius
    power = 1.5 if hertz else 1.0
    depth, most = (force / stiffness) ** (1.0 / power), DEEPEST * ball.radius
    if depth > most:
        key = "reduced_modulus" if hertz else "stiffness"
        raise MachineError(
            f"{_name(ball)}.resolved.{key}: at {highest:.4g} rad/s the wall is compressed by "
            f"{1e3 * depth:.3g} mm under a ball of {2e3 * ball.radius:.3g} mm, which would pass through it; use at least "
            f"{force / most**power / stiffness:.2g} times this value"
        )


def refuse_sharp_waves(race: Race, ball: Ball, gap: float) -> None:
    """Refuse an orbit that no wall can make, because it is bent more sharply around a wall than the ball is round."""
    key, orders = "roundness" if race.roundness is not None else "harmonics", race_harmonics(race).shape[0]
    if orders == 0:
        return
    radius, first, second = _orbit(race, ball, np.linspace(0.0, 2.0 * math.pi, 40 * orders, endpoint=False))
    for level, sign, wall in ((radius, -1.0, "outer"), (radius - gap, 1.0, "inner")):
        if not np.isfinite(level).all():
            continue
        if level.min() <= 0.0:
            raise MachineError(
                f"{_name(ball)}.{key}: the {wall} wall would leave the ball center {1e3 * level.min():.4g} mm from the center "
                "of the race; take smaller waves"
            )
        bend = sign * (level**2 + 2.0 * first**2 - level * second) / np.hypot(level, first) ** 3
        if bend.max() * ball.radius >= 1.0:
            raise MachineError(
                f"{_name(ball)}.{key}: a ball of {1e3 * ball.radius:.4g} mm radius cannot follow the {wall} wall: "
                f"its orbit is curved around it with a radius of {1e3 / bend.max():.4g} mm; use smaller or fewer waves"
            )


def orbit_at(race: Race, ball: Ball, angle: float) -> tuple[float, float]:
    """Radius of the orbit and its derivative at an angle, m."""
    radius, first, _ = _orbit(race, ball, np.array([angle]))
    return float(radius[0]), float(first[0])


def _orbit(race: Race, ball: Ball, angles: Floats) -> tuple[Floats, Floats, Floats]:
    waves = race_harmonics(race)
    orders = np.arange(1, waves.shape[0] + 1)
    turning = np.exp(1j * np.outer(angles, orders)) * (waves[:, 0] - 1j * waves[:, 1])
    radius, first, second = (np.asarray((turning * (1j * orders) ** n).sum(axis=1).real) for n in range(3))
    return ball.orbit_radius + radius, first, second


def stiffnesses(contact: ResolvedContact, ball: Ball, inner: float) -> tuple[float, float, float]:
    """Of outer wall, inner wall (of radius ``inner``, m) and another ball."""
    if contact.reduced_modulus is None:
        stiffness = float(contact.stiffness or 0.0)
        return stiffness, stiffness, stiffness
    modulus = float(contact.reduced_modulus)
    outer = hertz_stiffness(modulus, ball.radius, ball.orbit_radius + ball.radius)
    within = hertz_stiffness(modulus, ball.radius, -inner) if inner > 0.0 else 0.0
    return outer, within, hertz_stiffness(modulus, 1.0)  # of a pair whose radii reduce to 1 m


def damping_number(contact: ResolvedContact, share: float, rebound: Rebound | None) -> float:
    """Damping over sqrt(stiffness mass) that leaves this ``share`` of the speed; with Hertz that of d^(1/4).

    Where it depends on the impact, that of damping ratio 1.
    """
    if contact.reduced_modulus is not None:
        return hertz_damping_ratio(share) if rebound is None else math.sqrt(5.0)
    return 2.0 * (damping_ratio(share) if rebound is None else 1.0)


def meeting_damping(contact: ResolvedContact, race: Race) -> float:
    """The same of balls that meet each other or a partition."""
    return damping_number(contact, restitution(race), race.contact.rebound if race.contact is not None else None)


def set_partitions(row: Any, race: Race, ball: Ball, angle: float, mass: float, tables: Tables) -> float:
    """Fill a row with the partitions around a ball that starts at ``angle``; returns the angle beside them."""
    contact = race.resolved
    assert contact is not None
    half = math.asin(ball.radius / max(ball.orbit_radius - float(contact.start_gap), ball.radius))
    low, high = sector(race, ball, angle, half)
    stiffness = stiffnesses(contact, ball, math.inf)[0]
    if contact.reduced_modulus is not None:
        stiffness = hertz_stiffness(float(contact.reduced_modulus), ball.radius)
    elif race.contact is not None and race.contact.stiffness is not None:
        stiffness = 2.0 * float(
            race.contact.stiffness
        )  # a partition is where the mirror image of the ball would meet it
    behind, ahead = cmath.rect(1.0, low) * 1j, cmath.rect(1.0, high) * -1j
    row.behind_x, row.behind_y, row.ahead_x, row.ahead_y = behind.real, behind.imag, ahead.real, ahead.imag
    row.middle, row.stiffness = 0.5 * (low + high), stiffness
    row.damping = meeting_damping(contact, race) * math.sqrt(stiffness * mass)
    row.rebound = meeting_table(tables, race, ball)
    return min(max(angle, low + half), high - half)
