"""From a machine with deep chambers to the arrays of its kernels."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any

import numpy as np

from autobalancer.assembly.profile import corners, profile_pieces
from autobalancer.errors import MachineError
from autobalancer.kernels.chamber import layout as at
from autobalancer.laws.hertz import hertz_stiffness
from autobalancer.laws.rebound import hertz_damping_ratio
from autobalancer.machine.chamber import AsynchronousMotor, ChamberMachine, FreeBalls, HistoryContact
from autobalancer.machine.chamber.contact import ChamberContact
from autobalancer.machine.profile import Hill

Array = Any
MARGIN = 0.3  # of the least ball radius: how far beyond contact pairs are listed
NEIGHBORS = 24  # pairs kept for each ball


@dataclass
class ChamberNumbers:
    """The arrays of ``kernels/chamber`` in the order in which ``verlet`` takes them, and what runs carry along."""

    balls: Array  # (n, BALL_COLUMNS)
    chambers: Array  # (c, CHAMBER_COLUMNS)
    wall_springs: Array  # (n, 9)
    number: Array  # (NUMBERS,)
    pair_stiffness: Array  # (kinds, kinds) N/m^1.5
    first: Array
    second: Array
    touching: Array
    springs: Array
    old_row: Array
    old_second: Array
    old_springs: Array
    cells: Array
    order: Array
    places: Array
    host: Array  # (HOST,)
    inertia: Array  # (6, 6) of body and rotor about the rotor's middle
    stiffness: Array  # (6, 6)
    damping: Array  # (6, 6)
    active: Array  # free coordinates, then -1
    work: Array
    block: Array  # (BLOCK_ROWS, BLOCK) contacts under evaluation
    profile: Array  # (p, 2) time, speed
    power: Array
    before: Array
    ledger: Array
    greatest: Array
    counts: Array

    def checkpoint(self) -> dict[str, Array]:
        """Copies of everything that a run changes."""
        return {field.name: getattr(self, field.name).copy() for field in fields(self)}


def ball_groups(machine: ChamberMachine) -> list[tuple[int, FreeBalls]]:
    """(chamber, balls) of all groups."""
    return [(number, balls) for number, chamber in enumerate(machine.chambers) for balls in chamber.balls]


def pair_stiffness(contact: ChamberContact, first: float, second: float) -> float:
    """k of two balls with these radii, N/m^1.5."""
    if contact.stiffness is not None:
        return float(contact.stiffness)
    return 4.0 / 3.0 * _reduced(contact) * math.sqrt(first * second / (first + second))


def wall_stiffness(contact: ChamberContact, radius: float, wall: float = math.inf) -> float:
    """k of a ball on the race (radius ``wall``) or on a flat wall, N/m^1.5."""
    if contact.stiffness is not None:
        return float(contact.stiffness)
    return hertz_stiffness(_reduced(contact), radius, wall)


def _reduced(contact: ChamberContact) -> float:
    return float(contact.youngs_modulus or 0.0) / (2.0 * (1.0 - float(contact.poisson_ratio) ** 2))


def contact_time(machine: ChamberMachine, speed: float = 4.0) -> float:
    """Least duration of an elastic collision at the relative ``speed``, s (Johnson 1985, (11.24))."""
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
        for k, mass in pairs:
            deepest = (1.25 * mass * speed**2 / k) ** 0.4
            least = min(least, 2.9432750 * deepest / speed)
    return least


def assemble_chamber(machine: ChamberMachine, positions: Array, step: float) -> ChamberNumbers:
    """Numbers of a machine at rest whose balls are at ``positions`` (n, 3) from the middles of their chambers."""
    groups = ball_groups(machine)
    n = sum(balls.count for _, balls in groups)
    rows = np.zeros((n, at.BALL_COLUMNS))
    smallest = min(balls.radius for _, balls in groups)
    kinds = [balls.radius for _, balls in groups]
    i = 0
    for kind, (number, group) in enumerate(groups):
        chamber = machine.chambers[number]
        own = rows[i : i + group.count]
        own[:, at.POS : at.POS + 3] = positions[i : i + group.count]
        own[:, at.POS] += chamber.position
        own[:, at.RADIUS], own[:, at.MASS] = group.radius, group.ball_mass
        own[:, at.INERTIA] = 0.4 * group.ball_mass * group.radius**2
        own[:, at.INVERSE_MASS], own[:, at.INVERSE_INERTIA] = 1.0 / own[:, at.MASS], 1.0 / own[:, at.INERTIA]
        own[:, at.KIND], own[:, at.CHAMBER] = kind, number
        own[:, at.K_RACE] = wall_stiffness(machine.contact, group.radius, float(chamber.radius))
        own[:, at.K_FLAT] = wall_stiffness(machine.contact, group.radius)
        if chamber.inner_radius > 0.0:
            own[:, at.K_INNER] = wall_stiffness(machine.contact, group.radius, -float(chamber.inner_radius))
        if group.velocities is not None:
            own[:, at.VEL : at.VEL + 3] = group.velocities
        if group.spins is not None:
            own[:, at.SPIN : at.SPIN + 3] = group.spins
        i += group.count
    room = NEIGHBORS * n + 64
    host = np.zeros(at.HOST)
    host[at.Q + 6], host[at.V + 6] = machine.start.rotor_angle, machine.start.speed
    inertia, stiffness, damping = _body(machine)
    active = {"fixed": [], "planar": [1, 2, 3], "free": [0, 1, 2, 3, 4, 5]}[machine.body.freedom]
    return ChamberNumbers(
        balls=rows,
        chambers=np.array(
            [
                [c.position, c.radius, 0.5 * c.inner_depth, c.drag, c.square_drag, c.inner_radius or -math.inf]
                for c in machine.chambers
            ],
            np.float64,
        ),
        wall_springs=np.zeros((n, at.WALL_SPRINGS)),
        number=_number(machine, step, MARGIN * smallest),
        pair_stiffness=np.array([[pair_stiffness(machine.contact, a, b) for b in kinds] for a in kinds]),
        first=np.zeros(room, np.int32),
        second=np.zeros(room, np.int32),
        touching=np.zeros(room, np.int8),
        springs=np.zeros((room, 3)),
        old_row=np.zeros(n + 1, np.int32),
        old_second=np.zeros(room, np.int32),
        old_springs=np.zeros((room, 3)),
        cells=np.zeros(max(8 * n, 64) + 2, np.int64),
        order=np.zeros(n, np.int32),
        places=np.zeros(n, np.int32),
        host=host,
        inertia=inertia,
        stiffness=stiffness,
        damping=damping,
        active=np.array([*active, -1], np.int64),
        work=np.zeros((14, 8)),
        block=np.zeros((at.BLOCK_ROWS, at.BLOCK)),
        profile=_profile(machine),
        power=np.zeros(at.POWERS),
        before=np.zeros(at.STORED + 1 + 12),
        ledger=np.zeros(at.POWERS),
        greatest=np.zeros(2),
        counts=np.zeros(at.COUNTS, np.int64),
    )  # fmt: skip


def _cross(r: Any) -> Array:
    return np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])


def _body(machine: ChamberMachine) -> tuple[Array, Array, Array]:
    """Inertia of body and rotor, stiffness and damping of the supports, all (6, 6) about the rotor's middle."""
    inertia = np.zeros((6, 6))
    inertia[:3, :3] = machine.rotor.mass * np.eye(3)
    inertia[[4, 5], [4, 5]] = machine.rotor.transverse_inertia
    body = machine.body
    if body.mass is not None and body.inertia is not None:
        arm = np.hstack([np.eye(3), -_cross(body.center)])
        inertia += body.mass * arm.T @ arm
        inertia[3:, 3:] += np.diag(body.inertia)
    stiffness, damping = np.zeros((6, 6)), np.zeros((6, 6))
    for support in machine.supports:
        arm = np.hstack([np.eye(3), -_cross(support.position)])
        stiffness += arm.T @ np.diag(support.stiffness) @ arm
        damping += arm.T @ np.diag(support.damping) @ arm
    return inertia, stiffness, damping


