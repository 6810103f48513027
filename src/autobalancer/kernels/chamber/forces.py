"""All forces on balls, body and rotor in one state."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import njit

from autobalancer.kernels.chamber.body import body_rates
from autobalancer.kernels.chamber.contact import APART, TOUCH, touch
from autobalancer.kernels.chamber.layout import (
    BEGUN_BALL,
    BEGUN_WALL,
    CENTER,
    CHAMBER,
    CONTACT,
    DRAG,
    FORCE,
    FORCE_SEEN,
    GRAVITY_X,
    GRAVITY_Y,
    GRAVITY_Z,
    HALF_DEPTH,
    INNER_RADIUS,
    K_FLAT,
    K_INNER,
    K_RACE,
    KIND,
    MASS,
    MOMENT,
    P_CONTACT,
    P_DRAG,
    P_FRICTION,
    P_ROLLING,
    PAIRS,
    POS,
    RADIUS,
    SPIN,
    SQUARE_DRAG,
    STORED,
    TOUCHES,
    VEL,
    WALL_RADIUS,
    Q,
    V,
)
from autobalancer.kernels.pointers import data


@njit(**TOUCH)
def _wall(
    number, ball, host, power, counts, greatest, springs, which, overlap, k, nx, ny, nz, mx, my, mz, w, ux, uy, uz
):
    """A wall with outward normal ``n`` presses on a ball.

    ``m`` is the place of the ball from O, ``u`` the axis of the rotor, which turns at ``w``.
    """
    r = ball[RADIUS]
    # the contact point, from O, and the velocity of the wall there
    px, py, pz = mx + r * nx, my + r * ny, mz + r * nz
    ox, oy, oz = w * ux, w * uy + host[V + 4], w * uz + host[V + 5]
    vx, vy, vz = host[V] + oy * pz - oz * py, host[V + 1] + oz * px - ox * pz, host[V + 2] + ox * py - oy * px
    sx, sy, sz = ball[SPIN], ball[SPIN + 1], ball[SPIN + 2]
    vx = ball[VEL] + r * (sy * nz - sz * ny) - vx
    vy = ball[VEL + 1] + r * (sz * nx - sx * nz) - vy
    vz = ball[VEL + 2] + r * (sx * ny - sy * nx) - vz
    o = 3 * which
    fx, fy, fz, rx, ry, rz, lost, slid, rolled, stored, normal, a, b, c = touch(
        number, overlap, k, 1.0 / ball[MASS], r, nx, ny, nz, vx, vy, vz, sx - ox, sy - oy, sz - oz,
        springs[o], springs[o + 1], springs[o + 2],
    )  # fmt: skip
    springs[o], springs[o + 1], springs[o + 2] = a, b, c
    ball[FORCE] += fx
    ball[FORCE + 1] += fy
    ball[FORCE + 2] += fz
    ball[MOMENT] += r * (ny * fz - nz * fy) + rx
    ball[MOMENT + 1] += r * (nz * fx - nx * fz) + ry
    ball[MOMENT + 2] += r * (nx * fy - ny * fx) + rz
    host[CONTACT] -= fx
    host[CONTACT + 1] -= fy
    host[CONTACT + 2] -= fz
    tx, ty, tz = py * fz - pz * fy + rx, pz * fx - px * fz + ry, px * fy - py * fx + rz
    host[CONTACT + 3] -= tx * ux + ty * uy + tz * uz
    host[CONTACT + 4] -= ty
    host[CONTACT + 5] -= tz
    power[P_CONTACT] += lost
    power[P_FRICTION] += slid
    power[P_ROLLING] += rolled
    power[STORED] += stored
    greatest[FORCE_SEEN] = max(greatest[FORCE_SEEN], normal)
    if ball[TOUCHES + which] == 0.0:
        ball[TOUCHES + which] = 1.0
        counts[BEGUN_WALL] += 1


@njit(**TOUCH)
def _leave(ball, springs, which):
    if ball[TOUCHES + which] != 0.0:
        ball[TOUCHES + which] = 0.0
        springs[3 * which] = springs[3 * which + 1] = springs[3 * which + 2] = 0.0


@njit(**APART)
def forces(
    balls,
    chambers,
    wall_springs,
    number,
    pair_stiffness,
    first,
    second,
    touching,
    springs,
    host,
    inertia,
    stiffness,
    damping,
    active,
    work,
    power,
    counts,
    greatest,
    prescribed,
):
    """Fill the forces and moments of the balls, the second rates of the body, losses, and what is stored in contacts."""
    for i in range(STORED + 1):
        power[i] = 0.0
    for i in range(6):
        host[CONTACT + i] = 0.0
    # the spin, and the part along x of a tilting motion, which is across the axis
    w = host[V + 6] + host[Q + 4] * host[V + 5] - host[Q + 5] * host[V + 4]
    ux, uy, uz = 1.0, host[Q + 5], -host[Q + 4]
    scale = 1.0 / sqrt(1.0 + uy * uy + uz * uz)
    ux, uy, uz = scale, scale * uy, scale * uz
    _walls(balls, chambers, wall_springs, number, host, power, counts, greatest, w, ux, uy, uz)
    _pairs(balls, number, pair_stiffness, first, second, touching, springs, power, counts, greatest)
    body_rates(number, host, inertia, stiffness, damping, active, work, power, prescribed)


@njit(**APART)
def _walls(balls, chambers, wall_springs, number, host, power, counts, greatest, w, ux, uy, uz):
    for i in range(balls.shape[0]):
        ball = data(balls[i])
        own = data(wall_springs[i])
        mass = ball[MASS]
        ball[FORCE] = mass * number[GRAVITY_X]
        ball[FORCE + 1] = mass * number[GRAVITY_Y]
        ball[FORCE + 2] = mass * number[GRAVITY_Z]
        ball[MOMENT] = ball[MOMENT + 1] = ball[MOMENT + 2] = 0.0
        chamber = chambers[int(ball[CHAMBER])]
        mx, my, mz = ball[POS] - host[Q], ball[POS + 1] - host[Q + 1], ball[POS + 2] - host[Q + 2]
        axial = mx * ux + my * uy + mz * uz
        rx, ry, rz = mx - axial * ux, my - axial * uy, mz - axial * uz
        axial -= chamber[CENTER]
        radial = sqrt(rx * rx + ry * ry + rz * rz)
        r = ball[RADIUS]
        overlap = radial + r - chamber[WALL_RADIUS]
        if overlap > 0.0:
            one = 1.0 / radial
            _wall(
                number, ball, host, power, counts, greatest, own, 0, overlap, ball[K_RACE],
                one * rx, one * ry, one * rz, mx, my, mz, w, ux, uy, uz,
            )  # fmt: skip
        else:
            _leave(ball, own, 0)
        inward = chamber[INNER_RADIUS] + r - radial
        if inward > 0.0:
            one = -1.0 / radial
            _wall(
                number, ball, host, power, counts, greatest, own, 3, inward, ball[K_INNER],
                one * rx, one * ry, one * rz, mx, my, mz, w, ux, uy, uz,
            )  # fmt: skip
        else:
            _leave(ball, own, 3)
        side = abs(axial) + r - chamber[HALF_DEPTH]
        if side > 0.0:
            way = 1.0 if axial > 0.0 else -1.0
            which = 1 if axial > 0.0 else 2
            _wall(
                number, ball, host, power, counts, greatest, own, which, side, ball[K_FLAT],
                way * ux, way * uy, way * uz, mx, my, mz, w, ux, uy, uz,
            )  # fmt: skip
            _leave(ball, own, 3 - which)
            # a chamber as deep as its balls touches both
            other = r - abs(axial) - chamber[HALF_DEPTH]
            if other > 0.0:
                _wall(
                    number, ball, host, power, counts, greatest, own, 3 - which, other, ball[K_FLAT],
                    -way * ux, -way * uy, -way * uz, mx, my, mz, w, ux, uy, uz,
                )  # fmt: skip
        else:
            _leave(ball, own, 1)
            _leave(ball, own, 2)
        if chamber[DRAG] != 0.0 or chamber[SQUARE_DRAG] != 0.0:
            _drag(ball, host, power, chamber, mx, my, mz, w, ux, uy, uz)


@njit(**TOUCH)
def _drag(ball, host, power, chamber, mx, my, mz, w, ux, uy, uz):
    """Fluid that turns with the chamber."""
    ox, oy, oz = w * ux, w * uy + host[V + 4], w * uz + host[V + 5]
    vx = ball[VEL] - host[V] - (oy * mz - oz * my)
    vy = ball[VEL + 1] - host[V + 1] - (oz * mx - ox * mz)
    vz = ball[VEL + 2] - host[V + 2] - (ox * my - oy * mx)
    square = vx * vx + vy * vy + vz * vz
    part = chamber[DRAG] + chamber[SQUARE_DRAG] * sqrt(square)
    fx, fy, fz = -part * vx, -part * vy, -part * vz
    ball[FORCE] += fx
    ball[FORCE + 1] += fy
    ball[FORCE + 2] += fz
    host[CONTACT] -= fx
    host[CONTACT + 1] -= fy
    host[CONTACT + 2] -= fz
    tx, ty, tz = my * fz - mz * fy, mz * fx - mx * fz, mx * fy - my * fx
    host[CONTACT + 3] -= tx * ux + ty * uy + tz * uz
    host[CONTACT + 4] -= ty
    host[CONTACT + 5] -= tz
    power[P_DRAG] += part * square


@njit(**APART)
def _pairs(balls, number, pair_stiffness, first, second, touching, springs, power, counts, greatest):
    kinds = pair_stiffness.shape[0]
    table = data(pair_stiffness)
    for p in range(counts[PAIRS]):
        one, two = data(balls[first[p]]), data(balls[second[p]])
        dx, dy, dz = two[POS] - one[POS], two[POS + 1] - one[POS + 1], two[POS + 2] - one[POS + 2]
        square = dx * dx + dy * dy + dz * dz
        r1, r2 = one[RADIUS], two[RADIUS]
        both = r1 + r2
        if square >= both * both:
            if touching[p] != 0:
                touching[p] = 0
                springs[p, 0] = springs[p, 1] = springs[p, 2] = 0.0
            continue
        length = sqrt(square)
        inverse = 1.0 / length
        nx, ny, nz = dx * inverse, dy * inverse, dz * inverse
        # both arms end at one point, or angular momentum would drift
        radius = min(r1, r2)
        r1, r2 = r1 * length / both, r2 * length / both
        sx, sy, sz = (
            r1 * one[SPIN] + r2 * two[SPIN],
            r1 * one[SPIN + 1] + r2 * two[SPIN + 1],
            r1 * one[SPIN + 2] + r2 * two[SPIN + 2],
        )
        vx = one[VEL] - two[VEL] + (sy * nz - sz * ny)
        vy = one[VEL + 1] - two[VEL + 1] + (sz * nx - sx * nz)
        vz = one[VEL + 2] - two[VEL + 2] + (sx * ny - sy * nx)
        k = table[int(one[KIND]) * kinds + int(two[KIND])]
        inverse_mass = 1.0 / one[MASS] + 1.0 / two[MASS]
        fx, fy, fz, rx, ry, rz, lost, slid, rolled, stored, normal, a, b, c = touch(
            number, both - length, k, inverse_mass, radius, nx, ny, nz, vx, vy, vz,
            one[SPIN] - two[SPIN], one[SPIN + 1] - two[SPIN + 1], one[SPIN + 2] - two[SPIN + 2],
            springs[p, 0], springs[p, 1], springs[p, 2],
        )  # fmt: skip
        springs[p, 0], springs[p, 1], springs[p, 2] = a, b, c
        one[FORCE] += fx
        one[FORCE + 1] += fy
        one[FORCE + 2] += fz
        two[FORCE] -= fx
        two[FORCE + 1] -= fy
        two[FORCE + 2] -= fz
        tx, ty, tz = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
        one[MOMENT] += r1 * tx + rx
        one[MOMENT + 1] += r1 * ty + ry
        one[MOMENT + 2] += r1 * tz + rz
        two[MOMENT] += r2 * tx - rx
        two[MOMENT + 1] += r2 * ty - ry
        two[MOMENT + 2] += r2 * tz - rz
        power[P_CONTACT] += lost
        power[P_FRICTION] += slid
        power[P_ROLLING] += rolled
        power[STORED] += stored
        greatest[FORCE_SEEN] = max(greatest[FORCE_SEEN], normal)
        if touching[p] == 0:
            touching[p] = 1
            counts[BEGUN_BALL] += 1
