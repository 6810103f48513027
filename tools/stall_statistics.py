"""Statistics of random starts of the discoidal rig in three oils, for the gallery: python -m tools.stall_statistics 500.

Writes ``examples/run_ups/stall_statistics.csv``: for each oil the number of run-ups, how many stalled, and quantiles of the
time in the stall. A run-up takes about 12 ms of a core.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import autobalancer as ab
from autobalancer.results.answers.ensemble import Ensemble

ROOT = Path(__file__).resolve().parents[1]
OILS = ("10 mm^2/s", "20 mm^2/s", "50 mm^2/s")
HEAD = (
    "viscosity [mm^2/s],run_ups,stalled,balanced,share_low [%],share_high [%],"
    "stall_least [s],stall_median [s],stall_greatest [s],peak_greatest [mm]"
)


def statistics(count: int) -> list[str]:
    """Lines of the table."""
    machine = ROOT / "examples" / "machines" / "discoidal.toml"
    found = ab.ensemble(machine, {"viscosity": OILS}, seeds=count, tolerance=1e-6)
    lines = []
    for viscosity, own in found.groupby("viscosity"):
        time = np.nan_to_num(own["stalled_time"].values)
        numbers = own.sizes["member"], int((time > 0.0).sum()), int(own["balanced"].sum())
        _, low, high = Ensemble.of(own).share_of(time > 0.0)
        spread = (
            100.0 * low,
            100.0 * high,
            time.min(),
            np.median(time),
            time.max(),
            1e3 * float(own["peak_deflection"].max()),
        )
        lines.append(",".join([f"{1e6 * viscosity:g}", *map(str, numbers), *(f"{value:.6g}" for value in spread)]))
    return lines


if __name__ == "__main__":
    table = "\n".join([HEAD, *statistics(int(sys.argv[1]))]) + "\n"
    (ROOT / "examples" / "run_ups" / "stall_statistics.csv").write_text(table, encoding="utf-8")
