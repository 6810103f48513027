"""
A race, a ball and rubber, from what was measured of them
=========================================================

What a model of a balancer needs and no drawing says: the shape of the race, the friction that holds a ball, the drag of the oil,
the stiffness and damping of rubber. Each comes from a short table of measured numbers, with its uncertainty.
"""

# %%
# The wall of a race, as a dial gauge found it around the axis of the rotor: its eccentricity, and the waves that remain.

import autobalancer as ab

race = ab.measure.race_shape(ab.catalog.example_path("race_profile"))
figure = ab.plot.answer(race)
print(race)

# %%
# Where a ball came to rest in 40 run-ups. It can rest wherever friction holds it, so the width of these places is the friction.

machine = ab.example("one_ball_run_up")
friction = ab.measure.rest_friction(machine, ab.catalog.example_path("rest_positions"), "1200 rpm")
figure = ab.plot.answer(friction)
low, high = friction.low, friction.high
print(f"adherence {1e6 * friction.adherence:.0f}, 95 % between {1e6 * low:.0f} and {1e6 * high:.0f}, in millionths")

# %%
# How far a ball lags behind a rotor that speeds up is the drag of its fluid.

drag = ab.measure.drag_from_lag(machine, ab.catalog.example_path("ball_lag"))
print(drag)

# %%
# Hysteresis loops of rubber at some frequencies and amplitudes become a law that machine files take.

rubber = ab.measure.rubber(ab.measure.load_rubber(ab.catalog.example_path("rubber_loops")))
figure = ab.plot.answer(rubber)
print(rubber.toml())

# %%
# Two sensors at a right angle: the orbit in a window of some turns, and the envelope of each turn.

run = ab.simulate(ab.example("discoidal"), duration=20.0, save=ab.Samples(20000), progress=False)
sensors = [
    *(ab.measure.Sensor("displacement", direction=way, name=way, noise="45 dB") for way in "xy"),
    ab.measure.Tacho(),
]
signals = ab.measure.rotor_angle(ab.measure.record(run, sensors, "1 kHz", start=5.0, seed=1))
figure = ab.plot.answer(ab.measure.orbit(signals, "x", "y"))
print(ab.measure.envelope(signals))

# %%
# The tables were computed with an adherence of 2e-4 and the drag of this machine; both lie within three deviations.

(true,) = ab.check(machine).races[0].drag
print(f"adherence {friction.adherence:.3g} for 2e-4; drag {drag.drag:.4g} N m s for {true:.4g} N m s")
assert friction.low < 2e-4 < friction.high
assert abs(drag.drag - true) < 3.0 * drag.drag_deviation
