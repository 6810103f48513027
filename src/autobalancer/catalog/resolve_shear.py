"""From the shear law of a fluid to its numbers at the temperature of the fluid, and to the drag on a ball in it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from autobalancer.catalog.fluid_families import ROOM
from autobalancer.catalog.fluid_table import fluid
from autobalancer.catalog.resolve_drag import law_of
from autobalancer.errors import QuestionError
from autobalancer.laws.liquid.sheared_drag import FASTEST, SLOWEST, Sheared, ShearedDragCurve, tried
from autobalancer.machine import Fluid, Race
from autobalancer.machine.balancer.drag import BallInRace
from autobalancer.machine.balancer.shear import ShearLaw

VELOCITIES = np.geomspace(SLOWEST, FASTEST, 1201)  # m/s


def sheared(part: Fluid, viscosity: float) -> Sheared | None:
    """The shear law of a fluid that has this kinematic ``viscosity`` (m^2/s) at rest; None if it has none.

    Raises
    ------
    CatalogError
        If the fluid is not available at the temperature of the measurement.
    QuestionError
        If the law is no viscosity.
    """
    law = part.shear
    if law is None:
        return None
    _tried(law)
    if law.measured_at is None or part.name is None:
        return Sheared(law)
    here, there = float(part.temperature or ROOM), float(law.measured_at)
    return Sheared(law, viscosity / fluid(part.name, there).viscosity * there / here)


def sheared_curve(
    race: Race, radius: float, orbit: float, numbers: tuple[float, float], shear: Sheared
) -> ShearedDragCurve:
    """Drag on a ball; ``numbers`` are density and viscosity at rest, SI.

    Raises
    ------
    QuestionError
        If the drag falls as a ball becomes faster.
    """
    assert race.fluid is not None
    assert race.fluid.shear is not None
    law = law_of(race.drag, BallInRace(radius, orbit))
    curve = ShearedDragCurve(law, *numbers, 2.0 * radius, shear, float(race.fluid.shear.at_ball or 0.0))
    falls = np.flatnonzero(np.diff(curve.force(VELOCITIES)) <= 0.0)
    if falls.size:
        raise QuestionError(
            f"fluid.shear gives less drag as a ball becomes faster, about {VELOCITIES[falls[0]]:.3g} m/s"
        )
    return curve


@lru_cache(maxsize=64)
def _tried(law: ShearLaw) -> None:
    tried(law, law.word())
