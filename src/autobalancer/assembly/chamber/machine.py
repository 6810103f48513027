"""Body, rotor and drive of a machine with deep chambers."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from autobalancer.assembly.profile import corners, profile_pieces
from autobalancer.errors import MachineError
from autobalancer.kernels.chamber.records import BODY, COORDINATES, MACHINE, PROFILE, THETA
from autobalancer.kernels.fields import Row, Rows
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.drive import AsynchronousMotor
from autobalancer.machine.profile import Hill

Array = Any
FREE = {"fixed": [], "planar": [1, 2, 3], "free": [0, 1, 2, 3, 4, 5]}  # coordinates


def body_row(machine: ChamberMachine) -> Row:
    """The body before the start."""
    row = BODY.row()
    row.place[THETA], row.rate[THETA] = machine.start.rotor_angle, machine.start.speed
    return row


def machine_row(machine: ChamberMachine) -> Row:
    """Constants of body, supports, rotor, unbalance and motor."""
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
