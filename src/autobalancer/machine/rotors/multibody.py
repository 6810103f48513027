"""A rig of rigid bodies on bearings and rubber bushings (Spannan 2021, section 6.1)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import ImpossiblePart, Listed, Part, Problem, key
from autobalancer.machine.rotors.body import GROUND, Body
from autobalancer.machine.rotors.joints import BallBearing, BodyJoint, Bushing, Dashpot, Joint, Lock, Spring


class MultibodyRotor(Part):
    """Rigid ``bodies``, rotating and standing, with ``joints`` between them and to the ground.

    Positions count along the axis from an origin of your choice. ``modes`` is how many pairs of modes a simulation in
    time keeps, all of them if it is left out. ``up`` says which way is up on a vertical axis; then the weight of the
    bodies tilts what stands on soft joints and rights what hangs from them. Without it weight has no effect.
    """

    kind: Literal["multibody"] = "multibody"
    bodies: Annotated[tuple[Body, ...], Field(min_length=1), Listed] = key("rotating and non-rotating")
    joints: Annotated[tuple[Joint, ...], Field(min_length=1), Listed] = key("between bodies, and to the ground")
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
                problems += [(("joints", i, *path), text) for path, text in _unfit(joint, moving)]
        if problems:
            raise ImpossiblePart("MultibodyRotor", problems)
        problems = self._locked_twice()
        if problems:
            raise ImpossiblePart("MultibodyRotor", problems)
        return self

    def _locked_twice(self) -> list[Problem]:
        problems: list[Problem] = []
        merged = {body.name: {body.name} for body in self.bodies}
        for i, joint in enumerate(self.joints):
            if isinstance(joint, Lock):
                a, b = joint.between
                if b in merged[a]:
                    problems.append((("joints", i), f"{a!r} and {b!r} are locked to each other already; leave it out"))
                group = merged[a] | merged[b]
                merged.update(dict.fromkeys(group, group))
        for i, joint in enumerate(self.joints):
            a, b = joint.between
            if not isinstance(joint, Lock) and b in merged.get(a, ()):
                problems.append(
                    (("joints", i), f"{a!r} and {b!r} are locked to each other; it has no effect, leave it out")
                )
        return problems

    @property
    def inertia(self) -> float | None:
        """Of the rotating bodies about the axis, what a torque accelerates; ``None`` of point masses."""
        return sum(body.inertias[2] for body in self.bodies if body.rotating) or None


def _unfit(joint: BodyJoint, turning: int) -> list[Problem]:
    """What is wrong with a joint of which ``turning`` ends turn."""
    if isinstance(joint, Lock):
        text = f"a body cannot be locked to the {GROUND!r}; leave it out and connect the others to the ground"
        return [(("between",), text)] if GROUND in joint.between else []
    if isinstance(joint, BallBearing) and turning != 1:
        which = "both turn" if turning else "none of them turns"
        return [(("between",), f"a bearing connects a rotating body and a non-rotating one; {which}")]
    if not turning:
        return []
    if isinstance(joint, Bushing):
        return [
            (
                ("between",),
                "a bushing connects non-rotating bodies, or one to the ground; use a 'spring' on the axis here",
            )
        ]
    found: list[Problem] = []
    if isinstance(joint, (Spring, Dashpot)):
        if joint.offset != (0.0, 0.0):
            found.append((("offset",), "a joint on a rotating body must be on its axis; leave it out"))
        for key in ("torsional_stiffness", "torsional_damping"):
            if getattr(joint, key, 0.0):
                found.append(
                    ((key,), "a body that rotates with the rotor cannot be held against rotation; leave it out")
                )
    if turning == 2 and isinstance(joint, (Spring, Dashpot)):
        found += _turns_along(joint)
    return found


def _turns_along(joint: Spring | Dashpot) -> list[Problem]:
    """What a joint between two rotating bodies must not have."""
    table = joint.table if isinstance(joint, Spring) else None
    damped = joint.damping not in (0.0, (0.0, 0.0)) or joint.tilt_damping
    if damped or (table is not None and any(entry not in (0.0, (0.0, 0.0)) for entry in table.damping)):
        text = "damping between two rotating bodies rotates with them and can cause whirl; this is not modelled, leave it out"
        return [(("damping",), text)]
    pairs = (joint.stiffness, *(table.stiffness if table else ())) if isinstance(joint, Spring) else ()
    if any(isinstance(entry, tuple) and entry[0] != entry[1] for entry in pairs):
        return [
            (("stiffness",), "between two rotating bodies x and y must be equal, because the joint rotates with them")
        ]
    return []
