"""Contact of a ball with another or with a wall that is curved in one direction (Hertz), and of a cylinder parallel to it."""

from __future__ import annotations

import math

from autobalancer.errors import QuestionError

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

    from scipy.optimize import brentq  # only where needed: it takes a tenth of a second to load
    from scipy.special import ellipe, ellipkm1

    def ratio(axes: float) -> float:  # of the curvatures that make an ellipse with these axes, b/a, (4.28)
        first, second = float(ellipkm1(axes**2)), float(ellipe(1.0 - axes**2))
        return (second / axes**2 - first) / (first - second)

    axes = float(brentq(lambda b: ratio(b) - sharp / blunt, 1e-6, 1.0 - 1e-6, xtol=1e-14))
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
