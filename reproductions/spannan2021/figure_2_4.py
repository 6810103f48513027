"""Figure 2.4: how much of its potential a race exploits when its balls occupy a sector.

The figure prints no numbers, and what the text says of it, greatest at half of the annulus and less from every further ball,
follows from the closed form of (2.3) itself. So there is a picture and no row; the closed form against the sum is a test.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.laws.capabilities import potential_ratio
from autobalancer.plots.style import BALLS, CRITICAL, INK, look, picture

RATIOS = (0.05, 0.27)
"""Ball diameter over orbit diameter: smallest and largest deep groove bearing of section 2.1."""


def reproduce(out: Path) -> list[dict[str, Any]]:
    """The picture."""
    draw(out)
    return []


def draw(out: Path) -> None:
    """Share of the greatest potential against the occupied sector, from one ball to a full annulus."""
    sector = np.linspace(0.0, 360.0, 361)
    with look():
        figure = picture(6.6, 4.2)
        axes = figure.subplots()
        axes.axvline(180.0, color=CRITICAL, lw=0.9, ls="--")
        axes.plot(sector, 100.0 * np.sin(np.radians(0.5 * sector)), color=INK, lw=1.0, label="very small balls")
        for ratio, color in zip(RATIOS, BALLS, strict=False):
            alpha = math.asin(ratio)
            counts = np.arange(1, math.floor(math.pi / alpha) + 1)
            share = 100.0 * potential_ratio(counts, alpha) * math.sin(alpha)
            axes.plot(np.degrees(2.0 * counts * alpha), share, "o", ms=4.5, color=color, label=f"d/2ε = {ratio:g}")
        axes.annotate("half of the annulus", (183.0, 3.0), color=INK, fontsize=8.5)
        axes.set(xlim=(0, 360), ylim=(0, 107), xticks=range(0, 361, 60), xlabel="sector occupied by the balls [deg]")
        axes.set(ylabel="exploited potential [%]", title="the last balls add little, then take away")
        axes.legend(loc="upper right")
        figure.savefig(out / "figure_2_4.png", dpi=150)
