"""What is measured while a speed is held.

Measured on the dense output of every step, at :data:`PIECES` equal parts of it and, between two of these, wherever a
radius stops growing or a ball turns back (rule of the Illinois).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import types

from autobalancer.kernels.flags import INLINE, PART, njit
from autobalancer.kernels.integrators.dense import component, slope
from autobalancer.kernels.integrators.memory import TAKEN, TIME
from autobalancer.kernels.integrators.record import PIECES
from autobalancer.kernels.pointers import behind
from autobalancer.kernels.system import BALLS, THETA, Floats, Matrix, matrix_type, system_at, vector_type


class Window(NamedTuple):
    """What is measured of S stations and n balls, in both halves of the window, and room for it."""

    rows: Matrix  # (2 S, R) deflection of the stations along x and y
    weights: Floats  # (S,) in the mean radius
    greatest: Matrix  # (2, S + 1) greatest radius of each station, then of their mean
    low: Matrix  # (2, n) least ball angle in the rotor
    high: Matrix  # (2, n) greatest
    ends: Matrix  # (2, n) at begin and end of the window
    forward: Matrix  # (S, 2) mean deflection in the rotor
    spent: Floats  # (3,) time on the way, relative change between the halves, weight of the mean
    place: Floats  # (R,) work
    move: Floats  # (R,) work
    points: Matrix  # (S, 2) work
    value: Floats  # (S + 1,) work
    growth: Floats  # (S + 1,) work
    before: Floats  # (S + 1,) work


window_type = types.NamedTuple(
    [
        matrix_type, vector_type, matrix_type, matrix_type, matrix_type, matrix_type, matrix_type,
        vector_type, vector_type, vector_type, matrix_type, vector_type, vector_type, vector_type,
    ],
    Window,
)  # fmt: skip


@njit(**PART)
def _look(x, count, seen):  # type: ignore[no-untyped-def]
    """Radii and their growth at the fraction x of the step; ``seen`` points to (memory, window)."""
    m, w = behind(seen)
    stations, size = w.weights.size, w.rows.shape[1]
    for k in range(size):
        i = k if k < 2 else BALLS + 2 * count + k - 2
        w.place[k], w.move[k] = component(i, x, m), slope(i, x, m)
    mean, growing = 0.0, 0.0
    for s in range(stations):
        a, b, da, db = 0.0, 0.0, 0.0, 0.0
        for k in range(size):
            a += w.rows[2 * s, k] * w.place[k]
            b += w.rows[2 * s + 1, k] * w.place[k]
            da += w.rows[2 * s, k] * w.move[k]
            db += w.rows[2 * s + 1, k] * w.move[k]
        radius = math.sqrt(a * a + b * b)
        rate = (a * da + b * db) / radius if radius > 0.0 else 0.0
        w.points[s, 0], w.points[s, 1] = a, b
        w.value[s], w.growth[s] = radius, rate
        mean += w.weights[s] * radius
        growing += w.weights[s] * rate
    w.value[stations], w.growth[stations] = mean, growing


@njit(**INLINE)
def _next_guess(low: float, high: float, f_low: float, f_high: float) -> float:
    return (low * f_high - high * f_low) / (f_high - f_low)


@njit(**PART)
def _turning_radius(k, left, right, f_left, f_right, count, seen):  # type: ignore[no-untyped-def]
    """Greatest value of radius k between two places where its growth has opposite signs."""
    _, w = behind(seen)
    low, high, f_low, f_high, best = left, right, f_left, f_right, 0.0
    for _ in range(6):
        x = _next_guess(low, high, f_low, f_high)
        _look(x, count, seen)
        best, f = max(best, w.value[k]), w.growth[k]
        if f * f_high < 0.0:
            low, f_low = high, f_high
        else:
            f_low *= 0.5
        high, f_high = x, f
        if f == 0.0 or abs(high - low) < 1e-9:
            break
    return best


@njit(**PART)
def _turning_angle(b, left, right, f_left, f_right, count, seen):  # type: ignore[no-untyped-def]
    """Angle of a ball where it turns back."""
    m, _ = behind(seen)
    low, high, f_low, f_high = left, right, f_left, f_right
    for _ in range(6):
        x = _next_guess(low, high, f_low, f_high)
        f = component(BALLS + count + b, x, m)
        if f * f_high < 0.0:
            low, f_low = high, f_high
        else:
            f_low *= 0.5
        high, f_high = x, f
        if f == 0.0 or abs(high - low) < 1e-9:
            break
    return component(BALLS + b, high, m)


@njit(**PART)
def note(left, begin, length, half, parameters, seen):  # type: ignore[no-untyped-def]
    """Fold the step that began at ``left`` into the window that began at ``begin``; it counts up to where it was cut."""
    p, (m, w) = behind(system_at(parameters)), behind(seen)
    count, radii, step = p.ball_count, w.weights.size + 1, m.clock[TAKEN]
    cut = min(1.0, (m.clock[TIME] - left) / step)
    for piece in range(PIECES + 1):
        x = cut * piece / PIECES
        _look(x, count, seen)
        # Simpson's rule over the pieces, and the weight of Hann, which lets no part of a turn leak into the mean
        share = cut * step / (3.0 * PIECES) * (1.0 if piece in (0, PIECES) else 4.0 if piece % 2 == 1 else 2.0)
        share *= 1.0 - math.cos(2.0 * math.pi * (left + x * step - begin) / length)
        c, s = 1.0, 0.0
        if p.rotating != 1:
            angle = component(THETA, x, m)
            c, s = math.cos(angle), math.sin(angle)
        w.spent[2] += share
        for k in range(radii - 1):
            a, b = w.points[k, 0], w.points[k, 1]
            w.forward[k, 0] += share * (a * c + b * s)
            w.forward[k, 1] += share * (b * c - a * s)
        for k in range(radii):
            w.greatest[half, k] = max(w.greatest[half, k], w.value[k])
            after = w.growth[k]
            if piece > 0 and w.before[k] > 0.0 and after < 0.0:
                best = _turning_radius(k, x - cut / PIECES, x, w.before[k], after, count, seen)
                w.greatest[half, k] = max(w.greatest[half, k], best)
                _look(x, count, seen)
            w.before[k] = w.growth[k]
        for ball in range(count):
            angle = component(BALLS + ball, x, m)
            w.low[half, ball], w.high[half, ball] = min(w.low[half, ball], angle), max(w.high[half, ball], angle)
            if piece == 0:
                continue
            back = x - cut / PIECES
            old, new = component(BALLS + count + ball, back, m), component(BALLS + count + ball, x, m)
            if old * new < 0.0:
                angle = _turning_angle(ball, back, x, old, new, count, seen)
                w.low[half, ball], w.high[half, ball] = min(w.low[half, ball], angle), max(w.high[half, ball], angle)
