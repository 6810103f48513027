"""Joints of a rig as struts: springs and dampers that each feel one relative motion of two bodies.

K and C are sums of k r r^T and c r r^T over the struts, r being the row of that motion; so they are symmetric and
positive semidefinite however a rig is put together. A joint with coupled motions is a strut for each principal motion at each
frequency. What is not symmetric, as of a fluid film, is added as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.joint_matrices import joint_matrices
from autobalancer.assembly.rotors.model import Floats, Matrix
from autobalancer.assembly.rotors.rig_bodies import Rig
from autobalancer.assembly.rotors.supports import table_speeds
from autobalancer.machine import MultibodyRotor
from autobalancer.machine.rotors.joint import PointJoint, Spot

SMALL = 1e-12  # share of the greatest value of a matrix that is rounding
Point = tuple[float, float, float]


@dataclass(frozen=True)
class Strut:
    """A spring-damper along or about ``direction`` at ``point`` between two bodies."""

    row: Floats  # (N,) its stretch for each coordinate
    stiffness: Floats  # (k,) at the speeds of the rig
    damping: Floats  # (k,)
    between: tuple[str, str]
    point: Point
    direction: Floats  # (3,) of its force; zero where it only turns


@dataclass(frozen=True)
class Coupling:
    """The antisymmetric part of a joint: forces that no energy gives."""

    rows: Matrix  # (6, N)
    stiffness: Matrix  # (k, 6, 6)
    damping: Matrix  # (k, 6, 6)


def rig_speeds(rotor: MultibodyRotor) -> Floats:
    """The common speeds of all tables of a rig."""
    return table_speeds(
        speeds for joint in rotor.joints if isinstance(joint, PointJoint) for speeds in joint.frequencies()
    )


def struts(rotor: MultibodyRotor, rig: Rig, speeds: Floats) -> tuple[list[Strut], list[Coupling]]:
    """All struts of a rig, and what joins its motions without being symmetric."""
    found: list[Strut] = []
    skew: list[Coupling] = []
    turning = {body.name: body.rotating for body in rotor.bodies}
    for number, joint in enumerate(rotor.joints):
        if isinstance(joint, PointJoint):
            ends = sum(turning.get(name, False) for name in joint.between)
            one, other = joint_struts(joint, rig, speeds, number, ends)
            found, skew = found + one, skew + other
    return found, skew


def joint_struts(
    joint: PointJoint, rig: Rig, speeds: Floats, number: int, turning: int
) -> tuple[list[Strut], list[Coupling]]:
    """The struts of one joint, the ``number`` of its rotor (from 0), of which ``turning`` bodies rotate."""
    stiffness, damping = joint_matrices(joint, speeds, number, turning)
    found: list[Strut] = []
    skew: list[Coupling] = []
    for spot, six in zip(joint.spots(), rig.spots(joint), strict=True):
        found += _principal(joint, spot, six, _symmetric(stiffness), _symmetric(damping))
        if not joint.symmetric:
            skew.append(Coupling(six, stiffness - _symmetric(stiffness), damping - _symmetric(damping)))
    return found, skew


def assembled(parts: list[Strut], skew: list[Coupling], size: int, count: int) -> tuple[Matrix, Matrix]:
    """C and K at each speed, each (k, N, N)."""
    rows = np.array([strut.row for strut in parts]).reshape(-1, size)
    damping, stiffness = np.zeros((2, count, size, size))
    for i in range(count):
        damping[i] = rows.T @ (np.array([strut.damping[i] for strut in parts])[:, None] * rows)
        stiffness[i] = rows.T @ (np.array([strut.stiffness[i] for strut in parts])[:, None] * rows)
    damping, stiffness = _symmetric(damping), _symmetric(stiffness)
    for coupling in skew:
        damping += coupling.rows.T @ coupling.damping @ coupling.rows
        stiffness += coupling.rows.T @ coupling.stiffness @ coupling.rows
    return damping, stiffness


def _principal(joint: PointJoint, spot: Spot, six: Matrix, stiffness: Matrix, damping: Matrix) -> list[Strut]:
    """Struts along the axes of a joint; where its motions are coupled, along the principal ones of each matrix."""
    directions = np.vstack([np.array(spot.axes), np.zeros((3, 3))])
    if not any((stack * (1.0 - np.eye(6))).any() for stack in (stiffness, damping)):
        every = [
            Strut(six[i], stiffness[:, i, i], damping[:, i, i], joint.between, spot.point, directions[i])
            for i in range(6)
        ]
        return [strut for strut in every if strut.stiffness.any() or strut.damping.any()]
    found: list[Strut] = []
    for which, stack in enumerate((stiffness, damping)):
        for i, (values, vectors) in enumerate(zip(*np.linalg.eigh(stack), strict=True)):
            for value, vector in zip(values, vectors.T, strict=True):
                if value > SMALL * max(values[-1], 0.0):
                    own = np.zeros((2, len(stack)))
                    own[which, i] = value
                    found.append(Strut(vector @ six, own[0], own[1], joint.between, spot.point, vector @ directions))
    return found


def _symmetric(stack: Matrix) -> Matrix:
    return 0.5 * (stack + stack.swapaxes(1, 2))