def _number(machine: ChamberMachine, step: float, margin: float) -> Array:
    number = np.zeros(at.NUMBERS)
    contact, rotor, drive = machine.contact, machine.rotor, machine.drive
    number[at.STEP] = step
    number[[at.GRAVITY_X, at.GRAVITY_Y, at.GRAVITY_Z]] = machine.gravity
    number[at.FRICTION], number[at.RESTITUTION_SQUARED] = contact.friction, contact.restitution**2
    number[at.ROLLING_ARM], number[at.SLOW] = contact.rolling_arm, contact.slow
    if isinstance(contact, HistoryContact):
        number[at.LAW] = at.HISTORY
        number[at.DAMPING_RATIO] = hertz_damping_ratio(contact.restitution)
        nu = contact.poisson_ratio
        ratio = contact.shear_ratio
        number[at.SHEAR_RATIO] = ratio if ratio is not None else 2.0 * (1.0 - nu) / (2.0 - nu)
    if isinstance(drive, AsynchronousMotor):
        number[at.DRIVEN] = 1.0
        number[at.RATED], number[at.OVERLOAD] = drive.rated_torque, drive.overload
        number[at.SYNCHRONOUS] = drive.synchronous_speed
        number[at.BREAKDOWN] = drive.synchronous_speed * (1.0 - drive.breakdown_slip)
    number[at.NECK] = 0.5 * rotor.bearing_friction * rotor.neck_diameter
    number[[at.BEARING_1, at.BEARING_2]] = rotor.bearings
    number[[at.ROTOR_MASS, at.POLAR, at.TRANSVERSE]] = rotor.mass, rotor.polar_inertia, rotor.transverse_inertia
    number[at.ROTOR_DAMPING], number[at.SKIN] = rotor.damping, margin
    for unbalance in machine.unbalances:
        along, up = unbalance.size * math.cos(unbalance.angle), unbalance.size * math.sin(unbalance.angle)
        number[[at.U_C, at.U_S]] += along, up
        number[[at.COUPLE_C, at.COUPLE_S]] += unbalance.position * along, unbalance.position * up
    return number


def _profile(machine: ChamberMachine) -> Array:
    if isinstance(machine.drive, AsynchronousMotor):
        return np.zeros((1, 2))
    profile = machine.drive.profile
    if isinstance(profile, Hill):
        piece = profile_pieces(profile)[0]
        end, half, exponent, begin = piece.numbers
        times = half * np.geomspace(1e-3, 1e3, 4000)
        rise = (times / half) ** exponent
        return np.column_stack([np.r_[0.0, times], np.r_[begin, begin + (end - begin) * rise / (1.0 + rise)]])
    points = corners(profile)
    if any(b[0] <= a[0] for a, b in pairwise(points)):
        raise MachineError("drive.profile: the speed jumps; give its change some time")
    return np.array(points, np.float64)
