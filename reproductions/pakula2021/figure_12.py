"""Figure 12: means of the vertical amplitude over 8 to 50 balls in the deep chamber and 3 to 10 in the single layer.

The source states 83 % less vibration with the deep chamber, provided that the friction is 0.5 or more. On our reference
machine the deep chamber begins to carry its balls at larger numbers, so the range of the source holds points where they stay
at the bottom; one of those outweighs all others. The second pair of rows takes the means over the numbers that are
carried. The amplitude contains what is left of free vibrations after 16 s; the synchronous part does not.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import xarray as xr

from autobalancer.plots.chamber_study import plot_optimal_means
from autobalancer.plots.save import save_picture
from autobalancer.studies.chamber_means import optimal_means, pick_up_borders
from reproductions import compared_all
from reproductions.pakula2021._grid import COUNTS, table

PRINTED, TOLERANCE = 83.0, 15.0  # %
KINDS = {"vertical_amplitude": "vertical amplitude", "vertical_synchronous": "synchronous vertical amplitude"}


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Vibration saved by the deep chamber, in percent of that of the single layer."""
    study = table().sel(friction=[0.3, 0.5, 0.7])
    means = optimal_means(study)
    title = "Means over 8 to 50 and 3 to 10 balls (Pakuła 2021, figure 12)"
    save_picture(plot_optimal_means(means, title=title), out / "figure_12.png")
    rows = []
    for friction in (0.5, 0.7):
        least = pick_up_borders(study)["least_balls"].sel(layers="deep", friction=friction)
        first = int(least) if least.notnull() else COUNTS["deep"][-1]
        own = optimal_means(study, {"deep": (max(first, 8), 50)})
        for kind, text in KINDS.items():
            told = f"{text} saved by the deep chamber, friction {friction:g}, means over"
            rows.append((f"{told} 8 to 50 against 3 to 10 balls", saved(means, kind, friction)))
            rows.append(
                (f"{told} {max(first, 8)} to 50 against 3 to 10 balls, those carried", saved(own, kind, friction))
            )
    return compared_all("Pakuła 2021", "12", [(name, "%", PRINTED, obtained, TOLERANCE) for name, obtained in rows])


def saved(means: xr.Dataset, kind: str, friction: float) -> float:
    """One less the ratio of the means, %."""
    at = means[kind].sel(friction=friction)
    return 100.0 * (1.0 - float(at.sel(layers="deep") / at.sel(layers="single")))
