"""Which |S2|, S2 = sum of e^(2 i phi), equal balls can have while they balance a given unbalance.

Exact stability depends on the ball positions through |S2| only. Two balls have no choice; more balls have a continuum.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from autobalancer.patience import still_time
from autobalancer.stability.host.planar import Complexes, Floats

POINTS = 361  # directions that are tried for the first group of balls


def spread_of_two(share: Floats) -> Floats:
    """|S2| of two balls whose unit vectors add up to ``share`` (0 to 2)."""
    return np.asarray(np.abs(np.asarray(share, np.float64) ** 2 - 2.0))


@lru_cache(maxsize=1024)
def spread_range(count: int, share: float) -> tuple[float, float]:
    """Least and greatest |S2| of ``count`` unit vectors that add up to ``share``, 0 <= share <= count.

    Balls in three groups, each in one direction, are tried in all sizes and directions of the groups: where |S2| is
    extreme its multipliers leave few directions. The least one is known in closed form for an even count,
    max(0, 2 share^2/N - N): sum cos^2 >= (sum cos)^2/N, reached by balls at two angles. An odd count reaches zero if
    one ball along the unbalance and pairs beside it can have S2 of both signs.
    """
    if count == 2:
        value = float(spread_of_two(np.array(share)))
        return value, value
    if share >= count * (1.0 - 1e-12):
        return float(count), float(count)
    low, high = np.inf, 0.0
    for groups in _groups(count):
        still_time()
        angles = np.linspace(0.0, np.pi, POINTS)
        values = _spreads(np.exp(1j * angles), groups, share)
        if np.isnan(values).all():
            continue
        least, most = (
            np.unravel_index(np.nanargmin(values), values.shape),
            np.unravel_index(np.nanargmax(values), values.shape),
        )
        if values[least] < low + 0.02 * count:
            low = min(low, _refined(angles, int(least[1]), groups, share, 1.0))
        if values[most] > high - 0.02 * count:
            high = max(high, -_refined(angles, int(most[1]), groups, share, -1.0))
    if count % 2 == 0:
        low = max(0.0, 2.0 * share**2 / count - count)
    elif any(_symmetric_zero(count, share, first) for first in (1.0, -1.0)):
        low = 0.0
    return float(low), float(high)


def _groups(count: int) -> list[tuple[int, int, int]]:
    """Sizes of three groups; the second and third change places without effect."""
    return [
        (first, second, count - first - second)
        for first in range(1, count - 1)
        for second in range(1, (count - first) // 2 + 1)
    ]


def _spreads(first: Complexes, groups: tuple[int, int, int], share: float) -> Floats:
    """|S2| over the direction of the first group, for both ways to close the sum with the others; nan if none does."""
    a, b, c = groups
    rest = share - a * first
    size = np.abs(rest)
    possible = (size <= b + c) & (size >= abs(b - c)) & (size > 1e-12)
    size = np.where(possible, size, 1.0)
    cosine = np.clip((size**2 + b * b - c * c) / (2.0 * size * b), -1.0, 1.0)
    opening = np.exp(1j * np.arccos(cosine))
    along = rest / size
    rows = []
    for turn in (opening, opening.conj()):
        second = along * turn
        third = (rest - b * second) / c
        rows.append(np.where(possible, np.abs(a * first**2 + b * second**2 + c * third**2), np.nan))
    return np.array(rows)


def _refined(angles: Floats, place: int, groups: tuple[int, int, int], share: float, sign: float) -> float:
    """The extreme value near a grid point, times ``sign``."""
    from scipy.optimize import minimize_scalar

    def value(angle: float) -> float:
        found = sign * _spreads(np.exp(1j * np.array([angle])), groups, share)
        return float(np.nanmin(found)) if np.isfinite(found).any() else float(groups[0] + groups[1] + groups[2])

    low, high = angles[max(place - 1, 0)], angles[min(place + 1, POINTS - 1)]
    best = minimize_scalar(value, bounds=(float(low), float(high)), method="bounded", options={"xatol": 1e-10})
    return float(min(best.fun, value(float(angles[place]))))


def _symmetric_zero(count: int, share: float, first: float) -> bool:
    """One ball at 0 or 180 deg, pairs with cosines c beside it: whether 1 + 4 sum c^2 - (N - 1) can be zero."""
    pairs, total = (count - 1) // 2, 0.5 * (share - first)
    if abs(total) > pairs:
        return False
    least = total**2 / pairs
    whole = int(np.floor(0.5 * (pairs + abs(total))))  # pairs at the limit +1; the others at -1 but for one between
    left = min(pairs - whole, 1)
    between = abs(total) - whole + (pairs - whole - left)
    most = pairs - left + left * between**2
    goal = 0.25 * (count - 2.0)
    return bool(least <= goal <= most)
