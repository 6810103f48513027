"""Rubber of a rotor that softens with the amplitude: where it is, and which motions stretch it."""

from __future__ import annotations

from collections.abc import Iterator

from autobalancer.machine import Machine, MultibodyRotor, PlanarRotor, PointJoint, Rubber


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
