"""Where balls stand that add up to a given sum, and exact stability of those at right angles in closed form."""

from __future__ import annotations

import cmath
import math
from functools import lru_cache

import numpy as np

from autobalancer.arrays import Complexes, Floats
from autobalancer.progress import check_deadline
from autobalancer.roots import least
from autobalancer.stability.host.stations import Plane

SAME = 1e-5 + 1e-9  # distance of directions, as unit vectors, of balls that are at one place
PATTERNS = 4096  # at most so many ways of placing balls on the two sides are gone through


def close_polygon(lengths: Floats, target: complex) -> list[Floats]:
    """Directions in which vectors of these lengths add up to ``target``; both mirror images, empty if they cannot.

    For more than two vectors one pair out of the continuum is returned.
    """
    reach, size = float(lengths.sum()), abs(target)
    longest = float(lengths.max()) if lengths.size else 0.0
    slack = 1e-12 * max(reach, size)
    if size > reach + slack or size < 2.0 * longest - reach - slack or lengths.size < 2:
        if lengths.size == 1 and abs(size - reach) <= slack:
            return [np.array([cmath.phase(target)])]
        return []
    if lengths.size == 2:
        a, b = lengths
        cosine = (size**2 + a**2 - b**2) / (2.0 * size * a) if size > 0.0 else 0.0
        opening = math.acos(min(max(cosine, -1.0), 1.0))
        result = []
        for side in (1.0, -1.0):
            first = cmath.phase(target) + side * opening
            second = cmath.phase(target - a * cmath.exp(1j * first))
            result.append(np.array([first, second]))
        same = (np.abs(np.exp(1j * result[0]) - np.exp(1j * result[1])) <= SAME).all()
        return result[:1] if same else result
    opened = directions(lengths, target)
    return [] if opened is None else [opened, 2.0 * cmath.phase(target) - opened]


# Directions of vectors of given lengths that add up to a given sum.


def directions(lengths: Floats, target: complex) -> Floats | None:
    """Angles (rad) with sum lengths e^(i angle) = target; none if there are no such.

    The vectors and the target are the sides of a polygon. Cut where half of its perimeter is passed: the sides before,
    the one that passes it, and those after form a triangle, which exists if no side is longer than all others together.
    The other solutions of two vectors are the mirror image in the target; for more vectors there is a continuum.
    """
    sides = np.append(lengths, abs(target))
    half = 0.5 * float(sides.sum())
    if lengths.size == 0 or sides.max() > half * (1.0 + 1e-12):
        return None
    cut = min(int(np.searchsorted(np.cumsum(sides), half, side="right")), lengths.size)
    a, b, c = float(sides[:cut].sum()), float(sides[cut]), float(sides[cut + 1 :].sum())
    full = np.empty(sides.size)  # a along 0, then b, then c back to the start
    # directions of the second and third side when the first points along zero and the third leads back
    first, second = 0.0, math.pi
    if a != 0.0 and b != 0.0:
        cosine = (a * a + b * b - c * c) / (2.0 * a * b)
        first = math.pi - math.acos(min(max(cosine, -1.0), 1.0))
        second = cmath.phase(-a - b * cmath.exp(1j * first))
    full[:cut], full[cut], full[cut + 1 :] = 0.0, first, second
    return np.asarray(full[:-1] - full[-1] + math.pi + cmath.phase(target))


# Which |S2|, S2 = sum of e^(2 i phi), equal balls can have while they balance a given unbalance.
#
# Exact stability depends on the ball positions through |S2| only. Two balls have no choice; more balls have a
# continuum.


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
    # three directions and all sizes of groups; a fine search about the best of a grid
    low, high = np.inf, 0.0
    # sizes of three groups, of which the second and third change places without effect
    pairs = [(first, second) for first in range(1, count - 1) for second in range(1, (count - first) // 2 + 1)]
    for groups in ((first, second, count - first - second) for first, second in pairs):
        check_deadline()
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

    def value(angle: float) -> float:
        result = sign * _spreads(np.exp(1j * np.array([angle])), groups, share)
        return float(np.nanmin(result)) if np.isfinite(result).any() else float(groups[0] + groups[1] + groups[2])

    low, high = angles[max(place - 1, 0)], angles[min(place + 1, POINTS - 1)]
    return min(least(value, low, high, xtol=1e-10)[1], value(float(angles[place])))


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


# Equal balls with S2 = sum e^(2 i phi) = 0, such as two at right angles: exact stability on orthotropic supports in
# closed form.
#
# With u = sum s i e^(i phi) dphi, U = u e^(i W t) in space and the deflection z = x + iy the balls of a balanced
# planar rotor obey
#
#     I u'' + beta u' + (N s^2/2) e^(-i W t) z'' = 0    for S2 = 0,    M z'' + b z' + k z + U'' = 0 in x and y each.
#
# So they act like a ring that is alike in all directions. Seen in space all coefficients are constant whatever the
# supports are: no Floquet theory is needed. With D = M t^2 + b t + k of x and y and A = I t^2 + beta t - I W^2 the
# exponents t are the roots of
#
#     D_x D_y [A^2 + W^2 (2 I t + beta)^2] - (N s^2/2) t^4 (D_x + D_y) A + (N s^2/2)^2 t^8 = 0,
#
# a real polynomial of degree eight. Seen from the rotor they are t - iW. On isotropic supports it is the product of
# two factors, of which the explicit border of balls at right angles follows.


def exponents(p: Plane, speeds: Floats) -> Complexes:
    """The eight exponents in space, 1/s, of equal balls with S2 = 0 in races on the axis, (k, 8)."""
    k, own = speeds.size, np.eye(2)
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])
    w, inertia, drag = speeds[:, None, None], float(p.inertia[0]), float(p.drag[0])
    coupling = 0.5 * float((p.moment**2).sum())
    mass, damping, stiffness = np.zeros((4, 4)), np.zeros((k, 4, 4)), np.zeros((k, 4, 4))
    mass[:2, :2], mass[2:, 2:] = p.mass * own, inertia * own
    mass[:2, 2:], mass[2:, :2] = own, coupling * own
    damping[:, :2, :2], stiffness[:, :2, :2] = np.diag(p.damping), np.diag(p.stiffness)
    damping[:, 2:, 2:] = drag * own - 2.0 * w * inertia * turned
    stiffness[:, 2:, 2:] = -w * w * inertia * own - w * drag * turned
    first = np.zeros((k, 8, 8))
    first[:, :4, 4:] = np.eye(4)
    first[:, 4:, :4], first[:, 4:, 4:] = -np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)
    unit = np.tile([1.0, 1.0, p.moment[0], p.moment[0]], 2)  # of U a moment
    return np.asarray(np.linalg.eigvals(first * unit / unit[:, None]), np.complex128)


def growth_rates(p: Plane, speeds: Floats) -> Floats:
    """Greatest real part at each speed, 1/s."""
    return np.asarray(exponents(p, speeds).real.max(axis=1))
