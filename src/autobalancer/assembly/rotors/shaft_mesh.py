"""The nodes of a shaft: ends of elements, disks, supports and thrust bearing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.model import Floats
from autobalancer.assembly.rotors.shaft_element import Element, cowper
from autobalancer.machine import ShaftRotor, ShaftSegment
from autobalancer.machine.rotors.shaft import SAME

NEAR = 0.01  # share of an element below which its end gives way to a place that must be a node


@dataclass(frozen=True)
class Mesh:
    """Nodes along a shaft and the elements between them."""

    nodes: Floats  # (n,) ascending, m
    elements: tuple[Element, ...]  # (n - 1,)

    def node(self, position: float) -> int:
        """The node nearest to a position, m."""
        return int(np.argmin(np.abs(self.nodes - position)))


def mesh(rotor: ShaftRotor) -> Mesh:
    """Cut the segments into their elements, and these again where a disk, a support or the thrust bearing is."""
    places = [float(disk.position) for disk in rotor.disks] + [float(support.position) for support in rotor.supports]
    if rotor.thrust_bearing is not None:
        places.append(float(rotor.thrust_bearing))
    same = SAME * rotor.length
    nodes, elements, start = [0.0], [], 0.0
    for segment in rotor.segments:
        end = start + float(segment.length)
        size = float(segment.length) / segment.elements
        fixed = [start, *sorted(p for p in places if start + same < p < end - same), end]
        grid = start + size * np.arange(1, segment.elements)
        free = [z for z in grid if np.abs(np.array(fixed) - z).min() > NEAR * size]
        for z in sorted([*fixed[1:], *free]):
            if z - nodes[-1] > same:
                elements.append(_element(rotor, segment, z - nodes[-1]))
                nodes.append(float(z))
        start = end
    return Mesh(np.array(nodes), tuple(elements))


def _element(rotor: ShaftRotor, segment: ShaftSegment, length: float) -> Element:
    material = rotor.material_of(segment)
    kappa = segment.shear_coefficient
    if kappa is None:
        kappa = cowper(material.poisson, float(segment.inner_diameter) / float(segment.diameter))
    density, young = float(material.density), float(material.youngs_modulus)
    return Element(
        length=length,
        bending=young * segment.second_moment,
        shearing=float(kappa) * material.shear * segment.area,
        mass=density * segment.area,
        rotary=density * segment.second_moment,
    )
