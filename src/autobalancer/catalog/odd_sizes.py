"""Sizes that are possible, but so odd beside each other that a unit may be wrong."""

from __future__ import annotations

from autobalancer.catalog.resolve import Ball
from autobalancer.drag.race_geometry import AnnulusDrag
from autobalancer.machine import Machine

HIGH = 20.0  # height of a chamber over the diameter of its largest ball
NARROW, WIDE = 1e-3, 100.0  # clear width over ball radius


def odd_sizes(machine: Machine, balls: tuple[Ball, ...]) -> tuple[str, ...]:
    """Sentences about odd sizes, for ``check``."""
    found = []
    for b, balancer in enumerate(machine.balancers):
        for r, race in enumerate(balancer.races):
            largest = max((ball.diameter for ball in balls if (ball.balancer, ball.race) == (b, r)), default=0.0)
            place = f"balancers[{b + 1}].races[{r + 1}]"
            if race.height is not None and 0.0 < largest * HIGH < race.height:
                found.append(_odd(f"{place}.height", race.height, largest))
            drag = race.drag
            if isinstance(drag, AnnulusDrag) and not NARROW < 2.0 * drag.clear_width / max(largest, 1e-12) < WIDE:
                found.append(_odd(f"{place}.drag.clear_width", drag.clear_width, largest))
    return tuple(found)


def _odd(place: str, size: float, ball: float) -> str:
    return f"{place} is {1e3 * size:.4g} mm beside balls of {1e3 * ball:.4g} mm; is its unit right?"
