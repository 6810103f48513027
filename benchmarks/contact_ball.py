"""The run-up of the discoidal stand-in, 145 s, with two balls resolved in contact: how long it takes.

Friction, rolling resistance, adherence and floor are all on. The guided balls of the same machine stand beside it.
"""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any

import autobalancer as ab
from benchmarks import measured

MACHINES = Path(__file__).resolve().parent.parent / "examples" / "machines"
GOAL, DURATION = 30.0, 145.0


def bench() -> list[dict[str, Any]]:
    """One row; the time of the second run, when everything is compiled."""
    resolved, steps = timed("resolved_balls.toml")
    guided, _ = timed("discoidal.toml")
    note = f"{DURATION:g} s of run-up, {steps} steps; with guided balls {guided:.3g} s"
    row = measured("contact_ball_run_s", resolved, "s", note=note)
    return [row | {"peer": f"limit {GOAL:g} s", "ratio": GOAL / resolved}]


def timed(name: str) -> tuple[float, int]:
    """Seconds and steps of a run."""
    machine = ab.load_machine(MACHINES / name)
    ab.simulate(machine, duration=0.01)
    start = perf_counter()
    run = ab.simulate(machine, duration=DURATION)
    assert run.attrs["outcome"] == "finished"
    return perf_counter() - start, int(run.attrs["steps"])
