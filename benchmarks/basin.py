"""A basin map of the discoidal stand-in."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

import autobalancer as ab
from benchmarks import measured

MACHINE = Path(__file__).parents[1] / "examples" / "machines" / "discoidal.toml"
LIMIT = 60.0  # s


def bench() -> list[dict[str, Any]]:
    """Seconds for 200 x 200 starts at 1200 rpm."""
    angles = np.linspace(-np.pi, np.pi, 200, endpoint=False)
    ab.basin(MACHINE, 125.66, {"ball_angle[1]": angles[:2], "ball_angle[2]": angles[:2]})
    start = perf_counter()
    ab.basin(MACHINE, 125.66, {"ball_angle[1]": angles, "ball_angle[2]": angles})
    taken = perf_counter() - start
    row = measured("basin_map_s", taken, "s", note="200 x 200 initial ball angles at 1200 rpm; ratio against the limit")
    return [row | {"peer": f"limit {LIMIT:g} s", "ratio": LIMIT / taken}]
