"""Plans of samples: numbers between 0 and 1 for every draw, the same whoever asks for them, and in whatever pieces."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from autobalancer.random_numbers import generator

Floats = NDArray[np.float64]
Plan = Literal["random", "sobol", "latin_hypercube", "sensitivity"]
PLANS = ("random", "sobol", "latin_hypercube", "sensitivity")
BLOCK = 1024  # draws that come from one generator
LEAST = 2.0**-54  # keeps infinity out of normal distributions
_DRAWS, _AGAIN, _WHOLE = 1, 2, 3  # streams of random numbers


def shares(plan: Plan, seed: int, width: int, draws: NDArray[np.int64], total: int) -> Floats:
    """Numbers between 0 and 1 of some draws.

    Parameters
    ----------
    plan
        How they are placed.
    seed
        Equal seeds, equal numbers.
    width
        How many numbers a draw has.
    draws
        Which draws, counted from 0.
    total
        Draws of the whole plan.

    Returns
    -------
    numpy.ndarray
        (draws, width).
    """
    if width == 0 or draws.size == 0:
        return np.zeros((draws.size, width))
    if plan == "random":
        blocks = draws // BLOCK
        found = np.empty((draws.size, width))
        for block in np.unique(blocks):
            here = blocks == block
            found[here] = _block(seed, int(block), width)[draws[here] % BLOCK]
    elif plan == "sensitivity":
        found = _columns_changed(seed, width, draws, total)
    else:
        found = _whole(plan, seed, width, total)[draws]
    return np.clip(found, LEAST, 1.0 - 2.0**-53)


def drawn_again(seed: int, width: int, draw: int, attempt: int) -> Floats:
    """Numbers for a draw that is to be taken once more, (1, width)."""
    return np.clip(generator(seed, _AGAIN, draw, attempt).random((1, width)), LEAST, 1.0 - 2.0**-53)


def correlated(share: Floats, factor: Floats | None) -> Floats:
    """The same numbers with the correlations of ``factor``, (draws, width)."""
    return share if factor is None else np.asarray(ndtr(ndtri(share) @ factor.T))


@lru_cache(maxsize=8)
def _block(seed: int, block: int, width: int) -> Floats:
    return generator(seed, _DRAWS, block).random((BLOCK, width))


@lru_cache(maxsize=4)
def _whole(plan: str, seed: int, width: int, total: int) -> Floats:
    from scipy.stats import qmc

    source = generator(seed, _WHOLE)
    if plan == "latin_hypercube":
        return np.asarray(qmc.LatinHypercube(width, rng=source).random(total))
    return _sobol(source, width, total)


def _sobol(source: Any, width: int, total: int) -> Floats:
    """Sobol' points, scrambled; made as many as a power of 2, of which the first are the same for any total."""
    from scipy.stats import qmc

    return np.asarray(qmc.Sobol(width, rng=source).random_base2(max(total - 1, 1).bit_length())[:total])


# For Sobol' indices (Saltelli 2002) a base sample is run with its numbers A, with other numbers B, and with A in which one
# number is taken from B: width + 2 runs.


def _columns_changed(seed: int, width: int, draws: NDArray[np.int64], total: int) -> Floats:
    both = _whole_pair(seed, width, total // (width + 2))
    base, which = np.divmod(draws, width + 2)
    found = np.where((which == 1)[:, None], both[base, width:], both[base, :width])
    changed = which >= 2
    column = which[changed] - 2
    found[changed, column] = both[base[changed], width + column]
    return found


@lru_cache(maxsize=4)
def _whole_pair(seed: int, width: int, bases: int) -> Floats:
    return _sobol(generator(seed, _WHOLE), 2 * width, bases)
