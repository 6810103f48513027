"""From a machine with deep chambers to the numbers of its kernels."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from autobalancer.assembly.contact import Tables, dampers, shares
from autobalancer.assembly.drive_train import corners, profile_pieces
from autobalancer.errors import MachineError
from autobalancer.kernels.chamber import chamber_records
from autobalancer.kernels.chamber.chamber_records import (
    BODY,
    CONTACT,
    COORDINATES,
    MACHINE,
    PROFILE,
    THETA,
    Chamber,
    Pairs,
    Scratch,
    Search,
)
from autobalancer.kernels.fields import Row, Rows
from autobalancer.kernels.laws.contact_law import NONE
from autobalancer.kernels.system import Floats, Integers
from autobalancer.laws import impacts
from autobalancer.laws.impacts import end_stiffness, hertz_damping_ratio, line_stiffness, slowest_rebound
from autobalancer.machine.chamber import Chamber as RoundChamber
from autobalancer.machine.chamber import ChamberContact, ChamberMachine, FreeBalls, HistoryContact
from autobalancer.machine.drive import AsynchronousMotor, Hill

# From a machine with deep chambers to what its kernels take.


Array = Any
MARGIN = 0.3  # of the least ball radius: how far beyond contact pairs are listed
NEIGHBORS = 24  # pairs kept for each ball


def assemble_chamber(machine: ChamberMachine, positions: Array, step: float) -> Chamber:
    """Numbers of a machine at rest whose balls are at ``positions`` (n, 3) from the middles of their chambers.

    Without any position the balls are held: masses in the middles of their chambers.
    """
    groups = ball_groups(machine)
    least = min(min(balls.radius, balls.half_width) for _, balls in groups)
    n = len(positions)
    room = NEIGHBORS * n + 64
    rebounds, pair_rebounds = rebound_tables(machine)
    return Chamber(
        run=chamber_records.RUN.row(step=step, margin=MARGIN * least),
        contact=_contact(machine),
        machine=machine_row(machine, held=not n),
        rooms=_rooms(machine),
        pair_stiffness=_pair_stiffness(machine),
        rebounds=rebounds,
        pair_rebounds=pair_rebounds,
        profile=profile_rows(machine),
        balls=_balls(machine, positions) if n else chamber_records.BALL.rows(0),
        wall_stretch=np.zeros((n, chamber_records.WALLS, 3)),
        pairs=_pairs(n, room),
        body=body_row(machine),
        power=chamber_records.POWER.row(),
        before=chamber_records.POWER.row(),
        account=chamber_records.ACCOUNT.row(),
        since=chamber_records.SINCE.row(),
        progress=chamber_records.PROGRESS.row(),
        scratch=_scratch(n, room),
    )


def _contact(machine: ChamberMachine) -> Row:
    row = contact_row(machine.contact)
    row.cylinders = has_cylinders(machine)
    return row


def _pair_stiffness(machine: ChamberMachine) -> Array:
    """Of balls k for each pair of groups; of cylinders the reduced modulus, as k depends on where they meet."""
    radii = [balls.radius for _, balls in ball_groups(machine)]
    if has_cylinders(machine):
        return np.full((len(radii), len(radii)), reduced_modulus(machine.contact))
    return np.array([[pair_stiffness(machine.contact, a, b) for b in radii] for a in radii])


def _pairs(n: int, room: int) -> Pairs:
    first, second = np.zeros(room, np.int32), np.zeros(room, np.int32)
    return Pairs(first, second, np.zeros(room, np.int8), np.zeros((room, 3)), np.zeros((n, 3)))


def _scratch(n: int, room: int) -> Scratch:
    return Scratch(
        search=Search(
            old_row=np.zeros(n + 1, np.int32),
            old_second=np.zeros(room, np.int32),
            old_stretch=np.zeros((room, 3)),
            cells=np.zeros(max(8 * n, 64) + 2, np.int64),
            order=np.zeros(n, np.int32),
            places=np.zeros(n, np.int32),
        ),
        # places that are not in use are computed too
        contacts=chamber_records.CONTACTS.row(line=1.0, stiffness=1.0, lightness=1.0, roll_radius=1.0),
        equations=np.zeros((7, 8)),
        reduced=np.zeros((7, 8)),
        begun=chamber_records.MOTION.rows(n),
        gone=chamber_records.MOTION.rows(n),
        body_begun=chamber_records.BODY_MOTION.row(),
        body_gone=chamber_records.BODY_MOTION.row(),
    )


def _balls(machine: ChamberMachine, positions: Array) -> Rows:
    groups = ball_groups(machine)
    rows = chamber_records.BALL.rows(sum(balls.count for _, balls in groups))
    i = 0
    for kind, (number, group) in enumerate(groups):
        chamber = machine.chambers[number]
        own = rows[i : i + group.count]
        own.position = positions[i : i + group.count]
        own.position[:, 0] += chamber.position
        own.radius, own.mass = group.radius, group.ball_mass
        own.inertia = group.spin_inertia
        own.inverse_mass, own.inverse_inertia = 1.0 / own.mass, 1.0 / own.inertia
        own.kind, own.chamber = kind, number
        _walls(machine, own, group, chamber)
        if group.velocities is not None:
            own.velocity = group.velocities
        if group.spins is not None:
            own.spin = group.spins
        i += group.count
    return rows


def _walls(machine: ChamberMachine, own: Rows, group: FreeBalls, chamber: RoundChamber) -> None:
    """Stiffness of the walls, and what a cylinder is along the rotor."""
    contact, radius = machine.contact, group.radius
    if group.length is not None:
        own.half_length = group.half_width
        own.race_stiffness = own.inner_stiffness = line_stiffness(reduced_modulus(contact), float(group.length))
        own.flat_stiffness = end_stiffness(reduced_modulus(contact), radius)
        return
    own.race_stiffness = wall_stiffness(contact, radius, float(chamber.radius))
    own.flat_stiffness = wall_stiffness(contact, radius)
    if chamber.inner_radius > 0.0:
        own.inner_stiffness = wall_stiffness(contact, radius, -float(chamber.inner_radius))


def _rooms(machine: ChamberMachine) -> Rows:
    rows = chamber_records.ROOM.rows(len(machine.chambers))
    for room, chamber in zip(rows, machine.chambers, strict=True):
        room.center, room.wall_radius, room.half_depth = chamber.position, chamber.radius, 0.5 * chamber.inner_depth
        room.drag, room.square_drag = chamber.drag, chamber.square_drag
        room.inner_radius = chamber.inner_radius or -math.inf
    return rows


# Body, rotor and drive of a machine with deep chambers.


FREE = {"fixed": [], "planar": [1, 2, 3], "free": [0, 1, 2, 3, 4, 5]}  # coordinates


def body_row(machine: ChamberMachine) -> Row:
    """The body before the start."""
    row = BODY.row()
    row.place[THETA], row.rate[THETA] = machine.start.rotor_angle, machine.start.speed
    return row


def machine_row(machine: ChamberMachine, *, held: bool = False) -> Row:
    """Constants of body, supports, rotor, unbalance and motor; with the balls ``held`` in the middles of their chambers."""
    rotor, drive = machine.rotor, machine.drive
    inertia, stiffness, damping = _body(machine)
    free = FREE[machine.body.freedom]
    row = MACHINE.row(
        gravity=machine.gravity,
        inertia=inertia,
        stiffness=stiffness,
        damping=damping,
        free=free + [-1] * (COORDINATES - len(free)),
        rotor_mass=rotor.mass,
        polar_inertia=rotor.polar_inertia,
        transverse_inertia=_transverse_inertia(machine),
        bearings=rotor.bearings,
        neck=0.5 * rotor.bearing_friction * rotor.neck_diameter,
        rotor_damping=rotor.damping,
    )
    if isinstance(drive, AsynchronousMotor):
        row.driven = 1
        row.rated_torque, row.overload = drive.rated_torque, drive.overload
        row.synchronous_speed = drive.synchronous_speed
        row.breakdown_speed = drive.synchronous_speed * (1.0 - drive.breakdown_slip)
    for unbalance in machine.unbalances:
        vector = np.array([unbalance.vector.real, unbalance.vector.imag])
        row.unbalance += vector
        row.couple += unbalance.position * vector
    for chamber in machine.chambers if held else ():
        mass, arm = sum(group.count * group.ball_mass for group in chamber.balls), np.zeros((3, 6))
        arm[:, :3] = np.eye(3)
        arm[1, 5], arm[2, 4] = chamber.position, -chamber.position
        row.inertia += mass * arm.T @ arm
        row.rotor_mass += mass
        row.transverse_inertia += mass * chamber.position**2
    return row


def _transverse_inertia(machine: ChamberMachine) -> float:
    """Of the rotor, with that of cylinders about their own middles, which tilt with it, kg m²."""
    carried = sum(balls.count * balls.tilt_inertia for chamber in machine.chambers for balls in chamber.balls)
    return float(machine.rotor.transverse_inertia) + carried


def profile_rows(machine: ChamberMachine) -> Rows:
    """Corners of a prescribed speed."""
    if isinstance(machine.drive, AsynchronousMotor):
        return PROFILE.rows(1)
    profile = machine.drive.profile
    if isinstance(profile, Hill):
        piece = profile_pieces(profile)[0]
        end, half, exponent, begin = piece.numbers
        times = half * np.geomspace(1e-3, 1e3, 4000)
        rise = (times / half) ** exponent
        return _corners(np.r_[0.0, times], np.r_[begin, begin + (end - begin) * rise / (1.0 + rise)])
    points = corners(profile)
    if any(b[0] <= a[0] for a, b in pairwise(points)):
        raise MachineError("drive.profile: the speed jumps; give its change some time")
    return _corners(*np.array(points, np.float64).T)


def _corners(times: Array, speeds: Array) -> Rows:
    rows = PROFILE.rows(len(times))
    rows.time, rows.speed = times, speeds
    return rows


def _cross(r: Any) -> Array:
    return np.array([[0.0, -r[2], r[1]], [r[2], 0.0, -r[0]], [-r[1], r[0], 0.0]])


def _body(machine: ChamberMachine) -> tuple[Array, Array, Array]:
    """Inertia of body and rotor, stiffness and damping of the supports, all (6, 6) about the rotor's middle."""
    inertia = np.zeros((6, 6))
    inertia[:3, :3] = machine.rotor.mass * np.eye(3)
    inertia[[4, 5], [4, 5]] = _transverse_inertia(machine)
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


