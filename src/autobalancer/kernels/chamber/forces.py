"""All forces on balls, body and rotor in one state.

Contacts at walls and between balls are gathered into a block; a full block is evaluated and shared out.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import njit

from autobalancer.kernels.chamber.body import body_rates
from autobalancer.kernels.chamber.contact import APART
from autobalancer.kernels.chamber.gather import near_pairs, walls
from autobalancer.kernels.chamber.layout import CONTACT, STORED, Q
from autobalancer.kernels.chamber.share import act


@njit(**APART)
def forces(
    balls,
    chambers,
    wall_springs,
    number,
    pair_stiffness,
    first,
    second,
    touching,
    springs,
    host,
    inertia,
    stiffness,
    damping,
    active,
    work,
    block,
    power,
    counts,
    greatest,
    prescribed,
):
    """Fill the forces and moments of the balls, the second rates of the body, losses, and what is stored in contacts."""
    for i in range(STORED + 1):
        power[i] = 0.0
    for i in range(6):
        host[CONTACT + i] = 0.0
    uy, uz = host[Q + 5], -host[Q + 4]
    ux = 1.0 / sqrt(1.0 + uy * uy + uz * uz)
    uy, uz = ux * uy, ux * uz
    filled = walls(balls, chambers, wall_springs, springs, number, host, block, power, counts, greatest, ux, uy, uz)
    filled = near_pairs(
        balls, wall_springs, springs, number, host, pair_stiffness, first, second, touching, block, filled, power, counts,
        greatest, ux, uy, uz,
    )  # fmt: skip
    if filled:
        act(balls, wall_springs, springs, number, host, block, filled, power, greatest, ux, uy, uz)
    body_rates(number, host, inertia, stiffness, damping, active, work, power, prescribed)
