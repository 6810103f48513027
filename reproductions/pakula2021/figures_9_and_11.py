"""Figures 9 and 11: where the balls are before, during and after the start-up, and three and nine balls in both chambers.

Figure 11 shows up to four balls of the deep chamber in one row along the axis, and nine balls of the single layer that fill so
much of the race that some come to the heavy side. Figure 9 shows most balls opposite to the unbalance in the end. On our
reference machine with a friction of 0.7 three balls of the deep chamber stay at the bottom in their row; nine are carried late.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import xarray as xr

import autobalancer as ab
from autobalancer.files.machine_file import balls_in_chambers
from autobalancer.plots.style import save_picture
from autobalancer.results.chamber_measures import ball_places_in_rotor, balls_carried
from autobalancer.simulation.chamber import simulate_chamber
from reproductions import compared_all, said
from reproductions.pakula2021._grid import MACHINE


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Places of the balls as pictures, and what the source says of them."""
    stages = _run("deep", 20, 0.7, 10.0)
    picture = ab.plot.chamber_arrangement(
        stages, [0.0, 0.5, 10.0], title="Start-up with 20 balls (Pakuła 2021, figure 9)"
    )
    save_picture(picture, out / "figure_9.png")
    found = {}
    for layers, balls, friction, duration in (
        ("single", 3, 0.7, 6.0),
        ("single", 9, 0.7, 6.0),
        ("deep", 3, 0.7, 4.0),
        ("deep", 9, 0.7, 16.0),
    ):
        run = found[layers, balls] = _run(layers, balls, friction, duration)
        name = {"single": "single layer", "deep": "deep chamber"}[layers]
        title = f"{balls} balls, {name}, friction {friction:g} (Pakuła 2021, figure 11)"
        save_picture(
            ab.plot.chamber_arrangement(run, [0.0, duration], title=title), out / f"figure_11_{layers}_{balls}.png"
        )
    rows = [
        said("most of 20 balls in the deep chamber on the light side in the end", _on_heavy_side(stages) < 50.0),
        said("9 balls in the deep chamber are all carried, friction 0.7", bool(balls_carried(found["deep", 9]).all())),
        said("single layer of 9 balls: some on the heavy side", _on_heavy_side(found["single", 9]) > 0.0),
        said("single layer of 3 balls: none on the heavy side", _on_heavy_side(found["single", 3]) == 0.0),
    ]
    return compared_all("Pakuła 2021", "9 and 11", rows)


def _run(layers: str, balls: int, friction: float, duration: float) -> xr.Dataset:
    machine = balls_in_chambers(MACHINE)
    return simulate_chamber(
        ab.chamber.variant(machine, balls=balls, friction=friction, layers=layers), duration=duration
    )


def _on_heavy_side(run: xr.Dataset) -> float:
    """Share in the half with the unbalance in the last tenth of the run, %; the unbalance is at the zero mark."""
    last = ball_places_in_rotor(run).isel(time=slice(-run.sizes["time"] // 10, None))
    return 100.0 * float((last.mean("time").isel(axis=1) > 0.0).mean())
