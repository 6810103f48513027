"""A thousand run-ups with varied drag and unbalance on two cores, against one core and against one run at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

import autobalancer as ab
from benchmarks import compared, seconds
from benchmarks._run_up import MACHINE

VARIATIONS = {
    "balancers[1].races[1].drag.damping": np.geomspace(5e-5, 5e-4, 40).tolist(),
    "unbalances[1].mass": np.linspace(2e-3, 6e-3, 25).tolist(),
}
RUNS = 1000


def bench() -> list[dict[str, Any]]:
    """The whole of ``sweep``: 1000 machines checked and assembled, run, measured and labelled."""
    machine = ab.load_machine(MACHINE)
    times = {w: seconds(lambda w=w: ab.sweep(machine, VARIATIONS, workers=w), repeats=3) for w in (1, 2)}
    single = seconds(lambda: ab.simulate(machine, tolerance=1e-7), repeats=20)
    return [
        compared("sweep_two_cores", times[2], "one core", times[1], note=f"{RUNS} run-ups of 20 s, tolerance 1e-7"),
        compared("sweep_vs_simulate", times[2], "simulate() in a loop", RUNS * single, note=f"{RUNS} run-ups of 20 s"),
    ]
