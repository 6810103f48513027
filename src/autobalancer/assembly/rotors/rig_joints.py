"""Joints of a rig as struts: springs and dampers that each feel one relative motion of two bodies.

K and C are sums of k r r^T and c r r^T over the struts, r being the row of that motion; so they are symmetric and
positive semidefinite however a rig is put together. A joint with coupled motions is a strut for each principal motion at each
frequency. What is not symmetric, as of a fluid film, is added as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.model import Floats, Matrix
from autobalancer.assembly.rotors.rig_bodies import Rig
from autobalancer.assembly.rotors.supports import table_speeds
from autobalancer.machine import MultibodyRotor
from autobalancer.machine.part import ImpossiblePart
from autobalancer.machine.rotors.joint import PointJoint, Spot
from autobalancer.patience import returned

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


# Stiffness and damping of a joint at the speeds of its rig, tried: whatever somebody's own joint may return.


ROUNDING = 1e-9
ANGLE = 0.7  # rad, by which a joint between two rotating bodies is turned to see whether that changes it
MOTIONS = ("along x", "along y", "along z", "about x", "about y", "about z")


def joint_matrices(joint: PointJoint, speeds: Floats, number: int, turning: int) -> tuple[Matrix, Matrix]:
    """K and C in the axes of a joint, each (k, 6, 6).

    Raises
    ------
    ImpossiblePart
        If they are not finite, not symmetric although the joint says so, push away or drive, or cannot be on rotating
        bodies; with the ``number`` of the joint, from 0, the speed and the entry.
    """
    found = [_pair(joint, float(speed), number) for speed in speeds]
    stiffness, damping = (np.array([pair[which] for pair in found]) for which in range(2))
    if turning:
        _refuse_turning(joint, stiffness, damping, number, turning)
    return stiffness, damping


def _pair(joint: PointJoint, speed: float, number: int) -> tuple[Matrix, Matrix]:
    where = f"the joint {joint.word()!r} at {speed:.6g} rad/s"
    try:
        own = not type(joint).__module__.startswith("autobalancer.")
        pair = returned(lambda: joint.matrices(speed), where) if own else joint.matrices(speed)
        stiffness, damping = (np.array(one, dtype=float) for one in pair)
    except Exception as reason:  # whatever a joint of somebody else may raise
        raise _refusal(number, f"{where} fails: {type(reason).__name__}: {reason}") from None
    for name, matrix, wrong in (
        ("stiffness", stiffness, "pushes away"),
        ("damping", damping, "drives what it should damp"),
    ):
        if matrix.shape != (6, 6):
            raise _refusal(number, f"{where}: its {name} has the shape {matrix.shape}; must be (6, 6)")
        if not np.isfinite(matrix).all():
            i, j = np.argwhere(~np.isfinite(matrix))[0]
            raise _refusal(number, f"{where}: its {name} {MOTIONS[i]} for a motion {MOTIONS[j]} is {matrix[i, j]}")
        apart = np.abs(matrix - matrix.T)
        if joint.symmetric and apart.max() > ROUNDING * np.abs(matrix).max():
            i, j = np.unravel_index(int(apart.argmax()), (6, 6))
            raise _refusal(
                number,
                f"{where}: its {name} is not symmetric, {matrix[i, j]:.6g} {MOTIONS[i]} for a motion {MOTIONS[j]}, but "
                f"{matrix[j, i]:.6g} {MOTIONS[j]} for a motion {MOTIONS[i]}; correct it, or write "
                "symmetric: ClassVar[bool] = False",
            )
        values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
        if values[0] < -ROUNDING * max(abs(values[0]), abs(values[-1])):
            moved = MOTIONS[int(np.abs(vectors[:, 0]).argmax())]
            raise _refusal(number, f"{where}: its {name} {wrong}, most {moved} ({values[0]:.6g}); must not be negative")
    return stiffness, damping


def _refuse_turning(joint: PointJoint, stiffness: Matrix, damping: Matrix, number: int, turning: int) -> None:
    """Refuse what cannot be on one rotating body, or between two."""
    where, both = f"the joint {joint.word()!r}", np.concatenate([stiffness, damping])
    for spot in joint.spots():
        if spot.point[0] or spot.point[1]:
            raise _refusal(number, f"{where}: a joint on a rotating body must be on its axis")
        axes = np.kron(np.eye(2), np.array(spot.axes))
        fixed = axes.T @ both @ axes
        if max(np.abs(fixed[:, 5]).max(), np.abs(fixed[:, :, 5]).max()) > ROUNDING * np.abs(both).max():
            raise _refusal(number, f"{where}: a body that rotates with the rotor cannot be held against rotation")
        if turning == 2:
            c, s = np.cos(ANGLE), np.sin(ANGLE)
            turn = np.kron(np.eye(2), np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]))
            if damping.any():
                text = "damping between two rotating bodies rotates with them and can cause whirl; this is not modelled"
                raise _refusal(number, f"{where}: {text}")
            if np.abs(turn @ fixed @ turn.T - fixed).max() > ROUNDING * np.abs(both).max():
                raise _refusal(number, f"{where}: between two rotating bodies x and y must be equal")


def _refusal(number: int, text: str) -> ImpossiblePart:
    return ImpossiblePart("Machine", [(("rotor", "joints", number), text)])
