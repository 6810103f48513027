"""A rig of rigid bodies as matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.model import Floats, LateralModel, Matrix, Rows, matrices
from autobalancer.assembly.rotors.rig_bodies import SLOPE_X, SLOPE_Y, TURN, MergedBody, Rig, X, inertia_matrices, rig_of
from autobalancer.assembly.rotors.rig_joints import Point, Strut, assembled, rig_speeds, struts
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


# The effect of weight on the tilting of a rig with a vertical axis.
#
# A force F that acts at the arm s of a body does the second-order work F . phi x (phi x s)/2 when the body turns by
# the rotation vector phi. With the weights, and the loads of the joints that carry them at rest, the sum is the
# stiffness of a pendulum: a body of weight m g whose center is h above the soft joint it stands on gets -m g h.


def weight_stiffness(rotor: MultibodyRotor, rig: Rig, parts: list[Strut], kept: list[int], gravity: float) -> Matrix:
    """What weight adds to K, (N, N), with the joints loaded as at speed zero.

    ``kept`` are the coordinates in use, ``gravity`` counts along +z, m/s^2.
    """
    load, added = np.zeros(rig.size), np.zeros((rig.size, rig.size))
    for body in rotor.bodies:
        force = np.array([0.0, 0.0, float(body.mass) * gravity])
        load += force @ rig.motion(body.name, body.center)[:3]
        added += _second_order(rig, body.name, body.center, force)
    if not set(np.flatnonzero(load)) <= set(kept):
        text = "no joint carries the weight along the axis; give axial stiffness, or leave 'up' out"
        raise ImpossiblePart("Machine", [(("rotor", "up"), text)])
    rows = np.array([strut.row for strut in parts])[:, kept]
    springs = np.array([strut.stiffness[0] for strut in parts])
    rest = np.linalg.solve(rows.T @ (springs[:, None] * rows), load[kept])
    for strut, stretch in zip(parts, rows @ rest, strict=True):
        force = -strut.stiffness[0] * stretch * strut.direction
        if force.any():
            added += _second_order(rig, strut.between[0], strut.point, force)
            added -= _second_order(rig, strut.between[1], strut.point, force)
    return added


def refuse_falling(stiffness: Matrix) -> None:
    """Raise :class:`ImpossiblePart` if weight overcomes the springs, K (N, N)."""
    if np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))[0] <= 0.0:
        text = "the bodies fall over under their weight; make the joints stiffer, or leave 'up' out"
        raise ImpossiblePart("Machine", [(("rotor", "up"), text)])


def _second_order(rig: Rig, name: str, point: Point, force: Floats) -> Matrix:
    merged = rig.of(name)
    if merged is None:
        return np.zeros((rig.size, rig.size))
    rows = rig.motion(name, point)
    rotation = np.array([-rows[SLOPE_Y], rows[SLOPE_X], rows[TURN]])
    arm = np.array([point[0], point[1], point[2] - merged.height])
    middle = float(force @ arm) * np.eye(3) - 0.5 * (np.outer(force, arm) + np.outer(arm, force))
    return np.asarray(rotation.T @ middle @ rotation)


# Is every body of a rig held?


FREE = 1e-10  # share of the stiffest motion, all springs alike, below which a motion counts as free
MOTIONS = (
    "move along x",
    "move along y",
    "move along the axis",
    "tilt towards x",
    "tilt towards y",
    "turn about the axis",
)


def unresisted(rig: Rig, parts: list[Strut], mass: Matrix) -> list[int]:
    """Coordinates along z, or turning angles, if nothing resists any of them and nothing is moved by them."""
    found: list[int] = []
    for kind in (2, 5):
        columns = [merged.columns[kind] for merged in rig.merged if merged.columns[kind] >= 0]
        others = [i for i in range(rig.size) if i not in columns]
        felt = any(np.abs(strut.row[columns]).max(initial=0.0) > 0.0 for strut in parts)
        if not felt and np.abs(mass[np.ix_(columns, others)]).max(initial=0.0) <= 1e-12 * np.abs(mass).max():
            found += columns
    return found


def refuse_free_motion(rig: Rig, parts: list[Strut], kept: list[int]) -> None:
    """Raise :class:`ImpossiblePart` if a motion of bodies stretches no spring; it names bodies and motion.

    All springs count alike, so that the answer depends on how a rig is joined only, not on how stiff.
    """
    springs = [strut.row for strut in parts if strut.stiffness.any()]
    rows = np.array(springs).reshape(-1, rig.size)
    tilts = [column for merged in rig.merged for column in merged.columns[3:] if column >= 0]
    reach = np.abs(rows[:, tilts]).max(initial=0.0) or 1.0
    scale = np.ones(rig.size)
    scale[tilts] = 1.0 / reach  # angles count as the displacements they make
    held = (rows * scale)[:, kept]
    values, vectors = np.linalg.eigh(held.T @ held)
    free = vectors[:, values <= FREE * max(values[-1], 1e-300)]
    if free.size == 0:
        return
    share = np.zeros(rig.size)
    share[kept] = np.sum(free**2, axis=1)
    worst = int(np.argmax(np.round(share, 9)))
    kind = next(m.columns.index(worst) for m in rig.merged if worst in m.columns)
    bodies = [m.label for m in rig.merged if _along(m.columns[kind], share) > 1e-6]
    text = f"{' and '.join(map(repr, bodies))} can {MOTIONS[kind]} freely; connect them to a supported body"
    raise ImpossiblePart("Machine", [(("rotor", "joints"), text)])


def _along(column: int, share: Floats) -> float:
    return float(share[column]) if column >= 0 else 0.0
