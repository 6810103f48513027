"""
Oil that follows the rotor
==========================

The walls of the race drag the fluid along, and the fluid drags the balls. While the rotor speeds up the fluid lags. How
much depends less on diffusion than one would think: thin layers at the lids throw fluid outward, and what flows back has
been at the walls already.
"""

# %%
# The race of a laboratory centrifuge with thin oil, started suddenly: the rotor turns with 60 rad/s, the oil not yet.

import autobalancer as ab

machine = ab.example("discoidal")
start = ab.flow.annulus_flow(machine, 60.0, initial_speed=0.0, duration=2.0, times=[0.02, 0.05, 0.1, 0.2, 0.4, 1.0])

# %%
# The oil at the orbit of the balls (blue) is spun up many times faster than by diffusion alone (dashed).

ab.plot.answer(start, speed_unit="rad/s")

# %%
# Fluid between the walls still rests while that next to them turns.

ab.plot.answer(start, "velocity_profiles", moments=[0.02, 0.05, 0.1, 0.2, 0.4])

# %%
# Outward along the lids, inward in the middle; inside of the orbit the flow against the inner wall is not stable.

ab.plot.answer(start, "secondary_flow", time=0.1, speed_unit="rad/s")

# %%
# In the slow run-up of the machine itself the oil lags only a little, and less the faster the rotor turns:

run_up = ab.flow.annulus_flow(machine)
early, late = (run_up.speed - run_up.fluid_speed).interp(time=[20.0, 120.0]).values
print(f"spun up within {start.spin_up_time:.2f} s after the sudden start")
print(f"slow run-up: lag {early:.2f} rad/s after 20 s, {late:.2f} rad/s after 120 s")
assert start.spin_up_time < 0.25
assert 0.0 < late < 0.7 * early
