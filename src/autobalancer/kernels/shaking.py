"""What shakes a machine from outside: motion of its base, and forces on its rotor."""

from __future__ import annotations

from numba import njit

from autobalancer.kernels.curves import table_value
from autobalancer.kernels.drive import unbalance_value
from autobalancer.kernels.flags import INLINE
from autobalancer.kernels.pointers import behind
from autobalancer.kernels.race_layout import (
    AMP_XI,
    AMP_XR,
    AMP_YI,
    AMP_YR,
    BY_ANGLE,
    FELT,
    RECORDED,
    SHAKE_FREQUENCY,
    SHAKE_KIND,
    SHAKE_VECTORS,
    TABLE_X,
    TABLE_Y,
)
from autobalancer.kernels.rotor_layout import COORDINATES, PLACES, SHAKERS, TABLE, WIDTH, blocks
from autobalancer.kernels.system import PRESCRIBED, THETA
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**INLINE)
def shake(time, y, system, r, turn_sin, turn_cos, gx, gy, torque):  # type: ignore[no-untyped-def]
    """Add the accelerations of the coordinates to f; returns gravity as felt on the base, and the torque."""
    p = behind(system)
    size, width = int(r[COORDINATES]), int(r[WIDTH])
    k = blocks(width, int(r[PLACES]) * 2, int(r[TABLE]))
    shaken = int(r[SHAKERS])
    if shaken > 0:
        for e in range(int(r[shaken])):
            at = shaken + 1 + e * (SHAKE_VECTORS + 2 * width)
            if r[at + SHAKE_KIND] == RECORDED:
                along_x, along_y = (
                    table_value(r, int(r[at + TABLE_X]), time),
                    table_value(r, int(r[at + TABLE_Y]), time),
                )
            else:
                phase = r[at + SHAKE_FREQUENCY] * (y[THETA] if r[at + BY_ANGLE] == 1.0 else time)
                s, c = sine_cosine(phase)
                along_x, along_y = r[at + AMP_XR] * c - r[at + AMP_XI] * s, r[at + AMP_YR] * c - r[at + AMP_YI] * s
            for i in range(size):
                r[k.f + i] += r[at + SHAKE_VECTORS + i] * along_x + r[at + SHAKE_VECTORS + width + i] * along_y
            if r[at + FELT] == 1.0:
                gx -= along_x
                gy -= along_y
                if p.drive != PRESCRIBED:
                    ux, uy = unbalance_value(time, p)
                    torque -= (turn_cos * ux - turn_sin * uy) * along_y - (turn_sin * ux + turn_cos * uy) * along_x
    return gx, gy, torque
