"""Where bearings that become stiffer as they deflect sit in a rotor, and their stiffness where it rests."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from autobalancer.assembly.bearings.central_force import CentralForce
from autobalancer.assembly.rotors.model import SAME, LateralModel, Matrix, turns_alike
from autobalancer.assembly.rotors.multibody import RigAxis
from autobalancer.catalog.resolve_springs import planar_rotor
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
                yield from ((f"joint {number}", number, one) for one in joint.hardenings())
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
