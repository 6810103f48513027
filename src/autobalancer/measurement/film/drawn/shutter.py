"""When pictures are taken, and at which instants the light of one picture falls."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.drawn.camera import Exposure
from autobalancer.results.drawn.motion import Motion

Floats = NDArray[np.float64]
STEP = 0.7  # pixels between instants
MOST = 64  # instants of one flash


def picture_times(motion: Motion, start: float, end: float, exposure: Exposure) -> Floats:
    """Middle of the light of each picture, s.

    Raises
    ------
    QuestionError
        If a stroboscope that follows the rotor has no turn.
    """
    if exposure.stroboscope != "turn":
        step = 1.0 / exposure.frame_rate
        return np.asarray(start + step * np.arange(int(np.floor((end - start) / step * (1.0 + 1e-12))) + 1))
    rotor = motion.at(np.linspace(start, end, 2)).rotor_angle / (2.0 * np.pi)
    passed = np.arange(np.ceil(rotor[0]), np.floor(rotor[1]) + 1.0)
    flashes = _times_of(motion, 2.0 * np.pi * passed, start, end)
    kept: list[float] = []
    for flash in flashes:
        if not kept or flash - kept[-1] >= (1.0 - 1e-6) / exposure.frame_rate:
            kept.append(float(flash))
    if not kept:
        raise QuestionError(f"stroboscope: the rotor makes no full turn from {start:g} s to {end:g} s")
    return np.array(kept)


def _times_of(motion: Motion, angles: Floats, start: float, end: float) -> Floats:
    """When the rotor passes angles (rad), by bisection, which no shape of a run-up can mislead."""
    low, high = np.full(angles.size, start), np.full(angles.size, end)
    for _ in range(60):
        middle = 0.5 * (low + high)
        before = motion.at(middle).rotor_angle < angles
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    return np.asarray(0.5 * (low + high))


def instants_of(motion: Motion, moment: float, exposure: Exposure, pixels: float) -> Floats:
    """Instants whose mean is one picture; ``pixels`` is the orbit radius in the picture."""
    first, last = float(motion.time[0]), float(motion.time[-1])
    lit = float(exposure.time)
    if isinstance(exposure.stroboscope, int | float):
        half = 0.5 / exposure.frame_rate
        rate = float(exposure.stroboscope)
        number = np.arange(np.ceil((moment - half) * rate), np.ceil((moment + half) * rate))
        middles = number / rate if number.size else np.array([moment])
        lit = min(lit, 1.0 / rate)
    else:
        middles = np.array([moment])
    at = motion.at(np.clip([moment], first, last))
    way = lit * pixels * (abs(float(at.speed[0])) + float(np.abs(motion.ball_slip).max(initial=0.0)))
    count = int(np.clip(np.ceil(way / STEP), 1, max(1, MOST // middles.size)))
    within = lit * ((np.arange(count) + 0.5) / count - 0.5)
    return np.clip((middles[:, None] + within).ravel(), first, last)
