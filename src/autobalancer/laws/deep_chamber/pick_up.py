r"""When friction and fluid can lift a ball from the bottom of a chamber that turns and does not shake.

A ball slides on the race as long as it has not the spin of rolling, and the race runs ahead of it: friction is mu N, all the
way up. With the angle b from the bottom, the radius rho of its path and u = v^2 / (2 g rho), Newton's law is

    u' = 2 mu u + mu cos b - sin b + d,      d = (force of the fluid) / (m g),

linear in u. From rest at the bottom it gives

    u = A (cos b - e^(2 mu b)) + B sin b + d (e^(2 mu b) - 1) / (2 mu),
    A = (1 - 2 mu^2) / (1 + 4 mu^2),   B = 3 mu / (1 + 4 mu^2).

Friction can lift no more than that, for its sum is mu times that of the normal force, also if the ball hops, and the fluid is
slowest against a ball at rest. On 0 < b < 90 deg a ball that has stopped once would be stopped further up as well, so that
u(90 deg) >= 0 is the condition for passing the horizontal. Derived here.
"""

from __future__ import annotations

import math

from scipy.optimize import brentq

from autobalancer.errors import QuestionError


def lift(friction: float, drag_ratio: float = 0.0, angle: float = 0.5 * math.pi) -> float:
    """u of a ball that slid from rest at the bottom up to an ``angle`` (rad); negative if it does not get there.

    ``friction`` is the coefficient of sliding friction, ``drag_ratio`` the force of the fluid on a ball at rest over its weight;
    the ``angle`` is by default that of the height of the axis.

    Raises
    ------
    QuestionError
        If a number is negative.
    """
    if friction < 0.0 or drag_ratio < 0.0:
        raise QuestionError(f"friction, drag_ratio: given {friction:g}, {drag_ratio:g}; must not be below zero")
    growth, square = 2.0 * friction * angle, friction**2
    fluid = angle * (math.expm1(growth) / growth if growth else 1.0)
    even = (1.0 - 2.0 * square) * (math.cos(angle) - math.exp(growth))
    return (even + 3.0 * friction * math.sin(angle)) / (1.0 + 4.0 * square) + drag_ratio * fluid


def least_friction(drag_ratio: float = 0.0) -> float:
    """Least friction with which one ball passes the height of the axis on a calm rotor: 0.603 without a fluid.

    ``drag_ratio`` is the force of the fluid on a ball at rest over its weight; from 2/pi on no friction is needed.
    """
    if lift(0.0, drag_ratio) >= 0.0:
        return 0.0
    return float(brentq(lift, 0.0, 1.0, args=(drag_ratio,), xtol=1e-12))


def shaking(vibration: float, speed: float, gravity: float) -> float:
    """Acceleration of a whirl (m, rad/s) over that of gravity (m/s^2): above 1 balls leave the bottom of the chamber."""
    return vibration * speed**2 / gravity if gravity > 0.0 else math.inf
