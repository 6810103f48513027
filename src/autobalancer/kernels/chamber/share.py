"""What a block of contacts does to balls, body and rotor."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from autobalancer.kernels.chamber.block import press, press_varied, vector
from autobalancer.kernels.chamber.vectors import add, cross, dot, minus, plus, take, three, times
from autobalancer.kernels.flags import APART, MERGED, njit
from autobalancer.kernels.pointers import data, row


@njit(**APART)
def act(chamber, count, axis):
    """Evaluate the first ``count`` contacts and add their forces, in their order; ``axis`` is that of the rotor."""
    block, body, power, since = chamber.scratch.contacts, chamber.body, chamber.power, chamber.since
    if chamber.contact.varies != 0:
        press_varied(chamber.run, chamber.contact, block, count, chamber.rebounds)
    else:
        press(chamber.run, chamber.contact, block, count)
    remember = chamber.contact.has_memory != 0
    middle = three(body.place)
    force = moment = 0.0, 0.0, 0.0
    lost = slid = rolled = held = 0.0
    most = since.greatest_force
    for i in range(count):
        number, partner, place = data(block.one)[i], data(block.two)[i], data(block.place)[i]
        one = row(chamber.balls, number)
        push, twist, resist = vector(block.push, i), vector(block.twist, i), vector(block.resist, i)
        arm = data(block.arm)[i]
        turn = plus(times(arm * one.radius, twist), resist)
        add(one.force, push)
        add(one.moment, turn)
        if partner >= 0:
            two = row(chamber.balls, partner)
            take(two.force, push)
            add(two.moment, minus(times(arm * two.radius, twist), resist))
            if remember:
                stretch = vector(block.stretch, i)
                for j in range(3):
                    chamber.pairs.stretch[place, j] = stretch[j]
        else:
            force = plus(force, push)
            moment = plus(moment, plus(cross(minus(three(one.position), middle), push), turn))
            if remember:
                stretch = vector(block.stretch, i)
                for j in range(3):
                    chamber.wall_stretch[number, place, j] = stretch[j]
        lost += data(block.lost)[i]
        slid += data(block.slid)[i]
        rolled += data(block.rolled)[i]
        held += data(block.held)[i]
        most = max(most, data(block.normal)[i])
    push_back(body, force, moment, axis)
    power.contact += lost
    power.friction += slid
    power.rolling += rolled
    power.stored += held
    since.greatest_force = most


@njit(**MERGED)
def push_back(body, force, moment, axis):
    """Body and rotor feel the opposite of a ``force`` on balls and of its ``moment`` about the rotor's middle."""
    take(body.contact_force, force)
    take(body.contact_moment, (dot(moment, axis), moment[1], moment[2]))
