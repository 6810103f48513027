"""
A centrifuge rotor on its elastic shaft
=======================================

The rotor of carbon fiber of Spannan (2021), section 6.2, is suspended on a thin shaft. Its polar inertia is far greater than its
transverse one, so its natural frequencies change much with the speed, and only one critical speed is met.
"""

# %%
# The rig is one of the catalog. Without balls its Campbell diagram shows what the source measured and simulated.

import numpy as np

import autobalancer as ab

machine = ab.example("cfrp_rig")
figure = ab.plot.campbell(
    ab.rotor.campbell(machine, np.linspace(0.0, 60.0, 61), balls=False, modes=4), speed_unit="rad/s"
)

# %%
# The first mode swings about the clamp, the second about the race: there the balls do not feel it.

figure = ab.plot.modes(ab.rotor.modes(machine, balls=False, modes=4))

# %%
# Two balls of 4.4 g in silicone oil take 300 g mm away once the rotor has passed its critical speed at 4.4 Hz.

run = ab.simulate(machine)
figure = ab.plot.run_up(run)
print(f"deflection at the end: {float(run['deflection'][-1]):.1e} m")
