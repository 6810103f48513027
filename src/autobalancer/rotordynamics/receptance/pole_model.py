"""A receptance as a sum over poles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


@dataclass(frozen=True)
class PoleModel:
    """A receptance sum r/(sigma - p) over all poles. ``added_mass``: of the balls, if it was measured without them."""

    poles: Complexes
    residues: Complexes
    added_mass: float = 0.0

    def receptance(self, sigma: Complexes) -> Complexes:
        """H(sigma) with the balls on the rotor, m/N."""
        bare = (self.residues / (sigma[..., None] - self.poles)).sum(axis=-1)
        return np.asarray(bare / (1.0 + self.added_mass * sigma**2 * bare), np.complex128)

    def at(self, frequency: Floats) -> Complexes:
        """H(i frequency), m/N."""
        return self.receptance(np.asarray(1j * frequency, np.complex128))
