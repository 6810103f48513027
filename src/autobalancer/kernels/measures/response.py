"""What unbalance does at the planes and places of a machine at a steady speed w.

(K + i w (C + w G) - w^2 M) q = w^2 u,    deflections are Re(q e^(i theta))
"""

from __future__ import annotations

import math
from typing import Any

from numba import types, void

from autobalancer.kernels.flags import EXACT, INLINE, njit
from autobalancer.kernels.measures.equations import least_squares, solve
from autobalancer.kernels.measures.gauges import PLANAR, Desk, Gauges, complexes_type, desk_type, gauges_type
from autobalancer.kernels.measures.tables import segment_at, share_of, since
from autobalancer.kernels.system import Floats, System, system_type, vector_type

LEAST = 1e-11  # relative: planes that can as good as not be told apart


@njit(**INLINE)
def _dynamic_stiffness(g: Gauges, speed: float, d: Desk) -> None:
    size, a = g.rows.shape[0], d.small
    for i in range(size):
        for j in range(size):
            a[i, j] = complex(-(speed * speed) * g.mass[i, j], speed * speed * g.gyroscopic[i, j])
    for k in range(g.model_speeds.size):
        share = share_of(k, g.model_speeds, speed)
        for i in range(size if share != 0.0 else 0):
            for j in range(size):
                a[i, j] += share * complex(g.model_stiffness[k, i, j], speed * g.model_damping[k, i, j])


@njit(**INLINE)
def _load(p: System, time: float, r: int) -> complex:
    """Entry r of the load of all unbalances."""
    k = segment_at(time, p)
    now = since(time, k, p)
    if p.host.size > 0:
        u = p.host.loads[k]
        return complex(u[2, r] + now * u[6, r], u[3, r] + now * u[7, r])
    own = p.drive.segments[k]
    x, y = own.unbalance_x + now * own.unbalance_rate_x, own.unbalance_y + now * own.unbalance_rate_y
    return complex(x, y) if r == 0 else complex(y, -x)


@njit(**INLINE)
def _weight(g: Gauges, k: int, greatest: float) -> float:
    """Capability of a plane; a full race can balance nothing."""
    if g.capability[k] > 0.0:
        return g.capability[k]
    return 1e-6 * greatest if greatest > 0.0 else 1.0


@njit(void(system_type, gauges_type, types.float64, types.float64, desk_type, complexes_type), **EXACT)
def plane_unbalances(p: System, g: Gauges, time: float, speed: float, d: Desk, wanted: Any) -> None:
    """The unbalance that the balls of each plane have to balance so that all planes rest, kg m in the rotor.

    It is what the unbalances do at the planes at this speed, put into these planes; on a planar rotor their sum. nan at a
    critical speed of an undamped rotor. Of many solutions it is the one that takes the least share of the capabilities.
    """
    size, planes, a = g.rows.shape[0], g.capability.size, d.small
    if g.scalars[PLANAR] != 0.0:
        for k in range(planes):
            wanted[k] = _load(p, time, 0)
        return
    _dynamic_stiffness(g, speed, d)
    for r in range(size):
        for k in range(planes):  # forces of a unit vector that turns with the rotor
            a[r, size + k] = complex(g.rows[r, 2 * k], -g.rows[r, 2 * k + 1])
        a[r, size + planes] = _load(p, time, r)
    if not solve(a, size, planes + 1):
        for k in range(planes):
            wanted[k] = complex(math.nan, math.nan)
        return
    greatest, host = 0.0, d.columns
    for k in range(planes):
        greatest = max(greatest, g.capability[k])
    for k in range(planes):
        for j in range(planes + 1):
            value = complex(0.0, 0.0)
            for r in range(size):
                value += complex(g.rows[r, 2 * k], g.rows[r, 2 * k + 1]) * a[r, size + j]
            host[k, j] = 0.5 * value
    for k in range(planes):
        for j in range(planes):
            host[k, j] *= _weight(g, j, greatest)
    least_squares(host, planes, 1, LEAST, a)
    for k in range(planes):
        wanted[k] = host[k, planes] * _weight(g, k, greatest)


@njit(**INLINE)
def _semi_major(x: complex, y: complex) -> float:
    """Greatest length of Re((x, y) e^(i theta))."""
    return 0.5 * (
        math.sqrt((x.real - y.imag) ** 2 + (x.imag + y.real) ** 2)
        + math.sqrt((x.real + y.imag) ** 2 + (x.imag - y.real) ** 2)
    )


@njit(void(system_type, gauges_type, types.float64, types.float64, desk_type, vector_type, vector_type), **EXACT)
def with_balls_held(p: System, g: Gauges, time: float, speed: float, d: Desk, vibration: Floats, force: Floats) -> None:
    """Greatest vibration of each place (m) and greatest vibrating force on each support (N) at a steady speed.

    The balls are spread evenly over their races and held, and nothing shakes the machine from outside. nan at a critical speed
    of an undamped rotor.
    """
    size, places, supports, a = g.rows.shape[0], g.rows.shape[1] // 2, g.weight.size // 2, d.small
    _dynamic_stiffness(g, speed, d)
    for r in range(size):
        a[r, size] = speed * speed * (_load(p, time, r) + complex(g.held_loads[0, r], g.held_loads[1, r]))
    if not solve(a, size, 1):
        for k in range(places):
            vibration[k] = math.nan
        for k in range(supports):
            force[k] = math.nan
        return
    for k in range(places):
        x, y = complex(0.0, 0.0), complex(0.0, 0.0)
        for r in range(size):
            x, y = x + g.rows[r, 2 * k] * a[r, size], y + g.rows[r, 2 * k + 1] * a[r, size]
        vibration[k] = _semi_major(x, y)
    for k in range(supports):
        x, y = complex(0.0, 0.0), complex(0.0, 0.0)
        for i in range(g.speeds.size):
            share = share_of(i, g.speeds, speed)
            for r in range(size if share != 0.0 else 0):
                stiff, damp = g.held_stiffness[i, r], g.held_damping[i, r]
                x += share * complex(stiff[2 * k], speed * damp[2 * k]) * a[r, size]
                y += share * complex(stiff[2 * k + 1], speed * damp[2 * k + 1]) * a[r, size]
        force[k] = _semi_major(x, y)
