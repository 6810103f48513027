"""Rubber that softens with the amplitude as the numbers of kernels/host/rubber.py, and its forces at the start."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from autobalancer.assembly.host import padded_size
from autobalancer.assembly.rotors.model import Floats
from autobalancer.assembly.spatial import Parts
from autobalancer.kernels.records.rubber import ELASTOPLASTIC, ELEMENT, ENDOCHRONIC, MAXWELL, MOUNT
from autobalancer.kernels.system import Rubber as RubberRows
from autobalancer.machine import Machine, MultibodyRotor, PlanarRotor, PointJoint, Rubber

LAWS = {"elastoplastic": ELASTOPLASTIC, "endochronic": ENDOCHRONIC}


def rubbers(machine: Machine) -> Iterator[tuple[str, Rubber]]:
    """Every piece of rubber of a machine with its name for people, in the order of the file."""
    rotor = machine.rotor
    if isinstance(rotor, PlanarRotor):
        if rotor.rubber is not None:
            yield "support", rotor.rubber
    elif isinstance(rotor, MultibodyRotor):
        for number, joint in enumerate(rotor.joints, 1):
            if isinstance(joint, PointJoint):
                yield from ((f"joint {number}, {one.name}", one.rubber) for one in joint.rubbers())
    else:
        for number, support in enumerate(rotor.supports, 1):
            if support.rubber is not None:
                yield f"support {number}", support.rubber


def has_rubber(machine: Machine) -> bool:
    """Whether any of it softens with the amplitude."""
    return any(True for _ in rubbers(machine))


def element_count(parts: Parts) -> int:
    """Elements of all rubber; each has two states."""
    return sum(len(_elements(mount.rubber)) for mount in parts.mounts)


def rubber_rows(parts: Parts, first_state: int) -> RubberRows:
    """All rubber of a rotor; the forces of its elements begin at ``first_state``."""
    width, count = padded_size(parts.size), len(parts.mounts)
    found, elements = MOUNT.rows(count), ELEMENT.rows(element_count(parts))
    rows, number = np.zeros((2 * count, width)), 0
    for i, mount in enumerate(parts.mounts):
        rows[2 * i : 2 * i + 2, : parts.size] = mount.rows @ parts.reduction.basis
        its = _elements(mount.rubber)
        found[i].first, found[i].elements = number, len(its)
        for law, stiffness, give in its:
            one = elements[number]
            one.law, one.state, one.stiffness, one.give = law, first_state + 2 * number, stiffness, give
            number += 1
    reach = np.zeros_like(rows)
    reach[:, : parts.size] = rows[:, : parts.size] @ np.linalg.inv(parts.mass)
    return RubberRows(found, elements, rows, reach)


def pulled_forces(parts: Parts, place: Floats) -> Floats:
    """Forces of all elements when the rotor was pulled straight and slowly from rest to the coordinates r, (2 elements,)."""
    found = []
    for mount in parts.mounts:
        stretch = mount.rows @ parts.reduction.basis @ place
        size = float(np.hypot(*stretch))
        for law, stiffness, give in _elements(mount.rubber):
            share = 0.0
            if size > 0.0 and law != MAXWELL:  # a Maxwell element has relaxed
                limit = slipping_force(law, stiffness, give)
                ratio = stiffness * size / limit
                share = limit * (math.tanh(ratio) if law == ELASTOPLASTIC else -math.expm1(-ratio)) / size
            found.append(share * stretch)
    return np.concatenate(found) if found else np.zeros(0)


def force_scales(parts: Parts, length: float) -> Floats:
    """Sizes of the forces of all elements in motions of a length (m), for tolerances, (2 elements,)."""
    sizes = [
        min(stiffness * length, slipping_force(law, stiffness, give))
        for mount in parts.mounts
        for law, stiffness, give in _elements(mount.rubber)
    ]
    return np.repeat(np.array(sizes, np.float64), 2)


def slipping_force(law: int, stiffness: float, give: float) -> float:
    """The force at which an element slides, N; infinite of one that relaxes."""
    if law == MAXWELL:
        return math.inf
    return math.sqrt(stiffness / give) if law == ELASTOPLASTIC else stiffness / give


def _elements(rubber: Rubber) -> list[tuple[int, float, float]]:
    """Law, stiffness and give of each element, as in :data:`autobalancer.kernels.records.rubber.ELEMENT`."""
    found = []
    if rubber.friction is not None:
        law = LAWS[rubber.friction.law]
        for a, k in zip(rubber.friction.breakaway_amplitude, rubber.friction.stiffness, strict=True):
            found.append((law, float(k), 1.0 / (k * a * a) if law == ELASTOPLASTIC else 1.0 / a))
    if rubber.maxwell is not None:
        pairs = zip(rubber.maxwell.stiffness, rubber.maxwell.relaxation_time, strict=True)
        found += [(MAXWELL, float(k), 1.0 / tau) for k, tau in pairs]
    return found
