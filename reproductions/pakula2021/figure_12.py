"""Figure 12: means of the vertical amplitude over 8 to 50 balls in the deep chamber and 3 to 10 in the single layer.

The source states 83 % less vibration with the deep chamber, provided that the friction is 0.5 or more. On our reference
machine the deep chamber begins to carry its balls at larger numbers, so the range of the source holds points where they stay
at the bottom; one of those outweighs all others. The second row of each friction takes the means over the numbers that are
carried, a range chosen after seeing this. The amplitude contains what is left of free vibrations after 16 s.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import xarray as xr

import autobalancer as ab
from autobalancer.plots.style import save_picture
from autobalancer.studies.chamber_study import optimal_means, pick_up_borders
from reproductions import Found, compared_all
from reproductions.pakula2021._grid import COUNTS, LOST, table

PRINTED, TOLERANCE = 83.0, 15.0  # %


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Vibration saved by the deep chamber, in percent of that of the single layer."""
    study = table().sel(friction=[0.3, 0.5, 0.7])
    means = optimal_means(study)
    title = "Means over 8 to 50 and 3 to 10 balls (Pakuła 2021, figure 12)"
    save_picture(ab.plot.answer(means, title=title), out / "figure_12.png")
    rows = []
    for friction in (0.5, 0.7):
        least = pick_up_borders(study)["least_balls"].sel(layers="deep", friction=friction)
        first = max(int(least) if least.notnull() else COUNTS["deep"][-1], 8)
        own = optimal_means(study, {"deep": (first, 50)})
        about = f"vertical amplitude saved by the deep chamber, friction {friction:g}, means over"
        whole, carried = (f"{about} {n} to 50 against 3 to 10 balls" for n in (8, first))
        rows += [
            Found("printed", whole, "%", PRINTED, saved(means, friction), TOLERANCE, LOST),
            Found("fitted", f"{carried}, those carried", "%", PRINTED, saved(own, friction), TOLERANCE),
        ]
    return compared_all("Pakuła 2021", "12", rows)


def saved(means: xr.Dataset, friction: float) -> float:
    """One less the ratio of the means, %."""
    at = means["vertical_amplitude"].sel(friction=friction)
    return 100.0 * (1.0 - float(at.sel(layers="deep") / at.sel(layers="single")))
