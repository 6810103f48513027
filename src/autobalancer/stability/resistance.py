"""Release and capture of balls with any drag law and rolling resistance, on a planar rotor.

With linear drag and no friction on a planar rotor the release speed has a closed form, see
:mod:`autobalancer.stability.release`; else it is a fold of the torque balance of :mod:`autobalancer.laws.stall`.
"""

from __future__ import annotations

import math

import numpy as np

from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.laws.stall import Receptance, StalledBall, StallRange, planar_receptance, stall_ranges
from autobalancer.machine import Machine
from autobalancer.stability.border import Border
from autobalancer.stability.lateral import Floats, Plane
from autobalancer.stability.release import release_border


def resists(machine: Machine) -> bool:
    """Whether a ball meets more than linear drag on its way along the race."""
    rubbed = any(race.friction is not None for balancer in machine.balancers for race in balancer.races)
    return rubbed or any(ball.drag_curve is not None for ball in resolve(machine))


def release_of(machine: Machine, p: Plane) -> tuple[Border, ...]:
    """*release speed* and, where it is a torque balance, *capture speed*."""
    if not resists(machine):
        return (release_border(p),)
    balls = resolve(machine)
    critical = sorted({math.sqrt(k / p.mass) for k in p.stiffness})
    receptance = planar_receptance(p.mass, p.stiffness, p.damping)
    release, capture = 0.0, math.nan
    kinds = {(b.balancer, b.race, b.moment, b.orbit_radius, b.drag, b.drag_curve): b for b in balls}
    for ball in kinds.values():
        for fold in _folds(machine, ball, balls, receptance, critical):
            release = max(release, fold.release)
            if not math.isnan(fold.capture):
                capture = fold.capture if math.isnan(capture) else max(capture, fold.capture)
    how = "torque balance of stalled balls in line"
    if release == 0.0:
        return (Border("release speed", max(critical), "the balls never stall: drag and friction carry them through"),)
    first = Border("release speed", release, f"{how}, highest of all resonances" if len(critical) > 1 else how)
    if math.isinf(release):
        return (Border("release speed", release, "never: no drag is enough at a resonance"),)
    return first, Border("capture speed", capture, f"{how}: below it balls in line fall back to the resonance")


def _folds(
    machine: Machine, ball: Ball, balls: tuple[Ball, ...], receptance: Receptance, critical: list[float]
) -> tuple[StallRange, ...]:
    race = machine.balancers[ball.balancer].races[ball.race]
    rolling = float(race.friction.rolling_resistance) if race.friction is not None else 0.0
    total = sum(other.moment for other in balls)

    def drag(slip: Floats) -> Floats:
        if ball.drag_curve is None:
            return np.asarray(ball.drag * slip)
        return ball.drag_curve.torque(slip, ball.orbit_radius)

    return stall_ranges(StalledBall(ball.moment, total, ball.orbit_radius, drag, rolling), receptance, critical)
