"""
Up through four resonances and down again
=========================================

A rig with a ball balancer is measured as on a test stand: hold a speed, wait, measure, go on; then the same way down.
Where a curve upwards differs from that downwards, the rotor remembers where its balls were.
"""

# %%
# The rig of Rodrigues et al. (2011): a rigid rotor that tilts on anisotropic bearings, with four critical speeds between
# 1450 and 2300 rpm. Every speed is held for two seconds and measured for half a second more. The amplitude is the mean of
# the greatest deflections at both bearings.

import numpy as np

import autobalancer as ab

speeds = np.arange(1200.0, 3001.0, 20.0) * np.pi / 30.0
machine = ab.example("rodrigues_rig")
machine = ab.with_parameter(machine, "balancers[1].races[1].drag.damping", "2.83e-6 N*m*s")
found = ab.stepped_response(machine, speeds, dwell=2.0, window=0.5, direction="both", stations=["B1", "B2"])

# %%
# On the way up the balls stay behind at the first critical speed and whirl about the race (purple), through all others, until
# the drag tears them away. On the way down they come from the light side and stay with the rotor at most speeds.

ab.plot.stepped_response(found)

# %%
# The greatest ratio of both ways, and where it is:

ratio = (found["amplitude"].sel(direction="up") / found["amplitude"].sel(direction="down")).values
place = int(ratio.argmax())
print(f"upwards {ratio[place]:.0f} times as much as downwards, at {speeds[place] * 30.0 / np.pi:.0f} rpm")
whirling = {way: speeds[found["motion"].sel(direction=way).values == 2] * 30.0 / np.pi for way in ("up", "down")}
for way, there in whirling.items():
    print(f"{way}: balls whirl at {there.size} speeds, from {there.min():.0f} to {there.max():.0f} rpm")
assert ratio[place] > 10.0
assert whirling["up"].max() > 2200.0 > 1900.0 > whirling["down"].max()
