"""
A rotor that tilts, through both of its critical speeds
=======================================================

A rigid rotor on two supports has two critical speeds: near the lower one its mass center moves most, near the upper
one it mostly tilts. The balls stall at the first, break away, and have balanced the rotor before it reaches the second.
"""

# %%
# The balancer sits 40 mm above the mass center, in the plane of the unbalance. Three stations are watched.

import numpy as np

import autobalancer as ab

machine = ab.example("rigid_rotor")
run = ab.simulate(machine)

# %%
# The same rotor without its balls, for comparison. Its reference is then the first station.

bare = ab.simulate(machine.model_copy(update={"balancers": ()}))


def at(run, station):
    """Deflection at a station, µm."""
    return 1e6 * np.hypot(run.station_x.sel(station=station), run.station_y.sel(station=station))


with ab.plot.style.look():
    figure = ab.plot.style.picture(8.0, 6.0)
    axes = figure.subplots(2, 1, sharex=True, sharey=True)
    for panel, what, title in zip(axes, (bare, run), ("Without balls", "With balls"), strict=True):
        for station, color in zip(("lower bearing", "upper bearing"), ab.plot.style.BALLS, strict=False):
            panel.plot(what.time, at(what, station), color=color, label=station)
        panel.set(ylabel="deflection (µm)", yscale="log", ylim=(1e-2, 3e3))
        panel.set_title(title)
    axes[1].set_xlabel("time (s)")
    ab.plot.style.heading(figure, "Rigid rotor through two critical speeds")
    ab.plot.style.legend(axes[0])

# %%
# Where the balls are: they leave the line of the rotor at the first critical speed, and catch up later.

ab.plot.run_up(run, speed_unit="rad/s")

# %%
# Critical speeds, and what is left at full speed where it is most:

first, second = run.attrs["critical_speeds"]
end = slice(9.5, 10.0)
left = max(float(at(run, s).sel(time=end).max()) for s in run.station.values)
before = max(float(at(bare, s).sel(time=end).max()) for s in run.station.values)
print(f"critical speeds {first:.1f} and {second:.1f} rad/s")
print(
    f"greatest deflection at {run.speed.values[-1]:.0f} rad/s: {before:.1f} µm without balls, {left:.3f} µm with them"
)
assert abs(first - 210.14) < 0.01
assert abs(second - 402.63) < 0.01
assert left < 1e-2 * before
