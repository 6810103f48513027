"""
Branches on supports that differ along x and y
==============================================

On such supports nothing rests in the rotor: its deflection runs on an ellipse, and the balls swing with twice the speed. Steady
states repeat with every half turn. Where do they begin, end and lose stability, and does a run see it?
"""

# %%
# The discoidal rotor with supports that are 40 % softer along x and 40 % stiffer along y. Both resonances show in the greatest
# and the least deflection, the half axes of the ellipse. The balanced state is stable above the second, as always, and between
# the two, where the rotor is above one critical speed and below the other. Hopf points bound both ranges.

import numpy as np

import autobalancer as ab

rotor = ab.example("discoidal")
k = rotor.rotor.stiffness
rotor = ab.with_parameter(rotor, "rotor.stiffness", (0.6 * k, 1.4 * k))
found = ab.stability.branches(rotor, "speed", "35 rad/s", "90 rad/s", from_state="all", largest_step=0.05)
states = ab.plot.branches(found, speed_unit="rad/s")

# %%
# How different do the supports have to be? The Hopf points, followed over the stiffness along x while that along y stays: the
# range between the resonances closes where the first is 71 % of the second.

curves = ab.stability.bifurcation_curves(
    rotor, "Hopf", "speed", "85 rad/s", "38 rad/s", "rotor.stiffness[1]", 0.5 * k, 1.05 * k, largest_step=0.1
)
window = ab.plot.answer(curves, speed_unit="rad/s")

# %%
# A single ball, and less unbalance. Its stable state turns back at a fold. A stepped response, run like a measurement, follows
# this state up to the fold (circles: greatest deflection); beyond it the ball cannot stay and slips round in the rotor.

ball = {"diameter": "12.3 mm", "density": "7800 kg/m^3", "motion": "rolling"}
one = ab.with_parameter(rotor, "balancers[1].races[1].balls", [ball])
one = ab.with_parameter(one, "unbalances[1].mass", "3 g")
alone = ab.stability.branches(one, "speed", "35 rad/s", "46 rad/s", from_state="all", switch=False, largest_step=0.01)
fold = float(alone["special_parameter"].values[alone["special_type"].values == "fold"][0])
steps = np.append(np.arange(36.0, fold - 0.2, 1.0), fold + np.array([-0.1, 0.1, 0.6]))
response = ab.stepped_response(one, steps, dwell="60 s", window="4 s")
jump = ab.plot.branches(alone, speed_unit="rad/s")
jump.axes[0].plot(response["speed"], 1e6 * response["amplitude"], "ko", ms=3.5, mfc="none", zorder=4)

# %%
# The numbers: the Hopf points are the ends of the ranges that the scan over the speed finds from multipliers, and the response is
# on the branch, but for its first speed, at which the ball still moves to its place.

hopf = np.sort(found["special_parameter"].values[found["special_type"].values == "Hopf"])
ranges = ab.stability.stable_windows(rotor, "90 rad/s", lowest="35 rad/s")
print(f"Hopf points: {', '.join(f'{speed:.3f}' for speed in hopf)} rad/s; fold of one ball: {fold:.3f} rad/s")
print(ranges)

below = response["speed"].values < fold
upper = alone.isel(point=np.flatnonzero(alone["verdict"].values == "stable")).sortby("parameter")
branch = np.interp(response["speed"].values[below], upper["parameter"], upper["deflection_max"])
apart = 100.0 * np.abs(response["amplitude"].values[below] / branch - 1.0)[1:]
print(f"response and branch differ by {apart[:-1].max():.2g} %, 0.1 rad/s below the fold by {apart[-1]:.2g} %")
assert apart[:-1].max() < 0.1
