"""How many modes a receptance has, and where: AAA proposes poles, an information criterion chooses their number."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import AAA

from autobalancer.rotordynamics.receptance.modal_model import Fitting, Modes
from autobalancer.rotordynamics.receptance.noise import NoiseShapes, smoothed

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Progress = Callable[[float, float], None]
EXACT = 1e-9  # a root mean square deviation below this share of the values is no noise
PASSES = 6  # of fit and noise in turn
SETTLED = 0.02  # change of the noise below which another pass is not needed
WORSE = 2  # so many orders without a better score end the search
FEWEST = 8  # lines that may propose poles
CLEAR = 3.0  # lines with so many times their noise may propose poles
DAMPED = 0.05  # damping ratio of a pole that is guessed; the refinement finds its own
SHARP = 0.02  # of one guessed at the line that stands out most from the fit so far
OUTSIDE = 2.5  # a guess outside the band is so many times beyond its end


@dataclass(frozen=True)
class Found:
    """Modes, the variance of the noise in which they were found, and their Bayesian information criterion."""

    modes: Modes
    variance: Floats
    score: float  # -inf: exact


def best_order(noise: NoiseShapes, modes: int | None, most: int, progress: Progress | None = None) -> Found:
    """Orders one after the other; each starts from the order below and a new pole, and from poles of its own."""
    clear = np.abs(smoothed(noise.values)) > CLEAR * np.sqrt(noise.start)
    clear = clear if clear.sum() >= FEWEST else np.ones_like(clear)
    fitting = Fitting(noise.frequency, noise.values, 1.0 / np.sqrt(noise.start * noise.values.size))
    best, previous = None, None
    for count in range(1, (modes or most) + 1):
        if progress is not None:
            progress(count - 1, modes or most)
        previous = fitting.search(_starts(noise, clear, count, previous))
        found = with_its_noise(noise, previous, noise.start)
        if best is None or found.score < best.score or modes is not None:
            best = found
        if modes is None and (count - best.modes.count == WORSE or math.isinf(found.score)):
            break
    assert best is not None
    return best


def with_its_noise(noise: NoiseShapes, modes: Modes, variance: Floats) -> Found:
    """The fit whose weights are the noise that it leaves, from ``modes`` fitted with this ``variance``."""
    values = noise.values
    for _ in range(PASSES):
        fitted = modes.at(noise.frequency)
        squares = np.abs(values - fitted) ** 2
        if float((squares / np.abs(values) ** 2).mean()) < EXACT**2:
            return Found(modes, np.maximum(squares.mean(), 1e-30 * np.abs(values) ** 2), -math.inf)
        before, variance = variance, noise.variances(fitted, squares, modes.taken(noise.frequency, variance))
        if np.abs(np.log(variance / before)).max() < SETTLED:
            break
        modes = Fitting(noise.frequency, values, 1.0 / np.sqrt(variance * values.size)).refined(modes)
    squares = np.abs(values - modes.at(noise.frequency)) ** 2
    unlikely = 2.0 * float((np.log(variance) + squares / variance).sum())
    return Found(modes, variance, unlikely + (4 * modes.count - 1) * math.log(2 * values.size))


def one_less(noise: NoiseShapes, found: Found, number: int) -> Found:
    """The fit that begins with all modes but one."""
    fitting = Fitting(noise.frequency, noise.values, 1.0 / np.sqrt(found.variance * noise.values.size))
    return with_its_noise(noise, fitting.refined(found.modes.without(number)), found.variance)


def _starts(noise: NoiseShapes, clear: NDArray[np.bool_], count: int, previous: Modes | None) -> list[Complexes]:
    frequency, values = noise.frequency[clear], noise.values[clear]
    own = _proposals(frequency, values, 2 * count + 1)
    starts = [own[:count]] if own.size >= count else []
    if previous is None:
        return [*starts, np.array([-DAMPED + 1j]) * frequency[int(np.abs(values).argmax())]]
    kept, left = previous.poles_and_residues()[0][: previous.count], values - previous.at(frequency)
    fresh = [complex(pole) for pole in _proposals(frequency, left, 5)[:2]]
    worst = int((np.abs(smoothed(left)) / np.sqrt(noise.start[clear])).argmax())
    fresh.append((-SHARP + 1j) * frequency[worst])
    fresh += [(-DAMPED + 1j) * at for at in (OUTSIDE * frequency[-1], frequency[0] / OUTSIDE)]
    return starts + [np.append(kept, pole) for pole in fresh]


def _proposals(frequency: Floats, values: Complexes, terms: int) -> Complexes:
    """Poles of the AAA approximant, one of each pair, on the stable side, the greatest contribution first."""
    points = np.concatenate([1j * frequency, -1j * frequency])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that the tolerance was not reached with so few terms is meant to be so
        found = AAA(points, np.concatenate([values, values.conj()]), max_terms=terms, clean_up=False)
    poles, residues = np.asarray(found.poles(), np.complex128), np.asarray(found.residues(), np.complex128)
    keep = np.isfinite(poles) & (poles.imag >= 0.0) & (np.abs(poles) > 0.0)
    poles, residues = poles[keep], residues[keep]
    nearest = np.abs(points[:, None] - poles).min(axis=0, initial=np.inf) + np.abs(poles.real)
    poles = -np.maximum(np.abs(poles.real), 1e-6 * np.abs(poles)) + 1j * poles.imag
    return np.asarray(poles[np.argsort(-np.abs(residues) / nearest)], np.complex128)
