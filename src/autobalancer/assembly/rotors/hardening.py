"""Where bearings that become stiffer as they deflect sit in a rotor, and their stiffness where it rests."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.assembly.rotors.lateral_model import SAME, LateralModel, Matrix, turns_alike
from autobalancer.assembly.rotors.rig import RigAxis
from autobalancer.catalog.resolve import planar_rotor
from autobalancer.errors import QuestionError
from autobalancer.machine import Hardening, Machine, MultibodyRotor, PlanarRotor, PointJoint
from autobalancer.machine.rotors.body import GROUND


@dataclass(frozen=True)
class HardPlace:
    """One such bearing: the rows of its deflection along x and y."""

    name: str
    hardening: Hardening
    rows: Matrix  # (2, N)
    support: int  # number of the support or joint of the rotor, from 1
    grounded: bool  # whether it stands on the ground

    def isotropic(self, pairs: int) -> bool:
        """Whether it is alike in all directions: its deflection, and the place where the rotor rests in it."""
        return self.hardening.center == (0.0, 0.0) and turns_alike(self.rows, pairs)

    @property
    def stiffness(self) -> Matrix:
        """What small motions about the place where the rotor rests feel, (2, 2)."""
        x, y = self.hardening.center
        return central_force(self.hardening).stiffness(-float(x), -float(y))


def hardenings(machine: Machine) -> Iterator[tuple[str, int, Hardening]]:
    """Each of them with a name for people and the number of its support or joint, from 1."""
    rotor = machine.rotor
    if isinstance(rotor, PlanarRotor):
        if rotor.hardening is not None:
            yield "support", 1, rotor.hardening
    elif isinstance(rotor, MultibodyRotor):
        for number, joint in enumerate(rotor.joints, 1):
            if isinstance(joint, PointJoint):
                yield from ((f"joint {number}", number, hardening) for hardening in joint.hardenings())
    else:
        for number, support in enumerate(rotor.supports, 1):
            if support.hardening is not None:
                yield f"support {number}", number, support.hardening


def hard_places(machine: Machine, model: LateralModel) -> tuple[HardPlace, ...]:
    """All of them, in the order of the file; a joint with several spots has one at each."""
    return tuple(
        HardPlace(name, one, rows, number, grounded)
        for name, number, one in hardenings(machine)
        for rows, grounded in _rows(machine, model, number)
    )


def with_hardening(machine: Machine, model: LateralModel) -> LateralModel:
    """The rotor with the stiffness that its bearings add where it rests."""
    more = np.zeros_like(model.mass)
    for place in hard_places(machine, model):
        more += place.rows.T @ place.stiffness @ place.rows
    return replace(model, stiffness=model.stiffness + more) if more.any() else model


def planar_springs(machine: Machine, owner: str) -> tuple[tuple[float, float], tuple[float, float]]:
    """Stiffness and damping of a planar rotor along x and y in small motions about the place where it rests.

    Raises
    ------
    QuestionError
        If it rests in its bearing in a direction between x and y, which these two do not describe; ``owner`` is who asks.
    """
    springs = planar_rotor(machine)
    (kx, ky), hardening = springs.stiffness_xy, springs.hardening
    if hardening is not None:
        (xx, xy), (_, yy) = HardPlace("support", hardening, np.eye(2), 1, True).stiffness
        if abs(xy) > SAME * max(xx, yy):
            raise QuestionError(
                f"{owner}: the rotor rests beside the middle of its bearing between x and y, so that they are coupled; turn the "
                "axes until 'center' of its hardening is on one of them, or simulate it"
            )
        kx, ky = kx + float(xx), ky + float(yy)
    return (kx, ky), springs.damping_xy


def central_force(hardening: Hardening) -> CentralForce:
    """A hardening in numbers."""
    table = zip(hardening.distance or (), hardening.force or (), strict=True)
    return CentralForce(
        float(hardening.cubic_stiffness), float(hardening.contact_stiffness or 0.0), float(hardening.clearance or 0.0),
        tuple((float(r), float(force)) for r, force in table),
    )  # fmt: skip


def _rows(machine: Machine, model: LateralModel, number: int) -> Iterator[tuple[Matrix, bool]]:
    rotor = machine.rotor
    if isinstance(rotor, PlanarRotor):
        yield np.eye(2), True
    elif isinstance(rotor, MultibodyRotor):
        axis, joint = model.axis, rotor.joints[number - 1]
        assert isinstance(axis, RigAxis)
        assert isinstance(joint, PointJoint)
        kept = [axis.rig.coordinates.index(name) for name in model.coordinates]
        for six in axis.rig.spots(joint):
            yield six[:2, kept], GROUND in joint.between
    else:
        place = model.axis.rows(float(rotor.supports[number - 1].position), None).deflection
        yield np.asarray(model.both(place[None])), True


# Force of a nonlinear bearing towards its middle: a cubic spring, a stop behind a clearance, a measured
# characteristic.
#
#     F(r) = k r^3 + K max(r - g, 0) + T(r)
#
# T goes through the points of the table as a monotone cubic (Fritsch and Carlson 1980), and straight on with its last
# slope beyond them.


Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CentralForce:
    """The force in numbers, SI; ``points`` are distance (from 0, ascending) and force of the table."""

    cubic: float = 0.0
    contact: float = 0.0
    clearance: float = 0.0
    points: tuple[tuple[float, float], ...] = ()
    pieces: Floats = field(
        init=False, repr=False, compare=False
    )  # (n, 5) of T: distance where it begins, c3, c2, c1, c0

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", _pieces(np.array(self.points, float).reshape(-1, 2)))

    def force(self, r: ArrayLike) -> Floats:
        """F at distances, N."""
        r = np.asarray(r, float)
        s, (c3, c2, c1, c0) = self._piece(r)
        far = np.maximum(r - self.clearance, 0.0)
        return np.asarray(self.cubic * r**3 + self.contact * far + ((c3 * s + c2) * s + c1) * s + c0)

    def slope(self, r: ArrayLike) -> Floats:
        """dF/dr, N/m; at the clearance itself that before the stop, unless there is no clearance."""
        r = np.asarray(r, float)
        s, (c3, c2, c1, _) = self._piece(r)
        touching = (r > self.clearance) | (self.clearance == 0.0)
        return np.asarray(3.0 * self.cubic * r**2 + self.contact * touching + (3.0 * c3 * s + 2.0 * c2) * s + c1)

    def stiffness(self, x: float, y: float) -> Floats:
        """What small motions about a deflection feel, (2, 2): F' along it and F/r across it."""
        r = float(np.hypot(x, y))
        along = float(self.slope(r))
        across = float(self.force(r)) / r if r > 0.0 else along
        n = np.array([x, y]) / r if r > 0.0 else np.array([1.0, 0.0])
        return np.asarray(across * np.eye(2) + (along - across) * np.outer(n, n))

    @property
    def reach(self) -> float:
        """The last distance of the table; infinite without one."""
        return float(self.points[-1][0]) if self.points else np.inf

    def _piece(self, r: Floats) -> tuple[Floats, Floats]:
        if not len(self.pieces):
            return np.zeros_like(r), np.zeros((4, *r.shape))
        number = np.maximum(np.searchsorted(self.pieces[:, 0], r, side="right") - 1, 0)
        return np.asarray(r - self.pieces[number, 0]), np.moveaxis(self.pieces[number, 1:], -1, 0)


def _pieces(points: Floats) -> Floats:
    if not len(points):
        return np.zeros((0, 5))
    from scipy.interpolate import PchipInterpolator  # only where needed: it takes a tenth of a second to load

    if points[0, 0] > 0.0:
        points = np.vstack([[0.0, 0.0], points])
    curve = PchipInterpolator(points[:, 0], points[:, 1])
    last = [points[-1, 0], 0.0, 0.0, float(curve(points[-1, 0], 1)), points[-1, 1]]
    return np.vstack([np.column_stack([points[:-1, 0], curve.c.T]), last])
