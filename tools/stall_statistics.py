"""Statistics of random starts of the discoidal rig in three oils, for the gallery: python -m tools.stall_statistics 60000.

Writes to ``examples/run_ups/``: ``stall_statistics.csv`` has for each oil the number of run-ups, how many stalled, and quantiles
of the time in the stall, ``stall_times.csv`` how many starts stalled for so long. A run-up takes about 1.8 ms of a core. They are
run in parts, so that memory does not grow with their number.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.random_numbers import wilson_interval

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "examples" / "run_ups"
OILS = ("10 mm^2/s", "20 mm^2/s", "50 mm^2/s")
PART = 10_000  # starts in each oil that are run at once
BINS = 5000  # of the 160 s of a run, 32 ms each: the resolution of the times
KEPT = ("viscosity", "stalled_time", "balanced", "peak_deflection")
QUANTILES = (0.0, 0.025, 0.5, 0.975, 1.0)
HEAD = (
    "viscosity [mm^2/s],run_ups,stalled,balanced,share_low [%],share_high [%],stall_least [s],stall_2.5 % [s],"
    "stall_median [s],stall_97.5 % [s],stall_greatest [s],peak_greatest [mm]"
)
TIMES_HEAD = "viscosity [mm^2/s],stall [s],run_ups"
Kept = dict[str, np.ndarray[Any, Any]]  # an entry for each run-up


def run_ups(count: int) -> Kept:
    """What is kept of so many starts in each oil."""
    parts = [_part(first, min(PART, count - first)) for first in range(0, count, PART)]
    return {name: np.concatenate([part[name] for part in parts]) for name in KEPT}


def _part(first: int, count: int) -> Kept:
    """The starts from one seed on."""
    machine = ROOT / "examples" / "machines" / "discoidal.toml"
    found = ab.ensemble(machine, {"viscosity": OILS}, seeds=count, seed=first, tolerance=1e-6, bins=BINS)
    print(f"{first + count} starts in each oil, {1e3 * found.attrs['run_time_per_member']:.2f} ms each", flush=True)
    return {name: found[name].values for name in KEPT}


def statistics(found: Kept) -> tuple[list[str], list[str]]:
    """Lines of both tables."""
    lines, times = [HEAD], [TIMES_HEAD]
    for viscosity in np.unique(found["viscosity"]):
        own = found["viscosity"] == viscosity
        time, oil = np.nan_to_num(found["stalled_time"][own]), f"{1e6 * viscosity:g}"
        stalled, total = int((time > 0.0).sum()), time.size
        low, high = wilson_interval(np.array([stalled]), total)
        greatest = 1e3 * found["peak_deflection"][own].max()
        values = 100.0 * low[0], 100.0 * high[0], *np.quantile(time, QUANTILES), greatest
        numbers = total, stalled, int(found["balanced"][own].sum())
        lines.append(",".join([oil, *map(str, numbers), *(f"{value:.6g}" for value in values)]))
        each, counts = np.unique(np.round(time, 3), return_counts=True)
        times += [f"{oil},{value:.6g},{number}" for value, number in zip(each, counts, strict=True)]
    return lines, times


def write(tables: tuple[list[str], list[str]]) -> None:
    """Both tables to their files."""
    for name, lines in zip(("stall_statistics.csv", "stall_times.csv"), tables, strict=True):
        (FOLDER / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    write(statistics(run_ups(int(sys.argv[1]))))
