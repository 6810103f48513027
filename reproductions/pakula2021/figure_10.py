"""Figure 10: vertical vibration over number of balls and friction, deep chamber against single layer, equal total mass.

The source does not print its machine, so our reference machine stands in and the comparison is of kinds. What comes out
alike: with a friction of 0.3 the deep chamber carries no ball, however many there are; a least number of balls and a least
friction exist, and the number falls with the friction; the single layer loses capability with many balls, which fill its
race, and the deep chamber does not. The borders lie at other numbers, so the deep chamber with five balls is missed: here they
stay at the bottom. The single layer needs more friction here, too. Who is carried follows from the vibration on the
way through the critical speeds, so from masses, supports and motor that are not printed.

The grid, with three fillings of each point, takes half an hour and is kept as a table; a long test computes some of its runs
again. They agree to the last digit on the same kind of processor. Another one may round differently, and what a
filling becomes depends on the last digit: then compute the table anew and compare the means.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import xarray as xr

import autobalancer as ab
from autobalancer.plots.style import save_picture
from autobalancer.studies.chamber_study import over_seeds, pick_up_borders
from reproductions import Found, compared_all
from reproductions.pakula2021._grid import BORDERS, LOST, complete, table

LEAST = {0.7: 4.0, 0.5: 8.0}  # friction: balls
BEST, WITHIN = 6.0, 3.0  # um
TITLE = "Reference machine (Pakuła 2021, figure 10)"


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Who is carried, and how many balls and how much friction it takes."""
    study = table()
    save_picture(ab.plot.answer(study.sel(friction=[0.3, 0.5, 0.7]), title=TITLE), out / "figure_10.png")
    save_picture(
        ab.plot.answer(_borders(study), "carried", title="Balls picked up from the bottom"),
        out / "figure_10_carried.png",
    )
    means = over_seeds(study)
    carried = 100.0 * means["share_carried"]
    slippery = carried.sel(friction=0.3)
    least = pick_up_borders(study)["least_balls"].sel(layers="deep")
    amplitude = 1e6 * means["vertical_amplitude"].sel(layers="deep")
    rows = [
        Found("words", "balls of the deep chamber carried, friction 0.3, most of any number", "%", 0.0,
              slippery.sel(layers="deep").max(), 0.0),
        Found("words", "balls of the single layer carried, friction 0.3, 3 to 10 balls", "%", 100.0,
              slippery.sel(layers="single").mean(), 0.0, LOST),
        *(Found("printed", f"least number of balls that the deep chamber carries, friction {friction:g}", "balls",
                printed, least.sel(friction=friction), 0.0, LOST) for friction, printed in LEAST.items()),
        Found("printed", "vertical amplitude of the deep chamber, 5 balls, friction 0.7", "um", BEST,
              amplitude.sel(balls=5, friction=0.7), WITHIN, LOST),
        Found("words", "least vertical amplitude of the deep chamber, any number of balls", "um", BEST,
              amplitude.sel(friction=[0.5, 0.7]).min(), WITHIN),
    ]  # fmt: skip
    return compared_all("Pakuła 2021", "10", rows)


def _borders(study: xr.Dataset) -> xr.Dataset:
    """The numbers of balls that were asked for at many frictions, nan at all others."""
    carried = study[["share_carried"]]
    return xr.concat(
        [carried.sel(layers=[layer], balls=list(counts)) for layer, counts in BORDERS.items()], "layers", join="outer"
    )


if __name__ == "__main__":
    if "--full" not in sys.argv:
        sys.exit(
            "python -m reproductions.pakula2021.figure_10 --full [--fresh]: run what the table lacks, or all of it"
        )
    complete(fresh="--fresh" in sys.argv)
