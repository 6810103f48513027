"""Contacts of a machine with deep chambers: stiffness by Hertz, durations, constants of the law."""

from __future__ import annotations

import math

import numpy as np

from autobalancer.assembly.contact.rebound import Tables, dampers, shares
from autobalancer.kernels.chamber.records import CONTACT
from autobalancer.kernels.fields import Row
from autobalancer.kernels.laws.rebound import NONE
from autobalancer.kernels.system import Floats, Integers
from autobalancer.laws import hertz
from autobalancer.laws.rebound import hertz_damping_ratio, slowest_rebound
from autobalancer.machine.chamber import ChamberMachine, FreeBalls, HistoryContact
from autobalancer.machine.chamber.contact import ChamberContact


def ball_groups(machine: ChamberMachine) -> list[tuple[int, FreeBalls]]:
    """(chamber, balls) of all groups."""
    return [(number, balls) for number, chamber in enumerate(machine.chambers) for balls in chamber.balls]


def pair_stiffness(contact: ChamberContact, first: float, second: float) -> float:
    """k of two balls with these radii, N/m^1.5."""
    if contact.stiffness is not None:
        return float(contact.stiffness)
    return hertz.pair_stiffness(reduced_modulus(contact), first, second)


def wall_stiffness(contact: ChamberContact, radius: float, wall: float = math.inf) -> float:
    """k of a ball on the race (radius ``wall``) or on a flat wall, N/m^1.5."""
    if contact.stiffness is not None:
        return float(contact.stiffness)
    return hertz.hertz_stiffness(reduced_modulus(contact), radius, wall)


def has_cylinders(machine: ChamberMachine) -> bool:
    """Whether its balls are cylinders; they all are, or none."""
    return machine.chambers[0].balls[0].body == "cylinder"


def reduced_modulus(contact: ChamberContact) -> float:
    return hertz.reduced_modulus(float(contact.youngs_modulus or 0.0), float(contact.poisson_ratio))


def contact_time(machine: ChamberMachine, speed: float = 4.0) -> float:
    """Least duration of an elastic collision at the relative ``speed``, s; that of cylinders is the same at any speed."""
    if has_cylinders(machine):
        return _cylinder_time(machine)
    least = math.inf
    groups = ball_groups(machine)
    contact = machine.contact
    for number, one in groups:
        walls = float(machine.chambers[number].radius), math.inf  # the inner wall is softer than a flat one
        pairs = [(wall_stiffness(contact, one.radius, wall), one.ball_mass) for wall in walls]
        for other_number, two in groups:
            if other_number == number:
                mass = 1.0 / (1.0 / one.ball_mass + 1.0 / two.ball_mass)
                pairs.append((pair_stiffness(contact, one.radius, two.radius), mass))
        least = min(least, *(hertz.collision_time(k, mass, speed) for k, mass in pairs))
    return least


def _cylinder_time(machine: ChamberMachine) -> float:
    """Least duration of a collision of cylinders with walls and each other, of sides and ends, s."""
    modulus, groups, least = reduced_modulus(machine.contact), ball_groups(machine), math.inf
    for number, one in groups:
        others = [(one.radius, one.half_width, math.inf)]
        others += [(two.radius, two.half_width, two.ball_mass) for other, two in groups if other == number]
        for radius, half, partner in others:
            mass = 1.0 / (1.0 / one.ball_mass + 1.0 / partner)
            for stiffness in (
                hertz.line_stiffness(modulus, 2.0 * min(one.half_width, half)),
                hertz.end_stiffness(modulus, min(one.radius, radius)),
            ):
                least = min(least, hertz.linear_collision_time(stiffness, mass))
    return least


def contact_row(contact: ChamberContact) -> Row:
    """Constants of the law."""
    row = CONTACT.row(
        friction=contact.friction,
        ball_friction=contact.friction if contact.ball_friction is None else contact.ball_friction,
        restitution_squared=contact.restitution**2,
        rolling_arm=contact.rolling_arm,
        slow=contact.slip_speed,
        varies=contact.rebound is not None,
    )
    if isinstance(contact, HistoryContact):
        row.has_memory = 1
        varies = contact.rebound is not None
        row.damping_ratio = math.sqrt(5.0) if varies else hertz_damping_ratio(contact.restitution)
        nu, ratio = contact.poisson_ratio, contact.shear_ratio
        row.shear_ratio = ratio if ratio is not None else 2.0 * (1.0 - nu) / (2.0 - nu)
    return row


def rebound_tables(machine: ChamberMachine) -> tuple[Floats, Integers]:
    """Tables of contacts whose restitution depends on the impact, and where that of each pair of groups begins.

    The last column is that of the walls. Groups of different chambers never meet.
    """
    contact, groups = machine.contact, ball_groups(machine)
    first = np.full((len(groups), len(groups) + 1), NONE, np.int64)
    tables, asked = (
        Tables(dampers if isinstance(contact, HistoryContact) else shares),
        (contact.rebound, contact.restitution),
    )
    for i, (number, one) in enumerate(groups):
        viscosity = float(machine.chambers[number].viscosity or 0.0)
        first[i, -1] = tables.first(*asked, _least(contact, one.ball_mass, one.radius, viscosity))
        for j, (other_number, two) in enumerate(groups):
            if other_number == number:
                mass = 1.0 / (1.0 / one.ball_mass + 1.0 / two.ball_mass)
                radius = 1.0 / (1.0 / one.radius + 1.0 / two.radius)
                first[i, j] = tables.first(*asked, _least(contact, mass, radius, viscosity))
    return tables.numbers, first


def _least(contact: ChamberContact, mass: float, radius: float, viscosity: float) -> float:
    """The speed below which a fluid leaves no rebound, m/s; reduced mass (kg) and radius (m)."""
    if contact.rebound is None or contact.rebound.critical_stokes is None:
        return 0.0
    return slowest_rebound(float(contact.rebound.critical_stokes), mass, radius, viscosity)
