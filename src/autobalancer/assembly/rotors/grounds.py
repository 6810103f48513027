"""Where a rotor stands on the ground, and what it presses there.

The force of a support across the axis is its share of the work in a translation T of the whole machine: of its
stiffness K_s and damping C_s it is F = T' (K_s q + C_s q'), since T moves the place of every support by one and tilts
nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.arrays import Floats, Matrix
from autobalancer.assembly.rotors import station_rows
from autobalancer.assembly.rotors.equivalent_stiffness import HardPlace, Mount, beyond_sliding, hardenings
from autobalancer.assembly.rotors.lateral_model import LateralModel, Rows, add_support
from autobalancer.assembly.rotors.rig import RigAxis, assembled, joint_struts
from autobalancer.errors import MachineError
from autobalancer.machine import Machine, MultibodyRotor, PlanarRotor
from autobalancer.machine.rotors.body import GROUND
from autobalancer.machine.rotors.joint import PointJoint

SAME = 1e-9  # of the motion of a support, beyond which a translation of the whole is none


@dataclass(frozen=True)
class Ground:
    """One support: rows of the force of the rotor on it along x and y, N, at the speeds of the model."""

    name: str
    stiffness: Matrix  # (k, 2, N), times coordinates
    damping: Matrix  # (k, 2, N), times their velocities
    row: Matrix  # (2, N) deflection of the rotor there
    number: int = 1  # of the support or joint in its file


def grounds(machine: Machine, model: LateralModel) -> tuple[Ground, ...]:
    """All supports of a machine, in the order of its file; those without force across the axis are left out."""
    rotor, grounds = machine.rotor, []
    across = model.translation
    if isinstance(rotor, PlanarRotor):
        return (Ground("support", across.T @ model.stiffness, across.T @ model.damping, np.eye(2)),)
    if isinstance(rotor, MultibodyRotor):
        for number, joint in enumerate(rotor.joints, 1):
            if isinstance(joint, PointJoint) and GROUND in joint.between:
                grounds.append(_joint(model, number, joint, across))
    else:
        factor = float(rotor.stiffness_proportional_damping)
        for number, support in enumerate(rotor.supports, 1):
            place = model.axis.rows(float(support.position), None)
            row = model.both(place.deflection[None])
            across = _moving(model, row, model.both(place.slope[None]))
            damping, stiffness = np.zeros((2, *model.stiffness.shape))
            add_support(support, place, model.speeds, damping, stiffness)
            damping = damping + factor * stiffness
            name = _name(machine, model, place, f"support {number}")
            grounds.append(Ground(name, across.T @ stiffness, across.T @ damping, row, number))
    hard = {number for _, number, _ in hardenings(machine)}
    return tuple(
        ground for ground in grounds if ground.stiffness.any() or ground.damping.any() or ground.number in hard
    )


def _moving(model: LateralModel, row: Matrix, slope: Matrix | None = None) -> Matrix:
    """Coordinates that move the place of a support by one along x and along y without a tilt there, (N, 2).

    A translation of the whole does, unless the modes that are known do not make up one.
    """
    across = model.translation
    if np.abs(row @ across - np.eye(2)).max() < SAME:
        return across
    both = row if slope is None else np.vstack([row, slope])
    return np.asarray(np.linalg.pinv(both if np.linalg.matrix_rank(both) == len(both) else row)[:, :2])


def sag(model: LateralModel, gravity: float) -> Floats:
    """Coordinates of the rotor without balls under its own weight, (N,); ``gravity`` acts along -y."""
    down = -gravity * model.mass @ model.translation[:, 1]
    try:
        return np.asarray(np.linalg.solve(model.stiffness_at(0.0), down), np.float64)
    except np.linalg.LinAlgError:
        raise MachineError(
            "rotor: its weight has no place of rest, since the stiffness is singular; look for a support that is missing, "
            "or one that is too stiff beside the others"
        ) from None


def large_motions(
    machine: Machine, model: LateralModel, ground: Ground, mounts: tuple[Mount, ...]
) -> tuple[Matrix, Matrix, Matrix]:
    """Stiffness and damping of a support, each (k, 2, N), without the elements of its rubber, and of these the rows of force.

    The rows are (2, 2 M), along x and y for a force along the two directions of each of the M pieces of rubber.
    """
    across, stiffness, damping = _moving(model, ground.row).T, ground.stiffness.copy(), ground.damping.copy()
    rows = np.zeros((2, len(mounts), 2))
    for i, mount in enumerate(mounts):
        if mount.grounded and mount.support == ground.number:
            rows[:, i] = across @ mount.rows.T
            more_stiffness, more_damping = beyond_sliding(machine, model, mount)
            stiffness -= more_stiffness[:, None, None] * (rows[:, i] @ mount.rows)
            damping -= more_damping[:, None, None] * (rows[:, i] @ mount.rows)
    return stiffness, damping, rows.reshape(2, -1)


def carried(model: LateralModel, grounds: tuple[Ground, ...], hard: tuple[HardPlace, ...]) -> Matrix:
    """Rows of the force on each support along x and y for the forces along both directions of each bearing, (S, 2, 2 H)."""
    rows = np.zeros((len(grounds), 2, len(hard), 2))
    for i, ground in enumerate(grounds):
        across = _moving(model, ground.row).T
        for j, place in enumerate(hard):
            if place.grounded and place.support == ground.number:
                rows[i, :, j] = across @ place.rows.T
    return rows.reshape(len(grounds), 2, 2 * len(hard))


def _joint(model: LateralModel, number: int, joint: PointJoint, across: Floats) -> Ground:
    axis = model.axis
    assert isinstance(axis, RigAxis)
    kept = [axis.rig.coordinates.index(name) for name in model.coordinates]
    parts, skew = joint_struts(joint, axis.rig, model.speeds, number - 1, 0)
    damping, stiffness = assembled(parts, skew, axis.rig.size, model.speeds.size)
    part = np.ix_(range(model.speeds.size), kept, kept)
    one, other = joint.between
    body = other if one == GROUND else one
    row = axis.rig.motion(body, (0.0, 0.0, float(joint.position)))[:2, kept]
    return Ground(f"joint {number}", across.T @ stiffness[part], across.T @ damping[part], row, number)


def _name(machine: Machine, model: LateralModel, place: Rows, otherwise: str) -> str:
    """The name of a station at this place."""
    for name, row in station_rows(machine, model).items():
        if np.abs(row.deflection - place.deflection).max() <= 1e-12:
            return name
    return otherwise
