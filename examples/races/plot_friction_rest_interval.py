"""
Where friction lets balls rest
==============================

One ball could balance the unbalance exactly. With adherence it rests wherever the force along the race stays below what
adherence holds, and so leaves some vibration. The interval of these rests has a closed form.
"""

import numpy as np

import autobalancer as ab

mass, stiffness, orbit, ball, speed, adherence = 10.0, 4e5, 0.1, 0.01, 300.0, 4e-4
race = {
    "orbit_radius": orbit,
    "drag": {"law": "viscous", "damping": 2e-3},
    "friction": {"rolling_resistance": 0.5 * adherence, "adherence": adherence},
    "balls": [{"mass": ball, "diameter": 0.01}],
}


def rest(start):
    """Angle at which a ball from ``start`` comes to rest."""
    placed = race | {"balls": [race["balls"][0] | {"start_angles": [np.pi + start]}]}
    machine = ab.machine.Machine(
        name="one ball that sticks",
        axis="vertical",
        rotor={"mass": mass, "stiffness": stiffness, "damping": 200.0},
        unbalances=[{"moment": ball * orbit}],
        balancers=[{"races": [placed]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": speed}},
    )
    run = ab.simulate(machine, duration=20.0, save=ab.Samples(201))
    assert bool(run["ball_at_rest"][-1, 0])
    return float(run["ball_angle_in_rotor"][-1, 0]) - np.pi


# %%
# Balls from all sides stop inside the interval, and all are exactly at rest.

starts = np.radians(np.linspace(-150.0, 150.0, 31))
rests = np.array([rest(start) for start in starts])
rotor = {"mass": mass + ball, "stiffness": stiffness, "damping": 200.0, "speed": speed}
low, high = ab.laws.rest_interval(ball * orbit, ball * orbit, orbit, adherence, **rotor)

with ab.plot.style.look():
    figure = ab.plot.style.picture(7.5, 4.0)
    axes = figure.subplots()
    axes.axhspan(
        np.degrees(low), np.degrees(high), color=ab.plot.style.FILL, alpha=0.5, lw=0.0, label="may rest, closed form"
    )
    axes.plot(np.degrees(starts), np.degrees(rests), "o", ms=4, color=ab.plot.style.BALLS[0], label="rests, simulated")
    axes.set(
        xlabel="start, from the balanced place (°)", ylabel="rest, from the balanced place (°)", ylim=(-16.0, 16.0)
    )
    ab.plot.style.heading(figure, "Where adherence lets one ball rest")
    ab.plot.style.legend(axes)
print(f"rests from {np.degrees(rests.min()):.3f} to {np.degrees(rests.max()):.3f} deg")
print(f"closed form {np.degrees(low):.3f} to {np.degrees(high):.3f} deg")
assert low < rests.min() < 0.0 < rests.max() < high
