"""How long answers take that have no peer: borders, branches, eigenvalues, basins of real races, fits of receptances."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from benchmarks import measured, seconds

MACHINES = Path(__file__).resolve().parent.parent / "examples" / "machines"
TWO_PLANES, REAL = MACHINES / "two_plane_rotor.toml", MACHINES / "real_race.toml"
HIGH, LOW, REAL_SPEED = 418.9, 83.8, 125.66  # rad/s: 4000, 800 and 1200 rpm
SPEEDS, STARTS = 400, 40


def bench() -> list[dict[str, Any]]:
    """One row for each question."""
    rotor, real = ab.load_machine(TWO_PLANES), ab.load_machine(REAL)
    hammer = ab.measure.load_receptance(ab.catalog.example_path("discoidal_hammer"))
    speeds = np.linspace(LOW, HIGH, SPEEDS)

    def per_second(call: Callable[[], Any], answers: int) -> float:
        return answers / seconds(call, repeats=2)

    return [
        taken(
            "borders_s",
            lambda: ab.stability.borders(rotor),
            "all border speeds of a rotor with two balls in each of two planes",
        ),
        taken(
            "branches_s",
            lambda: ab.stability.branches(rotor, "speed", HIGH, LOW),
            "of this rotor from 4000 to 800 rpm, with swinging balls",
        ),
        taken(
            "receptance_fit_s",
            lambda: ab.measure.receptance(hammer, progress=False),
            "modes and noise of a hammer test",
        ),
        measured(
            "eigenvalues_per_s",
            per_second(lambda: ab.stability.eigenvalues(rotor, speeds), SPEEDS),
            "1/s",
            note="speeds at which steady states of this rotor are found and judged",
        ),
        measured(
            "basin_real_race_per_s",
            per_second(lambda: ab.basin(real, REAL_SPEED, random=STARTS), STARTS),
            "1/s",
            note=f"{STARTS} random starts in a race with adherence on a floor that shakes, all cores",
        ),
    ]


def taken(name: str, call: Callable[[], Any], note: str) -> dict[str, Any]:
    """A row in seconds."""
    return measured(name, seconds(call, repeats=2), "s", note=note)
