"""
A rig described from what was measured on it
============================================

Tables of a rig rarely meet its measured critical speeds. Here the bearing stiffness of the rig of Rodrigues et al. (2011),
the axial position of its mass center and its transverse inertia follow from four measured critical speeds, with the errors
that the source gives as further measurements.
"""

# %%
# The free parameters and the measurements are in a file; several entries may be tied to one parameter.

import numpy as np

import autobalancer as ab

free, measured = ab.rotor.load_measurements(ab.catalog.example_path("rodrigues_critical_speeds"))
rodrigues = ab.example("rodrigues_rig")
fit = ab.rotor.identify(rodrigues, free, measured)
print(fit.report())
figure = ab.plot.answer(fit.data)

# %%
# The four parameters are strongly correlated: the data determine some combinations far better than each alone. The singular
# values say which.

print(fit.data["singular_value"].values.round(1))
print(fit.data["direction_part"].values.round(2))

# %%
# A response curve with known shape says much more. The curve that the authors simulated gives all parameters of their model
# to four digits; a robust loss does not mind two values that lie off it.

free, measured = ab.rotor.load_measurements(ab.catalog.example_path("rodrigues_plain_rotor"))
curve = ab.rotor.identify(rodrigues, free, measured, loss="cauchy")
print(curve.report())
figure = ab.plot.answer(curve.data)

# %%
# For the tools that support planar rotors only: one oscillator instead of the rig, and its range of speeds.

planar = ab.rotor.equivalent_planar(fit.machine, method="modal")
print(planar.machine.description)
figure = ab.plot.answer(planar.data)

# %%
# The fit meets the measured speeds within a percent, and the stiffness is twice that of the table.

after, target = fit.data["after"].values[:4], fit.data["measured"].values[:4]
assert np.abs(after / target - 1.0).max() < 0.01
assert abs(fit.data["value"].values[0] / 10750.0 - 2.0) < 0.05
