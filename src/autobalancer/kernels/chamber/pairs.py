"""Which balls may touch: a list of near pairs with a margin, rebuilt when a ball may have crossed it.

What all balls turn and move together does not count, so that balls at rest in the rotor keep their list.

Up to a hundred balls every pair is looked at; beyond, balls are sorted into cells as wide as the margin reaches, which costs
time in proportion to their number.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from autobalancer.kernels.chamber.records import LOST_BALLS, TOO_DENSE
from autobalancer.kernels.chamber.vectors import dot, minus, put, three
from autobalancer.kernels.flags import APART, MERGED, njit
from autobalancer.kernels.pointers import row

DIRECT = 100
FAR = 1e6  # m
ENOUGH = 0.8  # of the margin: when less is left, looking again and again would take longer than a new list


@njit(**MERGED)
def _note(chamber, i, j):
    if j < i:
        i, j = j, i
    one, two = row(chamber.balls, i), row(chamber.balls, j)
    if one.chamber != two.chamber:
        return
    line = minus(three(two.position), three(one.position))
    along, over = 0.0, -chamber.run.margin
    if chamber.contact.cylinders != 0:  # the tilt of the rotor is small against the margin
        along, over = line[0], abs(line[0]) - one.half_length - two.half_length
    square = dot(line, line) - along * along
    both = one.radius + two.radius
    reach = both + chamber.run.margin
    if square >= reach * reach or over >= chamber.run.margin:
        return
    pairs, search, progress = chamber.pairs, chamber.scratch.search, chamber.progress
    k = progress.pairs
    if k >= pairs.first.shape[0]:
        progress.trouble = TOO_DENSE
        return
    pairs.first[k], pairs.second[k] = i, j
    pairs.touching[k] = 1 if square < both * both and over < 0.0 else 0
    pairs.stretch[k, 0] = pairs.stretch[k, 1] = pairs.stretch[k, 2] = 0.0
    for o in range(search.old_row[i], search.old_row[i + 1]):
        if search.old_second[o] == j:
            _copy(search.old_stretch, o, pairs.stretch, k)
            break
    progress.pairs = k + 1


@njit(**MERGED)
def _copy(source, i, target, j):
    target[j, 0], target[j, 1], target[j, 2] = source[i, 0], source[i, 1], source[i, 2]


@njit(**APART)
def rebuild(chamber):
    """List the pairs nearer than the margin, in an order that depends on nothing but the positions.

    Springs of pairs that stay are kept.
    """
    n = chamber.balls.shape[0]
    for i in range(n):
        put(chamber.pairs.listed[i], minus(three(row(chamber.balls, i).position), three(chamber.body.place)))
    _remember(chamber)
    chamber.progress.pairs = 0
    chamber.progress.rebuilds += 1
    if n <= DIRECT:
        for i in range(n):
            for j in range(i + 1, n):
                _note(chamber, i, j)
        return
    _note_by_cells(chamber)


@njit(**MERGED)
def _remember(chamber):
    """Sort the pairs of before by their first ball, so that they are found again."""
    pairs, search, used = chamber.pairs, chamber.scratch.search, chamber.progress.pairs
    n, first = chamber.balls.shape[0], pairs.first
    for i in range(n + 1):
        search.old_row[i] = 0
    for k in range(used):
        search.old_row[first[k] + 1] += 1
    for i in range(n):
        search.old_row[i + 1] += search.old_row[i]
        search.places[i] = search.old_row[i]
    for k in range(used):
        o = search.places[first[k]]
        search.places[first[k]] = o + 1
        search.old_second[o] = pairs.second[k]
        _copy(pairs.stretch, k, search.old_stretch, o)


@njit(**APART)
def _note_by_cells(chamber):
    balls, search = chamber.balls, chamber.scratch.search
    cells, order, places = search.cells, search.order, search.places
    n = balls.shape[0]
    low0 = low1 = low2 = 1e300
    high0 = high1 = high2 = -1e300
    radius = away = 0.0
    for i in range(n):
        x, y, z = three(row(balls, i).position)
        away += abs(x) + abs(y) + abs(z)
        low0, low1, low2 = min(low0, x), min(low1, y), min(low2, z)
        high0, high1, high2 = max(high0, x), max(high1, y), max(high2, z)
        radius = max(radius, row(balls, i).radius, row(balls, i).half_length)
    if not away < FAR * n:  # there are no cells for balls that left all bounds, or whose places are no numbers
        chamber.progress.trouble = LOST_BALLS
        return
    size = 2.0 * radius + chamber.run.margin
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
        x, y, z = three(row(balls, i).position)
        a, b, c = int((x - low0) / size), int((y - low1) / size), int((z - low2) / size)
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
                line = (da * c1 + db) * c2
                for o in range(cells[line + max(c - 1, 0)], cells[line + min(c + 1, c2 - 1) + 1]):
                    j = order[o]
                    if j > i:
                        _note(chamber, i, j)


@njit(**APART)
def follow(chamber, way, times, ahead):
    """Add to the way of the fastest ball, and list the pairs again when ``times`` as much is more than the margin.

    ``ahead`` is the part of ``way`` that is still to be gone.
    """
    margin, progress = chamber.run.margin, chamber.progress
    progress.way += way
    if times * progress.way <= margin:
        return
    progress.way = moved(chamber) + ahead
    if times * progress.way > ENOUGH * margin:
        rebuild(chamber)
        progress.way = ahead


@njit(**APART)
def moved(chamber):
    """The farthest that a ball is from where it was listed, after the turn of all balls about the rotor that fits best."""
    balls, listed, middle = chamber.balls, chamber.pairs.listed, three(chamber.body.place)
    along = across = 0.0
    for i in range(balls.shape[0]):
        _, y, z = minus(three(row(balls, i).position), middle)
        along += listed[i, 1] * y + listed[i, 2] * z
        across += listed[i, 1] * z - listed[i, 2] * y
    size = sqrt(along * along + across * across)
    c, s = (along / size, across / size) if size > 0.0 else (1.0, 0.0)
    most = 0.0
    for i in range(balls.shape[0]):
        u, v = listed[i, 1], listed[i, 2]
        way = minus(minus(three(row(balls, i).position), middle), (listed[i, 0], c * u - s * v, s * u + c * v))
        most = max(most, dot(way, way))
    return sqrt(most)
