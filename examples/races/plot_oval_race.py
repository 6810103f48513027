"""
Balls prefer the wide places of a race
======================================

A race pressed into its rotor is a little oval. The centrifugal force drives a ball to the wide places, the unbalance
drives it to the opposite side; what results depends on where the unbalance sits on the oval. A ball that is free
between its walls comes to rest where the guided one does.
"""

import numpy as np

import autobalancer as ab

machine = ab.example("oval_race")
wide = float(machine.balancers[0].races[0].harmonics[0].angle)

# %%
# One run-up for each position of the unbalance, with oval and circular race.

places = np.radians(np.arange(0, 360, 15))


def rests(race, places=places):
    angles = []
    for place in places:
        run = ab.simulate(ab.with_parameter(race, "unbalances[1].angle", float(place)), save=ab.Samples(2))
        angles.append(float(run["ball_angle_in_rotor"][-1, 0]))
    return np.array(angles)


oval = rests(machine)
circle = rests(ab.with_parameter(machine, "balancers[1].races[1].harmonics", []))

# %%
# The same oval for a ball that is resolved in contact: an elastic wall, which it may leave and on which it may slip.

law = {"stiffness": "1000 kN/m", "restitution": 0.5, "sliding_friction": 0.1}
law |= {"slip_speed": "10 mm/s", "rest_speed": "1 mm/s"}
some = places[::4]
free = rests(ab.with_parameter(machine, "balancers[1].races[1].resolved", law), some)

# %%
# The deviation from the ideal place, opposite to the unbalance, has two periods per turn.


def miss(angles, places=places):
    return np.degrees(np.angle(np.exp(1j * (angles - places - np.pi))))


with ab.plot.style.look():
    figure = ab.plot.style.picture(7.5, 4.0)
    axes = figure.subplots()
    axes.plot(np.degrees(places), miss(circle), "o-", ms=3, color=ab.plot.style.INK, label="circular race")
    axes.plot(np.degrees(places), miss(oval), "o-", ms=3, color=ab.plot.style.BALLS[0], label="oval race, 10 µm")
    look = {"ms": 7, "mew": 1.8, "color": ab.plot.style.BALLS[1]}
    axes.plot(np.degrees(some), miss(free, some), "x", label="oval race, resolved ball", **look)
    axes.set(xlabel="direction of the unbalance (°)", ylabel="rest, from opposite of the unbalance (°)")
    axes.set_xticks(range(0, 361, 45))
    ab.plot.style.heading(figure, "Where a ball comes to rest in an oval race")
    ab.plot.style.legend(axes)

# %%
# Of all rests on the oval, more than half are within 45 deg of a wide place.

near = float(np.mean(np.cos(2.0 * (oval - wide)) > 0.0))
print(f"{100 * near:.0f} % of the rests are near a wide place")
assert near > 0.6
assert np.abs(miss(free, some) - miss(oval)[::4]).max() < 2.0
