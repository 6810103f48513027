"""Stiffness and damping of a joint at the speeds of its rig, tried: whatever somebody's own joint may return."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.rotors.model import Floats, Matrix
from autobalancer.machine.part import ImpossiblePart
from autobalancer.machine.rotors.joint import PointJoint
from autobalancer.patience import returned

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
