"""Figure 2.4: how much of its potential a race exploits when its balls occupy a sector.

The figure prints no numbers. Targets are eq. (2.3) taken literally, term by term, and what the text says of it: the
maximum lies where half of the annulus is filled (up to half a ball), and every further ball contributes less.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.laws.capability import largest_useful_count, potential_ratio
from autobalancer.plots.style import BALLS, CRITICAL, INK, look, picture
from reproductions import compared_all

RATIOS = (0.012, 0.05, 0.27)
"""Ball diameter over orbit diameter: smallest thin section, smallest and largest deep groove bearing of section 2.1."""


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Closed form against the sum, place of the maximum, and the sign of the curvature."""
    rows: list[tuple[str, str, float, float, float]] = []
    for ratio in RATIOS:
        alpha = math.asin(ratio)
        useful = largest_useful_count(1.0, 2.0 * ratio)
        greatest = float(potential_ratio(useful, alpha))
        counts = np.arange(1, useful + 1)
        literal = np.array([sum_2_3(int(n), alpha) for n in counts])
        worst = 100.0 * float(np.abs(potential_ratio(counts, alpha) - literal).max()) / greatest
        gains = np.diff(potential_ratio(np.arange(useful + 1), alpha))
        sector = math.degrees(2.0 * useful * alpha)
        name = f"d/2e = {ratio:g}"
        rows += [
            (f"{name}: closed form less sum (2.3), worst of {useful} counts", "%", 0.0, worst, 1e-9),
            (f"{name}: occupied sector at the maximum", "deg", 180.0, sector, math.degrees(alpha)),
            (f"{name}: balls that contribute more than the one before", "balls", 0, int(np.sum(np.diff(gains) > 0)), 0),
        ]
    draw(out)
    return compared_all("Spannan 2021", "2.4", rows)


def sum_2_3(count: int, alpha: float) -> float:
    """Eq. (2.3) of the source, term by term."""
    odd = 1.0 + sum(2.0 * math.cos((j - 1) * alpha) for j in range(3, count + 1, 2))
    even = sum(2.0 * math.cos((j - 1) * alpha) for j in range(2, count + 1, 2))
    return odd if count % 2 else even


def draw(out: Path) -> None:
    """Share of the greatest potential against the occupied sector, from one ball to a full annulus."""
    sector = np.linspace(0.0, 360.0, 361)
    with look():
        figure = picture(6.6, 4.2)
        axes = figure.subplots()
        axes.axvline(180.0, color=CRITICAL, lw=0.9, ls="--")
        axes.plot(sector, 100.0 * np.sin(np.radians(0.5 * sector)), color=INK, lw=1.0, label="very small balls")
        for ratio, color in zip(RATIOS[1:], BALLS, strict=False):
            alpha = math.asin(ratio)
            counts = np.arange(1, math.floor(math.pi / alpha) + 1)
            share = 100.0 * potential_ratio(counts, alpha) * math.sin(alpha)
            axes.plot(np.degrees(2.0 * counts * alpha), share, "o", ms=4.5, color=color, label=f"d/2ε = {ratio:g}")
        axes.annotate("half of the annulus", (183.0, 3.0), color=INK, fontsize=8.5)
        axes.set(xlim=(0, 360), ylim=(0, 107), xticks=range(0, 361, 60), xlabel="sector occupied by the balls [deg]")
        axes.set(ylabel="exploited potential [%]", title="the last balls add little, then take away")
        axes.legend(loc="upper right")
        figure.savefig(out / "figure_2_4.png", dpi=150)
