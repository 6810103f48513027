"""One ball in a slowly turned horizontal race: the angle at which it stands still in space, and what that says of its drag.

The fluid and the race carry the ball up by the angle s from the lowest point (Spannan 2021, section 6.1.4):

    m_eff g sin s = F_drag(W eps) + mu F_N,    F_N = m_eff g cos s - P,    P = rho V W^2 eps (1 + c)

P is the inward force of the pressure of the rotating fluid on a ball at rest, c its virtual mass; (6.6) leaves it out, which
matters at drag coefficients below one: P over m_eff g is (8/3) (r_b/eps) (1 + c)/c_d at 90 degrees.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError
from autobalancer.laws.drag_coefficient import DragLaw
from autobalancer.laws.drag_curve import DragCurve
from autobalancer.units import field_arguments, texts_argument

Floats = NDArray[np.float64]
GRAVITY = 9.80665


@dataclass(frozen=True)
class TurnedRace:
    """A ball in its race: ``diameter`` and ``orbit_radius`` in m, ``mass`` in kg, density (kg/m^3) and kinematic viscosity
    (m^2/s) of the fluid. ``pressure`` is 1 + c of the inward force above; 0 leaves it out, as (6.6) does.
    """

    diameter: float
    mass: float
    orbit_radius: float
    fluid_density: float
    viscosity: float
    pressure: float = 0.0
    gravity: float = GRAVITY

    def __post_init__(self) -> None:
        field_arguments(
            self, diameter="m", mass="kg", orbit_radius="m", fluid_density="kg/m^3", viscosity="m^2/s", gravity="m/s^2"
        )
        if self.weight <= 0.0:
            raise QuestionError(
                f"the ball floats: its mass of {self.mass:g} kg is not more than that of the fluid it displaces"
            )

    @property
    def volume(self) -> float:
        """Of the ball, m^3."""
        return math.pi / 6.0 * self.diameter**3

    @property
    def weight(self) -> float:
        """Less buoyancy, N."""
        return (self.mass - self.fluid_density * self.volume) * self.gravity

    def inward(self, speed: ArrayLike) -> Floats:
        """P, N, at rotor speeds in rad/s."""
        return np.asarray(self.fluid_density * self.volume * self.orbit_radius * self.pressure * np.square(speed))

    def reynolds(self, speed: ArrayLike) -> Floats:
        """W eps d_b / nu."""
        return np.asarray(np.abs(np.asarray(speed, dtype=float)) * self.orbit_radius * self.diameter / self.viscosity)

    def drag_scale(self, speed: ArrayLike) -> Floats:
        """Drag coefficient for a drag as great as the weight less buoyancy."""
        dynamic = 0.5 * self.fluid_density * np.square(np.asarray(speed, dtype=float) * self.orbit_radius)
        return np.asarray(self.weight / (dynamic * math.pi / 4.0 * self.diameter**2))


def equilibrium_angles(race: TurnedRace, law: DragLaw, speeds: ArrayLike, rolling: float = 0.0) -> Floats:
    """Angles from the lowest point, rad, of the shape of ``speeds`` (rad/s, positive), of a ball in ``race``.

    Its drag follows ``law``, its rolling resistance is ``rolling`` (arm over ball radius).

    nan where none up to 90 degrees holds the ball: from there on it is carried around, or leaves the wall.
    """
    speeds = texts_argument("speeds", speeds, "rad/s")
    w = np.asarray(speeds, dtype=float)
    curve = DragCurve(law, race.fluid_density, race.viscosity, race.diameter)
    force = curve.force(w * race.orbit_radius) - rolling * race.inward(w)
    # sin s - mu cos s = f has the solution s = arcsin(f / sqrt(1 + mu^2)) + arctan mu while the wall presses
    share = force / (race.weight * math.hypot(1.0, rolling))
    with np.errstate(invalid="ignore"):
        angle = np.arcsin(share) + math.atan(rolling)
        pressed = race.weight * np.cos(angle) > race.inward(w)
        free = np.arcsin(curve.force(w * race.orbit_radius) / race.weight)
    angle = np.where(pressed, angle, free)
    return np.asarray(np.where(angle <= 0.5 * math.pi, angle, np.nan))


def drag_coefficients(
    race: TurnedRace,
    speeds: ArrayLike,
    angles: ArrayLike,
    rolling: float = 0.0,
) -> Floats:
    """c_d from measured ``angles`` (rad, up to pi/2) at ``speeds`` (rad/s) of the same shape, (6.6).

    ``rolling`` is the rolling resistance (arm over ball radius); with the force P if ``race.pressure`` is not zero.
    """
    speeds = texts_argument("speeds", speeds, "rad/s")
    angles = texts_argument("angles", angles, "rad")
    w, s = np.asarray(speeds, dtype=float), np.asarray(angles, dtype=float)
    if np.any(s > 0.5 * math.pi) or np.any(w <= 0.0):
        raise QuestionError(
            f"given angles up to {math.degrees(np.max(s)):.4g} deg and speeds from {np.min(w):.4g} rad/s; angles must be at most "
            "90 deg, speeds greater than zero; leave out what is beyond"
        )
    normal = np.maximum(np.cos(s) - race.inward(w) / race.weight, 0.0)
    return np.asarray(race.drag_scale(w) * (np.sin(s) - rolling * normal))
