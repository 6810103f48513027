"""
Which oil? A stability map
==========================

Growth rate of the balanced state over speed and viscosity, with averaged border, exact border and release speed; and
the least oil with which the balancer works at its speed, whatever the unbalance.
"""

# %%
# The disc of a centrifuge on rubber bushings. Color is exact: green decays, red grows.

import numpy as np

import autobalancer as ab

machine = ab.example("discoidal")
axes = {"speed": np.linspace(50.0, 130.0, 400), "viscosity": np.geomspace(0.3e-6, 100e-6, 400)}
figure = ab.plot.map(ab.stability.map(machine, axes))

# %%
# With thin oil the border over the unbalance is constant except in a band where the two balls are at right angles.

race = "balancers[1].races[1].fluid"
thin = ab.with_parameter(ab.with_parameter(machine, race, {"name": "silicone oil 0.65"}), "name", "Thin oil")
figure = ab.plot.answer(ab.stability.border_curve(thin, "unbalance"))

# %%
# The least oil for 1200 rpm: for the unbalance of the machine, for any unbalance, and by the averaged equations.

names = ("exact border", "exact border, worst case", "averaged border", "release speed")
least = {name: 1e6 * ab.stability.minimum_viscosity(machine, "1200 rpm", name) for name in names}
print({name: f"{value:.3g} mm^2/s" for name, value in least.items()})
assert least["exact border"] < least["exact border, worst case"] < least["averaged border"] < least["release speed"]
assert abs(least["exact border, worst case"] - 0.998) < 1e-3
