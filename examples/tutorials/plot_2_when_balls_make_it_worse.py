"""
Tutorial 2: when balls make it worse
====================================

Below its critical speed a rotor shakes more with balls than without, and above it the balls may not follow. What the
resonance does, where balls stall, what the border speeds mean, and how an oil is chosen with a stability map.
"""

# %%
# The heavy side and the light side
# ---------------------------------
#
# The disc of a laboratory centrifuge on rubber bushings, with two balls in silicone oil, from Spannan (2021). The drag of
# its balls is the law that was measured on it, which holds for slow and fast balls.

import numpy as np

import autobalancer as ab

machine = ab.with_parameter(ab.example("discoidal"), "balancers[1].races[1].drag", {"law": "discoidal"})
ab.plot.machine(machine)

# %%
# The unbalance response of the disc without balls. Look at the phase: far below the critical speed the deflection is in
# the direction of the unbalance, far above it opposite. At the critical speed it lags by 90 degrees.

response = ab.rotor.response(machine, np.linspace(20.0, 130.0, 400))
ab.plot.response(response)

# %%
# Balls run to where the rotor is deflected to. So at 500 rpm, below the critical speed, they go to the heavy side and add
# their own unbalance to it:

below = ab.with_parameter(machine, "drive.profile", {"kind": "constant", "speed": "500 rpm"})
at_500 = ab.simulate(below, duration="60 s")
ab.plot.race(at_500)

# %%
# The black triangle is where the rotor is deflected to. The balls stand there side by side. It is not exactly the
# direction of the unbalance, because near the resonance the deflection already lags behind.

print(ab.verdict(at_500))

# %%
# This is not a fault of the machine. Every ball balancer does it, and every run-up passes through these speeds. If the
# machine has to *stay* below its critical speed, the balls must be held there, or no balls used.
#
# Balls that do not follow
# ------------------------
#
# The sample ``stall_and_release`` has very little drag in its race. Its critical speed is 250 rad/s, and here its run-up
# ends at 330 rad/s, well above it.

text = ab.catalog.example_path("stall_and_release").read_text(encoding="utf-8")
lively = ab.parse_machine(text.replace('end = "500 rad/s"', 'end = "330 rad/s"'))
stalled = ab.simulate(lively)
held = ab.simulate(lively, hold_balls=True)
ab.plot.run_up(stalled, speed_unit="rad/s", held=held)

# %%
# In the upper panel the rotor runs on, and the balls stay at the critical speed: they *stall*. The reason is a balance of
# torques. A ball that circles at nearly the critical speed shakes the rotor at its resonance. The rotor whirls, and this
# whirl brakes the ball when it is about to become faster. The drag of the oil, which would take the ball along, is too
# weak to overcome that.
#
# A stalled ball balances nothing. It is an additional unbalance that excites the resonance all the time:

print(ab.verdict(stalled, held))

# %%
# Four border speeds
# ------------------
#
# When does it work? There are four answers, because there are four questions:
#
# - The **exact border**: from which speed on do balls that *are* in their places stay there?
# - The **release speed**: at which speed does the drag tear stalled balls away, in a slow run-up?
# - The **capture speed**: below which speed do balls that circle with the rotor fall back to the critical speed?
# - The **averaged border**, of a theory that leaves out the inertia of the balls: near the exact one where the oil is
#   thick, far off where it is thin. It stands here because many papers give it.

borders = ab.stability.borders(lively)
borders

# %%
# As a picture, in which their order is seen at once:

ab.plot.borders(borders, speed_unit="rad/s")

# %%
# 330 rad/s is above the exact border and below the release speed. So the balls could balance there, but on the way up
# they did not get there. If this is so, then the same balls must balance at the same speed if they do not have to pass
# the resonance. Start the rotor at 330 rad/s with its balls turning along:

there = ab.with_parameter(lively, "drive", {"kind": "speed", "profile": {"kind": "constant", "speed": "330 rad/s"}})
started_there = ab.simulate(there, duration="60 s")
print(ab.verdict(started_there))
assert ab.run_measures(started_there, "residual_vibration") < 1e-3 * ab.run_measures(stalled, "residual_vibration")

# %%
# And a run-up to 500 rad/s must release them near the release speed:

released = ab.simulate(ab.example("stall_and_release"))
broke_away = ab.run_measures(released, "break_away_speed")
print(f"balls broke away at {', '.join(f'{speed:.0f}' for speed in broke_away.values)} rad/s")
ab.plot.run_up(released, speed_unit="rad/s")

# %%
# Choose the oil
# --------------
#
# Back to the centrifuge. More drag helps the balls through the resonance, but too much of it makes them slow: they creep
# to their places like spoons in honey. Five oils, each in a full run-up to 1200 rpm:

oils = {f"{oil} mm²/s": ab.with_parameter(machine, "viscosity", f"{oil} mm^2/s") for oil in (1, 5, 20, 100, 500)}
compared = ab.compare(oils)
compared

# %%
# Compare the columns *left* and *settled after*: there is a best oil in the middle.

ab.plot.answer(compared)

# %%
# Five runs are five points. The stability map has all speeds and all oils. Its color is the rate at which a small
# disturbance of the balanced state decays (green) or grows (red), computed from the eigenvalues of the full equations.
# The names at its right edge are oils of the catalog. Two operating points are marked: the machine itself, and one that
# somebody might propose.

stability = ab.stability.map(
    machine,
    {"speed": "500:1300 rpm:160", "viscosity": "0.5:500 mm^2/s:160:log"},
    operating_points={"proposed": ("700 rpm", "2 mm^2/s")},
)
ab.plot.map(stability)

# %%
# The machine lies in the darkest green, where the balls return to their places fastest. The proposed point is hardly to
# the right of the exact border: a degree of temperature or a slightly softer bushing decides whether it works. How much
# of its decay rate is left?

for name, growth in zip(
    stability["operating_point"].values,
    [
        float(stability["growth_rate"].sel(speed=speed, viscosity=oil, method="nearest"))
        for speed, oil in zip(stability["operating_speed"].values, stability["operating_viscosity"].values, strict=True)
    ],
    strict=True,
):
    print(f"{name}: growth rate {growth:.3f} 1/s")

# %%
# The least oil for a given speed follows directly:

for name in ("exact border", "release speed"):
    least = 1e6 * ab.stability.minimum_viscosity(machine, "700 rpm", name)
    print(f"{name} at 700 rpm or below: {f'at least {least:.2f} mm²/s' if least else 'any oil will do'}")

# %%
# Exercises
# ---------
#
# 1. Run the stall machine up faster: 500 rad/s within 3 s instead of 15 s. Do its balls still stall, and where do they
#    break away?
# 2. Cold oil is thicker. Set ``balancers[1].races[1].fluid.temperature`` to ``"0 degC"`` and to ``"60 degC"``, and
#    compare both with ``ab.compare``. Which is the safer mistake, too thin or too thick?
# 3. Halve the unbalance of the centrifuge. Which of the border speeds change, and why do the others not?
