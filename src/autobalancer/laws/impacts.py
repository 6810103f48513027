"""Contact of a ball with another or with a wall that is curved in one direction (Hertz), and of a cylinder parallel to it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.roots import root

DURATION = (
    0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9)
)  # of a collision, in greatest depths over the speed


def reduced_modulus(youngs_modulus: float, poisson_ratio: float) -> float:
    """E* of two bodies of the same material, Pa."""
    return youngs_modulus / (2.0 * (1.0 - poisson_ratio**2))


STEEL = reduced_modulus(2.06e11, 0.3)  # Pa, of steel on steel


def pair_stiffness(reduced_modulus: float, first: float, second: float) -> float:
    """k of F = k d^(3/2) of two balls with these radii (m), N/m^(3/2)."""
    return 4.0 / 3.0 * reduced_modulus * math.sqrt(first * second / (first + second))


def collision_time(stiffness: float, mass: float, speed: float) -> float:
    """Duration of an elastic collision, s (Hertz 1882; Johnson 1985, (11.24)).

    ``mass`` is the reduced one, 1/m = 1/m1 + 1/m2, and ``speed`` the relative one before it.
    """
    return float(DURATION * (1.25 * mass * speed**2 / stiffness) ** 0.4 / speed)


def hertz_stiffness(reduced_modulus: float, radius: float, wall_radius: float = math.inf) -> float:
    """k of F = k d^(3/2), N/m^(3/2) (Johnson 1985, section 4.2).

    Parameters
    ----------
    reduced_modulus
        E*, Pa, with 1/E* = sum (1 - nu^2)/E over both bodies.
    radius
        Of the ball, m.
    wall_radius
        Of the cylindrical wall, m: positive where the ball runs inside, negative where it runs around it, infinite if flat.

    Raises
    ------
    QuestionError
        If the ball does not fit into its wall.
    """
    mean, axes, first, second = _ellipse(radius, wall_radius)
    if axes == 1.0:
        return 4.0 / 3.0 * reduced_modulus * math.sqrt(mean)
    size = _size(axes, first, second)
    shape = 2.0 / math.pi * math.sqrt(axes) / size ** (1.0 / 3.0) * first  # F2 of (4.26c)
    return float(4.0 / 3.0 * reduced_modulus * math.sqrt(mean) / shape**1.5)


def greatest_pressure(force: float, reduced_modulus: float, radius: float, wall_radius: float = math.inf) -> float:
    """Pressure in the middle of the contact of a ball with a wall, Pa (Johnson 1985, (4.24), (4.26)).

    ``force`` in N, the others as of :func:`hertz_stiffness`; of two equal balls that meet take ``radius`` half of theirs.
    """
    mean, axes, first, second = _ellipse(radius, wall_radius)
    size = 1.0 if axes == 1.0 else _size(axes, first, second)  # F1 cubed
    area = math.pi * (0.75 * force * mean / reduced_modulus * size) ** (2.0 / 3.0)
    return 1.5 * force / area if force > 0.0 else 0.0


def _ellipse(radius: float, wall_radius: float) -> tuple[float, float, float, float]:
    """Mean radius of curvature (m), axes of the contact b/a, and the elliptic integrals of first and second kind."""
    if 0.0 < wall_radius <= radius:
        raise QuestionError(f"wall_radius: given {wall_radius:g} m; must exceed the radius of the ball, {radius:g} m")
    across, along = 1.0 / radius, 1.0 / radius - 1.0 / wall_radius
    sharp, blunt = max(across, along), min(across, along)  # principal relative curvatures
    mean = 1.0 / math.sqrt(sharp * blunt)
    if sharp / blunt < 1.0 + 1e-9:
        return mean, 1.0, 0.5 * math.pi, 0.5 * math.pi

    from scipy.special import ellipe, ellipkm1

    def ratio(axes: float) -> float:  # of the curvatures that make an ellipse with these axes, b/a, (4.28)
        first, second = float(ellipkm1(axes**2)), float(ellipe(1.0 - axes**2))
        return (second / axes**2 - first) / (first - second)

    axes = root(lambda b: ratio(b) - sharp / blunt, 1e-6, 1.0 - 1e-6, xtol=1e-14)
    return mean, axes, float(ellipkm1(axes**2)), float(ellipe(1.0 - axes**2))


def _size(axes: float, first: float, second: float) -> float:
    """F1 of (4.26a) to the power of three: what the ellipse changes in the product of its axes."""
    root = math.sqrt((second / axes**2 - first) * (first - second))
    return float(4.0 / (math.pi * (1.0 - axes**2)) * axes**1.5 * root)


def line_stiffness(reduced_modulus: float, length: float) -> float:
    """k of F = k d along a line of this length (m), N/m.

    Half cylinders of any radius, to within their logarithm: pi/4 E* L (Popov 2010, (5.33)).
    """
    return 0.25 * math.pi * reduced_modulus * length


def end_stiffness(reduced_modulus: float, radius: float) -> float:
    """k of F = k d of a flat end with this radius (m) on a flat wall, N/m (Johnson 1985, (3.36))."""
    return 2.0 * reduced_modulus * radius


def linear_collision_time(stiffness: float, mass: float) -> float:
    """Duration of an elastic collision with a linear spring (N/m), at any speed, s; ``mass`` is the reduced one."""
    return math.pi * math.sqrt(mass / stiffness)


# Restitution: what an impact leaves of the speed, as metal yields and in a film of fluid; and the damper that leaves
# it.


LEAST = 0.01  # restitution below which a contact would be too stiff


def damping_ratio(restitution: float) -> float:
    """Damping ratio of a spring and a damper that never pull, from the ratio of the speeds after and before.

    Below exp(-2) it is above one. A ratio under 1 % counts as 1 %, which takes a damping ratio of about five.
    """
    if restitution >= 1.0:
        return 0.0
    wanted, low, high = max(restitution, LEAST), 0.0, 20.0
    while low < (middle := 0.5 * (low + high)) < high:  # to the last digit; the rebound falls as the ratio grows
        low, high = (middle, high) if rebound(middle) > wanted else (low, middle)
    return high


def rebound(ratio: float) -> float:
    """Ratio of the speeds after and before, for a damping ratio.

    The contact ends where the force is zero, before the spring is long again (Schwager and Pöschel 2007, equations 9, 13):
    ln e = -z/sqrt(1 - z^2) (pi - atan2(2 z sqrt(1 - z^2), 1 - 2 z^2)), for z > 1 -2 z/sqrt(z^2 - 1) arcosh(z).
    """
    if abs(ratio - 1.0) < 1e-9:
        return math.exp(-2.0)
    root = math.sqrt(abs(1.0 - ratio * ratio))
    if ratio > 1.0:
        return math.exp(-2.0 * ratio / root * math.acosh(ratio))
    return math.exp(-ratio / root * (math.pi - math.atan2(2.0 * ratio * root, 1.0 - 2.0 * ratio * ratio)))


def hertz_damping_ratio(restitution: float) -> float:
    """The number a of a damper a sqrt(m k) d^(1/4) d' beside F = k d^(3/2) that leaves this share of the speed.

    The same as for a spring but for the factor sqrt(5) in place of 2 (Antypov and Elliott 2011), the end of the contact where
    the force is zero included: in d^(5/4) and a time of its own the motion is that of the spring and its damper.
    """
    return math.sqrt(5.0) * damping_ratio(restitution)


def yielding_factor(speed: Any, yield_speed: float, exponent: float = 0.25) -> Floats:
    """Restitution over that of slow impacts, (yield_speed/v)^exponent above the ``yield_speed`` (m/s), 1 below.

    The exponent 1/4 follows where the whole contact has yielded (Johnson 1985, section 11.5). The formula of Thornton (1997)
    tends to 1.18 (v_y/v)^(1/4): the ``yield_speed`` that agrees with it at high speed is 1.97 of his v_y, :func:`first_yield`.
    """
    speed = np.asarray(speed, np.float64)
    return np.asarray((yield_speed / np.maximum(speed, yield_speed)) ** exponent, np.float64)


def first_yield(yield_stress: float, reduced_modulus: float, density: float) -> float:
    """Speed at which a ball that hits a flat wall begins to yield, m/s: 1.56 sqrt(Y^5/(E*^4 rho)) (Thornton 1997).

    ``yield_stress`` is the contact pressure at first yield (Pa), 1.6 times the yield strength in tension by von Mises;
    ``reduced_modulus`` E* (Pa), ``density`` of the ball (kg/m^3).
    """
    # kinetic energy m v^2/2 = 8/15 E* sqrt(R) d^(5/2) at the depth where the pressure 2 E* sqrt(d/R)/pi reaches Y
    root = 0.5 * math.pi * yield_stress / reduced_modulus  # sqrt(d/R)
    return float(math.sqrt(0.8 * reduced_modulus / (math.pi * density)) * root**2.5)


def stokes_number(speed: Any, mass: float, radius: float, viscosity: float) -> Any:
    """St = m v/(6 pi mu a^2) of bodies that approach at the ``speed`` v (m/s) in a fluid of the dynamic ``viscosity`` mu (Pa s).

    ``mass`` and ``radius`` are reduced: 1/m = 1/m_1 + 1/m_2, 1/a = 1/a_1 + 1/a_2; of a ball at a wall its own, which gives
    rho d v/(9 mu) (Davis et al. 1986; Joseph et al. 2001).
    """
    return mass * speed / (6.0 * math.pi * viscosity * radius**2)


def wet_factor(stokes: Any, critical: float) -> Floats:
    """Restitution in a fluid over the dry one at these ``stokes`` numbers, 1 - St_c/St; none below the ``critical`` one.

    From lubrication theory (Davis et al. 1986; Barnocky and Davis 1988). Measured: no rebound below St of about 10, that of a dry
    impact above 500 (Joseph et al. 2001; Gondret et al. 2002).
    """
    stokes = np.asarray(stokes, np.float64)
    return np.asarray(1.0 - critical / np.maximum(stokes, critical), np.float64)


def slowest_rebound(critical: float, mass: float, radius: float, viscosity: float) -> float:
    """The speed below which bodies in a fluid do not rebound, m/s: that of the ``critical`` Stokes number."""
    return critical / float(stokes_number(1.0, mass, radius, viscosity))


# Energy error of a step size in an elastic collision of two equal balls: what a fixed step makes of the edge of a
# contact.


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


# Two balls of one race that touch: where they press, and how they rub while they roll.
#
# Ball i rolls with the spin -eps_i phi_i'/r_i as seen from its race, so it turns about the point of the wall it stands
# on. With e from the center of ball 1 to that of ball 2 and n_i outward, sin a_1 = -e.n_1 and sin a_2 = e.n_2. At
# their contact the surface of ball 1 moves along e turned by -90 degrees with eps_1 (1 + sin a_1) phi_1', that of ball
# 2 with -eps_2 (1 + sin a_2) phi_2', so that they slip with
#
#     v = l_1 phi_1' + l_2 phi_2',    l_1 = eps_1 (1 + sin a_1) = 2 R r_2/(r_1 + r_2),    l_2 = 2 R r_1/(r_1 + r_2),
#
# R = eps_i + r_i the radius of the wall, which is the arm of equal balls. A friction force f against the slip takes
# the torque f l_i from each ball, by virtual work; the rotor feels nothing of it, as no slip comes from its motion.
# The force F along e that presses the balls has the torque F eps_i cos a_i, the same for both, and presses each onto
# the wall with F sin a_i; friction presses ball 2 onto it, and ball 1 off it, with f cos a_i. Derived here; a resolved
# ball has all of it by itself.


class TouchingBalls(NamedTuple):
    """Geometry of a contact; the first of each pair is of the ball at the smaller angle."""

    arms: tuple[float, float]  # l_i: slip over ball speed, and torque over friction force, m
    outward: tuple[float, float]  # sin a_i: force onto the wall over force that presses the balls
    force: float  # force that presses the balls over its torque on either, 1/m


def touching_balls(orbits: tuple[float, float], radii: tuple[float, float]) -> TouchingBalls:
    """Geometry of two balls that touch, from their ``orbits`` (radii of the paths of their centers) and ``radii``, m."""
    apart = radii[0] + radii[1]
    difference = orbits[0] ** 2 - orbits[1] ** 2
    sines = (
        (apart**2 + difference) / (2.0 * apart * orbits[0]),
        (apart**2 - difference) / (2.0 * apart * orbits[1]),
    )
    return TouchingBalls(
        arms=(orbits[0] * (1.0 + sines[0]), orbits[1] * (1.0 + sines[1])),
        outward=sines,
        force=1.0 / (orbits[0] * math.sqrt(1.0 - sines[0] ** 2)),
    )


# Thin film between a ball and the wall on which it runs: how force and torque grow as the gap closes.
#
# The gap is h = delta + x^2/(2 A) + z^2/(2 B) with 1/A = 1/r - 1/R_x, 1/B = 1/r - 1/R_z; R are the radii of a hollow
# wall along and across the race. Reynolds' equation with walls that move with v_wall and v_ball along x has the exact
# solution p = -6 mu V x / ((3 + 2 A/B) h^2), V = v_wall + v_ball, so that with S = (A B)^(1/2) every unit of
# ln(1/delta) adds
#
#     force on the ball    2 pi mu S (v_wall - v_ball + 3 V / (3 + 2 A/B)),
#     torque / r           2 pi mu S (v_wall - v_ball - 3 V / (3 + 2 A/B)),
#
# the torque counted so that a force along x at the place of contact has a positive one. For a plane wall these are the
# logarithms of Goldman, Cox and Brenner (1967): 8/15, 2/15, 1/10 and 2/5.


class FilmSlopes(NamedTuple):
    """Change per unit of ln(1/gap): ``force`` over mu r U, ``torque`` over mu r^2 U."""

    force: float
    torque: float


def film_slopes(
    ball_velocity: float, wall_velocity: float = -1.0, race_radius: float = math.inf, groove_radius: float = math.inf
) -> FilmSlopes:
    """Force and torque on a ball per unit of ln(1/gap).

    Parameters
    ----------
    ball_velocity, wall_velocity
        Of both surfaces at the contact along the race, in the frame of the ball center and in units of its speed U: 0 and -1 for
        a ball that slides, -1 and -1 for one that rolls.
    race_radius, groove_radius
        Radii of the hollow wall along and across the race, in ball radii; infinite for a straight one.

    Raises
    ------
    QuestionError
        If a radius is not larger than that of the ball.
    """
    for name, radius in (("race_radius", race_radius), ("groove_radius", groove_radius)):
        if not radius > 1.0:
            raise QuestionError(f"{name}: given {radius:g} ball radii; a ball fits into larger radii than its own only")
    along, across = 1.0 / (1.0 - 1.0 / race_radius), 1.0 / (1.0 - 1.0 / groove_radius)
    shear = wall_velocity - ball_velocity
    wedge = 3.0 * (wall_velocity + ball_velocity) / (3.0 + 2.0 * along / across)
    size = 2.0 * math.pi * math.sqrt(along * across)
    return FilmSlopes(size * (shear + wedge), size * (shear - wedge))
