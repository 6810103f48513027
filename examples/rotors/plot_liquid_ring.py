"""
A ring of liquid beside balls
=============================

A drum with a ring partly filled with brine, in a steady whirl, and the same drum with balls of a sixth of the liquid's mass. The
surface of the liquid is a circle about the axis of rotation, so the liquid balances only as long as the drum still deflects: far
above the critical speed it leaves 57 % here, however little of it there is. Balls move to the light side and stay there, so
nothing is left above the speed at which this becomes stable; points at the lower edge mean less than 0.01 mm. Below it both make
things worse. In the shaded band the waves of the liquid and the drum excite each other.
"""

import numpy as np

import autobalancer as ab
from autobalancer.machine import Balancer

drum = ab.example("liquid_ring")
liquid = ab.rotor.liquid_response(drum, np.linspace(12.0, 105.0, 400))
print(liquid)

race = {
    "orbit_radius": "240 mm",
    "drag": {"law": "viscous", "damping": "0.2 N*m*s"},
    "balls": [{"count": 2, "diameter": "42 mm", "density": "7800 kg/m^3"}],
}
parts = {key: getattr(drum, key) for key in ("name", "axis", "rotor", "unbalances", "drive")}
balls = ab.machine.Machine(**parts, balancers=[Balancer(races=[race])])
speeds = np.array([15.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0, 90.0, 105.0])
stepped = ab.stepped_response(balls, speeds, dwell="30 s", window="4 s")

# %%
ab.plot.answer(liquid, balls=(speeds, np.maximum(stepped["amplitude"].values.ravel(), 1e-5)))
