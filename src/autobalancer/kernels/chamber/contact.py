"""One contact of a ball with another ball or a wall.

Law of Pakuła (2021), (15), (18), (26), (36)-(39): k d^1.5 in approach, R^2 of it in separation, so that the rebound speed is
R times the speed of approach whatever k, mass and speed; Coulomb friction that always slides; rolling resistance. Each of
the three steps in velocity is replaced by a slope that one step of time can resolve.

Alternative: Hertz contact with viscous damping (Tsuji et al. 1992) and a tangential spring with memory (Cundall and Strack
1979, stiffness of Mindlin 1949).
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt
from typing import Any

from numba import njit

from autobalancer.kernels.chamber.layout import (
    DAMPING_RATIO,
    FRICTION,
    HISTORY,
    LAW,
    RESTITUTION_SQUARED,
    ROLLING_ARM,
    SHEAR_RATIO,
    SLOW,
    STEP,
)

TOUCH: dict[str, Any] = {"forceinline": True, "error_model": "numpy", "_nrt": False, "fastmath": {"contract"}}
APART: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "fastmath": {"contract"}}
TURNING = 1.0  # slope of the normal law at the turning point, in changes of speed within one step
SLIDING = 2.0  # the same for friction and rolling resistance


@njit(**TOUCH)
def touch(number, overlap, k, inverse_mass, radius, nx, ny, nz, ux, uy, uz, wx, wy, wz, sx, sy, sz):
    """Force and rolling moment on a ball, losses and energy.

    ``n`` points from the ball to its partner, ``u`` is the velocity of its contact point and ``w`` its spin, both relative
    to the partner, ``s`` the stretch of the tangential spring. ``inverse_mass`` is the sum over both bodies.
    """
    h = number[STEP]
    root = sqrt(overlap)
    load = k * overlap * root
    approach = ux * nx + uy * ny + uz * nz
    tx, ty, tz = ux - approach * nx, uy - approach * ny, uz - approach * nz
    square = tx * tx + ty * ty + tz * tz
    friction = number[FRICTION]
    if number[LAW] == HISTORY:
        recovered = 1.0
        viscous = number[DAMPING_RATIO] * sqrt(k / inverse_mass * root)
        normal = max(load + viscous * approach, 0.0)
        shear = number[SHEAR_RATIO] * 1.5 * k * root
        off = sx * nx + sy * ny + sz * nz
        sx, sy, sz = sx - off * nx + h * tx, sy - off * ny + h * ty, sz - off * nz + h * tz
        fx, fy, fz = -shear * sx - viscous * tx, -shear * sy - viscous * ty, -shear * sz - viscous * tz
        size = sqrt(fx * fx + fy * fy + fz * fz)
        if size > friction * normal:
            part = friction * normal / size
            fx, fy, fz = part * fx, part * fy, part * fz
            back = -1.0 / shear
            sx, sy, sz = back * (fx + viscous * tx), back * (fy + viscous * ty), back * (fz + viscous * tz)
        slid = -(fx * tx + fy * ty + fz * tz)
    else:
        recovered = number[RESTITUTION_SQUARED]
        share = 0.5 + approach / (TURNING * h * load * inverse_mass + 1e-300)
        share = min(max(share, 0.0), 1.0)
        normal = load * (recovered + (1.0 - recovered) * share)
        least = max(number[SLOW], SLIDING * h * friction * normal * 3.5 * inverse_mass)
        pull = friction * normal / max(sqrt(square), least)
        fx, fy, fz = -pull * tx, -pull * ty, -pull * tz
        slid = pull * square
    lost = (normal - recovered * load) * approach
    mx, my, mz, rolled = 0.0, 0.0, 0.0, 0.0
    arm = number[ROLLING_ARM]
    if arm > 0.0:
        along = wx * nx + wy * ny + wz * nz
        wx, wy, wz = wx - along * nx, wy - along * ny, wz - along * nz
        square = wx * wx + wy * wy + wz * wz
        least = max(number[SLOW] / radius, SLIDING * h * arm * normal * 2.5 * inverse_mass / (radius * radius))
        moment = arm * normal / max(sqrt(square), least)
        mx, my, mz = -moment * wx, -moment * wy, -moment * wz
        rolled = moment * square
    stored = 0.4 * recovered * load * overlap
    fx, fy, fz = fx - normal * nx, fy - normal * ny, fz - normal * nz
    return fx, fy, fz, mx, my, mz, lost, slid, rolled, stored, normal, sx, sy, sz
