"""How the response of a rotor with rings of liquid shows itself."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import speed_axis
from autobalancer.shown import Column, rpm_and_si

ROWS = 12


class LiquidResponse(Answer):
    """Deflection over the speed with the liquid and without."""

    __slots__ = ()
    drawn_by = "liquid_response"
    row_of, needed = "speed", ("deflection", "without_liquid", "share")

    def facts(self) -> Sequence[tuple[str, str]]:
        """Masses, critical speeds, and where small motions grow."""
        return self.rows()

    def rows(self, said: Callable[[float], str] = rpm_and_si) -> list[tuple[str, str]]:
        """The same with speeds as ``said`` writes them."""
        a = self.attrs
        share = 100.0 * a["rotor_mass"] / (a["rotor_mass"] + a["full_mass"])
        rows = [
            ("liquid", f"{a['liquid_mass']:.4g} kg; it moves with the rotor like {a['full_mass']:.4g} kg"),
            (
                "critical speed",
                f"{said(a['critical_speed'])}; without liquid {said(a['dry_critical_speed'])}",
            ),
            ("far above it", f"leaves {share:.3g} % of the deflection without liquid"),
        ]
        if np.isfinite(a["unstable_from"]):
            band = f"{said(a['unstable_from'])} to {said(a['unstable_to'])}"
            rows.append(("self-excited", f"{band}: waves of the liquid and the rotor, without any damping"))
        return rows

    def columns(self, unit: str = "") -> list[Column]:
        """Speed, deflection without and with liquid, their ratio, and what the wall of the ring is like."""
        at = self._some()
        shown = speed_axis(unit or self.shown_in)
        return [
            Column("speed", at["speed"].values * shown.factor, shown.sign, ".5g"),
            Column("without liquid", 1e3 * at["without_liquid"].values, "mm", ".4g"),
            Column("liquid", 1e3 * at["deflection"].values, "mm", ".4g"),
            Column("share", 100.0 * at["share"].values, "%", ".3g"),
            Column("growth", at["growth_rate"].values, "1/s", ".3g"),
            Column("wall", [str(text) for text in at["wall"].values]),
        ]

    def remarks(self) -> Sequence[str]:
        """What is not in it."""
        return (str(self.attrs["leaves_out"]), *super().remarks())

    def _some(self) -> LiquidResponse:
        count = self.sizes["speed"]
        rows = np.unique(np.linspace(0, count - 1, min(count, ROWS)).round().astype(int))
        return LiquidResponse.of(self.isel(speed=rows))
