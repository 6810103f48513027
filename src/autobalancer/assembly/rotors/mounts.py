"""Where rubber that softens with the amplitude sits in a rotor, and what is left of the rotor when all of it slides."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from autobalancer.assembly.rotors.model import SAME, Floats, LateralModel, Matrix, turns_alike
from autobalancer.assembly.rotors.multibody import RigAxis
from autobalancer.catalog.resolve_springs import planar_rotor
from autobalancer.machine import Machine, MultibodyRotor, PlanarRotor, PointJoint, Rubber
from autobalancer.machine.rotors.body import GROUND


@dataclass(frozen=True)
class Mount:
    """One piece of rubber: the rows of its stretch along two directions, the second zero where it has but one."""

    name: str
    rubber: Rubber
    rows: Matrix  # (2, N)
    support: int  # number of the support or joint of the rotor, from 1
    grounded: bool  # whether it stands on the ground

    def isotropic(self, pairs: int) -> bool:
        """Whether both directions are alike, so that its stretch turns with the machine when that is turned about its axis."""
        return turns_alike(self.rows, pairs)


def mounts(machine: Machine, model: LateralModel) -> tuple[Mount, ...]:
    """All rubber of a machine that softens with the amplitude, in the order of its file."""
    return tuple(_mounts(machine, model))


def sliding_model(machine: Machine, model: LateralModel, found: tuple[Mount, ...]) -> LateralModel:
    """The rotor with the stiffness and the damping of large motions only: what a run adds the elements to."""
    damping, stiffness = model.damping.copy(), model.stiffness.copy()
    for mount in found:
        square = mount.rows.T @ mount.rows
        more_stiffness, more_damping = beyond_sliding(machine, model, mount)
        stiffness -= more_stiffness[:, None, None] * square
        damping -= more_damping[:, None, None] * square
    if all(np.abs(stack - stack[0]).max() <= SAME * np.abs(stack).max(initial=0.0) for stack in (damping, stiffness)):
        return replace(model, speeds=model.speeds[:1], damping=damping[:1], stiffness=stiffness[:1])
    return replace(model, damping=damping, stiffness=stiffness)


def beyond_sliding(machine: Machine, model: LateralModel, mount: Mount) -> tuple[Floats, Floats]:
    """What the elements of rubber add to stiffness (N/m) and damping (N s/m) in small motions, at the model's speeds."""
    small = np.array([_small(machine, mount.rubber, float(speed)) for speed in model.speeds])
    return small[:, 0] - float(mount.rubber.stiffness), small[:, 1] - float(mount.rubber.damping)


def _small(machine: Machine, rubber: Rubber, speed: float) -> tuple[float, float]:
    """Stiffness and damping of small motions as the model has them."""
    if isinstance(machine.rotor, PlanarRotor):
        rotor = planar_rotor(machine)
        return rotor.stiffness_xy[0], rotor.damping_xy[0]
    return rubber.small_motions(speed)


def _mounts(machine: Machine, model: LateralModel) -> Iterator[Mount]:
    rotor = machine.rotor
    if isinstance(rotor, PlanarRotor):
        if rotor.rubber is not None:
            yield Mount("support", rotor.rubber, np.eye(2), 1, True)
    elif isinstance(rotor, MultibodyRotor):
        yield from _on_joints(rotor, model)
    else:
        for number, support in enumerate(rotor.supports, 1):
            if support.rubber is not None:
                place = model.axis.rows(float(support.position), None).deflection
                yield Mount(f"support {number}", support.rubber, model.both(place[None]), number, True)


def _on_joints(rotor: MultibodyRotor, model: LateralModel) -> Iterator[Mount]:
    axis = model.axis
    assert isinstance(axis, RigAxis)
    kept = [axis.rig.coordinates.index(name) for name in model.coordinates]
    for number, joint in enumerate(rotor.joints, 1):
        if not isinstance(joint, PointJoint) or not joint.rubbers():
            continue
        spots = axis.rig.spots(joint)
        for place, six in enumerate(spots, 1):
            name = f"joint {number}" + (f", {place} of {len(spots)}" if len(spots) > 1 else "")
            for one in joint.rubbers():
                rows = np.zeros((2, len(kept)))
                rows[: len(one.motions)] = six[np.ix_(one.motions, kept)]
                yield Mount(f"{name}, {one.name}", one.rubber, rows, number, GROUND in joint.between)
