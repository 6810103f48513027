"""All forces on balls, body and rotor in one state.

Contacts at walls and between balls are gathered into a block; a full block is evaluated and shared out. Those of cylinders are
evaluated one by one.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from autobalancer.kernels.chamber.body import body_rates
from autobalancer.kernels.chamber.cylinders import cylinders_at_walls, cylinders_together
from autobalancer.kernels.chamber.gather import near_pairs, walls
from autobalancer.kernels.chamber.records import TURN_Y, TURN_Z
from autobalancer.kernels.chamber.share import act
from autobalancer.kernels.chamber.vectors import put
from autobalancer.kernels.flags import APART, MERGED, njit


@njit(**MERGED)
def _axis(place):
    """Direction of the rotor."""
    y, z = place[TURN_Z], -place[TURN_Y]
    x = 1.0 / sqrt(1.0 + y * y + z * z)
    return x, x * y, x * z


@njit(**APART)
def forces(chamber, prescribed):
    """Fill the forces and moments of the balls, the second rates of the body, losses, and what is stored in contacts.

    ``prescribed`` is the rate of a prescribed speed.
    """
    power, body = chamber.power, chamber.body
    power.motor = power.contact = power.friction = power.rolling = 0.0
    power.supports = power.bearings = power.drag = power.stored = 0.0
    put(body.contact_force, (0.0, 0.0, 0.0))
    put(body.contact_moment, (0.0, 0.0, 0.0))
    axis = _axis(body.place)
    if chamber.contact.cylinders != 0:
        cylinders_at_walls(chamber, axis)
        cylinders_together(chamber, axis)
    else:
        filled = near_pairs(chamber, walls(chamber, axis), axis)
        if filled:
            act(chamber, filled, axis)
    body_rates(chamber.machine, body, chamber.scratch, power, prescribed)
