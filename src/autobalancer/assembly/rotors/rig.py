"""A rig of rigid bodies as matrices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.arrays import Floats, Matrix
from autobalancer.assembly.rotors.lateral_model import LateralModel, Rows, matrices, table_speeds
from autobalancer.errors import MachineError
from autobalancer.machine import Body, MultibodyRotor
from autobalancer.machine.rotors.joint import PointJoint, Spot
from autobalancer.progress import returned

# Bodies of a rig as coordinates: bodies locked to each other are one, and the rest is how its points move.
#
# A merged body has the deflection x, y, z of its point on the axis at the height of its mass center, the slopes a =
# dx/dz and b = dy/dz, and the turning angle c about z, unless all of it turns with the rotor. Its rotation vector is
# (-b, a, c), so that the point (x, y, z) of it moves by (a h - c y, b h + c x, -a x - b y) more, h its height above.


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
        spots = []
        for spot in joint.spots():
            axes = np.array(spot.axes)
            rows = self.motion(joint.between[0], spot.point) - self.motion(joint.between[1], spot.point)
            turned = np.array([-rows[SLOPE_Y], rows[SLOPE_X], rows[TURN]])
            spots.append(np.vstack([axes @ rows[:3], axes @ turned]))
        return spots


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
    MachineError
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
            raise MachineError.of("Machine", [(("rotor", "bodies", number, "inertia"), text)])
    return mass, gyroscopic


@dataclass(frozen=True)
class RigAxis:
    """Places on the axis of each body, found by height and name."""

    rig: Rig
    marks: tuple[tuple[float, str], ...]  # heights of centers and joints on rotating bodies, ascending

    def rows(self, position: float | None, body: str | None) -> Rows:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
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
            result = self.rig.of(body)
            assert result is not None
            merged = result
        return self._place(merged, _middle(merged) if position is None else float(position))

    def line(self) -> list[tuple[float, Rows]]:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
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
    MachineError
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
            raise MachineError.of("Machine", [(("rotor", "up"), text)])
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
        raise MachineError.of("Machine", [(("rotor", "up"), text)])
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
    """Raise :class:`~autobalancer.errors.MachineError` if weight overcomes the springs, K (N, N)."""
    if np.linalg.eigvalsh(0.5 * (stiffness + stiffness.T))[0] <= 0.0:
        text = "the bodies fall over under their weight; make the joints stiffer, or leave 'up' out"
        raise MachineError.of("Machine", [(("rotor", "up"), text)])


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
    values: list[int] = []
    for kind in (2, 5):
        columns = [merged.columns[kind] for merged in rig.merged if merged.columns[kind] >= 0]
        others = [i for i in range(rig.size) if i not in columns]
        felt = any(np.abs(strut.row[columns]).max(initial=0.0) > 0.0 for strut in parts)
        if not felt and np.abs(mass[np.ix_(columns, others)]).max(initial=0.0) <= 1e-12 * np.abs(mass).max():
            values += columns
    return values


def refuse_free_motion(rig: Rig, parts: list[Strut], kept: list[int]) -> None:
    """Raise :class:`~autobalancer.errors.MachineError` if a motion of bodies stretches no spring; it names bodies and motion.

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
    bodies = [m.label for m in rig.merged if m.columns[kind] >= 0 and share[m.columns[kind]] > 1e-6]
    text = f"{' and '.join(map(repr, bodies))} can {MOTIONS[kind]} freely; connect them to a supported body"
    raise MachineError.of("Machine", [(("rotor", "joints"), text)])


# Joints of a rig as struts: springs and dampers that each feel one relative motion of two bodies.
#
# K and C are sums of k r r^T and c r r^T over the struts, r being the row of that motion; so they are symmetric and
# positive semidefinite however a rig is put together. A joint with coupled motions is a strut for each principal
# motion at each frequency. What is not symmetric, as of a fluid film, is added as it is.


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
    struts: list[Strut] = []
    skew: list[Coupling] = []
    turning = {body.name: body.rotating for body in rotor.bodies}
    for number, joint in enumerate(rotor.joints):
        if isinstance(joint, PointJoint):
            ends = sum(turning.get(name, False) for name in joint.between)
            one, other = joint_struts(joint, rig, speeds, number, ends)
            struts, skew = struts + one, skew + other
    return struts, skew


def joint_struts(
    joint: PointJoint, rig: Rig, speeds: Floats, number: int, turning: int
) -> tuple[list[Strut], list[Coupling]]:
    """The struts of one joint, the ``number`` of its rotor (from 0), of which ``turning`` bodies rotate."""
    stiffness, damping = joint_matrices(joint, speeds, number, turning)
    struts: list[Strut] = []
    skew: list[Coupling] = []
    for spot, six in zip(joint.spots(), rig.spots(joint), strict=True):
        struts += _principal(joint, spot, six, _symmetric(stiffness), _symmetric(damping))
        if not joint.symmetric:
            skew.append(Coupling(six, stiffness - _symmetric(stiffness), damping - _symmetric(damping)))
    return struts, skew


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
    struts: list[Strut] = []
    for which, stack in enumerate((stiffness, damping)):
        for i, (values, vectors) in enumerate(zip(*np.linalg.eigh(stack), strict=True)):
            for value, vector in zip(values, vectors.T, strict=True):
                if value > SMALL * max(values[-1], 0.0):
                    own = np.zeros((2, len(stack)))
                    own[which, i] = value
                    struts.append(Strut(vector @ six, own[0], own[1], joint.between, spot.point, vector @ directions))
    return struts


def _symmetric(stack: Matrix) -> Matrix:
    return 0.5 * (stack + stack.swapaxes(1, 2))


# Stiffness and damping of a joint at the speeds of its rig, tried: whatever somebody's own joint may return.


ROUNDING = 1e-9
ANGLE = 0.7  # rad, by which a joint between two rotating bodies is turned to see whether that changes it
FREEDOMS = ("along x", "along y", "along z", "about x", "about y", "about z")


def joint_matrices(joint: PointJoint, speeds: Floats, number: int, turning: int) -> tuple[Matrix, Matrix]:
    """K and C in the axes of a joint, each (k, 6, 6).

    Raises
    ------
    MachineError
        If they are not finite, not symmetric although the joint says so, push away or drive, or cannot be on rotating
        bodies; with the ``number`` of the joint, from 0, the speed and the entry.
    """
    items = [_pair(joint, float(speed), number) for speed in speeds]
    stiffness, damping = (np.array([pair[which] for pair in items]) for which in range(2))
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
            raise _refusal(number, f"{where}: its {name} {FREEDOMS[i]} for a motion {FREEDOMS[j]} is {matrix[i, j]}")
        apart = np.abs(matrix - matrix.T)
        if joint.symmetric and apart.max() > ROUNDING * np.abs(matrix).max():
            i, j = np.unravel_index(int(apart.argmax()), (6, 6))
            raise _refusal(
                number,
                f"{where}: its {name} is not symmetric, {matrix[i, j]:.6g} {FREEDOMS[i]} for a motion {FREEDOMS[j]}, but "
                f"{matrix[j, i]:.6g} {FREEDOMS[j]} for a motion {FREEDOMS[i]}; correct it, or write "
                "symmetric: ClassVar[bool] = False",
            )
        values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
        if values[0] < -ROUNDING * max(abs(values[0]), abs(values[-1])):
            moved = FREEDOMS[int(np.abs(vectors[:, 0]).argmax())]
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


def _refusal(number: int, text: str) -> MachineError:
    return MachineError.of("Machine", [(("rotor", "joints", number), text)])
