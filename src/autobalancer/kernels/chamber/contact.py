"""The law of a contact of a ball with another ball or a wall.

Law of Pakuła (2021), (15), (18), (26), (36)-(39): k d^1.5 in approach, R^2 of it in separation, so that the rebound speed is
R times the speed of approach whatever k, mass and speed; Coulomb friction that always slides; rolling resistance. Each of
the three steps in velocity is replaced by a slope that one step of time can resolve.

Alternative: Hertz contact with viscous damping (Tsuji et al. 1992) and a tangential spring with memory (Cundall and Strack
1979, stiffness of Mindlin 1949).

Nothing here branches, and no law knows an array: what is between them and the block of contacts stands in ``block.py``.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from autobalancer.kernels.chamber.vectors import cross, dot, minus, plus, times
from autobalancer.kernels.flags import MERGED, njit

TURNING = 1.0  # slope of the normal law at the turning point, in changes of speed within one step
SLIDING = 2.0  # the same for friction and rolling resistance
LEAST = 1e-30  # m: rounding must not make an overlap negative
TINY = 1e-300

Vector = tuple[float, float, float]


class Constants(NamedTuple):
    """What the laws need of ``CONTACT`` and ``RUN``, SI."""

    step: float
    friction: float
    slow: float
    rolling_arm: float
    recovered: float  # restitution squared
    damping: float  # over sqrt(mass stiffness) d^(1/4)
    shearing: float  # tangential stiffness over k d^(1/2)
    kept: float  # restitution squared of slow impacts: what counts as stored in a contact


class Meeting(NamedTuple):
    """Two bodies near each other, named as in ``CONTACTS``."""

    line: Vector
    offset: float
    taken: float
    stiffness: float
    lightness: float
    roll_radius: float
    shrink: float
    rate: Vector
    turn: Vector
    roll: Vector


class Overlap(NamedTuple):
    """Geometry and motion of a contact."""

    depth: float
    arm: float  # over the radius
    normal: Vector  # to the partner
    approach: float  # relative velocity along the normal
    across: Vector  # relative velocity at the point of contact


class Force(NamedTuple):
    """What a law answers."""

    normal: float
    friction: Vector
    lost: float  # power, in the impact
    slid: float  # power, by friction
    held: float  # energy


class Felt(NamedTuple):
    """What the ball feels, named as in ``CONTACTS``; its partner feels the opposite."""

    push: Vector
    twist: Vector
    resist: Vector
    arm: float
    rolled: float


@njit(**MERGED)
def overlap(m):
    """Overlap, normal to the partner, relative velocity along it and across it at the point of contact."""
    length = sqrt(dot(m.line, m.line))
    normal = times(1.0 / length, m.line)
    depth = max(m.offset + m.taken * length, LEAST)
    # the arms of both balls end at one point, or angular momentum would drift
    arm = 1.0 - depth * m.shrink
    velocity = plus(m.rate, times(arm, cross(m.turn, normal)))
    approach = dot(velocity, normal)
    return Overlap(depth, arm, normal, approach, minus(velocity, times(approach, normal)))


@njit(**MERGED)
def restitution(c, m, o):
    """Force of the law of restitution."""
    load = m.stiffness * o.depth * sqrt(o.depth)
    share = 0.5 + o.approach / (TURNING * c.step * load * m.lightness + TINY)
    normal = load * (c.recovered + (1.0 - c.recovered) * min(max(share, 0.0), 1.0))
    square = dot(o.across, o.across)
    least = max(c.slow, SLIDING * c.step * c.friction * normal * 3.5 * m.lightness)
    pull = c.friction * normal / max(sqrt(square), least)
    lost = (normal - c.kept * load) * o.approach
    return Force(normal, times(-pull, o.across), lost, pull * square, 0.4 * c.kept * load * o.depth)


@njit(**MERGED)
def with_memory(c, m, o, stretch):
    """Force of a damped Hertz contact, and the tangential spring after a step; ``stretch`` is that before."""
    root = sqrt(o.depth)
    load = m.stiffness * o.depth * root
    viscous = c.damping * sqrt(m.stiffness * root / m.lightness)
    normal = max(load + viscous * o.approach, 0.0)
    shear = c.shearing * m.stiffness * root
    stretch = plus(minus(stretch, times(dot(stretch, o.normal), o.normal)), times(c.step, o.across))
    friction = minus(times(-shear, stretch), times(viscous, o.across))
    # where friction cannot hold the force, the spring yields
    part = min(c.friction * normal / max(sqrt(dot(friction, friction)), TINY), 1.0)
    friction = times(part, friction)
    slipped = times(-1.0 / shear, plus(friction, times(viscous, o.across)))
    slides = part < 1.0
    x = slipped[0] if slides else stretch[0]
    y = slipped[1] if slides else stretch[1]
    z = slipped[2] if slides else stretch[2]
    lost = (normal - load) * o.approach
    return Force(normal, friction, lost, -dot(friction, o.across), 0.4 * load * o.depth), (x, y, z)


@njit(**MERGED)
def felt(c, m, o, force):
    """Push and moment of a force, with rolling resistance."""
    along = dot(m.roll, o.normal)
    roll = minus(m.roll, times(along, o.normal))
    square = dot(roll, roll)
    inverse = 1.0 / m.roll_radius
    least = max(
        c.slow * inverse, SLIDING * c.step * c.rolling_arm * force.normal * 2.5 * m.lightness * inverse * inverse
    )
    moment = c.rolling_arm * force.normal / max(sqrt(square), least)
    push = minus(force.friction, times(force.normal, o.normal))
    return Felt(push, cross(o.normal, force.friction), times(-moment, roll), o.arm, moment * square)
