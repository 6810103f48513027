"""Deflections, forces and unbalances at the places of a machine, from states of a run.

States stand in the rows of a ring with the time first; row ``first`` is the oldest.
"""

from __future__ import annotations

import math
from typing import Any

from numba import int64, types, void

from autobalancer.kernels.flags import EXACT, EXACT_PART, INLINE, njit
from autobalancer.kernels.host.hardening import central
from autobalancer.kernels.measures.gauges import RESOLVED, Desk, Gauges, desk_type, gauges_type
from autobalancer.kernels.measures.response import plane_unbalances
from autobalancer.kernels.measures.tables import segment_at, share_of, unbalance_at
from autobalancer.kernels.pointers import data, row
from autobalancer.kernels.records.resolved import BALL_STATES, BALL_VX, BALL_VY, BALL_X, BALL_Y
from autobalancer.kernels.system import (
    BALLS,
    SPEED,
    THETA,
    VX,
    Floats,
    Matrix,
    System,
    X,
    matrix_type,
    system_type,
    vector_type,
)
from autobalancer.kernels.trigonometry import sine_cosine

ball_type = types.UniTuple(types.float64, 2)


@njit(int64(vector_type), **EXACT)
def turns_of(angle: Floats) -> int:
    """How many of the last of these angles, at equal steps, make whole revolutions; the entry before them is their begin."""
    count = angle.size
    step = abs(angle[count - 1] - angle[count - 2]) if count > 1 else 0.0
    if not step > 0.0:
        return 0
    each = math.floor(2.0 * math.pi / step + 0.5)
    return (count - 1) // each * each if each > 0 else 0


@njit(ball_type(vector_type, int64, int64, int64, int64), **EXACT_PART)
def ball_at(y: Floats, i: int, count: int, size: int, resolved: int) -> tuple[float, float]:
    """Angle and speed of ball i of ``count`` in the rotor, for R = ``size`` coordinates.

    The angle that resolved balls carry counts the turns; position and velocity are exact even where one passed near the center.
    """
    angle, rate = y[BALLS + i], y[BALLS + count + i]
    if resolved == 0:
        return angle, rate
    own = 2 + 2 * size + 2 * count + i * BALL_STATES
    a, b = y[own + BALL_X], y[own + BALL_Y]
    s, c = sine_cosine(angle)
    square = max(a * a + b * b, 1e-30)
    return angle + math.atan2(b * c - a * s, a * c + b * s), (a * y[own + BALL_VY] - b * y[own + BALL_VX]) / square


@njit(void(matrix_type, int64, int64, int64, matrix_type, matrix_type), **EXACT)
def ball_motion(states: Matrix, count: int, size: int, resolved: int, angle: Matrix, rate: Matrix) -> None:
    """Angles (rad) and speeds (rad/s) of the balls in the rotor, (T, n) each, from states without their time."""
    for t in range(states.shape[0]):
        for i in range(count):
            angle[t, i], rate[t, i] = ball_at(states[t], i, count, size, resolved)


@njit(**INLINE)
def _dot(one: Any, at: int, step: int, values: Any, count: int) -> float:
    """Sum of every ``step``-th number from a place on, each times its value."""
    total = 0.0
    for k in range(count):
        total += one[at + k * step] * values[k]
    return total


@njit(**INLINE)
def _rotor(y: Any, p: System, size: int, s: float, c: float, d: Desk) -> None:
    """Coordinates and their velocities in space."""
    rest = BALLS + 2 * p.ball_count
    for r in range(0, size, 2):
        at, to = (X, VX) if r == 0 else (rest + r - 2, rest + size + r - 4)
        d.place[r], d.place[r + 1] = y[at] * c - y[at + 1] * s, y[at] * s + y[at + 1] * c
        d.move[r], d.move[r + 1] = y[to] * c - y[to + 1] * s, y[to] * s + y[to + 1] * c


