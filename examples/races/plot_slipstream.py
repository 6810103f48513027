"""
Balls that line up in their slipstream
======================================

A ball behind another one feels less drag. Where both slip through the oil it comes up to the one ahead, until they stand side by
side. In line they shake the rotor with all their unbalance, and with less drag the oil tears them away later.
"""

# %%
# The run-up of the discoidal stand-in in 20 mm²/s oil, without the slipstream and with it. At a Reynolds number of 600 the factor
# is that of 300, where its fit ends; the run reports this in ``slipstream_warning``.

import warnings

import numpy as np

import autobalancer as ab

warnings.simplefilter("ignore", ab.errors.RangeWarning)
alone = ab.example("discoidal")
shielded = ab.with_parameter(alone, "balancers[1].races[1].slipstream", True)
runs = {"each ball alone": ab.simulate(alone), "slipstream": ab.simulate(shielded)}

# %%
# While stalled at the critical speed of 60 rad/s the balls touch all the time in the slipstream; without it they swing against
# each other, as the vibration of the rotor alone holds them together.

stalled = {}
with ab.plot.style.look():
    figure = ab.plot.style.picture(7.5, 5.0)
    gaps, speeds = figure.subplots(2, sharex=True)
    for (name, run), color in zip(runs.items(), ab.plot.style.BALLS, strict=False):
        one, other = (run.ball_angle_in_rotor.sel(ball=number) for number in (1, 2))
        gap = np.degrees(np.abs(np.angle(np.exp(1j * (one - other)))))
        stalls = (run.ball_speed_in_rotor.mean("ball") < -5.0) & (run.speed > 65.0)
        stalled[name] = float(np.percentile(gap[stalls], 90.0)), float(run.speed[stalls][-1])
        gaps.plot(run.speed, gap, color=color, label=name)
        speeds.plot(run.speed, run.ball_speed_in_space.mean("ball"), color=color)
    gaps.set(ylabel="angle between the balls (°)", xlim=(50.0, 85.0))
    speeds.set(xlabel="rotor speed (rad/s)", ylabel="speed of the balls in space (rad/s)", ylim=(40.0, 85.0))
    ab.plot.style.heading(figure, "Two balls at the critical speed")
    ab.plot.style.legend(gaps)
for name, (gap, release) in stalled.items():
    print(f"{name}: {gap:.1f} deg apart at most in 9/10 of the stalled time, released at {release:.1f} rad/s")
assert stalled["slipstream"][0] < 10.0 < 20.0 < stalled["each ball alone"][0]
assert stalled["slipstream"][1] > stalled["each ball alone"][1] + 3.0
