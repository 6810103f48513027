"""
Drag and friction from the angle of one ball
============================================

One ball in a slowly turned race stands still in space. The angle over the speed, in ten fluids, gives the drag
coefficient over five decades of the Reynolds number, and the rolling resistance with it.
"""

# %%
# In one oil: statics, and a run-up so slow that the ball nearly stands at any time.

import numpy as np

import autobalancer as ab

machine = ab.example("equilibrium_angle")
curve = ab.measure.equilibrium_angle(machine, simulation=True)
figure = ab.plot.answer(curve)
below = curve.where(curve["angle"] < np.radians(60.0), drop=True)
miss = float(np.degrees(np.abs(below["simulated_angle"] - below["angle"])).max())
print(f"simulated angle against statics up to 60 deg: {miss:.2f} deg")

# %%
# A table of angles in ten fluids, computed with a rolling resistance of 0.05 and scattered by half a degree. Where series
# of two fluids overlap they must agree, which they do with one coefficient only.

found = ab.measure.evaluate_angles(machine, ab.measure.load_angle_series(ab.catalog.example_path("equilibrium_angles")))
figure = ab.plot.answer(found)
one = found.sel(pressure_force="left out")
rolling, deviation = float(one["rolling_resistance"]), float(one["rolling_resistance_deviation"])
print(f"rolling resistance {rolling:.4f}, standard deviation {deviation:.4f}")
assert miss < 0.5
assert abs(rolling - 0.05) < 2.0 * deviation
