"""A fitted receptance as a table of its modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from autobalancer.results.answers.answer import Answer
from autobalancer.results.number_text import share_text
from autobalancer.tables import Column


class FittedReceptance(Answer):
    """Modes of a receptance that was measured."""

    __slots__ = ()
    drawn_by = "receptance"
    row_of, shown_in = "mode", "Hz"
    needed: ClassVar[tuple[str, ...]] = ("mode_frequency", "mode_damping_ratio", "mode_mass")

    def columns(self, unit: str = "") -> list[Column]:
        """Frequency, damping ratio and mass of each mode, each with its standard deviation."""
        spread = Column("+-", self.scaled("mode_frequency_deviation", "+-", unit, ".2g").values, form=".2g")
        return [
            Column("mode", np.arange(1, self.sizes["mode"] + 1).tolist()),
            self.scaled("mode_frequency", "frequency", unit),
            spread,
            Column("damping ratio", 100.0 * self["mode_damping_ratio"].values, "%", ".4g"),
            Column("+-", 100.0 * self["mode_damping_ratio_deviation"].values, form=".2g"),
            Column("mass", self["mode_mass"].values, "kg", ".4g"),
            Column("+-", self["mode_mass_deviation"].values, form=".2g"),
        ]

    def facts(self) -> list[tuple[str, str]]:
        """How well it fits, and where."""
        low, high = (float(self.attrs[f"band_{end}"]) / (2.0 * np.pi) for end in ("low", "high"))
        return [("left over", share_text(float(self.attrs["fit_error"]))), ("band", f"{low:.4g} to {high:.4g} Hz")]

    def has_table(self) -> bool:
        """The band and the error of the fit must be known, too."""
        return super().has_table() and {"fit_error", "band_low", "band_high"} <= set(self.attrs)

    def remarks(self) -> Sequence[str]:
        """What to be careful about."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]


# A receptance as a sum over poles.


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
