"""A rig of rigid bodies as matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.model import LateralModel, Rows, matrices
from autobalancer.assembly.rotors.rig_bodies import SLOPE_X, MergedBody, Rig, X, inertia_matrices, rig_of
from autobalancer.assembly.rotors.rig_checks import refuse_free_motion, unresisted
from autobalancer.assembly.rotors.rig_joints import assembled, rig_speeds, struts
from autobalancer.assembly.rotors.rig_weight import refuse_falling, weight_stiffness
from autobalancer.machine import MultibodyRotor
from autobalancer.machine.part import ImpossiblePart
from autobalancer.machine.rotors.joint import PointJoint


@dataclass(frozen=True)
class RigAxis:
    """Places on the axis of each body, found by height and name."""

    rig: Rig
    marks: tuple[tuple[float, str], ...]  # heights of centers and joints on rotating bodies, ascending

    def rows(self, position: float | None, body: str | None) -> Rows:
        """See :class:`autobalancer.assembly.rotors.model.Axis`."""
        known = [part.name for merged in self.rig.merged for part in merged.bodies]
        if body is None:
            turning = [m for m in self.rig.merged if any(part.rotating for part in m.bodies)]
            if len(turning) > 1:
                names = ", ".join(repr(part.name) for m in turning for part in m.bodies if part.rotating)
                raise ValueError(f"several bodies rotate, {names}; choose one by a station with 'body'")
            merged = turning[0]
        elif body not in known:
            raise ValueError(f"no body is named {body!r}; there is {', '.join(map(repr, known))}")
        else:
            found = self.rig.of(body)
            assert found is not None
            merged = found
        return self._place(merged, _middle(merged) if position is None else float(position))

    def line(self) -> list[tuple[float, Rows]]:
        """See :class:`autobalancer.assembly.rotors.model.Axis`."""
        return [(height, self.rows(height, name)) for height, name in self.marks]

    def _place(self, merged: MergedBody, height: float) -> Rows:
        n = self.rig.pairs
        motion = self.rig.motion(merged.bodies[0].name, (0.0, 0.0, height))
        return Rows(motion[X, :n], motion[SLOPE_X, :n])


@matrices.register
def multibody(rotor: MultibodyRotor, gravity: float) -> LateralModel:
    """Coordinates x and slope of each merged body, y and slope, then z and the turning angle of what stands.

    Axial motion is left out where nothing resists it, turning likewise. ``gravity`` along a vertical axis, m/s^2,
    counts where the rotor says which way is up; it is 0 where the axis is horizontal.

    Raises
    ------
    ImpossiblePart
        If a body has no inertia, is not held, or falls over.
    """
    rig = rig_of(rotor)
    mass, gyroscopic = inertia_matrices(rotor, rig)
    speeds = rig_speeds(rotor)
    parts, skew = struts(rotor, rig, speeds)
    dropped = unresisted(rig, parts, mass)
    kept = [i for i in range(rig.size) if i not in dropped]
    refuse_free_motion(rig, parts, kept)
    damping, stiffness = assembled(parts, skew, rig.size, speeds.size)
    if rotor.up is not None:
        if gravity == 0.0:
            text = "on a horizontal axis the weight does not change the stiffness; leave it out"
            raise ImpossiblePart("Machine", [(("rotor", "up"), text)])
        stiffness = stiffness + weight_stiffness(rotor, rig, parts, kept, -gravity if rotor.up == "+z" else gravity)
    part = np.ix_(kept, kept)
    stiffness, damping = (np.array([matrix[part] for matrix in stack]) for stack in (stiffness, damping))
    if rotor.up is not None:
        for matrix in stiffness:
            refuse_falling(matrix)
    return LateralModel(
        mass[part], gyroscopic[part], speeds, damping, stiffness, rig.pairs, tuple(rig.coordinates[i] for i in kept),
        RigAxis(rig, _marks(rotor)), rotor.inertia, float(sum(body.mass for body in rotor.bodies)),
    )  # fmt: skip


def _marks(rotor: MultibodyRotor) -> tuple[tuple[float, str], ...]:
    turning = {body.name: float(body.position) for body in rotor.bodies if body.rotating}
    marks = {(height, name) for name, height in turning.items()}
    for joint in rotor.joints:
        if isinstance(joint, PointJoint):
            marks |= {(float(joint.position), name) for name in joint.between if name in turning}
    return tuple(sorted(marks))


def _middle(merged: MergedBody) -> float:
    """Mass center of what turns, or of all if nothing does."""
    parts = [body for body in merged.bodies if body.rotating] or list(merged.bodies)
    return float(sum(body.mass * body.position for body in parts) / sum(body.mass for body in parts))
