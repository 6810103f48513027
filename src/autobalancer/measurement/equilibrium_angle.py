"""One ball in a slowly turned horizontal race: the angle at which it stands still in space, and what that says of its drag.

The fluid and the race carry the ball up by the angle s from the lowest point (Spannan 2021, section 6.1.4):

    m_eff g sin s = F_drag(W eps) + mu F_N,    F_N = m_eff g cos s - P,    P = rho V W^2 eps (1 + c)

P is the inward force of the pressure of the rotating fluid on a ball at rest, c its virtual mass; (6.6) leaves it out, which
matters at drag coefficients below one: P over m_eff g is (8/3) (r_b/eps) (1 + c)/c_d at 90 degrees.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError
from autobalancer.laws.drag_coefficient import DragLaw
from autobalancer.laws.drag_curve import DragCurve

Floats = NDArray[np.float64]
GRAVITY = 9.80665
STEEPEST = 0.3  # largest coefficient of rolling resistance in a fit


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


def equilibrium_angles(race: TurnedRace, law: DragLaw, speeds: ArrayLike, rolling: float = 0.0) -> Floats:
    """Angles from the lowest point, rad, of the shape of ``speeds`` (rad/s, positive).

    nan where none up to 90 degrees holds the ball: from there on it is carried around, or leaves the wall.
    """
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


def drag_coefficients(race: TurnedRace, speeds: ArrayLike, angles: ArrayLike, rolling: float = 0.0) -> Floats:
    """c_d from measured angles (rad, up to pi/2), (6.6); with the force P if ``race.pressure`` is not zero."""
    w, s = np.asarray(speeds, dtype=float), np.asarray(angles, dtype=float)
    if np.any(s > 0.5 * math.pi) or np.any(w <= 0.0):
        raise QuestionError("angles must be at most 90 deg, speeds greater than zero")
    normal = np.maximum(race.weight * np.cos(s) - race.inward(w), 0.0)
    force = race.weight * np.sin(s) - rolling * normal
    area = math.pi / 4.0 * race.diameter**2
    return np.asarray(2.0 * force / (race.fluid_density * area * np.square(w * race.orbit_radius)))


def fit_rolling_resistance(series: Sequence[tuple[TurnedRace, ArrayLike, ArrayLike]]) -> float:
    """The coefficient with which series in different fluids agree where their Reynolds numbers overlap.

    Parameters
    ----------
    series
        Race, speeds (rad/s) and angles (rad) of each; overlapping ones give the answer, since the left end of a series
        has small angles, which friction rules, and the right end large ones.

    Raises
    ------
    QuestionError
        If no two series overlap.
    """
    from scipy.optimize import minimize_scalar

    def mismatch(rolling: float) -> tuple[float, int]:
        curves = []
        for race, speeds, angles in series:
            c = drag_coefficients(race, speeds, angles, rolling)
            order = np.argsort(race.reynolds(speeds))
            curves.append((np.log(race.reynolds(speeds))[order], np.log(np.maximum(c, 1e-12))[order]))
        total, count = 0.0, 0
        for i, (x, y) in enumerate(curves):
            for other_x, other_y in curves[i + 1 :]:
                low, high = max(x[0], other_x[0]), min(x[-1], other_x[-1])
                if low >= high:
                    continue
                at = np.linspace(low, high, 9)
                gap = np.clip(np.interp(at, x, y) - np.interp(at, other_x, other_y), -3.0, 3.0)
                total, count = total + float(gap @ gap), count + 9
        return total / max(count, 1), count

    if mismatch(0.0)[1] == 0:
        raise QuestionError("no two series overlap in their Reynolds numbers; measure closer fluids")
    trial = np.linspace(0.0, STEEPEST, 61)
    best = int(np.argmin([mismatch(mu)[0] for mu in trial]))
    span = trial[max(best - 1, 0)], trial[min(best + 1, 60)]
    return float(minimize_scalar(lambda mu: mismatch(mu)[0], bounds=span, method="bounded", options={"xatol": 1e-8}).x)
