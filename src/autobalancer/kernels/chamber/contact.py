"""The law of a contact of a ball with another ball or a wall, for a block of contacts at once.

Law of Pakuła (2021), (15), (18), (26), (36)-(39): k d^1.5 in approach, R^2 of it in separation, so that the rebound speed is
R times the speed of approach whatever k, mass and speed; Coulomb friction that always slides; rolling resistance. Each of
the three steps in velocity is replaced by a slope that one step of time can resolve.

Alternative: Hertz contact with viscous damping (Tsuji et al. 1992) and a tangential spring with memory (Cundall and Strack
1979, stiffness of Mindlin 1949).

Nothing here branches, so the compiler takes eight columns of the block at a time.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt
from typing import Any

from numba import njit

from autobalancer.kernels.chamber.layout import (
    ARM,
    BLOCK,
    DAMPING_RATIO,
    FRICTION,
    HELD,
    HISTORY,
    LAW,
    LIGHTNESS,
    LINE,
    LOST,
    NORMAL,
    OFFSET,
    PUSH,
    RATE,
    RESIST,
    RESTITUTION_SQUARED,
    ROLL,
    ROLL_RADIUS,
    ROLLED,
    ROLLING_ARM,
    SHEAR_RATIO,
    SHRINK,
    SLID,
    SLOW,
    STEP,
    STIFFNESS,
    STRETCH,
    TAKEN,
    TURN,
    TWIST,
)
from autobalancer.kernels.pointers import data

TOUCH: dict[str, Any] = {"forceinline": True, "error_model": "numpy", "_nrt": False, "fastmath": {"contract"}}
APART: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "fastmath": {"contract"}}
TURNING = 1.0  # slope of the normal law at the turning point, in changes of speed within one step
SLIDING = 2.0  # the same for friction and rolling resistance
LEAST = 1e-30  # m: rounding must not make an overlap negative
TINY = 1e-300
AT_ONCE = 8


@njit(**TOUCH)
def _three(b, row, i):
    return b[row * BLOCK + i], b[(row + 1) * BLOCK + i], b[(row + 2) * BLOCK + i]


@njit(**TOUCH)
def _put(b, row, i, x, y, z):
    b[row * BLOCK + i], b[(row + 1) * BLOCK + i], b[(row + 2) * BLOCK + i] = x, y, z


@njit(**TOUCH)
def _meet(b, i):
    """Overlap, normal to the partner, relative velocity along it and across it at the point of contact."""
    dx, dy, dz = _three(b, LINE, i)
    length = sqrt(dx * dx + dy * dy + dz * dz)
    inverse = 1.0 / length
    nx, ny, nz = dx * inverse, dy * inverse, dz * inverse
    overlap = max(b[OFFSET * BLOCK + i] + b[TAKEN * BLOCK + i] * length, LEAST)
    # the arms of both balls end at one point, or angular momentum would drift
    arm = 1.0 - overlap * b[SHRINK * BLOCK + i]
    b[ARM * BLOCK + i] = arm
    vx, vy, vz = _three(b, RATE, i)
    sx, sy, sz = _three(b, TURN, i)
    vx, vy, vz = vx + arm * (sy * nz - sz * ny), vy + arm * (sz * nx - sx * nz), vz + arm * (sx * ny - sy * nx)
    approach = vx * nx + vy * ny + vz * nz
    return overlap, nx, ny, nz, approach, vx - approach * nx, vy - approach * ny, vz - approach * nz


@njit(**TOUCH)
def _leave(b, i, h, arm, slow, nx, ny, nz, fx, fy, fz, normal, lost, slid, held):
    """Rolling resistance, and the results into the block; ``f`` is the friction."""
    wx, wy, wz = _three(b, ROLL, i)
    radius, lightness = b[ROLL_RADIUS * BLOCK + i], b[LIGHTNESS * BLOCK + i]
    along = wx * nx + wy * ny + wz * nz
    wx, wy, wz = wx - along * nx, wy - along * ny, wz - along * nz
    square = wx * wx + wy * wy + wz * wz
    inverse = 1.0 / radius
    least = max(slow * inverse, SLIDING * h * arm * normal * 2.5 * lightness * inverse * inverse)
    moment = arm * normal / max(sqrt(square), least)
    _put(b, RESIST, i, -moment * wx, -moment * wy, -moment * wz)
    _put(b, TWIST, i, ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx)
    _put(b, PUSH, i, fx - normal * nx, fy - normal * ny, fz - normal * nz)
    b[LOST * BLOCK + i], b[SLID * BLOCK + i], b[ROLLED * BLOCK + i] = lost, slid, moment * square
    b[HELD * BLOCK + i], b[NORMAL * BLOCK + i] = held, normal


@njit(**APART)
def press(number, block, count):
    """Forces, losses and energy of the first ``count`` contacts of ``block``; unused columns are computed too."""
    b = data(block)
    h, friction, slow, arm = number[STEP], number[FRICTION], number[SLOW], number[ROLLING_ARM]
    padded = (count + AT_ONCE - 1) // AT_ONCE * AT_ONCE
    if number[LAW] == HISTORY:
        ratio, shearing = number[DAMPING_RATIO], 1.5 * number[SHEAR_RATIO]
        for i in range(padded):
            overlap, nx, ny, nz, approach, tx, ty, tz = _meet(b, i)
            k = b[STIFFNESS * BLOCK + i]
            root = sqrt(overlap)
            load = k * overlap * root
            viscous = ratio * sqrt(k * root / b[LIGHTNESS * BLOCK + i])
            normal = max(load + viscous * approach, 0.0)
            shear = shearing * k * root
            sx, sy, sz = _three(b, STRETCH, i)
            off = sx * nx + sy * ny + sz * nz
            sx, sy, sz = sx - off * nx + h * tx, sy - off * ny + h * ty, sz - off * nz + h * tz
            fx, fy, fz = -shear * sx - viscous * tx, -shear * sy - viscous * ty, -shear * sz - viscous * tz
            # where friction cannot hold the force, the spring yields
            part = min(friction * normal / max(sqrt(fx * fx + fy * fy + fz * fz), TINY), 1.0)
            fx, fy, fz = part * fx, part * fy, part * fz
            back = -1.0 / shear
            slides = part < 1.0
            sx = back * (fx + viscous * tx) if slides else sx
            sy = back * (fy + viscous * ty) if slides else sy
            sz = back * (fz + viscous * tz) if slides else sz
            _put(b, STRETCH, i, sx, sy, sz)
            slid = -(fx * tx + fy * ty + fz * tz)
            lost = (normal - load) * approach
            _leave(b, i, h, arm, slow, nx, ny, nz, fx, fy, fz, normal, lost, slid, 0.4 * load * overlap)
    else:
        recovered = number[RESTITUTION_SQUARED]
        for i in range(padded):
            overlap, nx, ny, nz, approach, tx, ty, tz = _meet(b, i)
            lightness = b[LIGHTNESS * BLOCK + i]
            load = b[STIFFNESS * BLOCK + i] * overlap * sqrt(overlap)
            share = 0.5 + approach / (TURNING * h * load * lightness + TINY)
            normal = load * (recovered + (1.0 - recovered) * min(max(share, 0.0), 1.0))
            square = tx * tx + ty * ty + tz * tz
            least = max(slow, SLIDING * h * friction * normal * 3.5 * lightness)
            pull = friction * normal / max(sqrt(square), least)
            lost = (normal - recovered * load) * approach
            held = 0.4 * recovered * load * overlap
            _leave(
                b, i, h, arm, slow, nx, ny, nz, -pull * tx, -pull * ty, -pull * tz, normal, lost, pull * square, held
            )
