"""
From many starts: basins, the worst start, envelopes
====================================================

Where several states are stable, the start decides which one the balls come to. A basin counts the starts and finds the worst of
them, and envelopes show what the deflection of many runs stays below.
"""

# %%
# A rig above its critical speed, run up at 40 accelerations. The balls hang at the critical speed in the slowest run-ups. In
# faster ones they come along, to one place, where they do not balance, or to the places that do.

import numpy as np

import autobalancer as ab

machine = ab.example("stall_and_release")
rates = ab.basin(machine, 330.0, {"acceleration": np.geomspace(5.0, 5000.0, 40)}, progress=False)
figure = ab.plot.answer(rates)
print(rates)

# %%
# Random places of the balls at the same speed, and the worst of them as a machine of its own, whose run shows what happens.

rig = ab.example("discoidal")
starts = ab.basin(rig, "1200 rpm", random=50, acceleration=20.0, progress=False)
figure = ab.plot.answer(starts)
worst = ab.worst_start(starts)
figure = ab.plot.run_up(ab.simulate(worst, progress=False))
print(worst.description)

# %%
# What the deflection of 60 run-ups with random starts stays below.

figure = ab.plot.answer(ab.envelopes(rig, members=60, progress=lambda done, of: None))

# %%
# Which state is stable in which range of speed says where a start may matter at all.

growth = ab.stability.eigenvalues(rig, np.linspace(40.0, 130.0, 91))
ranges = ab.stability.ranges(rig, growth)
figure = ab.plot.answer(growth)
print(ranges)
held = ab.stability.held_by_friction(ab.example("real_race"), "1200 rpm")
print(*(plane.sentence for plane in held.planes), sep="\n")

# %%
# The slowest and the fastest run-up do not end alike.

ends = rates["end"].values[rates["state"].values]
print(f"at 5 rad/s^2: {ends[0]}; at 5000 rad/s^2: {ends[-1]}")
assert ends[0] != ends[-1]
