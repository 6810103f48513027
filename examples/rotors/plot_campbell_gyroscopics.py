"""
Gyroscopics in a Campbell diagram
=================================

A rotor that tilts is stiffened by its spin when it whirls forward and softened when it whirls backward. The lines where
the whirl turns with the rotor are its critical speeds, and a disc has one less than a long rotor.
"""

# %%
# A rigid rotor on two equal supports, once long and once as flat as a disc. Its polar inertia is the only difference.

import math

import numpy as np

import autobalancer as ab


def rotor(name: str, polar_inertia: str) -> ab.machine.Machine:
    support = {"stiffness": "40 kN/m", "damping": "20 N*s/m"}
    return ab.machine.Machine(
        name=name,
        axis="vertical",
        rotor={
            "kind": "rigid",
            "mass": "2 kg",
            "transverse_inertia": "0.02 kg*m^2",
            "polar_inertia": polar_inertia,
            "supports": [{"position": "-120 mm", **support}, {"position": "120 mm", **support}],
        },
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": "3000 rpm"}},
    )


long, disc = rotor("long rotor", "0.008 kg*m^2"), rotor("disc", "0.03 kg*m^2")
speeds = np.linspace(0.0, 600.0, 121)
figure = ab.plot.campbell(ab.rotor.campbell(long, speeds))

# %%
# The forward conical whirl of the disc runs away from the synchronous line and never meets it.

figure = ab.plot.campbell(ab.rotor.campbell(disc, speeds))
found = ab.rotor.critical_speeds(disc)
for speed, name in zip(found["critical_speed"].values, found["name"].values, strict=True):
    print(f"{name}: {speed * 30.0 / math.pi:.0f} rpm")

# %%
# What the names mean is seen in the shapes along the axis.

figure = ab.plot.modes(ab.rotor.modes(long, 300.0))

# %%
# The critical speeds have closed forms: the inertia against tilting is the transverse less the polar one for forward
# whirl, and the sum of both for backward whirl.

tilting = 2.0 * 40e3 * 0.12**2
by_name = dict(
    zip(
        ab.rotor.critical_speeds(long)["name"].values,
        ab.rotor.critical_speeds(long)["critical_speed"].values,
        strict=True,
    )
)
assert math.isclose(by_name["conical forward"], math.sqrt(tilting / (0.02 - 0.008)), rel_tol=1e-9)
assert math.isclose(by_name["conical backward"], math.sqrt(tilting / (0.02 + 0.008)), rel_tol=1e-9)
assert "conical forward" not in found["name"].values
