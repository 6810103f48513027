"""
Unbalance response of a rig on anisotropic bearings
===================================================

Bearings that are softer along y than along x split each critical speed in two, and between the two the rotor whirls
against its rotation. The rig is that of Rodrigues et al. (2011), without balls.
"""

# %%
# Amplitude and phase at both bearings. Shaded are the speeds at which one of them whirls backward.

import numpy as np

import autobalancer as ab

machine = ab.example("rodrigues_rig")
rpm = np.pi / 30.0
found = ab.rotor.response(machine, np.linspace(600.0, 5500.0, 1500) * rpm, ["B1", "B2"])
figure = ab.plot.response(found)

# %%
# The same in the complex plane of the rotor: each resonance is a loop.

figure = ab.plot.answer(found, "polar_response")

# %%
# Near the second peak the orbits at the two bearings are passed in opposite directions.

orbits = ab.rotor.whirl_orbits(machine, 1675.0 * rpm)
figure = ab.plot.answer(orbits)

# %%
# Along the axis it is seen why: where the ellipse is a line, the direction changes.

figure = ab.plot.answer(orbits, "whirl_along_axis")

# %%
# Four peaks, of two cylindrical and two conical whirls.

peaks = ab.rotor.response_peaks(machine, 1000.0 * rpm, 3000.0 * rpm, ["B1", "B2"])
print((peaks["peak_speed"].values / rpm).round(1), "rpm")
assert peaks.sizes["peak"] == 4
assert list(orbits["whirl"].values[:2]) == ["backward", "forward"]
between = found.sel(speed=slice(1470.0 * rpm, 1600.0 * rpm))
assert (between["whirl"].values == "backward").any()
