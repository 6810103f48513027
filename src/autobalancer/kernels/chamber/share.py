"""What a block of contacts does to balls, body and rotor."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from numba import njit

from autobalancer.kernels.chamber.contact import APART, press
from autobalancer.kernels.chamber.layout import (
    ARM,
    BLOCK,
    CONTACT,
    FORCE,
    FORCE_SEEN,
    HELD,
    HISTORY,
    LAW,
    LOST,
    MOMENT,
    NORMAL,
    ONE,
    P_CONTACT,
    P_FRICTION,
    P_ROLLING,
    PLACE,
    POS,
    PUSH,
    RADIUS,
    RESIST,
    ROLLED,
    SLID,
    STORED,
    STRETCH,
    TWIST,
    TWO,
    Q,
)
from autobalancer.kernels.pointers import data


@njit(**APART)
def act(balls, wall_springs, springs, number, host, block, count, power, greatest, ux, uy, uz):
    """Evaluate the first ``count`` contacts and add their forces, in their order; ``u`` is the axis of the rotor."""
    press(number, block, count)
    b = data(block)
    remember = number[LAW] == HISTORY
    x, y, z = host[Q], host[Q + 1], host[Q + 2]
    px = py = pz = mx = my = mz = lost = slid = rolled = held = 0.0
    most = greatest[FORCE_SEEN]
    for i in range(count):
        one = data(balls[int(b[ONE * BLOCK + i])])
        other = int(b[TWO * BLOCK + i])
        place = int(b[PLACE * BLOCK + i])
        fx, fy, fz = b[PUSH * BLOCK + i], b[(PUSH + 1) * BLOCK + i], b[(PUSH + 2) * BLOCK + i]
        tx, ty, tz = b[TWIST * BLOCK + i], b[(TWIST + 1) * BLOCK + i], b[(TWIST + 2) * BLOCK + i]
        rx, ry, rz = b[RESIST * BLOCK + i], b[(RESIST + 1) * BLOCK + i], b[(RESIST + 2) * BLOCK + i]
        arm = b[ARM * BLOCK + i]
        r = arm * one[RADIUS]
        ax, ay, az = r * tx + rx, r * ty + ry, r * tz + rz
        one[FORCE] += fx
        one[FORCE + 1] += fy
        one[FORCE + 2] += fz
        one[MOMENT] += ax
        one[MOMENT + 1] += ay
        one[MOMENT + 2] += az
        if other >= 0:
            two = data(balls[other])
            r = arm * two[RADIUS]
            two[FORCE] -= fx
            two[FORCE + 1] -= fy
            two[FORCE + 2] -= fz
            two[MOMENT] += r * tx - rx
            two[MOMENT + 1] += r * ty - ry
            two[MOMENT + 2] += r * tz - rz
            if remember:
                for j in range(3):
                    springs[place, j] = b[(STRETCH + j) * BLOCK + i]
        else:
            ox, oy, oz = one[POS] - x, one[POS + 1] - y, one[POS + 2] - z
            px, py, pz = px + fx, py + fy, pz + fz
            mx += oy * fz - oz * fy + ax
            my += oz * fx - ox * fz + ay
            mz += ox * fy - oy * fx + az
            if remember:
                for j in range(3):
                    wall_springs[int(b[ONE * BLOCK + i]), 3 * place + j] = b[(STRETCH + j) * BLOCK + i]
        lost += b[LOST * BLOCK + i]
        slid += b[SLID * BLOCK + i]
        rolled += b[ROLLED * BLOCK + i]
        held += b[HELD * BLOCK + i]
        most = max(most, b[NORMAL * BLOCK + i])
    push(host, px, py, pz, mx, my, mz, ux, uy, uz)
    power[P_CONTACT] += lost
    power[P_FRICTION] += slid
    power[P_ROLLING] += rolled
    power[STORED] += held
    greatest[FORCE_SEEN] = most


@njit(**APART)
def push(host, px, py, pz, mx, my, mz, ux, uy, uz):
    """Body and rotor feel the opposite of a force ``p`` on balls and of its moment ``m`` about O."""
    host[CONTACT] -= px
    host[CONTACT + 1] -= py
    host[CONTACT + 2] -= pz
    host[CONTACT + 3] -= mx * ux + my * uy + mz * uz
    host[CONTACT + 4] -= my
    host[CONTACT + 5] -= mz
