"""
Balls that stall at the critical speed
======================================

The rotor runs on, the balls do not: at the critical speed the vibration of the rotor holds them back, until the drag
of the race at last tears them away. Then they fly to the light side, and nothing is left of the vibration.
"""

# %%
# Two balls, each half as heavy as needed, so that together they balance the rotor exactly.

import autobalancer as ab

run = ab.simulate(ab.example("stall_and_release"))

# %%
# In the upper panel the balls leave the line of the rotor at the critical speed and stay there for four seconds. In
# the frame of the rotor, the lower panel, they slip round and round meanwhile. After the release they come to rest
# opposite to the unbalance.

ab.plot.run_up(run, speed_unit="rad/s")

# %%
# At the end the balls (grey) give what the rotor lacks.

ab.plot.race(run)

# %%
# The speed of the stalled balls, and the rotor speed at which they exceed the critical speed by 1 %:

(critical_speed,) = run.attrs["critical_speeds"]
balls = run.ball_speed_in_space.mean("ball")
stalled = float(balls.sel(time=slice(10.0, 11.0)).mean())
away = run.time.where((run.time > 9.0) & (balls > 1.01 * critical_speed), drop=True)[0]
release = float(run.speed.sel(time=away))
final = ab.run_measures(run, "residual_vibration")
print(f"critical speed {critical_speed:.0f} rad/s, the balls stall at {stalled:.1f} rad/s")
print(f"they break away when the rotor has {release:.0f} rad/s; the deflection ends at {final * 1e9:.1f} nm")
assert abs(stalled - 248.0) < 1.0
assert 383.0 < release < 387.0
assert final < 1e-6
