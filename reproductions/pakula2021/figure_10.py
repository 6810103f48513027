"""Figures 10 and 12 in kind: vibration over number of balls and friction, deep chamber against single layer.

The source does not print its machine, so our reference machine stands in and the comparison is of kinds: balls stay at the
bottom of the deep chamber when friction or their number is too low; the single layer loses capability with many balls, for
they fill its race, and the deep chamber does not. Three and five balls balance the single layer better than any number does the
deep chamber, here; the means of figure 12 are those of a range. A coarse grid of single runs: a handful in place of hundreds.
After 16 s all balls that are carried have settled, and what is left of free vibrations is part of the amplitude.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from autobalancer.files.machine_file import load_chamber_machine
from autobalancer.plots.chamber_study import plot_amplitudes
from autobalancer.plots.save import save_picture
from autobalancer.studies.chamber_amplitudes import chamber_amplitudes
from autobalancer.studies.chamber_means import optimal_means
from reproductions import compared

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "deep_chamber.toml"


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Who is carried away, and the share of the vibration that the deep chamber saves."""
    machine = load_chamber_machine(MACHINE)
    found = chamber_amplitudes(machine, {"deep": [4, 12, 20], "single": [3, 5, 8, 10]}, [0.7], duration=16.0, last=1.0)
    slippery = chamber_amplitudes(machine, [4, 12], [0.3], duration=4.0, layers=["deep"])
    title = "Reference machine (Pakuła 2021, figure 10)"
    save_picture(plot_amplitudes(found, title=title), out / "figure_10.png")
    saved = {}
    for name in ("vertical_amplitude", "vertical_synchronous"):
        means = optimal_means(found)[name].sel(friction=0.7)
        saved[name] = 100.0 * (1.0 - float(means.sel(layers="deep") / means.sel(layers="single")))
    carried = 100.0 * found["share_carried"].sel(layers="deep", friction=0.7)
    rest = 100.0 * float(slippery["share_carried"].max())
    vibration = "vibration saved by the deep chamber, friction 0.7, means over 12 and 20 against 3 to 10 balls"
    rows = [
        ("balls of the deep chamber carried, friction 0.3, greatest of 4 and 12 balls", 0.0, rest, 0.0),
        (
            "balls of the deep chamber carried, friction 0.7, 12 and 20 balls",
            100.0,
            float(carried.sel(balls=[12, 20]).min()),
            0.0,
        ),
        (
            "balls of the deep chamber carried, friction 0.7, 4 balls: border of the source",
            100.0,
            float(carried.sel(balls=4)),
            0.0,
        ),
        (vibration, 83.0, saved["vertical_amplitude"], 15.0),
        (f"synchronous {vibration}", 83.0, saved["vertical_synchronous"], 15.0),
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


if __name__ == "__main__":
    import sys

    from reproductions.pakula2021._grid import complete

    if "--full" not in sys.argv:
        sys.exit("python -m reproductions.pakula2021.figure_10 --full [--fresh]: run what the table lacks")
    complete(fresh="--fresh" in sys.argv)
