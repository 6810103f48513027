"""How much room balls and cylinders take, and how far they are from each other."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.distance import cdist

from autobalancer.machine.chamber import FreeBalls

Array = Any


class Sizes(NamedTuple):
    """Of each ball (n,): radius and half of what it takes along the rotor, m; 1 for a cylinder, 0 for a ball."""

    radius: Array
    half: Array
    flat: Array


def sizes_of(group: FreeBalls, count: int) -> Sizes:
    """Of ``count`` balls of a group."""
    return Sizes(
        *(np.full(count, value) for value in (group.radius, group.half_width, float(group.body == "cylinder")))
    )


def together(sizes: list[Sizes]) -> Sizes:
    """Of several groups, one after the other."""
    return Sizes(*(np.concatenate(parts) for parts in zip(*sizes, strict=True)))


def gaps(one: Array, own: Sizes, others: Array, sizes: Sizes, air: float = 1.0) -> Array:
    """Distances (k, n) of the surfaces of balls or cylinders at ``one`` (k, 3) and ``others`` (n, 3), m.

    Negative where they overlap; with ``air`` above one they count as that much larger.
    """
    both = air * (own.radius[:, None] + sizes.radius)
    if not own.flat.any():
        return cdist(one, others) - both
    across = cdist(one[:, 1:], others[:, 1:]) - both
    along = cdist(one[:, :1], others[:, :1]) - air * (own.half[:, None] + sizes.half)
    return np.maximum(across, along)


def sized(group: FreeBalls, *, plural: bool = True) -> str:
    """Balls or cylinders with their size, for a message."""
    many = "s" * plural
    if group.length is None:
        return f"ball{many} of {2e3 * group.radius:.4g} mm"
    return f"cylinder{many} of {2e3 * group.radius:.4g} mm by {1e3 * group.length:.4g} mm"
