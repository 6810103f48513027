"""The flexible shaft: cylindrical segments with disks on them, carried by supports (Spannan 2021, section 6.2)."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.errors import MachineError, Problem
from autobalancer.machine.part import (
    Density,
    Label,
    Length,
    Listed,
    Mass,
    Offset,
    Part,
    PoissonRatio,
    Position,
    Positive,
    Quantity,
    Time,
    key,
)
from autobalancer.machine.rotors.body import RotorModel
from autobalancer.machine.rotors.support import Support

# A rigid body fixed to a shaft.


OwnInertia = Annotated[float, Quantity("kg*m^2", non_negative=True)]


class Disk(Part):
    """A rigid body fixed to the shaft at ``position``; inertias about its mass center, 0 of a point mass.

    ``offset`` is the distance of its mass center from there along the axis, positive towards the right end, carried by
    a rigid arm. ``extent`` is how far the body reaches from there, as a pair (from, to); places on it that lie beyond the
    ends of the shaft, or that name it as their ``body``, move with it.
    """

    name: Label = key("for stations that name it as their body", "")
    position: Position = key("where it is fixed to the shaft, from the left end")
    mass: Mass = key("without balls", symbol="m")
    transverse_inertia: OwnInertia = key("about a diameter through its mass center", symbol="J_t")
    polar_inertia: OwnInertia = key("about the axis", symbol="J_p")
    offset: Position = key("from its position to its mass center, positive towards the right end", 0.0)
    extent: tuple[Position, Position] = key("how far the body reaches from its position, from and to", (0.0, 0.0))

    @model_validator(mode="after")
    def _possible(self) -> Disk:
        if self.polar_inertia > 2.0 * self.transverse_inertia * (1.0 + 1e-9):
            raise ValueError(
                f"polar_inertia: given {self.polar_inertia:g} kg m^2; no body has more than twice its transverse inertia, "
                f"{2.0 * self.transverse_inertia:g} kg m^2 here"
            )
        if self.extent[0] > self.extent[1]:
            raise ValueError(f"extent: given {self.extent[0]:g} m to {self.extent[1]:g} m; the smaller one comes first")
        return self

    @property
    def reach(self) -> tuple[float, float]:
        """Positions along the shaft's axis from where to where the body is, m."""
        arm = (0.0, float(self.offset), float(self.extent[0]), float(self.extent[1]))
        return float(self.position) + min(arm), float(self.position) + max(arm)


# A cylindrical piece of a shaft, and what it is made of.


Modulus = Annotated[float, Quantity("Pa", positive=True)]


class ShaftMaterial(Part):
    """What a shaft is made of; either ``shear_modulus`` or ``poisson_ratio``, which gives the other."""

    density: Density = key("of the shaft", symbol=r"\rho")
    youngs_modulus: Modulus = key("Young's modulus", symbol="E")
    shear_modulus: Modulus | None = key("either this or Poisson's ratio", None, symbol="G")
    poisson_ratio: PoissonRatio | None = key("either this or the shear modulus", None, symbol=r"\nu")

    @model_validator(mode="after")
    def _one_way(self) -> ShaftMaterial:
        if (self.shear_modulus is None) == (self.poisson_ratio is None):
            raise ValueError("give either 'shear_modulus' or 'poisson_ratio'")
        if not -1e-9 <= self.poisson < 0.5 + 1e-9:
            where = "poisson_ratio" if self.shear_modulus is None else "shear_modulus"
            raise ValueError(f"{where}: gives a Poisson ratio of {self.poisson:g}; it must be from 0 to 0.5")
        return self

    @property
    def poisson(self) -> float:
        """Poisson's ratio, as given or E/(2 G) - 1."""
        if self.poisson_ratio is not None:
            return float(self.poisson_ratio)
        return float(self.youngs_modulus) / (2.0 * float(self.shear_modulus or 0.0)) - 1.0

    @property
    def shear(self) -> float:
        """Shear modulus, Pa, as given or E/(2 (1 + nu))."""
        if self.shear_modulus is not None:
            return float(self.shear_modulus)
        return float(self.youngs_modulus) / (2.0 * (1.0 + float(self.poisson_ratio or 0.0)))


class ShaftSegment(Part):
    """A cylinder, hollow if it has an ``inner_diameter``, cut into equal ``elements``.

    ``shear_coefficient`` is the share of the section that carries shear; by default that of Cowper (1966).
    """

    length: Length = key("along the axis")
    diameter: Length = key("outer diameter")
    inner_diameter: Offset = key("of the bore", 0.0)
    elements: Annotated[int, Field(strict=True, ge=1, le=1000)] = key(
        "equal pieces into which it is cut; disks and supports cut it further", 4
    )
    material: ShaftMaterial | None = key("in place of that of the rotor", None)
    shear_coefficient: Positive | None = key(
        "share of the section that carries shear; by default that of Cowper (1966)", None
    )

    @model_validator(mode="after")
    def _hollow(self) -> ShaftSegment:
        if self.inner_diameter >= self.diameter:
            raise ValueError(
                f"inner_diameter: given {self.inner_diameter:g} m; must be smaller than the diameter, {self.diameter:g} m"
            )
        return self

    @property
    def area(self) -> float:
        """Of the section, m^2."""
        return 0.25 * math.pi * (float(self.diameter) ** 2 - float(self.inner_diameter) ** 2)

    @property
    def second_moment(self) -> float:
        """Of the area about a diameter, m^4."""
        return math.pi / 64.0 * (float(self.diameter) ** 4 - float(self.inner_diameter) ** 4)

    @property
    def volume(self) -> float:
        """m^3."""
        return self.area * float(self.length)


SAME = 1e-9  # share of the length below which two places are one


class ShaftRotor(RotorModel):
    """A shaft that bends and shears (Przemieniecki 1968; Cowper 1966) with rigid ``disks``; its left end is at z = 0.

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
            raise MachineError.of("ShaftRotor", problems)
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
        material = segment.material if segment.material is not None else self.material
        assert material is not None
        return material

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
