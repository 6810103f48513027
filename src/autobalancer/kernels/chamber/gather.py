"""Which balls touch walls and each other now: what the law of contact needs of them goes into the block."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import njit

from autobalancer.kernels.chamber.contact import APART, TOUCH
from autobalancer.kernels.chamber.layout import (
    BEGUN_BALL,
    BEGUN_WALL,
    BLOCK,
    CENTER,
    CHAMBER,
    CHAMBER_COLUMNS,
    DRAG,
    FORCE,
    GRAVITY_X,
    GRAVITY_Y,
    GRAVITY_Z,
    HALF_DEPTH,
    HISTORY,
    INNER_RADIUS,
    INVERSE_MASS,
    K_FLAT,
    K_INNER,
    K_RACE,
    KIND,
    LAW,
    LIGHTNESS,
    LINE,
    MASS,
    MOMENT,
    OFFSET,
    ONE,
    P_DRAG,
    PAIRS,
    PLACE,
    POS,
    RADIUS,
    RATE,
    ROLL,
    ROLL_RADIUS,
    SHRINK,
    SPIN,
    SQUARE_DRAG,
    STIFFNESS,
    STRETCH,
    TAKEN,
    TOUCHES,
    TURN,
    TWO,
    VEL,
    WALL_RADIUS,
    Q,
    V,
)
from autobalancer.kernels.chamber.share import act, push
from autobalancer.kernels.pointers import data

WALLS = 4  # that a ball can touch at once


@njit(**TOUCH)
def _enter(
    b, i, one, two, place, lx, ly, lz, offset, taken, k, lightness, radius, shrink, vx, vy, vz, sx, sy, sz, wx, wy, wz,
    remember, stretch, at,
):  # fmt: skip
    b[LINE * BLOCK + i], b[(LINE + 1) * BLOCK + i], b[(LINE + 2) * BLOCK + i] = lx, ly, lz
    b[OFFSET * BLOCK + i], b[TAKEN * BLOCK + i], b[STIFFNESS * BLOCK + i] = offset, taken, k
    b[LIGHTNESS * BLOCK + i], b[ROLL_RADIUS * BLOCK + i], b[SHRINK * BLOCK + i] = lightness, radius, shrink
    b[RATE * BLOCK + i], b[(RATE + 1) * BLOCK + i], b[(RATE + 2) * BLOCK + i] = vx, vy, vz
    b[TURN * BLOCK + i], b[(TURN + 1) * BLOCK + i], b[(TURN + 2) * BLOCK + i] = sx, sy, sz
    b[ROLL * BLOCK + i], b[(ROLL + 1) * BLOCK + i], b[(ROLL + 2) * BLOCK + i] = wx, wy, wz
    b[ONE * BLOCK + i], b[TWO * BLOCK + i], b[PLACE * BLOCK + i] = float(one), float(two), float(place)
    if remember:
        for j in range(3):
            b[(STRETCH + j) * BLOCK + i] = stretch[at + j]


@njit(**APART)
def walls(balls, chambers, wall_springs, springs, number, host, block, power, counts, greatest, ux, uy, uz):
    """Weight and drag of all balls, and their contacts with walls; answers how many of them are left in the block."""
    b = data(block)
    rooms = data(chambers)
    gx, gy, gz = number[GRAVITY_X], number[GRAVITY_Y], number[GRAVITY_Z]
    remember = number[LAW] == HISTORY
    x, y, z = host[Q], host[Q + 1], host[Q + 2]
    xv, yv, zv = host[V], host[V + 1], host[V + 2]
    # the spin, and the part along x of a tilting motion, which is across the axis
    w = host[V + 6] + host[Q + 4] * host[V + 5] - host[Q + 5] * host[V + 4]
    ox, oy, oz = w * ux, w * uy + host[V + 4], w * uz + host[V + 5]
    filled = 0
    for i in range(balls.shape[0]):
        ball = data(balls[i])
        mass = ball[MASS]
        ball[FORCE], ball[FORCE + 1], ball[FORCE + 2] = mass * gx, mass * gy, mass * gz
        ball[MOMENT] = ball[MOMENT + 1] = ball[MOMENT + 2] = 0.0
        room = CHAMBER_COLUMNS * int(ball[CHAMBER])
        mx, my, mz = ball[POS] - x, ball[POS + 1] - y, ball[POS + 2] - z
        axial = mx * ux + my * uy + mz * uz
        rx, ry, rz = mx - axial * ux, my - axial * uy, mz - axial * uz
        axial -= rooms[room + CENTER]
        r = ball[RADIUS]
        way = rooms[room + WALL_RADIUS] - r
        half = rooms[room + HALF_DEPTH]
        side = abs(axial) + r - half
        square = rx * rx + ry * ry + rz * rz
        outside = square > way * way
        reach = rooms[room + INNER_RADIUS] + r
        inward = reach > 0.0 and square < reach * reach
        now = 0
        if outside or inward or side > 0.0:
            # against the wall as if it reached to the middle of the ball
            vx = ball[VEL] - xv - (oy * mz - oz * my)
            vy = ball[VEL + 1] - yv - (oz * mx - ox * mz)
            vz = ball[VEL + 2] - zv - (ox * my - oy * mx)
            wx, wy, wz = ball[SPIN] - ox, ball[SPIN + 1] - oy, ball[SPIN + 2] - oz
            light = ball[INVERSE_MASS]
            own = data(wall_springs[i])
            if outside:
                _enter(
                    b, filled, i, -1, 0, rx, ry, rz, -way, 1.0, ball[K_RACE], light, r, 0.0, vx, vy, vz,
                    r * wx, r * wy, r * wz, wx, wy, wz, remember, own, 0,
                )  # fmt: skip
                filled += 1
                now = 1
            if inward:
                _enter(
                    b, filled, i, -1, 3, -rx, -ry, -rz, reach, -1.0, ball[K_INNER], light, r, 0.0, vx, vy, vz,
                    r * wx, r * wy, r * wz, wx, wy, wz, remember, own, 9,
                )  # fmt: skip
                filled += 1
                now += 8
            if side > 0.0:
                sign = 1.0 if axial > 0.0 else -1.0
                which = 1 if axial > 0.0 else 2
                _enter(
                    b, filled, i, -1, which, sign * ux, sign * uy, sign * uz, side, 0.0, ball[K_FLAT], light, r, 0.0,
                    vx, vy, vz, r * wx, r * wy, r * wz, wx, wy, wz, remember, own, 3 * which,
                )  # fmt: skip
                filled += 1
                now += 2 * which
                # a chamber as deep as its balls touches both
                other = r - abs(axial) - half
                if other > 0.0:
                    which = 3 - which
                    _enter(
                        b, filled, i, -1, which, -sign * ux, -sign * uy, -sign * uz, other, 0.0, ball[K_FLAT], light, r,
                        0.0, vx, vy, vz, r * wx, r * wy, r * wz, wx, wy, wz, remember, own, 3 * which,
                    )  # fmt: skip
                    filled += 1
                    now += 2 * which
        before = int(ball[TOUCHES])
        if now != before:
            ball[TOUCHES] = float(now)
            for which in range(WALLS):
                if (now & ~before) >> which & 1:
                    counts[BEGUN_WALL] += 1
                if (before & ~now) >> which & 1:
                    for j in range(3):
                        wall_springs[i, 3 * which + j] = 0.0
        if rooms[room + DRAG] != 0.0 or rooms[room + SQUARE_DRAG] != 0.0:
            # fluid that turns with the chamber
            vx = ball[VEL] - xv - (oy * mz - oz * my)
            vy = ball[VEL + 1] - yv - (oz * mx - ox * mz)
            vz = ball[VEL + 2] - zv - (ox * my - oy * mx)
            square = vx * vx + vy * vy + vz * vz
            part = rooms[room + DRAG] + rooms[room + SQUARE_DRAG] * sqrt(square)
            fx, fy, fz = -part * vx, -part * vy, -part * vz
            ball[FORCE] += fx
            ball[FORCE + 1] += fy
            ball[FORCE + 2] += fz
            push(host, fx, fy, fz, my * fz - mz * fy, mz * fx - mx * fz, mx * fy - my * fx, ux, uy, uz)
            power[P_DRAG] += part * square
        if filled > BLOCK - WALLS:
            act(balls, wall_springs, springs, number, host, block, filled, power, greatest, ux, uy, uz)
            filled = 0
    return filled


@njit(**APART)
def near_pairs(
    balls, wall_springs, springs, number, host, pair_stiffness, first, second, touching, block, filled, power, counts,
    greatest, ux, uy, uz,
):  # fmt: skip
    """Contacts of balls with each other, into a block that holds ``filled``; answers how many are left in it."""
    kinds = pair_stiffness.shape[0]
    table, b, stretches = data(pair_stiffness), data(block), data(springs)
    remember = number[LAW] == HISTORY
    for p in range(counts[PAIRS]):
        i, j = first[p], second[p]
        one, two = data(balls[i]), data(balls[j])
        dx, dy, dz = two[POS] - one[POS], two[POS + 1] - one[POS + 1], two[POS + 2] - one[POS + 2]
        r1, r2 = one[RADIUS], two[RADIUS]
        both = r1 + r2
        if dx * dx + dy * dy + dz * dz >= both * both:
            if touching[p] != 0:
                touching[p] = 0
                springs[p, 0] = springs[p, 1] = springs[p, 2] = 0.0
            continue
        if touching[p] == 0:
            touching[p] = 1
            counts[BEGUN_BALL] += 1
        sx, sy, sz = one[SPIN], one[SPIN + 1], one[SPIN + 2]
        wx, wy, wz = two[SPIN], two[SPIN + 1], two[SPIN + 2]
        _enter(
            b, filled, i, j, p, dx, dy, dz, both, -1.0, table[int(one[KIND]) * kinds + int(two[KIND])],
            one[INVERSE_MASS] + two[INVERSE_MASS], min(r1, r2), 1.0 / both,
            one[VEL] - two[VEL], one[VEL + 1] - two[VEL + 1], one[VEL + 2] - two[VEL + 2],
            r1 * sx + r2 * wx, r1 * sy + r2 * wy, r1 * sz + r2 * wz, sx - wx, sy - wy, sz - wz,
            remember, stretches, 3 * p,
        )  # fmt: skip
        filled += 1
        if filled == BLOCK:
            act(balls, wall_springs, springs, number, host, block, filled, power, greatest, ux, uy, uz)
            filled = 0
    return filled
