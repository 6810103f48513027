"""Size, mass and rotation of balls, rollers and pendulums."""

from __future__ import annotations

import math

from autobalancer.catalog.bearing_table import Bearing
from autobalancer.catalog.material_table import material
from autobalancer.machine import Balls, Race

SOLID_BALL, SOLID_CYLINDER = 0.4, 0.5  # J / (m r^2)


def size_of(group: Balls, ring: Bearing | None) -> tuple[float, float, float]:
    """Mass, diameter and volume of one body of a group; diameter and volume are 0 where they are not known.

    Raises
    ------
    CatalogError
        If the material is not in the catalog.
    """
    stuff = float(group.density) if group.density is not None else None
    if group.material is not None:
        stuff = float(material(group.material).density)
    if group.body == "ball":
        return _ball(group, ring, stuff)
    mass, diameter = float(group.mass or 0.0), float(group.diameter or 0.0)
    if group.body == "pendulum":
        return mass, diameter, 0.0
    if group.length is not None:
        volume = roller_face(group) * float(group.length)
        return mass or (stuff or 0.0) * volume, diameter, volume
    return mass, diameter, mass / stuff if stuff else 0.0


def roller_face(group: Balls) -> float:
    """Area of the end of a roller, without its bore, m^2."""
    return 0.25 * math.pi * (float(group.diameter or 0.0) ** 2 - float(group.inner_diameter or 0.0) ** 2)


def spin_ratio_of(group: Balls, mass: float, orbit: float) -> float:
    """J over mass times the square of the rolling radius: 2/5 of a ball, 1/2 to 1 of a roller; of a pendulum J/(m eps^2)."""
    if group.body == "pendulum":
        return float(group.inertia or 0.0) / (mass * orbit**2)
    if group.body == "roller":
        return SOLID_CYLINDER * (1.0 + (float(group.inner_diameter or 0.0) / float(group.diameter or 1.0)) ** 2)
    return SOLID_BALL if group.motion == "rolling" else 0.0


def friction_of(group: Balls, race: Race, orbit: float) -> tuple[float, float]:
    """What brakes one body and what holds it at rest: torque over its normal force, per orbit radius.

    A pendulum has the friction of its bearing at the radius of that, all others that of the race.
    """
    if race.friction is None:
        return 0.0, 0.0
    arm = float(group.bearing_radius or 0.0) / orbit if group.body == "pendulum" else 1.0
    return arm * float(race.friction.rolling_resistance), arm * race.friction.holding


def _ball(group: Balls, ring: Bearing | None, stuff: float | None) -> tuple[float, float, float]:
    diameter = float(group.diameter) if group.diameter is not None else None
    if group.unsized and ring is not None:
        diameter = ring.ball_diameter
    if diameter is not None:
        volume = math.pi / 6.0 * diameter**3
        return float(group.mass) if group.mass is not None else (stuff or 0.0) * volume, diameter, volume
    mass = float(group.mass or 0.0)
    diameter = (6.0 * mass / (math.pi * stuff)) ** (1.0 / 3.0) if stuff else 0.0
    return mass, diameter, math.pi / 6.0 * diameter**3
