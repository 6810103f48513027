"""How many modes a receptance has, and where: AAA proposes poles, an information criterion chooses their number."""

from __future__ import annotations

import math
import warnings

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import AAA

from autobalancer.measurement.modal_model import Fitting, Modes

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
EXACT = 1e-9  # a weighted root mean square error below this share is no noise


def best_modes(fitting: Fitting, frequency: Floats, values: Complexes, modes: int | None, most: int) -> Modes:
    """Orders one after the other; each starts from the order below and a new pole, and from poles of its own."""
    best, least, previous, worse = None, math.inf, None, 0
    for count in range(1, (modes or most) + 1):
        found = previous = fitting.search(_starts(frequency, values, count, previous))
        points = 2 * frequency.size
        score = points * math.log(max(found.misfit, 1e-300)) + (4 * count - 1) * math.log(points)
        if modes == count:
            return found
        if modes is None:
            if score < least:
                best, least, worse = found, score, 0
            else:
                worse += 1
            if worse == 2 or found.misfit < EXACT**2:
                break
    assert best is not None
    return best


def _starts(frequency: Floats, values: Complexes, count: int, previous: Modes | None) -> list[Complexes]:
    own = _proposals(frequency, values, 2 * count + 1)
    starts = [own[:count]] if own.size >= count else []
    if previous is None:
        return starts or [np.array([-0.05 + 1j]) * frequency[int(np.abs(values).argmax())]]
    poles, residues = previous.poles_and_residues()
    kept = poles[: previous.count]
    left = values - (residues / (1j * frequency[:, None] - poles)).sum(axis=1)
    fresh = [complex(pole) for pole in _proposals(frequency, left, 5)[:2]]
    fresh += [(-0.05 + 1j) * 2.5 * frequency[-1], (-0.05 + 1j) * 0.4 * frequency[0]]  # what lies outside the band
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
