"""Springs and dampers of a planar rotor from what an engineer measures: its critical speed and its damping ratio."""

from __future__ import annotations

from typing import Any

from autobalancer.catalog.resolve import resolve
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.rotors.planar import DAMPERS, SPRINGS

WORDS = tuple(f"rotor.{key}" for key in (*SPRINGS[1:], *DAMPERS[1:]))
"""Paths of entries from which springs and dampers follow."""


def planar_rotor(machine: Machine) -> PlanarRotor:
    """The planar rotor of a machine with its stiffness and damping.

    A critical speed means w_c = sqrt(k/M), where the mass M in motion has the effective masses of the balls; a damping ratio
    means D = b / (2 sqrt(k M)), and a half-power bandwidth 2 D w_c, which is exact for light damping. Rubber has the stiffness
    and damping of small motions here.
    """
    rotor = machine.rotor
    assert isinstance(rotor, PlanarRotor)
    if rotor.settled:
        return rotor
    mass = float(rotor.mass) + sum(ball.effective_mass for ball in resolve(machine))
    stiffness, damping = (pair[0] if pair[0] == pair[1] else pair for pair in rotor.springs(mass))
    found = {
        "mass": rotor.mass,
        "stiffness": rotor.stiffness or stiffness,
        "damping": rotor.damping,
        "inertia": rotor.inertia,
        "hardening": rotor.hardening,
    }
    if rotor.damping is None:
        found["damping"] = damping
    return PlanarRotor(**{key: value for key, value in found.items() if value is not None})  # type: ignore[arg-type]


def settled(machine: Machine, path: str = "") -> Machine:
    """A machine whose planar rotor has stiffness and damping, so that they stay when something else is changed.

    It is left as it is where ``path`` names what they follow from, because then that is what is changed.
    """
    if path in WORDS or not isinstance(machine.rotor, PlanarRotor):
        return machine
    if machine.rotor.settled or machine.rotor.rubber is not None:
        return machine
    return Machine(
        **{**{key: getattr(machine, key) for key in machine.model_fields_set}, "rotor": planar_rotor(machine)}
    )


def with_spring(machine: Machine, path: str, value: Any) -> Machine:
    """A machine with another entry of those that give springs and dampers; the others of its group are dropped.

    So a machine with a stiffness can be given a critical speed, and the other way round.
    """
    machine, key = settled(machine, path), path.removeprefix("rotor.")
    rotor = machine.rotor
    dropped = {*(SPRINGS if key in SPRINGS else DAMPERS)}
    kept = {name: getattr(rotor, name) for name in rotor.model_fields_set - dropped}
    changed = PlanarRotor(**{**kept, key: value})
    return Machine(**{**{name: getattr(machine, name) for name in machine.model_fields_set}, "rotor": changed})


def is_spring(machine: Machine, path: str) -> bool:
    """Whether a path names one of these entries of a planar rotor."""
    return isinstance(machine.rotor, PlanarRotor) and path in (
        *WORDS,
        *(f"rotor.{keys[0]}" for keys in (SPRINGS, DAMPERS)),
    )
