"""
A blade is lost
===============

A fan runs balanced at constant speed. At 5 s it loses a piece of a blade: the unbalance jumps, and with it the
vibration. The balls leave their places at once and find new ones.
"""

# %%
# The machine is put together from its parts. A schedule with two equal times is a jump.

import numpy as np

import autobalancer as ab
from autobalancer.machine import (
    Balancer,
    Balls,
    Constant,
    Machine,
    PlanarRotor,
    PrescribedSpeed,
    Race,
    Schedule,
    Unbalance,
    ViscousDrag,
)

balls = Balls(count=2, mass="4 g", material="steel", start_angles=["110 deg", "250 deg"])
race = Race(orbit_radius="100 mm", drag=ViscousDrag(damping="1e-3 N*m*s"), balls=[balls])
fan = Machine(
    name="fan",
    axis="vertical",
    rotor=PlanarRotor(mass="10 kg", stiffness="625 kN/m", damping="100 N*s/m"),
    unbalances=[
        Unbalance(moment="200 g*mm", angle="0 deg"),
        Unbalance(moment="350 g*mm", angle="70 deg", schedule=Schedule(time=["5 s", "5 s"], factor=[0, 1])),
    ],
    balancers=[Balancer(races=[race])],
    drive=PrescribedSpeed(profile=Constant(speed="4800 rpm")),
)
run = ab.simulate(fan, duration=10.0)

# %%
# After the jump the balls go to new places, and the vibration goes.

ab.plot.run_up(run, log=True)

# %%
# The unbalance before and after it, and what the balls make of it:

ab.plot.race(run, time=4.99)

# %%

ab.plot.race(run)

# %%
# How large the jump is, and how soon nine tenths of it are gone:

after = run["deflection"].where(run["time"] > 5.0, drop=True)
peak = ab.verdict(run).parts[1].peak.deflection
late = after["time"].where(after > 0.1 * peak, drop=True)[-1]
print(f"unbalance {1e6 * run['unbalance'].values[0]:.0f}, then {1e6 * run['unbalance'].values[-1]:.0f} g mm")
print(f"deflection up to {1e6 * peak:.0f} um, below a tenth of it after {float(late) - 5.0:.2f} s")
assert np.all(run["residual_unbalance"].sel(time=[4.99, 10.0], method="nearest") < 1e-7)
assert 20e-6 < peak < 150e-6
assert late < 6.5
