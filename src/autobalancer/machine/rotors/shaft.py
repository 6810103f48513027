"""The flexible shaft: cylindrical segments with disks on them, carried by supports (Spannan 2021, section 6.2)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import ImpossiblePart, Listed, Part, Problem, key
from autobalancer.machine.quantity import Position, Time
from autobalancer.machine.rotors.disk import Disk
from autobalancer.machine.rotors.segment import ShaftMaterial, ShaftSegment
from autobalancer.machine.rotors.support import Support

SAME = 1e-9  # share of the length below which two places are one


class ShaftRotor(Part):
    """A shaft that bends and shears, with rigid ``disks``; positions count from its left end, where z = 0.

    ``segments`` follow each other from the left end. ``stiffness_proportional_damping`` is the factor t in C = t K, s, with
    the elastic K of shaft and supports, added to what the supports bring. ``modes`` is how many pairs of modes a
    simulation in time keeps; as many as are needed if it is left out. ``up`` says which way is up on a vertical axis and
    ``thrust_bearing`` the position where the weight is carried; then weight stretches the shaft below and compresses it
    above, and rights what hangs. Without them weight has no effect.
    """

    kind: Literal["shaft"] = "shaft"
    material: ShaftMaterial | None = key("of all segments without their own material", None)
    segments: Annotated[tuple[ShaftSegment, ...], Field(min_length=1), Listed] = key(
        "one after the other from the left end"
    )
    disks: Annotated[tuple[Disk, ...], Listed] = key("rigid bodies fixed to the shaft", ())
    supports: Annotated[tuple[Support, ...], Field(min_length=1), Listed] = key(
        "bearings, springs and dampers between shaft and ground"
    )
    stiffness_proportional_damping: Time = key("factor t in C = t K of shaft and supports", 0.0)
    modes: Annotated[int, Field(strict=True, ge=1)] | None = key(
        "pairs of modes that a simulation in time keeps; as many as are needed if left out", None
    )
    up: Literal["+z", "-z"] | None = key("which way is up on a vertical axis; without it weight has no effect", None)
    thrust_bearing: Position | None = key("position where the weight is carried; requires `up`", None)

    @model_validator(mode="after")
    def _possible(self) -> ShaftRotor:
        problems: list[Problem] = []
        if self.material is None:
            problems = [
                (("segments", i, "material"), "missing; give it here, or one for all segments in rotor.material")
                for i, segment in enumerate(self.segments)
                if segment.material is None
            ]
        names = [disk.name for disk in self.disks]
        for i, disk in enumerate(self.disks):
            if not self.on_shaft(float(disk.position)):
                problems.append((("disks", i, "position"), self._outside(float(disk.position))))
            if disk.name and disk.name in names[:i]:
                problems.append((("disks", i, "name"), f"{disk.name!r} is given twice"))
        for i, support in enumerate(self.supports):
            if not self.on_shaft(float(support.position)):
                problems.append((("supports", i, "position"), self._outside(float(support.position))))
        if (self.up is None) != (self.thrust_bearing is None):
            missing, there = ("up", "thrust_bearing") if self.up is None else ("thrust_bearing", "up")
            problems.append(((missing,), f"missing; weight requires it in addition to {there!r}, or leave both out"))
        if self.thrust_bearing is not None and not self.on_shaft(float(self.thrust_bearing)):
            problems.append((("thrust_bearing",), self._outside(float(self.thrust_bearing))))
        if not self._held():
            text = "the shaft is not supported; give springs at two positions, or one and 'tilt_stiffness'"
            problems.append((("supports",), text))
        if self.stiffness_proportional_damping and any(s.rubber is not None for s in self.supports):
            text = "given beside 'rubber' in a support, which has its own loss; leave it out"
            problems.append((("stiffness_proportional_damping",), text))
        if problems:
            raise ImpossiblePart("ShaftRotor", problems)
        return self

    def _held(self) -> bool:
        """Whether it can neither move nor tilt freely; what hangs from a hinge is held by its weight."""
        held = {float(s.position) for s in self.supports if s.carries}
        tilt = any(s.tilt_stiffness > 0.0 for s in self.supports)
        return bool(held) and (len(held) > 1 or tilt or self.up is not None)

    def _outside(self, position: float) -> str:
        return f"given {position:g} m; the shaft reaches from 0 to {self.length:g} m"

    def on_shaft(self, position: float) -> bool:
        """Whether there is shaft at a position, m."""
        return -SAME * self.length <= position <= self.length * (1.0 + SAME)

    def material_of(self, segment: ShaftSegment) -> ShaftMaterial:
        """The segment's own material, or that of all."""
        found = segment.material if segment.material is not None else self.material
        assert found is not None
        return found

    @property
    def length(self) -> float:
        """Of all segments, m."""
        return sum(float(segment.length) for segment in self.segments)

    @property
    def mass(self) -> float:
        """Of shaft and disks, kg."""
        shaft = sum(s.volume * float(self.material_of(s).density) for s in self.segments)
        return shaft + sum(float(disk.mass) for disk in self.disks)

    @property
    def inertia(self) -> float:
        """Polar inertia of shaft and disks, what a torque accelerates, kg m^2."""
        shaft = sum(2.0 * s.second_moment * float(s.length) * float(self.material_of(s).density) for s in self.segments)
        return shaft + sum(float(disk.polar_inertia) for disk in self.disks)
