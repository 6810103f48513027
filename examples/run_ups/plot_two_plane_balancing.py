"""
Balancing in two planes
=======================

A slender rotor with an unbalance and a couple, and two balls at each end. Above both of its critical speeds the balls take
away all vibration; between them one pattern of the balls is still driven to the heavy side.
"""

# %%
# What the two planes have to balance is the same at any speed, like the two supports of a beam.

import numpy as np

import autobalancer as ab

machine = ab.example("two_plane_rotor")
checked = ab.check(machine)
print("critical speeds:", [f"{speed:.1f} rad/s" for speed in checked.critical_speeds])
for plane in checked.stations:
    print(f"{plane.name}: needs {plane.required * 1e6:.1f} g mm, has {plane.capability * 1e6:.1f} g mm")

# %%
# Exactly where the balanced state is stable.

low, high = checked.critical_speeds
speeds = np.linspace(0.6 * low, 3.0 * high, 241)
figure = ab.plot.answer(ab.stability.eigenvalues(machine, speeds.tolist()))
border = {found.name: found.speed for found in ab.stability.borders(machine)}["exact border"]
print(f"exact border: {border:.2f} rad/s")
assert border > high
((first, last),) = ab.stability.stable_windows(machine, 1000.0).windows
assert abs(first - border) < 1e-6
assert last == 1000.0

# %%
# Steady states above the border: only the balanced one is stable, and nothing is left to vibrate at either end.

states = ab.stability.equilibria(machine, 300.0)
stable = states.where(states["verdict"] == "stable", drop=True)
print(states[["name", "deflection_at_station", "growth_rate"]].to_dataframe().head(8))
assert set(stable["name"].values) == {"balanced"}
assert float(stable["deflection_at_station"].max()) < 1e-15

# %%
# A run at 4000 rpm: each plane with its own balls, and what they have to balance there. The couple is a pair of opposite
# vectors, dashed.

run = ab.simulate(machine)
ab.plot.race(run)

# %%
# The deflection of both planes, and the vibration without balancing.

ab.plot.run_up(run)
assert float(run["plane_x"].isel(time=-1).max()) < 1e-7
