"""The chamber of a race as the fluid sees it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from autobalancer.arrays import Floats, Matrix
from autobalancer.catalog.resolve import fluid_numbers, resolve, sheared
from autobalancer.errors import MachineError, QuestionError
from autobalancer.laws.drag_coefficient import Sheared
from autobalancer.machine import Machine
from autobalancer.units import field_arguments


@dataclass(frozen=True)
class Annulus:
    """A ring of fluid of rectangular cross-section, closed by four walls.

    Parameters
    ----------
    inner, outer
        Radii of its walls, m.
    height
        Along the axis, m.
    orbit_radius
        Of the ball centers, m: there, at mid-height, the speed of the fluid is given.
    viscosity, density
        Kinematic viscosity (m^2/s) and density (kg/m^3) of the fluid.
    sheared
        How the viscosity changes with the rate of shear; ``viscosity`` is then that at rest.

    Raises
    ------
    MachineError
        If the walls do not enclose a ring with the orbit in it, or the fluid has no viscosity or mass.
    """

    inner: float
    outer: float
    height: float
    orbit_radius: float
    viscosity: float
    density: float
    sheared: Sheared | None = None

    def __post_init__(self) -> None:
        field_arguments(self, inner="m", outer="m", height="m", orbit_radius="m", viscosity="m^2/s", density="kg/m^3")
        if not 0.0 < self.inner < self.outer:
            raise MachineError(
                f"annulus: given an inner wall at {_mm(self.inner)} and an outer one at {_mm(self.outer)}; the inner "
                "radius must be positive and the smaller one"
            )
        if not self.height > 0.0:
            raise MachineError(f"annulus: given a height of {_mm(self.height)}; must be positive")
        if not self.inner < self.orbit_radius < self.outer:
            raise MachineError(
                f"annulus: given an orbit radius of {_mm(self.orbit_radius)}; must lie between the walls at "
                f"{_mm(self.inner)} and {_mm(self.outer)}"
            )
        if not (self.viscosity > 0.0 and math.isfinite(self.viscosity)):
            raise MachineError(
                f"annulus: given a kinematic viscosity of {self.viscosity:g} m^2/s; must be positive, because a fluid "
                "without viscosity is not set in motion by its walls"
            )
        if not self.density > 0.0:
            raise MachineError(f"annulus: given a density of {self.density:g} kg/m^3; must be positive")

    @property
    def width(self) -> float:
        """Radial distance of the walls, m."""
        return self.outer - self.inner

    @property
    def decay_rate(self) -> float:
        """nu (pi^2/W^2 + pi^2/H^2), 1/s: nearly the rate at which the slowest mode of diffusion decays."""
        return self.viscosity * math.pi**2 * (self.width**-2 + self.height**-2)

    def ekman_number(self, speed: float) -> float:
        """nu / (w H^2) at the rotor speed ``speed`` (rad/s)."""
        return self.viscosity / (max(abs(speed), 1e-300) * self.height**2)


@dataclass(frozen=True)
class Walls:
    """Angular velocities of single walls relative to the rotor, rad/s; all zero if every wall turns with it.

    A lid that is ``None`` rotates like the steady flow between infinitely long cylinders, A + B/r^2, and so does not
    disturb it; with equal cylinders this is their own speed.
    """

    inner: float = 0.0
    outer: float = 0.0
    bottom: float | None = None
    top: float | None = None

    def couette(self, annulus: Annulus, radius: Floats) -> Floats:
        """Angular velocity of circular Couette flow relative to the rotor, rad/s."""
        a2, b2 = annulus.inner**2, annulus.outer**2
        slope = (self.inner - self.outer) * a2 * b2 / (b2 - a2)
        return np.asarray((self.outer * b2 - self.inner * a2) / (b2 - a2) + slope / radius**2, np.float64)

    def momentum(self, annulus: Annulus, radius: Floats, height: Floats) -> Matrix:
        """g = r^2 (W - w) on the walls, 0 inside; (radius, height), the ends of both are the walls."""
        g = np.zeros((radius.size, height.size))
        for column, lid in ((0, self.bottom), (-1, self.top)):
            g[:, column] = radius**2 * (self.couette(annulus, radius) if lid is None else lid)
        g[0], g[-1] = annulus.inner**2 * self.inner, annulus.outer**2 * self.outer
        return g


class RaceWalls(NamedTuple):
    """Radii of the walls of a race, its height, the orbit of its balls and the diameter of the largest of them, m."""

    inner: float
    outer: float
    height: float
    orbit_radius: float
    ball_diameter: float


def annulus_of(machine: Machine, balancer: int = 1, race: int = 1) -> Annulus:
    """The annulus of the ``race`` of a ``balancer`` of ``machine``, both counted from 1; see :func:`walls_of`.

    Raises
    ------
    MachineError
        If the race lacks width, height, fluid or the size of its balls, or if the gap is negative.
    QuestionError
        If there is no such race.
    """
    walls = walls_of(machine, balancer, race)
    fluid = machine.balancers[balancer - 1].races[race - 1].fluid
    if fluid is None:
        raise MachineError(f"balancers[{balancer}].races[{race}].fluid: missing; the flow in the race needs it")
    density, viscosity = fluid_numbers(fluid)
    return Annulus(*walls[:4], viscosity, density, sheared(fluid, viscosity))


def walls_of(machine: Machine, balancer: int = 1, race: int = 1) -> RaceWalls:
    """The walls of the ``race`` of a ``balancer`` of ``machine``, both counted from 1.

    ``width`` of a race is the radial distance of its walls, ``height`` that along the axis (Spannan 2021, table 6.2).
    The balls touch the outer wall, so b = orbit radius + ball radius and a = b - width; the gap between ball and inner
    wall is the width less the ball diameter.

    Raises
    ------
    MachineError
        If the race lacks width, height or the size of its balls, or if the gap is negative.
    QuestionError
        If there is no such race.
    """
    for name, number, size in (
        ("balancer", balancer, len(machine.balancers)),
        ("race", race, len(machine.balancers[balancer - 1].races) if 0 < balancer <= len(machine.balancers) else 0),
    ):
        if not 1 <= number <= size:
            raise QuestionError(f"{name}: given {number}; there are {size}, counted from 1")
    part = machine.balancers[balancer - 1].races[race - 1]
    where = f"balancers[{balancer}].races[{race}]"
    if part.width is None or part.height is None:
        lacking = next(key for key in ("width", "height") if getattr(part, key) is None)
        raise MachineError(f"{where}.{lacking}: missing; the flow in the race needs it")
    balls = [ball for ball in resolve(machine) if (ball.balancer, ball.race) == (balancer - 1, race - 1)]
    largest = max(balls, key=lambda ball: ball.diameter)
    if largest.diameter == 0.0:
        raise MachineError(
            f"{where}.balls: of unknown size; give 'diameter', because the outer wall of the annulus is a ball radius "
            "outside of the orbit"
        )
    outer = largest.orbit_radius + largest.radius
    inner = outer - float(part.width)
    if part.width < largest.diameter:
        raise MachineError(
            f"{where}.width: given {_mm(part.width)}, so the gap between the inner wall and a ball of "
            f"{_mm(largest.diameter)} is negative; must be at least the ball diameter"
        )
    if inner <= 0.0:
        raise MachineError(
            f"{where}.width: given {_mm(part.width)}, but the outer wall is at {_mm(outer)}; must be smaller, because "
            "an annulus has an inner wall"
        )
    return RaceWalls(inner, outer, float(part.height), largest.orbit_radius, largest.diameter)


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