@njit(**INLINE)
def _supports(y: Any, p: System, g: Gauges, s: float, c: float, d: Desk) -> None:
    """Force of the rotor on each support, its weight included, to ``d.push``; coordinates are known."""
    wide, size, push, weight = g.weight.size, g.rows.shape[0], data(d.push), data(g.weight)
    place, move, stiffness, damping = data(d.place), data(d.move), data(g.stiffness), data(g.damping)
    for i in range(wide):
        total = weight[i]
        for k in range(g.speeds.size):
            share = share_of(k, g.speeds, y[SPEED])
            if share != 0.0:
                at = k * size * wide + i
                total += share * (_dot(stiffness, at, wide, place, size) + _dot(damping, at, wide, move, size))
        push[i] = total
    for m in range(p.rubber.mounts.shape[0]):
        mount, a, b = p.rubber.mounts[m], 0.0, 0.0
        for e in range(mount.first, mount.first + mount.elements):
            at = p.rubber.elements[e].state
            a, b = a + y[at], b + y[at + 1]
        a, b = a * c - b * s, a * s + b * c
        for i in range(wide):
            push[i] += a * g.rubber[2 * m, i] + b * g.rubber[2 * m + 1, i]
    for h in range(p.bearings.springs.shape[0]):
        a, b = 0.0, 0.0
        for r in range(size):
            a += p.bearings.rows[2 * h, r] * place[r]
            b += p.bearings.rows[2 * h + 1, r] * place[r]
        a, b = central(row(p.bearings.springs, h), data(p.bearings.tables), a, b)
        for i in range(wide):
            push[i] += a * g.hard[2 * h, i] + b * g.hard[2 * h + 1, i]


@njit(void(system_type, gauges_type, matrix_type, int64, int64, int64, desk_type), **EXACT)
def see(p: System, g: Gauges, ring: Matrix, first: int, count: int, planes: int, d: Desk) -> None:
    """Fill ``d.seen`` and ``d.rotor`` from ``count`` states; ``planes`` 1: work out what each plane has to balance, too."""
    size, n, seen, wide = g.rows.shape[0], g.ball_mass.size, d.seen, g.rows.shape[1]
    rows, place, move, push, states = data(g.rows), data(d.place), data(d.move), data(d.push), data(ring)
    at_z, at_v, at_force, length = data(seen.z), data(seen.v), data(seen.force), ring.shape[1]
    places, supports, speed_before, before = wide // 2, g.weight.size // 2, 0.0, -1
    resolved = 1 if g.scalars[RESOLVED] != 0.0 else 0
    for t in range(count):
        number = (first + t) % ring.shape[0]
        time, y = states[number * length], ring[number, 1:]
        s, c = 0.0, 1.0
        if p.rotating == 1:
            s, c = sine_cosine(y[THETA])
        d.rotor[t] = y[THETA]
        _rotor(y, p, size, s, c, d)
        for k in range(places):
            x, z = _dot(rows, 2 * k, wide, place, size), _dot(rows, 2 * k + 1, wide, place, size)
            at_z[t * places + k] = complex(x, z)
            x, z = _dot(rows, 2 * k, wide, move, size), _dot(rows, 2 * k + 1, wide, move, size)
            at_v[t * places + k] = complex(x, z)
        _supports(y, p, g, s, c, d)
        for k in range(supports):
            at_force[t * supports + k] = complex(push[2 * k], push[2 * k + 1])
        x, z = unbalance_at(time, p)
        seen.unbalance[t, 0] = complex(x, z)
        for k in range(g.capability.size):
            seen.held[t, k] = 0.0
        total_x, total_y = 0.0, 0.0
        for i in range(n):
            angle, _ = ball_at(y, i, n, size, resolved)
            seen.angles[t, i] = y[THETA] + angle
            a, b = g.ball_mass[i] * g.ball_centers[i, 0], g.ball_mass[i] * g.ball_centers[i, 1]
            if resolved == 1:
                own = 2 + 2 * size + 2 * n + i * BALL_STATES
                a, b = a + g.ball_mass[i] * y[own + BALL_X], b + g.ball_mass[i] * y[own + BALL_Y]
            else:
                sine, cosine = sine_cosine(angle)
                a, b = a + g.ball_moment[i] * cosine, b + g.ball_moment[i] * sine
            total_x, total_y = total_x + a, total_y + b
            seen.held[t, g.ball_planes[i]] += complex(a, b)
        seen.left[t, 0] = complex(x + total_x, z + total_y)
        if planes == 1:
            k = segment_at(time, p)
            if k == before and y[SPEED] == speed_before and p.drive.segments[k].changing == 0:
                for i in range(g.capability.size):
                    seen.wanted[t, i] = seen.wanted[t - 1, i]
            else:
                plane_unbalances(p, g, time, y[SPEED], d, seen.wanted[t])
            before, speed_before = k, y[SPEED]
