"""Which balls may touch: a list of near pairs with a margin, rebuilt when a ball may have crossed it.

Up to a hundred balls every pair is looked at; beyond, balls are sorted into cells as wide as the margin reaches, which costs
time in proportion to their number.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from numba import njit

from autobalancer.kernels.chamber.contact import APART, TOUCH
from autobalancer.kernels.chamber.layout import (
    CHAMBER,
    LOST_BALLS,
    OVERFLOW,
    PAIRS,
    POS,
    RADIUS,
    REBUILDS,
    SKIN,
    TOO_DENSE,
    WAY,
)

DIRECT = 100
FAR = 1e6  # m
X, Y, Z = POS, POS + 1, POS + 2


@njit(**TOUCH)
def _note(balls, i, j, number, first, second, touching, springs, old_row, old_second, old_springs, counts):
    if balls[i, CHAMBER] != balls[j, CHAMBER]:
        return
    if j < i:
        i, j = j, i
    dx, dy, dz = balls[j, X] - balls[i, X], balls[j, Y] - balls[i, Y], balls[j, Z] - balls[i, Z]
    square = dx * dx + dy * dy + dz * dz
    both = balls[i, RADIUS] + balls[j, RADIUS]
    reach = both + number[SKIN]
    if square >= reach * reach:
        return
    k = counts[PAIRS]
    if k >= first.shape[0]:
        counts[OVERFLOW] = TOO_DENSE
        return
    first[k], second[k] = i, j
    touching[k] = 1 if square < both * both else 0
    springs[k, 0] = springs[k, 1] = springs[k, 2] = 0.0
    for o in range(old_row[i], old_row[i + 1]):
        if old_second[o] == j:
            springs[k, 0], springs[k, 1], springs[k, 2] = old_springs[o, 0], old_springs[o, 1], old_springs[o, 2]
            break
    counts[PAIRS] = k + 1


@njit(**APART)
def rebuild(
    balls, number, first, second, touching, springs, old_row, old_second, old_springs, cells, order, places, counts
):
    """List the pairs nearer than the margin, in an order that depends on nothing but the positions.

    Springs of pairs that stay are kept. ``cells`` is scratch for the starts of cells, ``order`` and ``places`` one entry a ball.
    """
    n = balls.shape[0]
    used = counts[PAIRS]
    for i in range(n + 1):
        old_row[i] = 0
    for k in range(used):
        old_row[first[k] + 1] += 1
    for i in range(n):
        old_row[i + 1] += old_row[i]
        places[i] = old_row[i]
    for k in range(used):
        o = places[first[k]]
        places[first[k]] = o + 1
        old_second[o] = second[k]
        old_springs[o, 0], old_springs[o, 1], old_springs[o, 2] = springs[k, 0], springs[k, 1], springs[k, 2]
    counts[PAIRS] = 0
    counts[REBUILDS] += 1
    if n <= DIRECT:
        for i in range(n):
            for j in range(i + 1, n):
                _note(balls, i, j, number, first, second, touching, springs, old_row, old_second, old_springs, counts)
        return
    low0 = low1 = low2 = 1e300
    high0 = high1 = high2 = -1e300
    radius = away = 0.0
    for i in range(n):
        away += abs(balls[i, X]) + abs(balls[i, Y]) + abs(balls[i, Z])
        low0, low1, low2 = min(low0, balls[i, X]), min(low1, balls[i, Y]), min(low2, balls[i, Z])
        high0, high1, high2 = max(high0, balls[i, X]), max(high1, balls[i, Y]), max(high2, balls[i, Z])
        radius = max(radius, balls[i, RADIUS])
    if not away < FAR * n:  # there are no cells for balls that left all bounds, or whose places are no numbers
        counts[OVERFLOW] = LOST_BALLS
        return
    size = 2.0 * radius + number[SKIN]
    room = cells.shape[0] - 2
    while True:
        c0, c1, c2 = int((high0 - low0) / size) + 1, int((high1 - low1) / size) + 1, int((high2 - low2) / size) + 1
        if float(c0) * float(c1) * float(c2) <= room:
            break
        size *= 1.3
    total = c0 * c1 * c2
    for c in range(total + 2):
        cells[c] = 0
    for i in range(n):
        a, b, c = int((balls[i, X] - low0) / size), int((balls[i, Y] - low1) / size), int((balls[i, Z] - low2) / size)
        places[i] = (a * c1 + b) * c2 + c
        cells[places[i] + 2] += 1
    for c in range(total):
        cells[c + 2] += cells[c + 1]
    for i in range(n):
        o = cells[places[i] + 1]
        cells[places[i] + 1] = o + 1
        order[o] = i
    for i in range(n):
        place = places[i]
        a, rest = place // (c1 * c2), place % (c1 * c2)
        b, c = rest // c2, rest % c2
        for da in range(max(a - 1, 0), min(a + 2, c0)):
            for db in range(max(b - 1, 0), min(b + 2, c1)):
                row = (da * c1 + db) * c2
                for o in range(cells[row + max(c - 1, 0)], cells[row + min(c + 1, c2 - 1) + 1]):
                    j = order[o]
                    if j > i:
                        _note(
                            balls, i, j, number, first, second, touching, springs, old_row, old_second, old_springs,
                            counts,
                        )  # fmt: skip


@njit(**APART)
def follow(
    balls, number, first, second, touching, springs, old_row, old_second, old_springs, cells, order, places, counts,
    greatest, way, times, ahead,
):  # fmt: skip
    """Add to the way of the fastest ball, and list the pairs again when ``times`` as much is more than the margin.

    ``ahead`` is the part of ``way`` that is still to be gone.
    """
    greatest[WAY] += way
    if times * greatest[WAY] > number[SKIN]:
        rebuild(
            balls,
            number,
            first,
            second,
            touching,
            springs,
            old_row,
            old_second,
            old_springs,
            cells,
            order,
            places,
            counts,
        )
        greatest[WAY] = ahead
