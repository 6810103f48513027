"""The stalled-ball (Sommerfeld) solution: balls that hang near the critical speed while the rotor runs faster.

Ryzhik et al. (2001). In the frame of the rotor it is a periodic orbit on which the balls lose one revolution per period. It
is far from every state of rest, so it is found by letting balls that start at the critical speed run until they settle.
"""

from __future__ import annotations

import math

import numpy as np

from autobalancer.stability.continuation.follow import NoConvergence, at_parameter
from autobalancer.stability.continuation.steady import Range
from autobalancer.stability.continuation.symmetry import Groups
from autobalancer.stability.continuation.vector_field import Field
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.periodic.collocation import Mesh
from autobalancer.stability.periodic.integrated import flow
from autobalancer.stability.periodic.orbits import Orbits

SETTLING = 12.0  # time constants of rotor and balls before the motion counts as settled
SAMPLES = 400  # per turn of the rotor against the critical speed
PERIODS = 6  # over which a settled motion is looked at


def stalled_orbit(span: Range, groups: Groups, share: float, intervals: int) -> tuple[Orbits, Floats] | None:
    """The problem and the stalled orbit at a share of the range; ``None`` if balls do not hang there."""
    field = span.field(share, groups)
    count, p = len(groups), field.plane
    critical = math.sqrt(p.stiffness[0] / p.mass)
    if field.speed < 1.01 * critical or 0.0 in (p.damping[0], *p.drag):
        return None
    state = np.concatenate([np.zeros(4 + count), np.full(count, critical - field.speed)])
    settling = SETTLING * max(2.0 * p.mass / p.damping[0], float((p.inertia / p.drag).max()))
    beat = 2.0 * math.pi / (field.speed - critical)
    state = flow(field, state, np.array([settling + 4.0 * beat]))[-1]
    late = flow(field, state, np.linspace(0.0, PERIODS * beat, PERIODS * SAMPLES + 1))
    found = _period(late[:, 4 : 4 + count], PERIODS * beat)
    if found is None:
        return None
    period, winding = found
    mesh = Mesh(np.linspace(0.0, 1.0, intervals + 1))
    states = flow(field, late[-1], mesh.nodes * period) / span.scale(count)
    problem = Orbits(span, groups, winding, mesh, period, states)
    try:
        u = at_parameter(problem, np.append(states.ravel(), [0.0, share]), share)
    except (NoConvergence, np.linalg.LinAlgError):
        return None
    return (problem, u) if _same(field, problem, u) else None


def _period(angles: Floats, duration: float) -> tuple[float, tuple[int, ...]] | None:
    """Time in which the ball that slips most loses the last revolution, and the revolutions of all balls in it."""
    slip = angles[-1] - angles[0]
    leader = int(np.argmin(slip))
    if slip[leader] > -4.0 * math.pi:
        return None
    times = np.linspace(0.0, duration, angles.shape[0])
    before = np.flatnonzero(angles[:, leader] >= angles[-1, leader] + 2.0 * math.pi)[-1]
    a, b = angles[before : before + 2, leader] - angles[-1, leader] - 2.0 * math.pi
    period = duration - float(times[before] + (times[1] - times[0]) * a / (a - b))
    back = np.array([np.interp(duration - period, times, angles[:, i]) for i in range(angles.shape[1])])
    return period, tuple(np.rint((angles[-1] - back) / (2.0 * math.pi)).astype(int).tolist())


def _same(field: Field, problem: Orbits, u: Floats) -> bool:
    """Whether the orbit turns as the balls did, near the critical speed and not with the rotor."""
    slip = 2.0 * math.pi / problem.period(u)
    return bool(0.02 * field.speed < slip < field.speed)
