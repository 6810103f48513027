"""Numbers of a machine by their path."""

from __future__ import annotations

import re
from typing import Any

from autobalancer.catalog.resolve_springs import settled
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.machine.part import Part

_UNITS = {  # of the last key of a path
    **dict.fromkeys(("mass", "added_mass"), "kg"),
    **dict.fromkeys(("stiffness", "cross_stiffness", "axial_stiffness", "shear_stiffness"), "N/m"),
    **dict.fromkeys(("damping", "axial_damping", "shear_damping"), "N*s/m"),
    **dict.fromkeys(("inertia", "transverse_inertia", "polar_inertia", "couple"), "kg*m^2"),
    **dict.fromkeys(("position", "length", "radius", "diameter", "inner_diameter", "outer_diameter", "offset"), "m"),
    **dict.fromkeys(("orbit_radius", "race_radius", "eccentricity", "width", "height"), "m"),
    **dict.fromkeys(("angle", "misalignment", "eccentricity_angle"), "rad"),
    **dict.fromkeys(("tilt_stiffness", "torsional_stiffness", "bending_stiffness"), "N*m/rad"),
    **dict.fromkeys(("tilt_damping", "torsional_damping", "bending_damping"), "N*m*s/rad"),
    "moment": "kg*m",
    "beta": "N*m*s",
    "density": "kg/m^3",
    "youngs_modulus": "N/m^2",
    "shear_modulus": "N/m^2",
    "stiffness_proportional_damping": "s",
    "mass_proportional_damping": "1/s",
    **dict.fromkeys(("speed", "critical_speed"), "rad/s"),
    "gravity": "m/s^2",
}


def value_at(machine: Machine, path: str) -> float:
    """The number at a path, SI.

    Raises
    ------
    QuestionError
        If there is nothing, or no single number; the message says what there is.
    """
    entry: Any = settled(machine, path)
    for step in re.findall(r"[a-z_]+|\[\d+\]", path):
        if step.startswith("["):
            number = int(step[1:-1])
            if not isinstance(entry, tuple) or not 1 <= number <= len(entry):
                count = len(entry) if isinstance(entry, tuple) else 0
                raise QuestionError(
                    f"parameter {path!r}: entry {number} does not exist; there are {count}, counted from 1"
                )
            entry = entry[number - 1]
        elif isinstance(entry, Part) and step in type(entry).model_fields:
            entry = getattr(entry, step)
        else:
            known = ", ".join(type(entry).model_fields) if isinstance(entry, Part) else "nothing"
            raise QuestionError(f"parameter {path!r}: no {step!r} there; there is {known}")
    if isinstance(entry, tuple) and all(isinstance(part, float) for part in entry) and entry:
        raise QuestionError(f"parameter {path!r}: it is {len(entry)} numbers; choose one, such as '{path}[1]'")
    if isinstance(entry, bool) or not isinstance(entry, (int, float)):
        raise QuestionError(f"parameter {path!r}: it is {entry!r}, not a number; give it a number to start from first")
    return float(entry)


def unit_of(path: str) -> str:
    """SI unit of the entry at a path; empty where it has none or it is not known here."""
    keys = re.findall(r"[a-z_]+", path)
    return _UNITS.get(keys[-1], "") if keys else ""
