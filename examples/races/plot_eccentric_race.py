"""
A race that does not run true
=============================

The balls balance the race, not the rotor: they gather where the *center of the race* comes to rest. If this
center is off the shaft by 0.1 mm, the shaft keeps a deflection of 0.1 mm, however well the balls move. The start
is that of Bykov and Kovachev (2018): constant speed, both balls near the unbalance.
"""

import numpy as np

import autobalancer as ab

machine = ab.example("eccentric_race")
run = ab.simulate(machine, save=[ab.Samples(20_001), ab.Envelope(1000), ab.LastRevolutions(10)])

# %%
# The balls start on the heavy side, so the vibration is strong at first. It falls to the eccentricity, and no further.

ab.plot.run_up(run, deflection_unit="mm", end=2.5)

# %%
# At the end the shaft goes around on a circle as large as the eccentricity.

ab.plot.orbit(run, deflection_unit="mm")

# %%
# In the rotor it is opposite to the center of the race, so that this center does not move in space.

ab.plot.race(run)

# %%
# The deflection equals the eccentricity, and what is left of the unbalance is what it takes to hold the shaft there.

race = machine.balancers[0].races[0]
final = np.hypot(run["turn_x"], run["turn_y"])
in_rotor = (run["turn_x"] + 1j * run["turn_y"]) * np.exp(-1j * run["turn_rotor_angle"])
center = race.eccentricity * np.exp(1j * race.eccentricity_angle)
print(f"deflection {1e3 * float(final.mean()):.6f} mm, eccentricity {1e3 * race.eccentricity:.6f} mm")
assert np.allclose(final, race.eccentricity, rtol=1e-6)
assert np.allclose(in_rotor, -center, atol=1e-6 * race.eccentricity)
