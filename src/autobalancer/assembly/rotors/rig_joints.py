"""Joints of a rig as struts: springs and dampers that each feel one relative motion of two bodies.

K and C are sums of k r r^T and c r r^T over the struts, r being the row of that motion; so they are symmetric and
positive semidefinite however a rig is put together.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.model import Floats, Matrix
from autobalancer.assembly.rotors.rig_bodies import SLOPE_X, SLOPE_Y, TURN, Rig
from autobalancer.assembly.rotors.supports import at_speeds, table_speeds, two
from autobalancer.machine import BallBearing, Bushing, Dashpot, Lock, MultibodyRotor, SpeedTable, Spring
from autobalancer.machine.rotors.joints import PointJoint

Point = tuple[float, float, float]
Pair = tuple[Floats, Floats]  # stiffness and damping at the speeds of the rig


@dataclass(frozen=True)
class Strut:
    """A spring-damper along or about ``direction`` at ``point`` between two bodies."""

    row: Floats  # (N,) its stretch for each coordinate
    stiffness: Floats  # (k,) at the speeds of the rig
    damping: Floats  # (k,)
    between: tuple[str, str]
    point: Point
    direction: Floats  # (3,)
    turning: bool  # feels relative rotation in place of displacement


def rig_speeds(rotor: MultibodyRotor) -> Floats:
    """The common speeds of all tables of a rig."""
    tables = [
        table
        for joint in rotor.joints
        for table in (getattr(joint, name, None) for name in ("table", "axial_table", "shear_table"))
        if table is not None
    ]
    return table_speeds(tables)


def struts(rotor: MultibodyRotor, rig: Rig, speeds: Floats) -> list[Strut]:
    """All struts of a rig."""
    return [
        strut for joint in rotor.joints if not isinstance(joint, Lock) for strut in joint_struts(joint, rig, speeds)
    ]


def joint_struts(joint: PointJoint, rig: Rig, speeds: Floats) -> list[Strut]:
    """The struts of one joint."""
    found = _ring(joint, rig, speeds) if isinstance(joint, Bushing) else _on_axes(joint, rig, speeds)
    return [strut for strut in found if strut.stiffness.any() or strut.damping.any()]


def assembled(parts: list[Strut], size: int, count: int) -> tuple[Matrix, Matrix]:
    """C and K at each speed, each (k, N, N)."""
    rows = np.array([strut.row for strut in parts]).reshape(-1, size)
    damping, stiffness = np.zeros((2, count, size, size))
    for i in range(count):
        damping[i] = rows.T @ (np.array([strut.damping[i] for strut in parts])[:, None] * rows)
        stiffness[i] = rows.T @ (np.array([strut.stiffness[i] for strut in parts])[:, None] * rows)
    return 0.5 * (damping + damping.swapaxes(1, 2)), 0.5 * (stiffness + stiffness.swapaxes(1, 2))


def _on_axes(joint: Dashpot | Spring | BallBearing, rig: Rig, speeds: Floats) -> list[Strut]:
    """Struts of a joint whose axes are x, y and z."""
    offset = (0.0, 0.0) if isinstance(joint, BallBearing) else joint.offset
    point = (float(offset[0]), float(offset[1]), float(joint.position))

    def given(name: str) -> tuple[float, float]:
        value = getattr(joint, name, None)
        return two(0.0 if value is None else value)

    def pair(prefix: str, direction: int) -> Pair:
        table = getattr(joint, f"{prefix}table", None)
        return _values(table, direction, given(f"{prefix}stiffness"), given(f"{prefix}damping"), speeds)

    across = [pair("", 0), pair("", 1), pair("axial_", 0)]
    about = [pair("tilt_", 0), pair("tilt_", 1), pair("torsional_", 0)]
    found = [_strut(rig, joint.between, point, e, pair, False) for e, pair in zip(np.eye(3), across, strict=True)]
    return found + [_strut(rig, joint.between, point, e, pair, True) for e, pair in zip(np.eye(3), about, strict=True)]


def _ring(joint: Bushing, rig: Rig, speeds: Floats) -> list[Strut]:
    """Struts of bushings on a circle; the axis of each is turned with its place."""

    def pair(prefix: str) -> Pair:
        constants = [two(getattr(joint, f"{prefix}_{what}")) for what in ("stiffness", "damping")]
        return _values(getattr(joint, f"{prefix}_table", None), 0, constants[0], constants[1], speeds)

    shear, axial, bending, torsion = (pair(name) for name in ("shear", "axial", "bending", "torsional"))
    found: list[Strut] = []
    for number in range(joint.count):
        angle = float(joint.angle) + 2.0 * np.pi * number / joint.count
        turned = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
        point = (float(joint.radius) * turned[0, 0], float(joint.radius) * turned[1, 0], float(joint.position))
        along = turned @ (np.array(joint.direction, float) / np.linalg.norm(joint.direction))
        _, _, axes = np.linalg.svd(along[None])  # the axis, and two directions across it
        for kind, (lengthwise, crosswise) in enumerate(((axial, shear), (torsion, bending))):
            for direction, values in ((along, lengthwise), (axes[1], crosswise), (axes[2], crosswise)):
                found.append(_strut(rig, joint.between, point, direction, values, bool(kind)))
    return found


def _values(
    table: SpeedTable | None,
    direction: int,
    stiffness: tuple[float, float],
    damping: tuple[float, float],
    speeds: Floats,
) -> Pair:
    if table is not None:
        k, c = at_speeds(table, speeds)
        return k[:, direction], c[:, direction]
    return np.full(speeds.size, stiffness[direction]), np.full(speeds.size, damping[direction])


def _strut(rig: Rig, between: tuple[str, str], point: Point, direction: Floats, values: Pair, turning: bool) -> Strut:
    rows = rig.motion(between[0], point) - rig.motion(between[1], point)
    moved = np.array([-rows[SLOPE_Y], rows[SLOPE_X], rows[TURN]]) if turning else rows[:3]
    return Strut(direction @ moved, *values, between, point, direction, turning)
