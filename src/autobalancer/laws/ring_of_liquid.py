"""A ring partly filled with liquid that turns with a rotor: what the liquid does to it, in closed form.

In a steady whirl everything turns like a solid body about the axis of rotation in space, also the liquid, whatever its
viscosity: its surface is a circle about that axis, and its pressure rho w^2 (s^2 - b^2)/2 over the distance s. It loads the ring,
displaced by z, with w^2 S: as long as it covers the whole wall S = m z with the mass m = pi rho R^2 L that would fill the
circle of the wall, however little there is. A wall that falls dry carries only the area A(z) of the ring beyond the line between
the ends of the wet arc, S = rho L A z.

Small motions about the concentric state, liquid without viscosity: in the axes of the rotor the flow has the potential
(a r + c/r) e^(i (s t - phi)), s = W - w, and with a ring that whirls with W and q = R^2/b^2 the load is

    F = m W^2 (1 - 2 (W - w)^2 / D) z,    D = (1 + q) W^2 - 4 q w W + 2 q w^2.

It is S w^2 at W = w, that of the mass m for a full ring, and vanishes for an empty one. The motions of a rotor with it are the
four roots of (k - M W^2 - m W^2) D + 2 m W^2 (W - w)^2 = 0; two of them are complex above a critical speed (Wolf 1968).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.arrays import Floats
from autobalancer.roots import root


@dataclass(frozen=True)
class Ring:
    """``radius`` of the outer wall, ``height`` along the axis and thickness of the concentric ``layer`` (m), ``density`` of the
    liquid (kg/m^3); ``width`` to the inner wall (m), infinite without one."""

    radius: float
    height: float
    layer: float
    density: float
    width: float = math.inf

    @property
    def surface(self) -> float:
        """Radius of the surface of the concentric layer, m."""
        return self.radius - self.layer

    @property
    def mass(self) -> float:
        """Of the liquid, kg."""
        return math.pi * self.density * self.height * (self.radius**2 - self.surface**2)

    @property
    def full_mass(self) -> float:
        """That would fill the whole circle of the outer wall, kg: what the liquid adds to the rotor in a steady whirl."""
        return math.pi * self.density * self.height * self.radius**2

    def wet_radius(self, deflection: float) -> float:
        """Radius of the surface about the axis of rotation, m, at a ``deflection`` of the ring, m."""
        if deflection <= self.layer:
            return self.surface
        low, high = abs(self.radius - deflection), self.radius + deflection
        wanted = math.pi * self.surface**2
        return root(lambda b: self._dry(b, deflection) - wanted, low, high, xtol=1e-14 * high)

    def moment(self, deflection: float) -> float:
        """S, first moment of the liquid about the axis of rotation, kg m; not a number where its surface meets the inner wall."""
        surface = self.wet_radius(deflection)
        if surface - deflection < self.radius - self.width:
            return math.nan
        if deflection <= self.layer:
            return self.full_mass * deflection
        line, half = self._line(surface, deflection)
        area = self.radius**2 * math.acos(line / self.radius) - line * half
        return self.density * self.height * area * deflection

    def _line(self, surface: float, deflection: float) -> tuple[float, float]:
        """Distance from the center of the ring outward to the line through the ends of the wet arc, and half of this line, m."""
        line = (surface**2 - deflection**2 - self.radius**2) / (2.0 * deflection)
        line = min(max(line, -self.radius), self.radius)
        return line, math.sqrt(self.radius**2 - line**2)

    def _dry(self, surface: float, deflection: float) -> float:
        """Area within both circles, m^2."""
        line, half = self._line(surface, deflection)
        own = min(max((line + deflection) / surface, -1.0), 1.0)
        beyond = surface**2 * math.acos(own) - (line + deflection) * half
        return beyond + self.radius**2 * (math.pi - math.acos(line / self.radius)) + line * half


def whirl_speeds(rings: tuple[Ring, ...], mass: float, stiffness: float, speed: float, damping: float = 0.0) -> Any:
    """Whirl speeds W of small motions e^(i W t), rad/s, complex; growing where the imaginary part is negative.

    ``mass`` of the rotor without liquid (kg), ``stiffness`` and ``damping`` of its isotropic supports, ``speed`` of the rotor
    (rad/s). Source: derived here after Wolf (1968).
    """
    total = mass + sum(ring.full_mass for ring in rings)
    waves = [_wave(ring, speed) for ring in rings]
    product = np.array([-total + 0j, 1j * damping, stiffness])
    for wave in waves:
        product = np.polymul(product, wave)
    turned = np.polymul([1.0, 0.0, 0.0], np.polymul([1.0, -speed], [1.0, -speed]))
    for number, ring in enumerate(rings):
        others = np.array([2.0 * ring.full_mass])
        for other, wave in enumerate(waves):
            others = np.polymul(others, wave) if other != number else others
        product = np.polyadd(product, np.polymul(others, turned))
    return np.roots(product)


def growth_rate(rings: tuple[Ring, ...], mass: float, stiffness: float, speed: ArrayLike) -> Floats:
    """Greatest growth rate of small motions without any damping, 1/s; of the shape of ``speed`` (rad/s), zero if none grows."""
    speeds = np.asarray(speed, float)
    growth_rate = [_growth(whirl_speeds(rings, mass, stiffness, w), w) for w in speeds.ravel()]
    return np.array(growth_rate).reshape(speeds.shape)


def _growth(roots: Any, speed: float) -> float:
    rate = float(-np.min(roots.imag, initial=0.0))
    return rate if rate > 1e-6 * abs(speed) else 0.0  # a double root is known to half of the digits


def _wave(ring: Ring, speed: float) -> Floats:
    """D over W: the waves of the liquid in a ring at rest."""
    q = (ring.radius / ring.surface) ** 2
    return np.array([1.0 + q, -4.0 * q * speed, 2.0 * q * speed**2])
