"""Lines of a spectrum: where they are, how large, and what they may come from."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.optimize import brentq

Floats = NDArray[np.float64]
ABOVE = 4.0  # times the noise about it
ABOUT = 41  # frequencies from which the noise is judged
MOST = 12  # lines of a channel, the strongest
LEAST = 1e-3  # of the strongest


def found_lines(frequency: Floats, amplitude: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Frequency (rad/s) and amplitude of each line, ascending.

    The place between two frequencies is that at which the transform of the window has the ratio of the two amplitudes, and the
    amplitude is corrected by its height there, so that neither depends on where the line falls.

    Parameters
    ----------
    frequency, amplitude
        Of the spectrum, rad/s, ascending from zero.
    weights
        Of the window.
    """
    noise = median_filter(amplitude, ABOUT, mode="nearest")
    inner = amplitude[1:-1]
    peaks = 1 + np.flatnonzero((inner > amplitude[:-2]) & (inner >= amplitude[2:]) & (inner > ABOVE * noise[1:-1]))
    peaks = peaks[(peaks > 1) & (amplitude[peaks] > LEAST * amplitude.max())]
    peaks = np.sort(peaks[np.argsort(-amplitude[peaks])][:MOST])
    step = float(frequency[1] - frequency[0])
    places, sizes = [], []
    for k in peaks:
        side = 1 if amplitude[k + 1] >= amplitude[k - 1] else -1
        offset = _offset(float(amplitude[k + side] / amplitude[k]), weights)
        places.append(frequency[k] + side * offset * step)
        sizes.append(amplitude[k] / _height(offset, weights))
    return np.array(places, np.float64), np.array(sizes, np.float64)


def _height(offset: float, weights: Floats) -> float:
    """Transform of the window so many frequencies beside its middle, over that at the middle."""
    turns = 2.0 * math.pi * offset * np.arange(weights.size) / weights.size
    return float(abs((weights * np.exp(-1j * turns)).sum()) / weights.sum())


def _offset(ratio: float, weights: Floats) -> float:
    def miss(offset: float) -> float:
        return _height(1.0 - offset, weights) - ratio * _height(offset, weights)

    if miss(0.0) >= 0.0:
        return 0.0
    return float(brentq(miss, 0.0, 0.5, xtol=1e-9)) if miss(0.5) > 0.0 else 0.5


def named_lines(frequency: Floats, amplitude: Floats, speed: float, natural: Sequence[float], near: float) -> list[str]:
    """A name for each line.

    Multiples of the speed are orders. The strongest other line below the speed is called subsynchronous: in a balancer it is
    the speed of balls that do not turn with the rotor, or a whirl. Its multiples, its mirror at the speed, and the beat of
    both are named after it.

    Parameters
    ----------
    frequency, amplitude
        Of the lines; rad/s.
    speed
        Of the rotor, rad/s; nan if it is not known.
    natural
        Natural frequencies, rad/s.
    near
        So near are two frequencies the same, rad/s.
    """
    names = [_natural(f, natural, near) for f in frequency]
    if not math.isfinite(speed):
        return names
    orders = np.rint(frequency / speed)
    synchronous = (np.abs(frequency - orders * speed) <= near) & (orders > 0)
    slow = np.flatnonzero((frequency < speed - near) & ~synchronous)
    first = float(frequency[slow[np.argmax(amplitude[slow])]]) if slow.size else math.nan
    found = []
    for f, order, exact, text in zip(frequency, orders, synchronous, names, strict=True):
        if exact:
            own = f"order {order:g}"
        elif f == first:
            own = f"subsynchronous, {f / speed:.3f} of the speed: balls that turn at {f:.4g} rad/s, or a whirl"
        elif math.isfinite(first):
            own = _of_the_first(float(f), first, speed, near)
        else:
            own = f"{f / speed:.3f} of the speed"
        found.append("; ".join(part for part in (own, text) if part))
    return found


def _of_the_first(f: float, first: float, speed: float, near: float) -> str:
    multiple = round(f / first)
    if multiple > 1 and abs(f - multiple * first) <= near:
        return f"{multiple} times the subsynchronous line"
    for value, text in (
        (2.0 * speed - first, "mirror of the subsynchronous line"),
        (speed - first, "speed less that line"),
    ):
        if abs(f - value) <= near:
            return text
    if abs(f - speed - first) <= near:
        return "speed and that line together"
    return f"{f / speed:.3f} of the speed"


def _natural(f: float, natural: Sequence[float], near: float) -> str:
    close = [value for value in natural if abs(value - f) <= 2.0 * near]
    return f"near the natural frequency {min(close, key=lambda v: abs(v - f)):.4g} rad/s" if close else ""
