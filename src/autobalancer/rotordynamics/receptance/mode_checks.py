"""Which fitted modes are modes: those that show in more than a few lines and stand out of the noise."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from autobalancer.rotordynamics.receptance.noise import NoiseShapes
from autobalancer.rotordynamics.receptance.pole_search import Found, Progress, best_order, one_less

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
FEW = 3  # lines; a mode shows in more of them, a disturbance of one frequency does not, whatever the window
SAFE = 10.0  # standard deviations of its strength from which on a mode need not be tried to do without
CLEAR = 3.0  # standard deviations of its strength that a mode must exceed
SURE = 9.0  # a line this far from the fit, as a log probability beyond that of the worst of all lines, is no noise: e^-9 = 1e-4
NEAR = math.log(1.5)  # how far from its frequency a mode must stand out
ROUNDS = 6  # of leaving out lines and fitting anew; what is left after them stays in
DIGITS = 1e-12  # of the greatest value: the arithmetic of a fit leaves this of exact values, which is no disturbance
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
        found = best_order(part, modes, most, progress)
        lines = lone_lines(found, part) if modes is None else np.zeros(0, np.int64)
        if lines.size == 0 or (~kept).sum() + lines.size > max(FEW, MOST * kept.size):
            break
        kept[np.flatnonzero(kept)[lines]] = False
    found, dropped = (found, []) if modes is not None else without_weak(part, found)
    return found, kept, dropped


def without_weak(noise: NoiseShapes, found: Found) -> tuple[Found, list[float]]:
    """The fit without modes that the criterion or their own uncertainty is against; and where the latter were."""
    dropped: list[float] = []
    while found.modes.count > 1 and math.isfinite(found.score):
        weak = weak_modes(found, noise.frequency)
        doubted = {*weak, *np.flatnonzero(strengths(found, noise.frequency) < SAFE).tolist()}
        fewer = {i: one_less(noise, found, i) for i in doubted}
        better = [i for i in fewer if fewer[i].score < found.score]
        if not (weak or better):
            break
        least = min(better or weak, key=lambda i: fewer[i].score)
        if least in weak:
            dropped.append(float(frequencies(found)[least]))
        found = fewer[least]
    return found, dropped


def lone_lines(found: Found, noise: NoiseShapes) -> NDArray[np.int64]:
    """Lines that stand for themselves: far from the fit, or reached by modes fitted to no more than ``FEW`` of them."""
    fitted, parts = found.modes.at(noise.frequency), found.modes.parts(noise.frequency)
    left = np.abs(noise.values - fitted) ** 2
    variance = np.maximum(found.variance, (DIGITS * np.abs(noise.values).max()) ** 2)
    far = left / variance > math.log(noise.frequency.size) + SURE
    lone = _short_runs(far)
    for near in _groups(found, noise.frequency):
        part = parts[:, near].sum(axis=1)
        gain = (np.abs(noise.values - fitted + part) ** 2 - left) / variance
        strongest = np.argsort(gain)[::-1][:FEW]
        if gain.sum() - gain[strongest].sum() < cost(gain.size):
            lone += [int(i) for i in strongest if gain[i] > math.log(gain.size)]
    return np.unique(np.array(lone, np.int64))


def _short_runs(far: NDArray[np.bool_]) -> list[int]:
    """Indices in runs of no more than ``FEW``; longer ones are something that is not yet fitted."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], far.astype(np.int8), [0]])))
    runs = [range(int(start), int(end)) for start, end in zip(edges[::2], edges[1::2], strict=True)]
    return [i for run in runs if len(run) <= FEW for i in run]


def _groups(found: Found, frequency: Floats) -> list[NDArray[np.int64]]:
    """Modes within the band, together where they are nearer than ``FEW`` lines: then they may cancel each other."""
    at = frequencies(found)
    inside = np.flatnonzero((at >= frequency[0]) & (at <= frequency[-1]))
    inside = inside[np.argsort(at[inside])]
    places = np.interp(at[inside], frequency, np.arange(frequency.size))
    return np.split(inside, np.flatnonzero(np.diff(places) > FEW) + 1) if inside.size else []


def weak_modes(found: Found, frequency: Floats) -> list[int]:
    """Modes that cannot be told from noise or drift.

    Within the band: those whose strength at the race does not exceed its uncertainty clearly, or that do not stand out near
    their own frequency. Outside of it: those beyond an end where the noise is greater than the receptance. Below it also
    those that are overdamped or of no clear strength: above itself a mode acts as its mass alone, so that is well known.
    """
    at, unclear = frequencies(found), strengths(found, frequency) < CLEAR
    shares = np.abs(found.modes.parts(frequency)) ** 2 / found.variance[:, None]
    near = np.abs(np.log(frequency[:, None] / at)) < NEAR
    unseen = (shares * near).sum(axis=0) < cost(frequency.size)
    hidden = np.abs(found.modes.at(frequency)) ** 2 < found.variance
    below, above = at < frequency[0], at > frequency[-1]
    overdamped = np.exp(found.modes.shapes[: at.size]) > 2.0 * at
    weak = ~below & ~above & (unseen | unclear)
    weak |= below & (unclear | overdamped | hidden[:FEW].all())
    weak |= above & hidden[-FEW:].all()
    return [int(i) for i in np.flatnonzero(weak)]


def cost(lines: int) -> float:
    """What a mode must gain, in squares of deviations over the variance, for the criterion to be for it."""
    return 2.0 * math.log(2 * lines)


def strengths(found: Found, frequency: Floats) -> Floats:
    """Of each mode at the race, one over its mass, in its standard deviations."""
    k = found.modes.count
    variance = np.diag(covariance(found, frequency))[2 * k : 3 * k]
    return np.asarray(np.abs(found.modes.numerators[:, 0]) / np.sqrt(np.maximum(variance, 1e-300)))


def frequencies(found: Found) -> Floats:
    """Of the modes, undamped."""
    return np.asarray(np.exp(0.5 * found.modes.shapes[found.modes.count :]))


def covariance(found: Found, frequency: Floats) -> Floats:
    """Of the parameters of :meth:`Modes.slopes`; the noise has half its variance in either part of a value."""
    slopes = found.modes.slopes(frequency) / np.sqrt(0.5 * found.variance)[:, None]
    stacked = np.concatenate([slopes.real, slopes.imag])
    size = np.linalg.norm(stacked, axis=0)
    inverse = np.linalg.pinv(stacked / size)
    return np.asarray((inverse @ inverse.T) / np.outer(size, size))