# Contacts of a machine with deep chambers: stiffness by Hertz, durations, constants of the law.


def ball_groups(machine: ChamberMachine) -> list[tuple[int, FreeBalls]]:
    """(chamber, balls) of all groups."""
    return [(number, balls) for number, chamber in enumerate(machine.chambers) for balls in chamber.balls]


def pair_stiffness(contact: ChamberContact, first: float, second: float) -> float:
    """k of two balls with these radii, N/m^1.5."""
    if contact.stiffness is not None:
        return float(contact.stiffness)
    return impacts.pair_stiffness(reduced_modulus(contact), first, second)


def wall_stiffness(contact: ChamberContact, radius: float, wall: float = math.inf) -> float:
    """k of a ball on the race (radius ``wall``) or on a flat wall, N/m^1.5."""
    if contact.stiffness is not None:
        return float(contact.stiffness)
    return impacts.hertz_stiffness(reduced_modulus(contact), radius, wall)


def has_cylinders(machine: ChamberMachine) -> bool:
    """Whether its balls are cylinders; they all are, or none."""
    return machine.chambers[0].balls[0].body == "cylinder"


def reduced_modulus(contact: ChamberContact) -> float:
    return impacts.reduced_modulus(float(contact.youngs_modulus or 0.0), float(contact.poisson_ratio))


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
        least = min(least, *(impacts.collision_time(k, mass, speed) for k, mass in pairs))
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
                impacts.line_stiffness(modulus, 2.0 * min(one.half_width, half)),
                impacts.end_stiffness(modulus, min(one.radius, radius)),
            ):
                least = min(least, impacts.linear_collision_time(stiffness, mass))
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
    tables, requested = (
        Tables(dampers if isinstance(contact, HistoryContact) else shares),
        (contact.rebound, contact.restitution),
    )
    for i, (number, one) in enumerate(groups):
        viscosity = float(machine.chambers[number].viscosity or 0.0)
        first[i, -1] = tables.first(*requested, _least_rebound_speed(contact, one.ball_mass, one.radius, viscosity))
        for j, (other_number, two) in enumerate(groups):
            if other_number == number:
                mass = 1.0 / (1.0 / one.ball_mass + 1.0 / two.ball_mass)
                radius = 1.0 / (1.0 / one.radius + 1.0 / two.radius)
                first[i, j] = tables.first(*requested, _least_rebound_speed(contact, mass, radius, viscosity))
    return tables.numbers, first


def _least_rebound_speed(contact: ChamberContact, mass: float, radius: float, viscosity: float) -> float:
    """The speed below which a fluid leaves no rebound, m/s; reduced mass (kg) and radius (m)."""
    if contact.rebound is None or contact.rebound.critical_stokes is None:
        return 0.0
    return slowest_rebound(float(contact.rebound.critical_stokes), mass, radius, viscosity)
