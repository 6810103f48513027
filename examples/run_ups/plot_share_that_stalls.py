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
picture = ab.plot.answer(found, "distribution", measure="stalled_time")

# %%
# What 60 000 starts in each oil do was kept by ``python -m tools.stall_statistics 60000``. All stall, so that at most one in
# ten thousand starts does not. The run-up is slow, and the balls forget where they started: in thin oil the time in the stall is
# the same for nearly all. Few starts leave it earlier or later, too few to be seen in a hundred runs.

HERE = Path(__file__).parent if "__file__" in globals() else Path()
with open(HERE / "stall_statistics.csv", encoding="utf-8") as lines:
    for row in csv.DictReader(lines):
        interval = f"{float(row['share_low [%]']):.5g} to {row['share_high [%]']} %"
        spread = f"{row['stall_least [s]']} to {row['stall_greatest [s]']} s"
        print(
            f"{row['viscosity [mm^2/s]']} mm²/s: {row['stalled']} of {row['run_ups']} stall ({interval}), for {spread}"
        )

# %%
# Each point is the number of starts that stalled for so long, to 32 ms; the axis of numbers is logarithmic.

with open(HERE / "stall_times.csv", encoding="utf-8") as lines:
    table = [(row["viscosity [mm^2/s]"], float(row["stall [s]"]), int(row["run_ups"])) for row in csv.DictReader(lines)]
with ab.plot.style.look():
    figure = ab.plot.style.picture(9.0, 3.6)
    axes = figure.subplots(1, 3, sharey=True)
    for axis, oil in zip(axes, ["10", "20", "50"], strict=True):
        times, counts = zip(*[(time, count) for its, time, count in table if its == oil], strict=True)
        axis.vlines(times, 0.7, counts, lw=1.0, color="0.75")
        axis.plot(times, counts, "o", ms=4, color=ab.plot.style.BALLS[0])
        middle = 0.5 * (min(times) + max(times))
        axis.set(yscale="log", ylim=(0.7, None), xlim=(middle - 0.4, middle + 0.4), title=f"{oil} mm²/s")
        axis.set_xlabel("time in the stall (s)")
    axes[0].set_ylabel("run-ups")
    ab.plot.style.heading(figure, "How long 60 000 random starts stall")
