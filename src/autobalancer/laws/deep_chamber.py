"""What a deep chamber can do at best, in closed form: pick-up, settling, residual."""

from __future__ import annotations

import cmath
import math

from autobalancer.errors import QuestionError
from autobalancer.roots import root

# The fluid of a deep chamber: how much of it covers the balls, and its force on them.


def covering_fill(radius: float, ball_radius: float) -> float:
    """Share of a cylindrical chamber (radius, m) that must be fluid to cover balls (radius, m) on its wall at full speed.

    The fluid is then a ring with a free surface at the radius R sqrt(1 - fill). Balls displace some more, which is left out.
    """
    return 1.0 - max(1.0 - 2.0 * ball_radius / radius, 0.0) ** 2


# When friction and fluid can lift a ball from the bottom of a chamber that turns and does not shake.
#
# A ball slides on the race as long as it has not the spin of rolling, and the race runs ahead of it: friction is mu N,
# all the way up. With the angle b from the bottom, the radius rho of its path and u = v^2 / (2 g rho), Newton's law is
#
#     u' = 2 mu u + mu cos b - sin b + d,      d = (force of the fluid) / (m g),
#
# linear in u. From rest at the bottom it gives
#
#     u = A (cos b - e^(2 mu b)) + B sin b + d (e^(2 mu b) - 1) / (2 mu),
#     A = (1 - 2 mu^2) / (1 + 4 mu^2),   B = 3 mu / (1 + 4 mu^2).
#
# Friction can lift no more than that, for its sum is mu times that of the normal force, also if the ball hops, and the
# fluid is slowest against a ball at rest. On 0 < b < 90 deg a ball that has stopped once would be stopped further up
# as well, so that u(90 deg) >= 0 is the condition for passing the horizontal. Derived here.


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
    return root(lambda share: lift(share, drag_ratio), 0.0, 1.0, xtol=1e-12)


def shaking(vibration: float, speed: float, gravity: float) -> float:
    """Acceleration of a whirl (m, rad/s) over that of gravity (m/s^2): above 1 balls leave the bottom of the chamber."""
    return vibration * speed**2 / gravity if gravity > 0.0 else math.inf


# How fast the balls of a balanced rotor can come to rest, and what gravity and rolling resistance leave.
#
# Small motions s of equal balls along the race of a rotor far above its critical speeds. The whirl of the rotor, -U/M
# with the unbalance U that is left, pushes each ball along the race with m w^2 times it, so that with n balls
#
#     j m s'' + c s' + k (m^2 w^2 / M) s = 0,      j = 7/5 for a ball that rolls,
#
# for each of the two patterns of motion that change U; their k sum up to n, so the slower one has at most n/2. c is
# the drag. Its decay rate is greatest where the two roots meet, and falls on both sides: with little drag the balls
# swing, with much they creep.
#
# Gravity moves each ball that rolls to and fro in the rotor, once in a turn, by (5/7) g/w^2. Rolling resistance f N /
# r with N = m w^2 rho makes that less, and where it does not stop the swing, the swing smooths it: a small drift v
# feels (2/pi) (v/v0) of it, with the speed v0 of the swing, which is a drag too. Derived here.


ROLLING = 1.4  # inertia of a rolling ball over its mass


def best_drag(ball_mass: float, count: int, moved_mass: float, speed: float) -> float:
    """Drag over the speed of a ball (N s/m) with which the balls come to rest soonest; SI in."""
    return 2.0 * ball_mass * math.sqrt(ROLLING * _stiffness(ball_mass, count, moved_mass)) * speed


def decay_rate(drag: float, ball_mass: float, count: int, moved_mass: float, speed: float) -> float:
    """Rate (1/s) at which the slower pattern of motion decays, at most; ``drag`` (N s/m) over the speed of a ball.

    ``moved_mass`` (kg) is M: an unbalance over the whirl that it makes.
    """
    damping, stiffness = drag / ball_mass, _stiffness(ball_mass, count, moved_mass) * speed**2
    root = cmath.sqrt(damping**2 - 4.0 * ROLLING * stiffness)
    return (damping - root.real) / (2.0 * ROLLING)


def best_decay_rate(drag: float, ball_mass: float, count: int, moved_mass: float, speed: float) -> float:
    """The same with any friction in addition: that brings a thin fluid to the best drag at most, and slows a thick one."""
    best = best_drag(ball_mass, count, moved_mass, speed)
    return decay_rate(max(drag, best), ball_mass, count, moved_mass, speed)


def _stiffness(ball_mass: float, count: int, moved_mass: float) -> float:
    """Over the mass of a ball and the square of the speed."""
    return 0.5 * count * ball_mass / moved_mass


def swing(gravity: float, speed: float, resistance: float = 0.0) -> float:
    """Amplitude (m) with which gravity moves a rolling ball to and fro along the race, once in a turn.

    ``resistance`` is the force of rolling resistance over the mass of the ball, F (m/s^2). From one turning point to the
    next, half a period later, s'' = (g cos(w t + p) - F) / j; that the speed is zero at both asks for sin p = -pi F / (2 g), and
    the way between them is 2 g cos p / (j w^2). Exact while the ball turns without a stop, up to F = 0.54 g.
    """
    left = 1.0 - (0.5 * math.pi * resistance / gravity) ** 2 if gravity > 0.0 else 0.0
    return gravity * math.sqrt(max(left, 0.0)) / (ROLLING * speed**2)


def swung_residual(ball_masses: float, amplitude: float) -> float:
    """Mean residual unbalance (kg m), at least, while balls of this mass together (kg) swing by ``amplitude`` (m).

    A ball at the angle a swings by s cos(w t + a) along the race, which adds i m s/2 (e^(-i w t) + e^(i (w t + 2 a))) in the
    rotor. The first terms of all balls are equal. The mean size of a sum of turning vectors is at least that of each, so
    that neither the second terms nor a constant unbalance lower it. In space the first ones are a constant force: they
    count as unbalance, but shake nothing.
    """
    return 0.5 * ball_masses * amplitude


def smoothed_drag(resistance: float, gravity: float, speed: float) -> float:
    """Drag over the mass (1/s) that rolling resistance (a force over the mass, m/s^2) has for a slow drift of a ball that swings.

    Infinite where it holds the ball.
    """
    amplitude = swing(gravity, speed, resistance)
    return 2.0 / math.pi * resistance / (amplitude * speed) if amplitude > 0.0 else math.inf
