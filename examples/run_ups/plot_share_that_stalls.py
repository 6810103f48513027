"""
What share of run-ups stalls?
=============================

The balls of the discoidal rig start anywhere in their race. In which oil do they stall near the critical speed, for how long,
and does it matter where they start? An ensemble answers with statistics.
"""

# %%
# Twelve random starts in each of three oils take less than a second. The answer counts the ends, with intervals in which the
# shares of very many starts would lie.

import csv
from pathlib import Path

import autobalancer as ab

oils = ["10 mm^2/s", "20 mm^2/s", "50 mm^2/s"]
found = ab.ensemble(ab.example("discoidal"), {"viscosity": oils}, seeds=12, tolerance=1e-6)
print(found)

# %%
# All of them stall, and all are released and balance; in thin oil they stay at the critical speed for longer.

stalled = found["stalled_time"] > 0.0
share, low, high = found.share_of(stalled)
print(f"share that stalls: {100 * share:.3g} % (95 %: {100 * low:.3g} to {100 * high:.3g} %)")
picture = ab.plot.ensemble_distribution(found, "stalled_time")

# %%
# The statistics of 500 run-ups in each oil were kept by ``python -m tools.stall_statistics 500``. The start hardly matters: the
# time in the stall is the same to the resolution of the measures, a five hundredth of the run or 0.32 s.

HERE = Path(__file__).parent if "__file__" in globals() else Path()
with open(HERE / "stall_statistics.csv", encoding="utf-8") as lines:
    for row in csv.DictReader(lines):
        interval = f"{row['share_low [%]']} to {row['share_high [%]']} %"
        spread = f"{row['stall_least [s]']} to {row['stall_greatest [s]']} s"
        print(
            f"{row['viscosity [mm^2/s]']} mm²/s: {row['stalled']} of {row['run_ups']} stall ({interval}), for {spread}"
        )
