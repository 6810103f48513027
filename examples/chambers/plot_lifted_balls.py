"""
What lifts a ball
=================

A drum starts suddenly around a ball at its bottom. Friction pushes the ball up the wall only as long as it slides; a ball that
rolls hangs near the bottom. How far does it come?
"""

# %%
# The drum reaches 600 rad/s within 20 ms, so that the ball slides for a second and more. It feels its weight and the friction μN,
# with N = m (g cos θ + v²/s) and s the radius of its path. So u = v²/(g s) follows u' = 2μu + 2μ cos θ - 2 sin θ. Below
# μ = 0.603 it turns back before the height of the axis; above 0.713 it goes around.

import math

import matplotlib.pyplot as plt
import numpy as np

import autobalancer as ab
from autobalancer.machine import ChamberMachine

BALL = {"count": 1, "density": "7800 kg/m^3", "diameter": "50 mm", "positions": [[0.0, 0.0, -0.075]]}
described = {
    "name": "Drum",
    "body": {"freedom": "fixed"},
    "rotor": {"mass": 10.0, "polar_inertia": 0.05, "transverse_inertia": 0.06, "bearings": [0.1, -0.1]},
    "chambers": [{"radius": 0.1, "depth": 0.2, "balls": [BALL]}],
    "contact": {"law": "restitution", "restitution": 0.54, "youngs_modulus": "20.6 GPa"},
}


def drum(friction: float, end: float, duration: float, **chamber: object) -> ChamberMachine:
    """A drum of 0.1 m that reaches the speed ``end`` within ``duration``."""
    contact = {**described["contact"], "friction": friction}
    drive = {"kind": "speed", "profile": {"kind": "ramp", "end": end, "duration": duration}}
    chambers = [described["chambers"][0] | chamber]
    return ChamberMachine(**described | {"contact": contact, "drive": drive, "chambers": chambers})


def lifted(friction: float, angle: np.ndarray) -> np.ndarray:
    """v²/(g s) of a ball that slid all the way from the bottom."""
    square = 1.0 + 4.0 * friction**2
    even, odd = (2.0 - 4.0 * friction**2) / square, 6.0 * friction / square
    return even * (np.cos(angle) - np.exp(2.0 * friction * angle)) + odd * np.sin(angle)


highest = {}
figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
for friction, color in zip((0.5, 0.66, 0.72), ("#0072B2", "#E69F00", "#009E73"), strict=True):
    run = ab.simulate(drum(friction, 600.0, 0.02), duration=0.6)
    place = run["ball_position"].values[:, 0]
    angle = np.unwrap(np.arctan2(place[:, 1], -place[:, 2]))
    share = (run["ball_velocity"].values[:, 0] ** 2).sum(axis=1) / (9.80665 * 0.075)
    until = int(np.argmax(np.diff(angle) < 0.0)) or len(angle)
    axes.plot(np.degrees(angle[:until]), share[:until], color=color, label=f"friction {friction:g}")
    closed = np.linspace(0.0, 2.0 * math.pi, 400)
    there = lifted(friction, closed)
    axes.plot(np.degrees(closed), np.where(there >= 0.0, there, np.nan), "--", color="0.4", lw=0.9)
    highest[friction] = float(np.degrees(angle.max()))
axes.plot([], [], "--", color="0.4", lw=0.9, label="closed form")
axes.set(xlim=(0, 360), ylim=(0, 4), xlabel="angle from the bottom (°)", ylabel="v²/(g s)")
axes.legend()
assert highest[0.5] < 90.0 < highest[0.66] < 180.0
assert highest[0.72] > 360.0

# %%
# Six balls of 44 mm with a friction of 0.5, in a drum that takes a second to 157 rad/s. In one row along the axis they are six
# times one ball and stay. The same balls in a shallower chamber, side by side around the race, hold each other's spin, keep
# sliding, and go around.

SIX = {"count": 6, "density": "7800 kg/m^3", "diameter": "44 mm"}
carried = {}
for depth in ("270 mm", "135 mm", "90 mm"):
    run = ab.simulate(drum(0.5, 157.0, 1.0, depth=depth, balls=[SIX]), duration=4.0, seed=1)
    carried[depth] = float(ab.run_measures(run, last=0.5)["share_carried"])
    print(f"{depth}: {100.0 * carried[depth]:.0f} % carried")
figure = ab.plot.chamber_arrangement(run, [0.0, 0.3, 4.0])
assert carried["270 mm"] == 0.0
assert carried["90 mm"] == 1.0
