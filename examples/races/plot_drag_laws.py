"""
Why thin oil releases stalled balls
===================================

Up to a Reynolds number of about 10 the drag on a ball grows with its velocity, beyond with the square of it. Balls that
stall at the critical speed of a rotor with thin oil slip at a Reynolds number of some ten thousand, and are dragged along
far better than the linear law says.
"""

# %%
# Four laws. The race of the discoidal rig is narrower than a plane, so its ball is dragged more than one on a plane,
# and that one more than one far from any wall.

import math

import matplotlib.pyplot as plt
import numpy as np

import autobalancer as ab

ab.plot.drag_laws()

# %%
# The rig of Spannan (2021), section 6.1.7: oil of 0.65 mm²/s, two balls that circle at the speed v while the rotor turns
# at W. Where the curve has its highest point near the resonance, the balls break away; where it has its lowest one beyond,
# balls that turn nearly with the rotor are captured again. Rolling resistance lowers both.

orbit, moment, critical = 0.07695, 6.656e-3 * 0.07695, math.sqrt(44654.0 / 12.27)
rotor = ab.laws.planar_receptance(12.27, 44654.0, 68.37)
oil = ab.laws.DragCurve(ab.laws.discoidal(), 760.0, 0.65e-6, 0.0123)
whirl = np.linspace(52.0, 76.0, 900)

figure, axes = plt.subplots(figsize=(6.8, 4.4), layout="constrained")
released = {}
for rolling, color in ((0.0, "#0072B2"), (0.005, "#009E73"), (0.01, "#D55E00")):
    ball = ab.laws.StalledBall(moment, 2.0 * moment, orbit, lambda slip: oil.torque(slip, orbit), rolling)
    fold = ab.laws.stall_ranges(ball, rotor, [critical])[0]
    released[rolling] = fold.release
    axes.plot(
        ab.laws.stall_balance(ball, rotor, whirl).speed, whirl, color=color, label=f"rolling resistance {rolling:g}"
    )
    axes.plot([fold.release, fold.capture], [fold.release_whirl, fold.capture_whirl], "o", color=color)
axes.plot(whirl, whirl, color="#707070", lw=0.9, ls="--", label="ball turns with the rotor")
axes.axvline(64.0, color="#222222", lw=0.9, ls=":", label="measured release")
axes.set(xlim=(52, 76), xlabel="rotor speed W (rad/s)", ylabel="speed of the balls in space v (rad/s)")
axes.legend(frameon=False)
axes.spines[["top", "right"]].set_visible(False)
plt.show()

# %%
# With linear drag the balls would stay stalled up to 370 rad/s.

linear = ab.laws.StalledBall(moment, 2.0 * moment, orbit, lambda slip: oil.viscous * orbit**2 * slip)
print(f"linear drag: {ab.laws.stall_ranges(linear, rotor, [critical])[0].release:.0f} rad/s; (6.9): {released}")
assert abs(released[0.0] - 72.6) < 0.1
assert abs(released[0.01] - 64.8) < 0.1
