"""The law of a contact of a ball with another ball or a wall.

Law of Pakuła (2021), (15), (18), (26), (36)-(39): k d^1.5 in approach, R^2 of it in separation, so that the rebound speed is
R times the speed of approach whatever k, mass and speed; Coulomb friction that always slides; rolling resistance. Each of
the three steps in velocity is replaced by a slope that one step of time can resolve.

Alternative: Hertz contact with viscous damping (Tsuji et al. 1992) and a tangential spring with memory (Cundall and Strack
1979, stiffness of Mindlin 1949).

Nothing in the laws branches, and none knows an array: what is between them and the block of contacts stands below.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

from autobalancer.kernels.chamber.chamber_records import BLOCK
from autobalancer.kernels.compiler.flags import APART, MERGED, njit
from autobalancer.kernels.compiler.numba_struct import data
from autobalancer.kernels.laws.contact_law import held_speed, table_value

# mypy: disable-error-code="no-untyped-def"


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


# Vectors as three numbers, which the compiler keeps in registers; nothing here knows an array but the first three.


# mypy: disable-error-code="no-untyped-def"


@njit(**MERGED)
def three(numbers):
    """The first three of an array."""
    return numbers[0], numbers[1], numbers[2]


@njit(**MERGED)
def put(numbers, a):
    """Write a vector to the first three of an array."""
    numbers[0], numbers[1], numbers[2] = a[0], a[1], a[2]


@njit(**MERGED)
def add(numbers, a):
    """Add a vector to the first three of an array."""
    numbers[0] += a[0]
    numbers[1] += a[1]
    numbers[2] += a[2]


@njit(**MERGED)
def take(numbers, a):
    """Take a vector off the first three of an array."""
    numbers[0] -= a[0]
    numbers[1] -= a[1]
    numbers[2] -= a[2]


@njit(**MERGED)
def plus(a, b):
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@njit(**MERGED)
def minus(a, b):
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@njit(**MERGED)
def times(factor, a):
    """A multiple of a."""
    return factor * a[0], factor * a[1], factor * a[2]


@njit(**MERGED)
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(**MERGED)
def cross(a, b):
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


# The law of a contact of a cylinder, along a line or over its end.
#
# As between balls by Pakuła (2021): the whole elastic force in approach, R^2 of it in separation, friction that always
# slides, a rolling moment; each jump at velocity zero is a slope that one step resolves. Friction of an end is that of
# a disc with even pressure: mu F where it slides, 2/3 mu F r where it turns, and an ellipse between (Howe and Cutkosky
# 1996), so that force and moment together take energy, whatever the motion.


# mypy: disable-error-code="no-untyped-def"


DISC = 2.0 / 3.0  # lever of friction under a disc that turns, over its radius
HEAVIER = 3.0  # lightness of a cylinder at its surface, over that of its middle
SPUN = 2.0  # mass times square of the radius, over the inertia of a cylinder


class Press(NamedTuple):
    """Normal force."""

    normal: float
    lost: float  # power
    held: float  # energy


class Side(NamedTuple):
    """Friction along a line."""

    across: float  # force
    along: float  # along the axis
    lost: float


class End(NamedTuple):
    """Friction of an end."""

    force: Vector
    moment: float  # about the axis
    lost: float


class Roll(NamedTuple):
    """Rolling resistance."""

    moment: float
    lost: float


@njit(**MERGED)
def pressed(run, contact, load, energy, approach, lightness):
    """Normal force where the elastic one is ``load`` and its springs hold ``energy``."""
    kept = contact.restitution_squared
    share = 0.5 + approach / (TURNING * run.step * load * lightness + TINY)
    normal = load * (kept + (1.0 - kept) * min(max(share, 0.0), 1.0))
    return Press(normal, (normal - kept * load) * approach, kept * energy)


@njit(**MERGED)
def _slope(run, slow, force, lightness):
    """Sliding speed below which friction is in proportion to it."""
    return max(slow, SLIDING * run.step * force * HEAVIER * lightness)


@njit(**MERGED)
def side_rubs(run, friction, slow, normal, across, along, lightness):
    """Friction on a cylinder that slides with these velocities at its line of contact."""
    square = across * across + along * along
    pull = friction * normal / max(sqrt(square), _slope(run, slow, friction * normal, lightness))
    return Side(-pull * across, -pull * along, pull * square)


@njit(**MERGED)
def end_rubs(run, friction, slow, normal, rate, spin, radius, lightness):
    """Friction on the end of a cylinder that slides with ``rate`` in its plane and turns with ``spin``."""
    lever = DISC * radius
    square = dot(rate, rate) + lever * lever * spin * spin
    pull = friction * normal / max(sqrt(square), _slope(run, slow, friction * normal, lightness))
    return End(times(-pull, rate), -pull * lever * lever * spin, pull * square)


@njit(**MERGED)
def rolls(run, contact, normal, spin, radius, lightness):
    """Rolling resistance against the relative ``spin``."""
    arm, inverse = contact.rolling_arm, 1.0 / radius
    least = max(contact.slow * inverse, SLIDING * run.step * arm * normal * SPUN * lightness * inverse * inverse)
    moment = arm * normal / max(abs(spin), least)
    return Roll(-moment * spin, moment * spin * spin)


# Contacts side by side in a block, so that the compiler takes eight of them at a time.
#
# What the search found of a contact is entered, the law is evaluated for the whole block, and what it does is read.


# mypy: disable-error-code="no-untyped-def"


AT_ONCE = 8


@njit(**MERGED)
def vector(field, i):
    """Vector ``i`` of a field of three rows."""
    numbers = data(field)
    return numbers[i], numbers[BLOCK + i], numbers[2 * BLOCK + i]


@njit(**MERGED)
def put_vector(field, i, a):
    """Write vector ``i`` of a field of three rows."""
    numbers = data(field)
    numbers[i], numbers[BLOCK + i], numbers[2 * BLOCK + i] = a[0], a[1], a[2]


@njit(**MERGED)
def enter(block, i, meeting, one, two, place):
    """A contact into place ``i``: of ball ``one`` with ball ``two``, -1 for a wall; ``place`` is its pair or wall."""
    put_vector(block.line, i, meeting.line)
    data(block.offset)[i], data(block.taken)[i] = meeting.offset, meeting.taken
    data(block.stiffness)[i], data(block.lightness)[i] = meeting.stiffness, meeting.lightness
    data(block.roll_radius)[i], data(block.shrink)[i] = meeting.roll_radius, meeting.shrink
    put_vector(block.rate, i, meeting.rate)
    put_vector(block.turn, i, meeting.turn)
    put_vector(block.roll, i, meeting.roll)
    data(block.one)[i], data(block.two)[i], data(block.place)[i] = one, two, place


@njit(**MERGED)
def _meeting(block, i):
    return Meeting(
        vector(block.line, i), data(block.offset)[i], data(block.taken)[i], data(block.stiffness)[i],
        data(block.lightness)[i], data(block.roll_radius)[i], data(block.shrink)[i], vector(block.rate, i),
        vector(block.turn, i), vector(block.roll, i),
    )  # fmt: skip


@njit(**MERGED)
def _leave(block, i, feels, force):
    put_vector(block.push, i, feels.push)
    put_vector(block.twist, i, feels.twist)
    put_vector(block.resist, i, feels.resist)
    data(block.arm)[i], data(block.rolled)[i] = feels.arm, feels.rolled
    data(block.lost)[i], data(block.slid)[i], data(block.held)[i] = force.lost, force.slid, force.held
    data(block.normal)[i] = force.normal


@njit(**MERGED)
def _constants(run, contact, friction, recovered, damping):
    return Constants(
        run.step, friction, contact.slow, contact.rolling_arm, recovered, damping, 1.5 * contact.shear_ratio,
        contact.restitution_squared,
    )  # fmt: skip


@njit(**MERGED)
def _friction(block, i, wall, ball):
    """Coefficient of contact ``i``, of a ball on a wall or on a ball."""
    return wall if data(block.two)[i] < 0 else ball


@njit(**APART)
def _look_up(rebounds, block, count):
    """What the tables say of the first ``count`` contacts."""
    for i in range(count):
        m = _meeting(block, i)
        o = overlap(m)
        held = held_speed(o.depth, m.stiffness, m.lightness, 1)
        data(block.found)[i] = table_value(data(rebounds), data(block.rebound)[i], held, o.approach)


@njit(**APART)
def press(run, contact, block, count, rebounds):
    """Forces, losses and energy of the first ``count`` contacts of ``block``; unused places are computed too."""
    wall, ball, found = contact.friction, contact.ball_friction, data(block.found)
    padded = (count + AT_ONCE - 1) // AT_ONCE * AT_ONCE
    if contact.varies != 0:  # restitution depends on the speed of an impact
        _look_up(rebounds, block, count)
    else:
        for i in range(padded):
            found[i] = 1.0 if contact.has_memory != 0 else contact.restitution_squared
    if contact.has_memory != 0:
        for i in range(padded):
            m = _meeting(block, i)
            o = overlap(m)
            c = _constants(run, contact, _friction(block, i, wall, ball), 1.0, contact.damping_ratio * found[i])
            force, stretch = with_memory(c, m, o, vector(block.stretch, i))
            put_vector(block.stretch, i, stretch)
            _leave(block, i, felt(c, m, o, force), force)
    else:
        for i in range(padded):
            m = _meeting(block, i)
            o = overlap(m)
            c = _constants(run, contact, _friction(block, i, wall, ball), found[i], 0.0)
            force = restitution(c, m, o)
            _leave(block, i, felt(c, m, o, force), force)
