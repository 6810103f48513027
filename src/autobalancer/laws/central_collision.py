"""Energy error of a step size in an elastic collision of two equal balls: what a fixed step makes of the edge of a contact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalancer.laws.hertz import collision_time

Floats = NDArray[np.float64]
EXPONENT = 1.5  # of the force over the depth


def contact_time(speed: float, stiffness_over_mass: float) -> float:
    """Duration (s) of an elastic Hertz contact of two equal balls that meet at the relative ``speed`` (m/s).

    ``stiffness_over_mass`` is k/m (m^-0.5 s^-2) of one ball.
    """
    return collision_time(2.0 * stiffness_over_mass, 1.0, speed)


def edge_error(phase: Floats) -> Floats:
    """Error of the impulse at the edge of a contact under classical Runge-Kutta, as a share of (force rate) h^2.5.

    To leading order a ball crosses the edge in a straight line, and the scheme becomes Simpson's rule for (t - t0)_+^1.5 with
    the nodes of the steps and their middles. The Euler-Maclaurin formula for such an edge has Hurwitz' zeta function in
    place of Bernoulli numbers; the smooth interior adds terms of h^4 only.

    Parameters
    ----------
    phase
        Part of a step, in (0, 1], from the edge of the contact to the next end of a step inside it.
    """
    phase = np.asarray(phase, float)
    half = np.where(phase > 0.5, 2.0 * phase - 1.0, 2.0 * phase)
    half = np.where(half == 0.0, 1.0, half)
    fine = 4.0 * 0.5 ** (EXPONENT + 1.0) * zeta(-EXPONENT, half)
    return np.asarray((fine - zeta(-EXPONENT, phase)) / 3.0)


def energy_error(speed: float, step: float, stiffness_over_mass: float, entry: Floats, exit_: Floats) -> Floats:
    """Relative change of the kinetic energy in a head-on elastic collision under classical Runge-Kutta, leading order in h.

    An impulse that is too large takes energy where the balls still approach, at the ``entry``, and adds it where they part,
    at the ``exit_`` (phases as in :func:`edge_error`); both are as likely as their opposite. Pakuła (2021) tells of added
    energy only, which is one sample; so is the zero of his table at small steps, which is h^2.5 below the digits.
    """
    scale = 4.0 * stiffness_over_mass * np.sqrt(speed) * step**2.5
    return np.asarray(scale * (edge_error(exit_) - edge_error(entry)))


def zeta(order: float, start: Floats, terms: int = 12) -> Floats:
    """Hurwitz' zeta function for any real ``order`` but 1 and ``start`` above zero, by the Euler-Maclaurin formula."""
    start = np.asarray(start, float)
    total = np.zeros_like(start)
    for j in range(terms):
        total = total + (start + j) ** -order
    far = start + terms
    total = total + far ** (1.0 - order) / (order - 1.0) + 0.5 * far**-order
    rising = order
    for number, bernoulli in ((2, 1.0 / 6.0), (4, -1.0 / 30.0), (6, 1.0 / 42.0), (8, -1.0 / 30.0)):
        factorial = float(np.prod(np.arange(1.0, number + 1.0)))
        total = total + bernoulli / factorial * rising * far ** (1.0 - number - order)
        rising *= (order + number - 1.0) * (order + number)
    return np.asarray(total)
