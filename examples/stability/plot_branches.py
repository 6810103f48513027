"""
What else the balls can do
==========================

The balanced state is one of several. Which others there are, where each of them is born, loses stability or vanishes, and
where balls stay stalled, is followed along the rotor speed.
"""

# %%
# The stand-in of the discoidal rig with two balls in 20 mm²/s silicone oil, from below to above its critical speed of 60 rad/s.

import numpy as np

import autobalancer as ab

rig = ab.example("discoidal")
found = ab.stability.branches(rig, "speed", "45 rad/s", "80 rad/s", from_state="all")

# %%
# Below the critical speed the balls stand together on the heavy side. At the fold that state vanishes, and where it was a
# motion of infinite period begins: the balls start to slip, they are stalled. The balanced state becomes stable at a
# supercritical Hopf point, so that just below it the balls swing a little. Between that point and the end of the stalled
# motion both are stable, and the way there decides.

motions = ab.plot.branches(found, speed_unit="rad/s")

# %%
# Over the unbalance: two balls balance what they can. There the balanced pair and the coincident balls exchange stability.

size = ab.stability.branches(rig, "unbalance", "100 g*mm", "1500 g*mm", speed=100.0)
pitchfork = ab.plot.branches(size)

# %%
# The numbers of the pictures.


def places(data, kind):
    """Parameter values of the special points of one kind."""
    return data["special_parameter"].values[data["special_type"].values == kind]


hopf, vanish = places(found, "Hopf")[0], places(found, "fold").max()
print(f"balanced from {hopf:.2f} rad/s on, {found['criticality'].values[found['special_type'].values == 'Hopf'][0]}")
print(f"stalled up to {places(found, 'branch point')[0]:.2f} rad/s, and no more beyond {vanish:.2f} rad/s")
assert abs(hopf - 65.0802) < 1e-3
assert hopf < places(found, "branch point")[0] < vanish
assert np.isclose(places(size, "pitchfork")[0], 1.026422e-3, rtol=1e-6)
