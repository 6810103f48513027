"""
Balls that find their race
==========================

A guided ball is on its race from the first instant. Here two balls lie on the floor of the annulus, 6 mm from the wall,
when the rotor starts to turn. The oil takes them along, and they roll outward over the floor. In the corner of floor and
wall they roll on both until the friction of the wall carries their weight; then they do what guided balls do.
"""

import numpy as np

import autobalancer as ab

machine = ab.example("resolved_balls")
run = ab.simulate(machine, save=[ab.Samples(29_001), ab.Envelope(1000), ab.LastRevolutions(10)])

# %%
# Distance from the wall, and the force with which the wall presses back, m eps w^2 once the ball is there. The floor carries
# what the friction of the wall leaves of the weight.

measures = ab.run_measures(run)
print("on the floor until", measures.lift_off_time.values.round(1), "s")
early = run.sel(time=slice(0.0, 8.0))
with ab.plot.style.look():
    figure = ab.plot.style.picture(7.5, 5.0)
    above, below = figure.subplots(2, 1, sharex=True)
    for number, width in ((0, 3.0), (1, 1.3)):
        above.plot(
            early.time,
            1e3 * early.ball_gap[:, number],
            color=ab.plot.style.BALLS[number],
            lw=width,
            label=f"ball {number + 1}",
        )
        below.plot(early.time, early.ball_normal_force[:, number], color=ab.plot.style.BALLS[number], lw=width)
    below.plot(
        early.time,
        float(run.ball_moment[0]) * early.speed**2,
        "--",
        color=ab.plot.style.INK,
        lw=1.0,
        label="m ε Ω²",
    )
    above.set_ylabel("distance from the wall (mm)")
    below.plot(early.time, early.ball_floor_force[:, 0], color=ab.plot.style.CRITICAL, label="floor")
    below.set(xlabel="time (s)", ylabel="normal force (N)")
    ab.plot.style.heading(figure, "Two balls find their race")
    ab.plot.style.legend(above)
    ab.plot.style.legend(below)

# %%
# From then on it is the run-up of a balancer.

ab.plot.run_up(run)

# %%
# At the end the balls stand where they balance, up to what adherence holds back.

ab.plot.race(run)
print(f"residual unbalance {1e6 * float(run.residual_unbalance[-1]):.1f} g mm")
assert float(run.ball_gap[0].min()) > 5.9e-3
assert float(run.ball_gap[-1].max()) < 0.0
assert np.abs(run.ball_speed_in_rotor[-1]).max() < 1e-3
