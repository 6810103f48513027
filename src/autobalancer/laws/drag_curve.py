"""Drag force on a ball of a size in a fluid, against its velocity."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from autobalancer.errors import RangeWarning, warn
from autobalancer.laws.drag_coefficient import DragLaw, Floats
from autobalancer.units import field_arguments

STOKES = 10.0  # Reynolds number up to which drag is linear near a wall (Jan and Chen 1997; Spannan 2021, 5.21)


def stokes_record(reynolds: float) -> dict[str, Any]:
    """What to keep with a result whose drag is the linear range of a law at any speed, and whose balls reached ``reynolds``.

    A sentence in ``drag_warning`` where that is beyond the range, which is then also given as a ``RangeWarning``.
    """
    text = ""
    if reynolds > STOKES:
        text = (
            f"the Reynolds number of a ball reaches {reynolds:.3g}, but drag is linear up to about {STOKES:g} and "
            "greater beyond; set range = 'whole' in the drag of the race (the law cd_re then needs its plateau, too)"
        )
        warn(text, RangeWarning)
    return {"drag_reynolds": reynolds, "drag_reynolds_limit": STOKES, "drag_warning": text}


@dataclass(frozen=True)
class DragCurve:
    """A law for a ball of ``diameter`` (m) in a fluid of ``density`` (kg/m^3) and kinematic ``viscosity`` (m^2/s)."""

    law: DragLaw
    density: float
    viscosity: float
    diameter: float

    def __post_init__(self) -> None:
        field_arguments(self, density="kg/m^3", viscosity="m^2/s", diameter="m")

    @property
    def viscous(self) -> float:
        """Force over velocity in the Stokes range, N s/m; beta over the square of the orbit radius."""
        return math.pi / 8.0 * self.density * self.viscosity * self.diameter * self.law.cd_re

    def reynolds(self, velocity: ArrayLike) -> Floats:
        """Reynolds number, speed times diameter over nu; ``velocity`` in m/s, relative to the fluid."""
        return np.asarray(np.abs(np.asarray(velocity, dtype=float)) * self.diameter / self.viscosity)

    def force(self, velocity: ArrayLike) -> Floats:
        """Drag, N, along a velocity of the fluid relative to the ball, m/s; odd, of the shape of ``velocity``."""
        share = self.law.product(self.reynolds(velocity)) / self.law.cd_re
        return np.asarray(self.viscous * share * np.asarray(velocity, dtype=float))

    def torque(self, slip: ArrayLike, orbit_radius: float) -> Floats:
        """Drag torque, N m, on a ball that circles slower than the fluid by ``slip`` (rad/s)."""
        return orbit_radius * self.force(orbit_radius * np.asarray(slip, dtype=float))

    def points(
        self, first: float | None = None, last: float | None = None, per_decade: int = 50
    ) -> tuple[Floats, Floats, Floats]:
        """The curve on a uniform grid in the logarithm of velocity, for cubic interpolation.

        Parameters
        ----------
        first, last
            Reynolds numbers between which; by default the ends of the shape of the law. Below it is linear, above it c_d
            is kept, so these need no points, and what bends at an end is followed exactly.
        per_decade
            Least number of points for each factor of ten.

        Returns
        -------
        tuple
            Log of velocities (m/s), log of forces (N), and slopes d log F per step of the grid, each of shape (count,).
        """
        low, high = first or self.law.stokes_end, last or self.law.kept_from
        steps = max(math.ceil(per_decade * math.log10(high / low) - 1e-9), 1)
        log_re = np.linspace(math.log(low), math.log(high), steps + 1)
        re = np.exp(log_re)
        re[0], re[-1] = low, high
        log_velocity = log_re + math.log(self.viscosity / self.diameter)
        log_force = np.log(self.viscous * self.law.product(re) / self.law.cd_re) + log_velocity
        return log_velocity, log_force, (2.0 + self.law.log_slope(re)) * (log_re[-1] - log_re[0]) / steps

    def range_record(self, velocity: float) -> dict[str, Any]:
        """Attributes to store with a result in which the greatest relative velocity was ``velocity`` (m/s).

        Names of law and source, the greatest Reynolds number, that up to which the law holds, and a sentence in
        ``drag_warning`` if it was exceeded, which is then also given as a ``RangeWarning``.
        """
        reynolds = float(self.reynolds(velocity))
        text = self.law.outside(reynolds)
        if text:
            warn(text, RangeWarning)
        return {
            "drag_law": self.law.name,
            "drag_source": self.law.source,
            "drag_reynolds": reynolds,
            "drag_reynolds_limit": self.law.highest,
            "drag_warning": text,
        }
