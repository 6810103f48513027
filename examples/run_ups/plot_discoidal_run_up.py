"""
Two balls find their places
===========================

A disc on rubber bushings runs through its critical speed. Two balls that together could balance more than there is
stand apart in the end: the angle between them is set by how much they must balance, and by nothing else.
"""

# %%
# A centrifuge drive of Spannan (2021), here as a planar rotor at prescribed speed.

import numpy as np

import autobalancer as ab

run = ab.simulate(ab.example("discoidal"))

# %%
# On a logarithmic axis the deflection falls step by step: the balls are released from the critical speed, separate, and,
# when the rotor has reached its last speed, move slowly to their places.

ab.plot.run_up(run, log=True)

# %%
# While the balls slip, at 65 s, nothing is balanced. At the end all is.

ab.plot.race(run, time=65.0)

# %%

ab.plot.race(run)

# %%
# Two balls of moment :math:`m` balance the unbalance :math:`U` if each stands :math:`\arccos(U / 2m)` from the light
# side.

unbalance, moment = float(run.unbalance[-1]), float(run.ball_moment[0])
expected = 180.0 - np.rad2deg(np.arccos(unbalance / (2.0 * moment)))
found = np.rad2deg(np.abs(ab.run_measures(run, "ball_angle_to_unbalance")[-1].values))
print(f"balls at {found[0]:.3f} and {found[1]:.3f} degrees from the unbalance, expected {expected:.3f}")
assert np.allclose(found, expected, atol=1e-3)
