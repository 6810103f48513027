"""
Five speeds on softening rubber
===============================

Spannan (2021), section 6.1.7: two balls in thin oil, the speed of a rig on rubber bushings stepped upwards by 1 Hz, from 460 to
700 rpm. Printed are balls that turn slower than the rotor, at 53 rad/s, and only around 580 rpm. After a blow the rig vibrates at
60 rad/s, so why do its balls hang at 53?
"""

# %%
# The sample ``rubber`` is the planar stand-in of this rig on rubber that softens with the amplitude. Its rubber and its rolling
# resistance are fitted; that balls hang at none of the other speeds is not. The third machine is the whole rig: rigid bodies on
# three bushings of this rubber, whose balls are free in the plane of their race, roll and slide on its wall and meet each other.

import numpy as np

import autobalancer as ab

machine = ab.example("rubber")
linear = ab.with_parameter(
    machine, "rotor", ab.machine.PlanarRotor(mass="12.27 kg", stiffness="44.654 kN/m", damping="68.37 N*s/m")
)
rig = ab.example("discoidal_rig_rubber")
contact = {
    "stiffness": "1000 kN/m", "restitution": 0.5, "sliding_friction": 0.1, "slip_speed": "10 mm/s", "rest_speed": "1 mm/s",
}  # fmt: skip
machines = {
    "softening rubber": machine,
    "linear rubber": linear,
    "whole rig, balls resolved": ab.with_parameter(rig, "balancers[1].races[1].resolved", contact),
}
runs = {name: ab.simulate(one, save=ab.Samples(count=3081), tolerance=1e-7) for name, one in machines.items()}

# %%
# At 580 rpm the balls hang at the resonance of the soft rubber. They turn the rotor by 0.6 mm, and at this deflection its natural
# frequency is 53 rad/s. At 640 rpm the drag of the oil tears them away. On linear rubber the line would be at its one natural
# frequency, and the balls still hang at 640 rpm.

ends = np.array([60.0, 122.0, 184.0, 246.0, 308.0])  # s, of each speed
speeds = np.array([460.0, 520.0, 580.0, 640.0, 700.0]) * np.pi / 30.0
found = {}
for name, run in runs.items():
    angle = run.rotor_angle + run.ball_angle_in_rotor
    turned = angle.interp(time=ends).values - angle.interp(time=ends - 10.0).values
    found[name] = (turned / 10.0).min(axis=angle.dims.index("ball"))  # rad/s, over the last 10 s

with ab.plot.style.look():
    figure = ab.plot.style.picture(6.4, 4.0)
    axes = figure.subplots()
    axes.plot(speeds, speeds, color=ab.plot.style.CRITICAL, lw=0.9, ls="--", label="rotor speed")
    axes.plot([57.5, 64.0], [53.0, 53.0], color="black", lw=3.0, label="measured")
    for (name, line), color, mark in zip(found.items(), ab.plot.style.BALLS, ("o-", "s-", "x--"), strict=False):
        axes.plot(speeds, line, mark, ms=7, mfc="none", color=color, label=name)
    axes.set(xlabel="rotor speed (rad/s)", ylabel="speed of the slowest ball in space (rad/s)")
    ab.plot.style.heading(figure, "Balls that hang at 580 rpm only")
    ab.plot.style.legend(axes)

for name, line in found.items():
    print(f"{name}: {', '.join(f'{one:.1f}' for one in line)} rad/s")
assert abs(found["softening rubber"][2] - 53.0) < 1.0
assert np.allclose(np.delete(found["softening rubber"], 2), np.delete(speeds, 2), atol=0.1)
assert np.allclose(found["whole rig, balls resolved"], found["softening rubber"], atol=0.5)

# %%
# The speed of the balls over the run: they hang at 580 rpm only.

ab.plot.run_up(runs["softening rubber"], speed_unit="rad/s")
