"""
Which variant of the race spares the rotor its balls?
=====================================================

Below the critical speed free balls run to the heavy side and make things worse. Figure 2.5 of Spannan (2021) collects what has
been proposed against that. Ten machines, one rig, one question.
"""

# %%
# The planar stand-in of the discoidal rig rests at 40 rad/s, two thirds of its critical speed, and then runs through it to
# 1200 rpm. The variants are samples of the package; springs, magnets, pins and incline are assumed, none is optimized.

import autobalancer as ab

VARIANTS = (
    *("plain", "springs", "magnets", "radial_springs", "incline", "pins", "partitions", "two_oils"),
    *("rollers", "pendulums"),
)
found = ab.compare([ab.catalog.example_path(f"variant_{name}") for name in VARIANTS], at="40 rad/s")
print(found)

# %%
# What holds the balls, magnets or pins, leaves the rotor its own unbalance at 40 rad/s; free balls nearly triple it. Springs
# along the race do the same, but they also pull the balls away from where they balance. Radial springs and the inclined race
# work by the radius of the balls, which limits what they spare. Two oils nearly halve the peak, but their balls take four times
# as long to settle.

ab.plot.answer(found)

# %%
# The springs in numbers: a quarter of the vibration stays.

left = found["vibration"] / found["vibration_without_balls"]
print(f"left with springs along the race: {100 * float(left.sel(machine='Springs along the race')):.0f} %")
assert 0.2 < float(left.sel(machine="Springs along the race")) < 0.3
assert float(left.sel(machine="Pins")) < 1e-3
