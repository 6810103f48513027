"""The shape of a race as a table of its waves, and as lines of a machine file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.number_text import length_text
from autobalancer.shown import Column

CLEAR = 3.0  # deviations from which on a wave is one


class RaceShape(Answer):
    """Waves of a measured race."""

    __slots__ = ()
    drawn_by = "race_shape"
    row_of = "order"
    needed: ClassVar[tuple[str, ...]] = ("amplitude", "crest")

    def columns(self, unit: str = "") -> list[Column]:
        """Amplitude and crest of each wave with their standard deviations."""
        turn = 180.0 / np.pi
        return [
            Column("waves", self["order"].values.tolist()),
            Column("amplitude", 1e6 * self["amplitude"].values, "µm", ".3g"),
            Column("+-", 1e6 * self["amplitude_deviation"].values, "µm", ".2g"),
            Column("crest at", np.mod(turn * self["crest"].values, 360.0 / self["order"].values), "deg", ".1f"),
            Column("+-", turn * self["crest_deviation"].values, "deg", ".2g"),
        ]

    def facts(self) -> list[tuple[str, str]]:
        """Circle, center and roundness."""
        told = [("roundness", f"{length_text(float(self.attrs['roundness']))} from the lowest to the highest point")]
        if np.isfinite(self.attrs["radius"]):
            radius, sure = 1e3 * float(self.attrs["radius"]), length_text(float(self.attrs["radius_deviation"]))
            told.append(("radius", f"{radius:.6g} mm +- {sure}"))
        of = "of the race" if self.attrs["center"] == "axis" else "of the setup, taken away"
        size, way = float(self.attrs["eccentricity"]), np.degrees(float(self.attrs["eccentricity_angle"])) % 360.0
        sure = length_text(float(self.attrs["eccentricity_deviation"]))
        told.append(("eccentricity", f"{length_text(size)} +- {sure} at {way:.0f} deg, {of}"))
        told.append(("points scatter by", length_text(float(self.attrs["scatter"]))))
        return told

    def has_table(self) -> bool:
        """The circle must be known, too."""
        return super().has_table() and {"radius", "eccentricity", "roundness", "scatter"} <= set(self.attrs)

    def machine_lines(self) -> str:
        """Lines for a race of a machine file: waves that are clear of their uncertainty, and the eccentricity of the race."""
        lines = []
        if np.isfinite(self.attrs["radius"]):
            lines.append(f'race_radius = "{1e3 * float(self.attrs["radius"]):.5f} mm"')
        if self.attrs["center"] == "axis" and self.attrs["eccentricity"] > CLEAR * self.attrs["eccentricity_deviation"]:
            lines.append(f'eccentricity = "{1e6 * float(self.attrs["eccentricity"]):.4g} um"')
            lines.append(
                f'eccentricity_angle = "{np.degrees(float(self.attrs["eccentricity_angle"])) % 360.0:.5g} deg"'
            )
        clear = self["amplitude"].values > CLEAR * self["amplitude_deviation"].values
        waves = [
            f'    {{ order = {int(k)}, amplitude = "{1e6 * a:.4g} um", angle = "{np.degrees(crest) % (360.0 / k):.5g} deg" }},'
            for k, a, crest, one in zip(
                self["order"].values, self["amplitude"].values, self["crest"].values, clear, strict=True
            )
            if one
        ]
        if waves:
            lines += ["harmonics = [", *waves, "]"]
        return "\n".join(lines) + "\n"

    def remarks(self) -> Sequence[str]:
        """What to be careful about."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]
