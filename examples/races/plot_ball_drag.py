"""
Drag from the equations of the fluid
====================================

What drags a ball in a race of your own? Finite elements say it for any cross-section, before there is a rig to measure it on.
"""

# %%
# One of two balls of a laboratory centrifuge, on a wall whose roughness leaves 1 µm. A ball that rolls in a tight race pushes
# the fluid ahead through the narrow places beside it, and some of it around the whole ring.

import autobalancer as ab

found = ab.flow.ball_drag(ab.example("discoidal"), [0, 10, 30], gap="1 um")
ab.plot.answer(found)

# %%
# Up to Re = 10 the drag is linear, as drag laws of balls in races assume. These lines take the place of ``drag = ...``:

slow, ten, thirty = found["cd_times_re"].values
print(found.attrs["drag"])
print(
    f"the other ball moves the fluid too: it flows around the ring with {float(found.through_flow[0]):.0%} of their speed"
)
assert abs(ten / slow - 1.0) < 0.02 < thirty / slow - 1.0

# %%
# Alone in the same ring, a ball has to push the fluid farther around:

orbit = 76.95e-3
ring = ab.flow.Channel("12.3 mm", "13.8 mm", "20 mm", orbit, 2 * 3.14159 * orbit)
alone = ab.flow.ball_drag(ring, [0], gap="1 um")
print(
    f"c_d Re = {slow:.0f} for one of two balls, {float(alone.cd_times_re[0]):.0f} alone, measured by Spannan (2021): 387"
)
assert float(alone.cd_times_re[0]) > 1.05 * slow
