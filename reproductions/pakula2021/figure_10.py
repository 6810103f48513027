"""Figures 10 and 12 in kind: vibration over number of balls and friction, deep chamber against single layer.

The source does not print its machine, so our reference machine stands in and the comparison is of kinds: balls stay at the
bottom of the deep chamber when friction or their number is too low; the single layer loses capability with many balls, for
they fill its race, and the deep chamber does not. Runs of 8 s in place of the longer ones of the source leave free vibrations
of the weakly damped body, so amplitudes are synchronous ones. A coarse grid: a handful of runs in place of hundreds.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from autobalancer.files.machine_file import load_chamber_machine
from autobalancer.plots.chamber_study import plot_amplitudes
from autobalancer.plots.save import save_picture
from autobalancer.studies.chamber_amplitudes import chamber_amplitudes
from reproductions import compared

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "deep_chamber.toml"
MEASURE = "vertical_synchronous"


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Who is carried away, and the share of the vibration that the deep chamber saves."""
    machine = load_chamber_machine(MACHINE)
    found = chamber_amplitudes(machine, {"deep": [4, 12, 20], "single": [3, 5, 8, 10]}, [0.3, 0.7], duration=8.0)
    title = "Reference machine, 8 s (Pakuła 2021, figure 10)"
    save_picture(plot_amplitudes(found, measure=MEASURE, title=title), out / "figure_10.png")
    deep, single = found.sel(layers="deep"), found.sel(layers="single")
    carried = 100.0 * deep["share_carried"]
    alone = deep[MEASURE].sel(friction=0.7, balls=[12, 20]).mean()
    several = {"3 to 10 balls, of which 3 have not settled yet": [3, 5, 8, 10], "5 to 10 balls": [5, 8, 10]}
    saved = {
        text: 100.0 * (1.0 - float(alone / single[MEASURE].sel(friction=0.7, balls=counts).mean()))
        for text, counts in several.items()
    }
    few = float(carried.sel(friction=0.7, balls=4))
    many = float(carried.sel(friction=0.7, balls=[12, 20]).min())
    slippery = float(carried.sel(friction=0.3, balls=[4, 12, 20]).max())
    rows = [
        ("balls of the deep chamber carried, friction 0.3, greatest of 4 to 20 balls", 0.0, slippery, 0.0),
        ("balls of the deep chamber carried, friction 0.7, least of 12 and 20 balls", 100.0, many, 0.0),
        ("balls of the deep chamber carried, friction 0.7, 4 balls, the border of the source", 100.0, few, 50.0),
        *[
            (f"vibration saved, friction 0.7, single layer with {text}", 83.0, value, 15.0)
            for text, value in saved.items()
        ],
    ]
    return [
        compared(
            source="Pakuła 2021",
            figure="10 and 12",
            quantity=name,
            unit="%",
            target=target,
            obtained=obtained,
            tolerance=tolerance,
        )
        for name, target, obtained, tolerance in rows
    ]
