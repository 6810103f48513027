"""
Impacts that leave less
=======================

Metal yields in hard impacts, and a film of oil takes the speed of slow ones. In a deep chamber both make impacts rarer while
balls look for their places: with little rebound they bounce less often.
"""

# %%
# Restitution over the speed of an impact: constant, of steel that yields from 0.1 m/s on, and of the same steel in an oil of
# 100 mPa s, where balls of 23 mm do not rebound below the Stokes number 10.

import tomllib

import matplotlib.pyplot as plt
import numpy as np

import autobalancer as ab
from autobalancer.machine import ChamberMachine

speed = np.geomspace(1e-3, 3.0, 200)
mass, radius = 7800.0 * np.pi / 6.0 * 0.023**3, 0.0115
dry = 0.9 * ab.laws.yielding_factor(speed, 0.1)
wet = dry * ab.laws.wet_factor(ab.laws.stokes_number(speed, mass, radius, 0.1), 10.0)
figure, axes = plt.subplots(figsize=(6.4, 3.2), layout="constrained")
axes.semilogx(speed, np.full_like(speed, 0.9), label="constant")
axes.semilogx(speed, dry, label="dry, yields")
axes.semilogx(speed, wet, label="in oil")
axes.set(xlabel="impact speed at a wall (m/s)", ylabel="restitution", ylim=(0.0, 1.0))
axes.legend()

# %%
# The reference machine with twenty balls in each of them. Oil would also drag the balls; here it acts
# in impacts alone.

described = tomllib.loads(ab.machine_text(ab.chamber.variant(ab.example("deep_chamber"), balls=20, friction=0.7)))
described["contact"] |= {"law": "history", "restitution": 0.9}
yields, slow = {"yield_speed": "0.1 m/s"}, {"critical_stokes": 10}

for name, rebound in {"constant": None, "dry, yields": yields, "in oil": yields | slow}.items():
    described["contact"]["rebound"] = rebound
    if name == "in oil":
        described["chambers"][0]["viscosity"] = "0.1 Pa*s"
    run = ab.simulate(ChamberMachine(**described), duration=3.0, seed=1)
    measured = ab.run_measures(run).sel(stage="transient")
    speed, power = float(measured["impact_speed"]), float(measured["impact_power"])
    print(f"{name}: {float(measured['impact_rate']):.0f} impacts a second at {speed:.2f} m/s, {power:.1f} W")

# %%
# In oil: when it is loud, and how hard the balls hit.

figure = ab.plot.answer(run, "collisions")

# %%
# How small a step has to be for an elastic collision to keep its energy: the shorter the contact, the smaller the step.

figure = ab.plot.answer(ab.chamber.step_size(stiffness_over_mass=1e10))
