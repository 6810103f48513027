"""Bodies of a rig as coordinates: bodies locked to each other are one, and the rest is how its points move.

A merged body has the deflection x, y, z of its point on the axis at the height of its mass center, the slopes
a = dx/dz and b = dy/dz, and the turning angle c about z, unless all of it turns with the rotor. Its rotation vector
is (-b, a, c), so that the point (x, y, z) of it moves by (a h - c y, b h + c x, -a x - b y) more, h its height above.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.model import Matrix
from autobalancer.machine import Body, MultibodyRotor
from autobalancer.machine.part import ImpossiblePart
from autobalancer.machine.rotors.joint import PointJoint

X, Y, Z, SLOPE_X, SLOPE_Y, TURN = range(6)  # rows of a motion
SINGULAR = 1e-12


@dataclass(frozen=True)
class MergedBody:
    """Bodies that move as one."""

    bodies: tuple[Body, ...]
    columns: tuple[int, ...]  # where x, y, z, a, b, c are among all coordinates; c is -1 if it is none

    @property
    def height(self) -> float:
        """Of the mass center along the axis, m."""
        return float(sum(b.mass * b.position for b in self.bodies) / sum(b.mass for b in self.bodies))

    @property
    def label(self) -> str:
        """The names, joined."""
        return " + ".join(body.name for body in self.bodies)


@dataclass(frozen=True)
class Rig:
    """All merged bodies of a rotor, and what its N coordinates are."""

    merged: tuple[MergedBody, ...]
    coordinates: tuple[str, ...]  # (N,)

    @property
    def size(self) -> int:
        """Number of coordinates N."""
        return len(self.coordinates)

    @property
    def pairs(self) -> int:
        """Coordinates along x, as many as along y."""
        return 2 * len(self.merged)

    def of(self, name: str) -> MergedBody | None:
        """The merged body to which a body belongs; ``None`` for the ground."""
        return next((m for m in self.merged if any(body.name == name for body in m.bodies)), None)

    def motion(self, name: str, point: tuple[float, float, float]) -> Matrix:
        """Deflection x, y, z at a point, slopes a and b and turning c of a body, (6, N); zeros for the ground."""
        rows = np.zeros((6, self.size + 1))  # the last column takes what is no coordinate
        merged = self.of(name)
        if merged is not None:
            x, y, h = point[0], point[1], point[2] - merged.height
            ia, ib, ic = merged.columns[3:]
            for row, column in zip(range(6), merged.columns, strict=True):
                rows[row, column] = 1.0
            rows[X, ia], rows[X, ic] = h, -y
            rows[Y, ib], rows[Y, ic] = h, x
            rows[Z, ia], rows[Z, ib] = -x, -y
        return rows[:, :-1]

    def spots(self, joint: PointJoint) -> list[Matrix]:
        """The six motions of the first body of a joint relative to the second in its axes, at each of its places, (6, N)."""
        found = []
        for spot in joint.spots():
            axes = np.array(spot.axes)
            rows = self.motion(joint.between[0], spot.point) - self.motion(joint.between[1], spot.point)
            turned = np.array([-rows[SLOPE_Y], rows[SLOPE_X], rows[TURN]])
            found.append(np.vstack([axes @ rows[:3], axes @ turned]))
        return found


def rig_of(rotor: MultibodyRotor) -> Rig:
    """Merge what is locked and number the coordinates: x and slope of each, y and slope of each, z, turning angles."""
    groups: list[list[Body]] = []
    merged = {body.name: {body.name} for body in rotor.bodies}
    for joint in rotor.joints:
        if not isinstance(joint, PointJoint):
            names = merged[joint.between[0]] | merged[joint.between[1]]
            merged.update(dict.fromkeys(names, names))
    for body in rotor.bodies:
        if not any(body in group for group in groups):
            groups.append([other for other in rotor.bodies if other.name in merged[body.name]])
    count, turned = len(groups), 0
    parts: list[MergedBody] = []
    for i, group in enumerate(groups):
        stands = not all(body.rotating for body in group)
        turn = 5 * count + turned if stands else -1
        turned += stands
        parts.append(
            MergedBody(tuple(group), (2 * i, 2 * (count + i), 4 * count + i, 2 * i + 1, 2 * (count + i) + 1, turn))
        )
    labels = [""] * (5 * count + turned)
    for part in parts:
        for what, column in zip(("x", "y", "z", "slope of x", "slope of y", "turning"), part.columns, strict=True):
            if column >= 0:
                labels[column] = f"{what} of {part.label}"
    return Rig(tuple(parts), tuple(labels))


def inertia_matrices(rotor: MultibodyRotor, rig: Rig) -> tuple[Matrix, Matrix]:
    """M and G of the bodies, each (N, N).

    Raises
    ------
    ImpossiblePart
        If a body, together with what is locked to it, has no inertia about some axis.
    """
    mass, gyroscopic = np.zeros((2, rig.size, rig.size))
    for body in rotor.bodies:
        rows = rig.motion(body.name, body.center)
        jx, jy, jz = body.inertias
        weights = (body.mass, body.mass, body.mass, jy, jx, 0.0 if body.rotating else jz)
        mass += rows.T @ (np.array(weights)[:, None] * rows)
        if body.rotating:
            turning = jz * np.outer(rows[SLOPE_X], rows[SLOPE_Y])
            gyroscopic += turning - turning.T
    for merged in rig.merged:
        columns = [column for column in merged.columns if column >= 0]
        block = mass[np.ix_(columns, columns)]
        scale = np.sqrt(np.diag(block))
        if not scale.all() or np.linalg.eigvalsh(block / np.outer(scale, scale))[0] < SINGULAR:
            number = rotor.bodies.index(merged.bodies[0])
            text = f"{merged.label!r} has no inertia about some axis, so its mass matrix is singular; give it some"
            raise ImpossiblePart("Machine", [(("rotor", "bodies", number, "inertia"), text)])
    return mass, gyroscopic
