"""The fluid of a deep chamber: how much of it covers the balls, and its force on them."""

from __future__ import annotations

import math

BLUNT = (
    0.44  # drag coefficient of a sphere at high Reynolds numbers (Newton; Clift, Grace and Weber 1978, below Re = 2e5)
)


def covering_fill(radius: float, ball_radius: float) -> float:
    """Share of a cylindrical chamber (radius, m) that must be fluid to cover balls (radius, m) on its wall at full speed.

    The fluid is then a ring with a free surface at the radius R sqrt(1 - fill). Balls displace some more, which is left out.
    """
    return 1.0 - max(1.0 - 2.0 * ball_radius / radius, 0.0) ** 2


def free_drag(viscosity: float, density: float, ball_radius: float) -> tuple[float, float]:
    """Force on a ball over its speed (N s/m) and over the square of it (N s^2/m^2), far from walls.

    ``viscosity`` is dynamic, Pa s; ``density`` that of the fluid. Stokes' force and Newton's are added: c_d = 24/Re + 0.44.
    """
    return 6.0 * math.pi * viscosity * ball_radius, 0.5 * BLUNT * density * math.pi * ball_radius**2
