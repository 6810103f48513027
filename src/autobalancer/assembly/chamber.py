"""From a machine with deep chambers to the arrays of its kernels."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np

from autobalancer.assembly.profile import corners, profile_pieces
from autobalancer.errors import MachineError
from autobalancer.kernels.chamber import records as of
from autobalancer.kernels.chamber.chamber import Chamber, Pairs, Scratch, Search
from autobalancer.kernels.fields import Row, Rows
from autobalancer.laws import hertz
from autobalancer.laws.rebound import hertz_damping_ratio
from autobalancer.machine.chamber import AsynchronousMotor, ChamberMachine, FreeBalls, HistoryContact
from autobalancer.machine.chamber.contact import ChamberContact
from autobalancer.machine.profile import Hill

Array = Any
MARGIN = 0.3  # of the least ball radius: how far beyond contact pairs are listed
NEIGHBORS = 24  # pairs kept for each ball


def ball_groups(machine: ChamberMachine) -> list[tuple[int, FreeBalls]]:
    """(chamber, balls) of all groups."""
    return [(number, balls) for number, chamber in enumerate(machine.chambers) for balls in chamber.balls]


def pair_stiffness(contact: ChamberContact, first: float, second: float) -> float:
    """k of two balls with these radii, N/m^1.5."""
    if contact.stiffness is not None:
        return float(contact.stiffness)
    return hertz.pair_stiffness(_modulus(contact), first, second)


def wall_stiffness(contact: ChamberContact, radius: float, wall: float = math.inf) -> float:
    """k of a ball on the race (radius ``wall``) or on a flat wall, N/m^1.5."""
    if contact.stiffness is not None:
        return float(contact.stiffness)
    return hertz.hertz_stiffness(_modulus(contact), radius, wall)


def _modulus(contact: ChamberContact) -> float:
    return hertz.reduced_modulus(float(contact.youngs_modulus or 0.0), float(contact.poisson_ratio))


def contact_time(machine: ChamberMachine, speed: float = 4.0) -> float:
    """Least duration of an elastic collision at the relative ``speed``, s."""
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


def assemble_chamber(machine: ChamberMachine, positions: Array, step: float) -> Chamber:
    """Numbers of a machine at rest whose balls are at ``positions`` (n, 3) from the middles of their chambers."""
    groups = ball_groups(machine)
    radii = [balls.radius for _, balls in groups]
    n = sum(balls.count for _, balls in groups)
    room = NEIGHBORS * n + 64
    body = of.BODY.row()
    body.place[of.THETA], body.rate[of.THETA] = machine.start.rotor_angle, machine.start.speed
    return Chamber(
        run=of.RUN.row(step=step, margin=MARGIN * min(radii)),
        contact=_contact(machine.contact),
        machine=_machine(machine),
        rooms=_rooms(machine),
        pair_stiffness=np.array([[pair_stiffness(machine.contact, a, b) for b in radii] for a in radii]),
        profile=_profile(machine),
        balls=_balls(machine, positions),
        wall_stretch=np.zeros((n, of.WALLS, 3)),
        pairs=Pairs(np.zeros(room, np.int32), np.zeros(room, np.int32), np.zeros(room, np.int8), np.zeros((room, 3))),
        body=body,
        power=of.POWER.row(),
        before=of.POWER.row(),
        account=of.ACCOUNT.row(),
        since=of.SINCE.row(),
        progress=of.PROGRESS.row(),
        scratch=_scratch(n, room),
    )


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
        contacts=of.CONTACTS.row(
            line=1.0, stiffness=1.0, lightness=1.0, roll_radius=1.0
        ),  # all are computed, used or not
        equations=np.zeros((7, 8)),
        reduced=np.zeros((7, 8)),
        begun=of.MOTION.rows(n),
        gone=of.MOTION.rows(n),
        body_begun=of.BODY_MOTION.row(),
        body_gone=of.BODY_MOTION.row(),
    )


def _balls(machine: ChamberMachine, positions: Array) -> Rows:
    groups = ball_groups(machine)
    rows = of.BALL.rows(sum(balls.count for _, balls in groups))
    i = 0
    for kind, (number, group) in enumerate(groups):
        chamber = machine.chambers[number]
        own = rows[i : i + group.count]
        own.position = positions[i : i + group.count]
        own.position[:, 0] += chamber.position
        own.radius, own.mass = group.radius, group.ball_mass
        own.inertia = 0.4 * group.ball_mass * group.radius**2
        own.inverse_mass, own.inverse_inertia = 1.0 / own.mass, 1.0 / own.inertia
        own.kind, own.chamber = kind, number
        own.race_stiffness = wall_stiffness(machine.contact, group.radius, float(chamber.radius))
        own.flat_stiffness = wall_stiffness(machine.contact, group.radius)
        if chamber.inner_radius > 0.0:
            own.inner_stiffness = wall_stiffness(machine.contact, group.radius, -float(chamber.inner_radius))
        if group.velocities is not None:
            own.velocity = group.velocities
        if group.spins is not None:
            own.spin = group.spins
        i += group.count
    return rows


def _rooms(machine: ChamberMachine) -> Rows:
    rows = of.ROOM.rows(len(machine.chambers))
    for room, chamber in zip(rows, machine.chambers, strict=True):
        room.center, room.wall_radius, room.half_depth = chamber.position, chamber.radius, 0.5 * chamber.inner_depth
        room.drag, room.square_drag = chamber.drag, chamber.square_drag
        room.inner_radius = chamber.inner_radius or -math.inf
    return rows


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


def _contact(contact: ChamberContact) -> Row:
    row = of.CONTACT.row(
        friction=contact.friction,
        restitution_squared=contact.restitution**2,
        rolling_arm=contact.rolling_arm,
        slow=contact.slow,
    )
    if isinstance(contact, HistoryContact):
        row.has_memory = 1
        row.damping_ratio = hertz_damping_ratio(contact.restitution)
        nu, ratio = contact.poisson_ratio, contact.shear_ratio
        row.shear_ratio = ratio if ratio is not None else 2.0 * (1.0 - nu) / (2.0 - nu)
    return row


def _machine(machine: ChamberMachine) -> Row:
    rotor, drive = machine.rotor, machine.drive
    inertia, stiffness, damping = _body(machine)
    free = {"fixed": [], "planar": [1, 2, 3], "free": [0, 1, 2, 3, 4, 5]}[machine.body.freedom]
    row = of.MACHINE.row(
        gravity=machine.gravity,
        inertia=inertia,
        stiffness=stiffness,
        damping=damping,
        free=free + [-1] * (7 - len(free)),
        rotor_mass=rotor.mass,
        polar_inertia=rotor.polar_inertia,
        transverse_inertia=rotor.transverse_inertia,
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
        vector = np.array([math.cos(unbalance.angle), math.sin(unbalance.angle)]) * unbalance.size
        row.unbalance += vector
        row.couple += unbalance.position * vector
    return row


def _profile(machine: ChamberMachine) -> Rows:
    if isinstance(machine.drive, AsynchronousMotor):
        return of.PROFILE.rows(1)
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
    rows = of.PROFILE.rows(len(times))
    rows.time, rows.speed = times, speeds
    return rows
