"""What a race off the axis leaves, however well its balls balance: they bring the center of the race to rest, not the axis.

Spannan (2021), section 4.2.4: on isotropic supports the axis then whirls at the eccentricity. Where the machine has none, a
typical one is taken.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.place_response import off_center_unbalances
from autobalancer.assembly.places import Places
from autobalancer.catalog.resolve import Ball
from autobalancer.catalog.run_out import RING, TURNED, TURNED_ECCENTRICITY, ring_eccentricity
from autobalancer.results.number_text import length_text, moment_text


@dataclass(frozen=True)
class OffCenterPlane:
    """A plane of balancers: eccentricity of its races (the greatest, or a typical one) and vibration of the axis, m.

    ``residual`` (kg m) is the unbalance that stays in this plane while all races are at rest: of given eccentricities
    what they leave, of typical ones the most, over their directions; nan where the races cannot all be at rest. ``source``
    says where a typical eccentricity comes from.
    """

    name: str
    given: bool
    eccentricity: float
    residual: float
    source: str = ""


@dataclass(frozen=True)
class OffCenter:
    """The planes of a machine at a steady speed (rad/s)."""

    speed: float
    planes: tuple[OffCenterPlane, ...]

    @property
    def greatest(self) -> float:
        """The greatest eccentricity, m."""
        return max((plane.eccentricity for plane in self.planes), default=0.0)

    @property
    def given(self) -> bool:
        """Whether the machine gives the eccentricity of some race in each plane."""
        return all(plane.given for plane in self.planes)

    @property
    def sentence(self) -> str:
        """All that in words; empty for races that are said to be centered."""
        planes = [plane for plane in self.planes if plane.eccentricity > 0.0]
        if not planes:
            return ""
        unknown = not all(plane.given for plane in planes)
        several = len(self.planes) > 1
        parts = [
            f"{length_text(plane.eccentricity)}{f' at {plane.name}' if several else ''} "
            f"{'leaves' if plane.given else 'would leave'} a vibration of {length_text(plane.eccentricity)}"
            + (
                f" and {'up to ' * (several and unknown)}{moment_text(plane.residual)} of unbalance"
                if np.isfinite(plane.residual)
                else ""
            )
            for plane in planes
        ]
        sources = " or ".join(dict.fromkeys(plane.source for plane in planes if not plane.given))
        begin = f"not given{' everywhere' * any(p.given for p in planes)}; typical is {sources}: " if unknown else ""
        return begin + "; ".join(parts) + ", however well the balls balance"


def off_center(places: Places, balls: tuple[Ball, ...], speed: float) -> OffCenter | None:
    """The eccentricities of a machine and what they leave at a speed (rad/s); None without balls."""
    if not balls:
        return None
    given, greatest, fixed, sources = zip(
        *(_plane([ball for ball, p in zip(balls, places.plane_of_ball, strict=True) if p == i], places)
          for i in range(len(places.planes))),
        strict=True,
    )  # fmt: skip
    effect = off_center_unbalances(places, speed)
    known = np.array(given, bool)
    left = np.abs(effect[:, known] @ np.array(fixed)[known]) + np.abs(effect[:, ~known]) @ np.array(greatest)[~known]
    return OffCenter(
        float(speed),
        tuple(
            OffCenterPlane(name, bool(one), float(offset), float(residual), source)
            for name, one, offset, residual, source in zip(places.planes, given, greatest, left, sources, strict=True)
        ),
    )


def _plane(balls: list[Ball], places: Places) -> tuple[bool, float, complex, str]:
    """Whether an eccentricity is given, the greatest one or a typical one, the given one with its direction, m, and a source."""
    races = [places.machine.balancers[ball.balancer].races[ball.race] for ball in balls]
    if any("eccentricity" in race.model_fields_set for race in races):
        offset = max((ball.eccentricity for ball in balls), key=abs)
        return True, abs(offset), offset, ""
    if any(race.bearing is None for race in races):
        return False, TURNED_ECCENTRICITY, 0j, TURNED
    size = max((2.0 * ball.orbit_radius + ball.diameter for ball in balls), default=0.0)
    return False, ring_eccentricity(size), 0j, RING
