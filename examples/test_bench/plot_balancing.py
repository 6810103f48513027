"""
Balancing a rotor by hand
=========================

Three ways to the unbalance of a rotor: with trial masses and phase, with amplitudes alone, and with a model in place of
trial runs.
"""

# %%
# Readings of a fan at both bearings, from an application note of Brüel & Kjær: one run as it is, and one with a trial mass in
# each plane. The influence coefficients follow, and the masses that bring both bearings to rest.

import numpy as np

import autobalancer as ab

job = ab.measure.balance(ab.catalog.example_path("two_plane_job"))
print(job)
figure = ab.plot.answer(job)

# %%
# The fan has twelve holes, and there are pieces of half a gram, one and two grams. The nearest choice of up to three holes leaves
# a part in each plane, and with it some vibration.

split = ab.measure.balance(ab.catalog.example_path("two_plane_job"), holes=12, stock=["0.5 g", "1 g", "2 g"])
print(split)
assert split.residual.max() > job.residual.max()

# %%
# Without phase, circles around the trial masses meet where the correction goes. Here are four runs of the rig of Rodrigues et al.
# (2011), whose readings have a noise of 1 %.

runs = ab.measure.four_run(ab.catalog.example_path("four_runs"))
print(runs)
figure = ab.plot.answer(runs)

# %%
# Three runs leave two answers.

three = ab.measure.four_run(ab.measure.load_balance_runs(ab.catalog.example_path("four_runs"))[:3], both=True)
figure = ab.plot.answer(three)

# %%
# With a model of the rotor a single run-down is enough, for all planes at once.

rotor = ab.example("two_plane_rotor")
planes = ab.measure.unbalance_from_run_down(rotor, ab.catalog.example_path("run_down_orders"))
print(planes)
figure = ab.plot.answer(planes)

# %%
# The table was computed with 40 g mm at 60 degrees and 25 g mm at 200 degrees.

assert np.allclose(1e6 * planes.unbalance, [40.0, 25.0], rtol=0.01)
assert runs.sizes["solution"] == 1
assert three.sizes["solution"] == 2
