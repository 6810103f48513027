"""The orbit of a race that is not round: eps(phi), a Fourier series, and the point of it that is closest to a ball."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.compiler.cache import njit
from autobalancer.kernels.compiler.flags import INLINE
from autobalancer.kernels.trigonometry import sine_cosine

CLOSE = 1e-6  # rad; Newton's next step would be shorter than the square of the last one times the order of the waves
STEPS = 20


@njit(**INLINE)
def orbit(waves: Any, ball: Any, mean: float, c: float, s: float) -> tuple[float, float, float]:
    """Radius and its first two derivatives at the angle with cosine c and sine s; a circle where the ball has no waves."""
    radius, first, second = mean, 0.0, 0.0
    cosine, sine = c, s
    for h in range(1, ball.waves + 1):
        wave = waves[ball.first_wave + h - 1]
        radius += wave.cosine * cosine + wave.sine * sine
        first += h * (wave.sine * cosine - wave.cosine * sine)
        second -= h * h * (wave.cosine * cosine + wave.sine * sine)
        cosine, sine = cosine * c - sine * s, sine * c + cosine * s
    return radius, first, second


@njit(**INLINE)
def closest(waves: Any, ball: Any, mean: float, x: float, z: float, c: float, s: float) -> tuple[float, float, float]:
    """How far (x, z) is outside the orbit, and the outward normal of the orbit there; c and s are its direction.

    Newton's method for (P - C).C' = 0 from the point at the same angle. The distance is exact up to rounding where it is
    less than the radius of curvature, its gradient is the normal, and so a force that depends on it has a potential.
    """
    radius, first, second = orbit(waves, ball, mean, c, s)
    out, along = x * c + z * s - radius, 0.0
    path = radius * radius + first * first
    for _ in range(STEPS):
        bent = path - out * (second - radius) - 2.0 * along * first
        step = (out * first + along * radius) / max(
            bent, 0.25 * path
        )  # the bound keeps a far point on its way downhill
        turned, kept = sine_cosine(step)
        c, s = c * kept - s * turned, s * kept + c * turned
        radius, first, second = orbit(waves, ball, mean, c, s)
        out, along = x * c + z * s - radius, z * c - x * s
        path = radius * radius + first * first
        if abs(step) < CLOSE:
            break
    length = math.sqrt(path)
    even, odd = radius / length, first / length
    return out * even - along * odd, even * c + odd * s, even * s - odd * c
