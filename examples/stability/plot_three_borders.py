"""
Three border speeds and one run-up
==================================

From which speed on does the balancer work? The averaged border, the exact border and the release speed answer
three different questions. A slow run-up of two lightly damped balls shows which is which.
"""

# %%
# The stall-and-release machine, with a run-up of 5 rad/s in each second, slow enough for the release.

import numpy as np

import autobalancer as ab

machine = ab.example("stall_and_release")
slow = ab.with_parameter(machine, "drive.profile", {"kind": "ramp", "end": "450 rad/s", "duration": "90 s"})
run = ab.simulate(slow, duration=90.0)
borders = {border.name: border.speed for border in ab.stability.borders(slow)}

# %%
# The balls leave the rotor at the critical speed. From the exact border on the balanced state is stable: balls
# that were there would stay, but these are not there. At the averaged border nothing happens at all. They break
# away at the release speed.

figure = ab.plot.run_up(run, speed_unit="rad/s", start=45.0)
colors = {"averaged border": "#009E73", "exact border": "#D55E00", "release speed": "#CC79A7"}
for name, color in colors.items():
    passed = float(np.interp(borders[name], run["speed"], run["time"]))
    for axes in figure.axes:
        axes.axvline(passed, color=color, lw=1.2)
    panel = figure.axes[0]
    panel.text(passed + 0.2, 0.03, name, transform=panel.get_xaxis_transform(), color=color, fontsize=9)

# %%
# The same balls, started on the rotor at 300 rad/s, between exact and averaged border, find their places.

constant = {"kind": "speed", "profile": {"kind": "constant", "speed": "300 rad/s"}}
there = ab.simulate(ab.with_parameter(slow, "drive", constant), duration=60.0)
left = ab.run_measures(there, "residual_vibration")

released = ab.run_measures(run, "break_away_speed").values
print({name: round(speed, 1) for name, speed in borders.items()})
print(f"broke away at {released.max():.1f} rad/s; from a start at 300 rad/s {1e6 * left:.2f} um are left")
assert np.allclose(released, borders["release speed"], rtol=0.01)
assert left < 1e-6
