"""A rig of rigid bodies on bearings and rubber bushings (Spannan 2021, section 6.1)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.errors import MachineError, Problem
from autobalancer.machine.part import Listed, key
from autobalancer.machine.plugins import OneOf
from autobalancer.machine.rotors.body import GROUND, Body, RotorModel
from autobalancer.machine.rotors.joint import Joint, PointJoint


class MultibodyRotor(RotorModel):
    """Rigid ``bodies``, rotating and standing, with ``joints`` between them and to the ground.

    Positions count along the axis from an origin of your choice. ``modes`` is how many pairs of modes a simulation in
    time keeps, all of them if it is left out. ``up`` says which way is up on a vertical axis; then the weight of the
    bodies tilts what stands on soft joints and rights what hangs from them. Without it weight has no effect.
    """

    kind: Literal["multibody"] = "multibody"
    bodies: Annotated[tuple[Body, ...], Field(min_length=1), Listed] = key("rotating and non-rotating")
    joints: Annotated[tuple[Annotated[Joint, OneOf(Joint)], ...], Field(min_length=1), Listed] = key(
        "between bodies, and to the ground"
    )
    modes: Annotated[int, Field(strict=True, ge=1)] | None = key(
        "pairs of modes that a simulation in time keeps; all without it", None
    )
    up: Literal["+z", "-z"] | None = key("on a vertical axis; without it weight has no effect", None)

    @model_validator(mode="after")
    def _consistent(self) -> MultibodyRotor:
        names = [body.name for body in self.bodies]
        problems: list[Problem] = [
            (("bodies", i, "name"), f"{name!r} is given twice") for i, name in enumerate(names) if name in names[:i]
        ]
        turning = {body.name: body.rotating for body in self.bodies}
        if not any(turning.values()):
            problems.append((("bodies",), "none of them rotates; set 'rotating = true' for one"))
        for i, joint in enumerate(self.joints):
            unknown = [name for name in joint.between if name != GROUND and name not in turning]
            if unknown:
                known = ", ".join(map(repr, (*turning, GROUND)))
                problems.append((("joints", i, "between"), f"no body is named {unknown[0]!r}; there is {known}"))
            else:
                moving = sum(turning.get(name, False) for name in joint.between)
                problems += [(("joints", i, *path), text) for path, text in joint.unfit(moving)]
        if problems:
            raise MachineError.of("MultibodyRotor", problems)
        problems = self._locked_twice()
        if problems:
            raise MachineError.of("MultibodyRotor", problems)
        return self

    def _locked_twice(self) -> list[Problem]:
        problems: list[Problem] = []
        merged = {body.name: {body.name} for body in self.bodies}
        for i, joint in enumerate(self.joints):
            if not isinstance(joint, PointJoint):
                a, b = joint.between
                if b in merged[a]:
                    problems.append((("joints", i), f"{a!r} and {b!r} are locked to each other already; leave it out"))
                group = merged[a] | merged[b]
                merged.update(dict.fromkeys(group, group))
        for i, joint in enumerate(self.joints):
            a, b = joint.between
            if isinstance(joint, PointJoint) and b in merged.get(a, ()):
                problems.append(
                    (("joints", i), f"{a!r} and {b!r} are locked to each other; it has no effect, leave it out")
                )
        return problems

    @property
    def inertia(self) -> float | None:
        """Of the rotating bodies about the axis, what a torque accelerates; ``None`` of point masses."""
        return sum(body.inertias[2] for body in self.bodies if body.rotating) or None
