"""
Balls on a rotor of ROSS
========================

A compressor, a turbine or a pump exists as a rotor of ROSS, with its bearings from ROSS too. In this example it gets two balls
and is asked what only this package answers. Then ROSS answers itself: its own time response has the balls, its figures show them.

It needs ROSS, in an environment of its own: ``pip install 'autobalancer[ross]'``.
"""

# %%
# The rotor of ROSS: a shaft of 20 elements with a disk in the middle.

import numpy as np
import ross

import autobalancer as ab
from autobalancer.machine import Machine

SPEED, MOMENT, NODE, MIDDLE, END = 400.0, 1.5e-4, 10, 0.25, 1.0

steel = ross.Material(name="steel", rho=7810.0, E=211e9, Poisson=0.3)
rotor = ross.Rotor(
    [ross.ShaftElement(0.025, 0.0, 0.02, material=steel) for _ in range(20)],
    [ross.DiskElement(n=NODE, m=3.0, Id=0.008, Ip=0.015)],
    [ross.BearingElement(n=n, kxx=1e5, cxx=60.0) for n in (0, 20)],
)

# %%
# With balls it is a machine like any other: border speeds, modes, response and runs.

race = {"orbit_radius": 0.05, "drag": {"law": "viscous", "damping": 1.5e-4}, "collisions": False}
race["balls"] = [{"count": 2, "mass": 2.5e-3, "motion": "point", "start_angles": [1.57, 4.71]}]
machine = Machine.model_validate({
    "name": "a rotor of ROSS", "axis": "vertical", "rotor": ab.rotor.from_ross(rotor).model_dump(),
    "unbalances": [{"moment": MOMENT, "station": MIDDLE}],
    "balancers": [{"station": MIDDLE, "races": [race]}],
    "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": SPEED}},
})  # fmt: skip
print(ab.stability.borders(machine))
print(ab.rotor.modes(machine, SPEED, modes=4))

# %%
# The other way round, the time response of ROSS gets the balls: ``with_balls`` is the rotor, and all that ROSS does with it
# works as before. Forces are given as ROSS wants them; ``xout`` of the result has the balls.

with_balls = ab.balancer_element(machine).in_ross(rotor, [NODE])
t = np.linspace(0.0, END, 20001)
force = np.zeros((t.size, rotor.ndof))
force[:, 6 * NODE] = MOMENT * SPEED**2 * np.cos(SPEED * t)
force[:, 6 * NODE + 1] = MOMENT * SPEED**2 * np.sin(SPEED * t)
response = with_balls.run_time_response(SPEED, force, t, model_reduction={"num_modes": 24})
figure = response.plot_2d(node=NODE)  # a figure of ROSS
balls = response.xout[:, :2]

# %%
# Both say the same.

run = ab.simulate(machine, duration=END, save=ab.SampleTimes(t[::100].tolist()))
theirs = response.yout[::100, 6 * NODE] + 1j * response.yout[::100, 6 * NODE + 1]
ours = run["x"].values + 1j * run["y"].values
miss = np.abs(theirs - ours).max() / np.abs(ours).max()
print(
    f"greatest difference {miss:.1e} of the greatest deflection; the balls are at {np.degrees(balls[-1]) % 360.0} deg"
)
assert miss < 1e-3
