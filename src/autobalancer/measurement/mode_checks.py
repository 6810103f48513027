"""Which fitted modes are modes: those that show in more than a few lines and exceed their own uncertainty."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from autobalancer.measurement.noise import NoiseShapes
from autobalancer.measurement.pole_search import Found, Progress, orders

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
FEW = 3  # lines; a mode shows in more of them, a disturbance of one frequency does not, whatever the window
CLEAR = 3.0  # standard deviations of its strength that a mode must exceed
SURE = 9.0  # a line this far from the fit, as a log probability beyond that of the worst of all lines, is no noise
ROUNDS = 6
MOST = 0.05  # share of the lines that may be left out as disturbed


def sure_modes(
    noise: NoiseShapes, modes: int | None, most: int, progress: Progress | None
) -> tuple[Found, NDArray[np.bool_], list[float]]:
    """The modes; which lines they were found from; and the frequencies of modes that were dropped.

    With a number of ``modes`` given, nothing is dropped.
    """
    kept = np.ones(noise.frequency.size, np.bool_)
    for _ in range(ROUNDS):
        part = noise.only(kept)
        found = orders(part, modes, most, progress)
        lines = lone_lines(found[-1], part) if modes is None else np.zeros(0, np.int64)
        if lines.size == 0 or (~kept).sum() + lines.size > max(FEW, MOST * kept.size):
            break
        kept[np.flatnonzero(kept)[lines]] = False
    dropped: list[float] = []
    while modes is None and len(found) > 1:
        weak = weak_modes(found[-1], part.frequency)
        if not weak:
            break
        dropped += weak
        found.pop()
    return found[-1], kept, dropped


def lone_lines(found: Found, noise: NoiseShapes) -> NDArray[np.int64]:
    """Lines that stand for themselves: far from the fit, or reached by modes fitted to no more than ``FEW`` of them."""
    fitted, parts = found.modes.at(noise.frequency), found.modes.parts(noise.frequency)
    left = np.abs(noise.values - fitted) ** 2
    far = left / found.variance > math.log(noise.frequency.size) + SURE
    lone = _short_runs(far)
    for near in _groups(found, noise.frequency):
        part = parts[:, near].sum(axis=1)
        gain = (np.abs(noise.values - fitted + part) ** 2 - left) / found.variance
        strongest = np.argsort(gain)[::-1][:FEW]
        if gain.sum() - gain[strongest].sum() < 2.0 * math.log(2 * gain.size):  # what a mode costs in the criterion
            lone += [int(i) for i in strongest if gain[i] > math.log(gain.size)]
    return np.unique(np.array(lone, np.int64))


def _short_runs(far: NDArray[np.bool_]) -> list[int]:
    """Indices in runs of no more than ``FEW``; longer ones are something that is not yet fitted."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], far.astype(np.int8), [0]])))
    runs = [range(int(start), int(end)) for start, end in zip(edges[::2], edges[1::2], strict=True)]
    return [i for run in runs if len(run) <= FEW for i in run]


def _groups(found: Found, frequency: Floats) -> list[NDArray[np.int64]]:
    """Modes within the band, together where they are nearer than ``FEW`` lines: then they may cancel each other."""
    at = np.exp(0.5 * found.modes.shapes[found.modes.count :])
    inside = np.flatnonzero((at >= frequency[0]) & (at <= frequency[-1]))
    inside = inside[np.argsort(at[inside])]
    places = np.interp(at[inside], frequency, np.arange(frequency.size))
    return np.split(inside, np.flatnonzero(np.diff(places) > FEW) + 1) if inside.size else []


def weak_modes(found: Found, frequency: Floats) -> list[float]:
    """Frequencies of modes within the band whose strength at the race is not more than its uncertainty."""
    k = found.modes.count
    at, strength = np.exp(0.5 * found.modes.shapes[k:]), np.abs(found.modes.numerators[:, 0])
    deviation = np.sqrt(np.maximum(np.diag(covariance(found, frequency))[2 * k : 3 * k], 0.0))
    inside = (at >= frequency[0]) & (at <= frequency[-1])
    return [float(value) for value in at[inside & (strength < CLEAR * deviation)]]


def covariance(found: Found, frequency: Floats) -> Floats:
    """Of the parameters of :meth:`Modes.slopes`; the noise has half its variance in either part of a value."""
    slopes = found.modes.slopes(frequency) / np.sqrt(0.5 * found.variance)[:, None]
    stacked = np.concatenate([slopes.real, slopes.imag])
    size = np.linalg.norm(stacked, axis=0)
    inverse = np.linalg.pinv(stacked / size)
    return np.asarray((inverse @ inverse.T) / np.outer(size, size))
