"""Contacts side by side in a block, so that the compiler takes eight of them at a time.

What the search found of a contact is entered, the law is evaluated for the whole block, and what it does is read.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from autobalancer.kernels.chamber.contact import Constants, Meeting, felt, overlap, restitution, with_memory
from autobalancer.kernels.chamber.records import BLOCK
from autobalancer.kernels.flags import APART, MERGED, njit
from autobalancer.kernels.laws.rebound import held_speed, looked_up
from autobalancer.kernels.pointers import data

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
        data(block.found)[i] = looked_up(data(rebounds), data(block.rebound)[i], held, o.approach)


@njit(**APART)
def press_varied(run, contact, block, count, rebounds):
    """The same as ``press`` where restitution depends on the speed of an impact."""
    _look_up(rebounds, block, count)
    wall, ball = contact.friction, contact.ball_friction
    padded = (count + AT_ONCE - 1) // AT_ONCE * AT_ONCE
    if contact.has_memory != 0:
        for i in range(padded):
            m = _meeting(block, i)
            o = overlap(m)
            c = _constants(
                run, contact, _friction(block, i, wall, ball), 1.0, contact.damping_ratio * data(block.found)[i]
            )
            force, stretch = with_memory(c, m, o, vector(block.stretch, i))
            put_vector(block.stretch, i, stretch)
            _leave(block, i, felt(c, m, o, force), force)
    else:
        for i in range(padded):
            m = _meeting(block, i)
            o = overlap(m)
            c = _constants(run, contact, _friction(block, i, wall, ball), data(block.found)[i], 0.0)
            force = restitution(c, m, o)
            _leave(block, i, felt(c, m, o, force), force)


@njit(**APART)
def press(run, contact, block, count):
    """Forces, losses and energy of the first ``count`` contacts of ``block``; unused places are computed too."""
    wall, ball = contact.friction, contact.ball_friction
    recovered, damping = contact.restitution_squared, contact.damping_ratio
    padded = (count + AT_ONCE - 1) // AT_ONCE * AT_ONCE
    if contact.has_memory != 0:
        for i in range(padded):
            m = _meeting(block, i)
            o = overlap(m)
            c = _constants(run, contact, _friction(block, i, wall, ball), recovered, damping)
            force, stretch = with_memory(c, m, o, vector(block.stretch, i))
            put_vector(block.stretch, i, stretch)
            _leave(block, i, felt(c, m, o, force), force)
    else:
        for i in range(padded):
            m = _meeting(block, i)
            o = overlap(m)
            c = _constants(run, contact, _friction(block, i, wall, ball), recovered, damping)
            force = restitution(c, m, o)
            _leave(block, i, felt(c, m, o, force), force)
