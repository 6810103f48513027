"""
Tutorial 4: from the test bench to the machine
==============================================

A logger has written down a run-up and a blow with a hammer. From these files to a machine with uncertainties, and a run
of it beside the measurement.
"""

# %%
# What the logger wrote
# ---------------------
#
# A centrifuge without balls runs up through its resonance. Two displacement sensors look at its shaft along x and y, and
# a tacho gives a pulse each time the zero mark passes. The file is a table with units in its first line. It was computed,
# not measured, with noise and an uneven shaft; what was put in stands in its first lines, and we shall not look at them
# until the end.

import numpy as np

import autobalancer as ab

path = ab.catalog.example_path("run_up_signals")
signals = ab.measure.load_signals(path)
signals

# %%
# The pulses of the tacho give angle and speed of the rotor at every sample.

turned = ab.measure.rotor_angle(signals)
print(turned)

# %%
# Always look at the raw picture first. Over speed and order, vibration that turns with the rotor is a horizontal line at
# order 1.

ab.plot.order_map(ab.measure.order_map(turned, "x"))

# %%
# Amplitude and phase
# -------------------
#
# An unbalance makes a vibration of order 1, so this is the line to extract. There is a trap: at slow roll, where there is
# no unbalance force, the sensors still see something. It is the surface of the shaft, which is not round (*run-out*), and
# it must be taken off:

orders = ab.measure.orders(turned, (1, 2), slow_roll="0:4 s")
ab.plot.orders(orders)

# %%

orders

# %%
# Each amplitude has a standard deviation. The second order is hardly more than noise once the run-out is subtracted.
#
# Damping
# -------
#
# The width of the resonance peak would give the damping if the run-up were slow. It is not:

print(ab.measure.half_power(orders))

# %%
# The last line is a warning that decides: this number is too great. A blow on the rotor at standstill is the better test.
# An accelerometer wrote the decay:

decay = ab.measure.damping(ab.measure.load_signals(ab.catalog.example_path("decay_signals")))
ab.plot.answer(decay)

# %%

decay

# %%
# A machine with guesses
# ----------------------
#
# The mass was weighed: 12.27 kg. Stiffness, damping and unbalance are guesses for now. One thing is not guessed: the
# speed over time, which the tacho has measured.

coarse = turned["speed"].isel(time=slice(None, None, 100))
time = [0.0, *coarse["time"].values.tolist(), 14.0]
speed = [float(coarse[0]), *coarse.values.tolist(), float(coarse[-1])]

guess = ab.parse_machine("""
name = "centrifuge on its bushings"
axis = "vertical"
rotor = { kind = "planar", mass = "12.27 kg", stiffness = "42 kN/m", damping = "90 N*s/m" }
unbalances = [{ moment = "500 g*mm" }]
drive = { kind = "speed", profile = { kind = "constant", speed = "100 rad/s" } }
run = { duration = "13.9 s" }
""")
guess = ab.with_parameter(guess, "drive.profile", {"kind": "table", "time": time, "speed": speed})

# %%
# Fit it
# ------
#
# Four numbers are unknown. First the usual way: compare the measured amplitudes and phases with the *steady* response of
# the machine.

free = {
    "rotor.stiffness": ("20 kN/m", "80 kN/m"),
    "rotor.damping": ("10 N*s/m", "300 N*s/m"),
    "unbalances[1].moment": ("100 g*mm", "2000 g*mm"),
    "unbalances[1].angle": ("-180 deg", "180 deg"),
}
steady = ab.rotor.identify(guess, free, [ab.measure.MeasuredOrders(orders)])
print(steady.report())

# %%
# It looks exact, with tiny uncertainties, and it is wrong. The note says so: the deviations are many times what the noise
# explains. The run-up is too fast for a steady response, as the warning about the half-power width told us already. Read
# chi square before the values: it should be about as large as the number of degrees of freedom.
#
# So compare with a simulated run-up instead, tracked by the same method:

fit = ab.rotor.identify(guess, free, [ab.measure.MeasuredOrders(orders, steady=False)])
print(fit.report())

# %%

ab.plot.answer(fit.data)

# %%
# The deviations have shrunk from dozens of standard deviations to about one. One error is special: the run-out was found
# from a few slow turns, and what is wrong with it is the same in all points of a channel. ``orders["runout_deviation"]``
# says how much that may be, and the fit counts it once, not in every point anew. There is also an independent witness,
# the hammer, which knows nothing of the run-up:

rotor = fit.machine.rotor
ratio = rotor.damping / (2.0 * np.sqrt(rotor.stiffness * rotor.mass))
hammer, its_error = float(decay["damping_ratio"][0]), float(decay["damping_ratio_uncertainty"][0])
print(f"damping ratio: run-up {100 * ratio:.3f} %, hammer {100 * hammer:.3f} % +- {100 * its_error:.3f} %")
assert abs(ratio - hammer) < 4.0 * its_error

# %%
# The run beside the measurement
# ------------------------------

beside = ab.compare(ab.simulate(fit.machine, save=ab.Samples(14000)), signals)
ab.plot.answer(beside)

# %%
# The table compares what one would read off both. What differs is mostly the run-out, which the signals have and the run
# has not. No uncertainties are given, because the file does not say how noisy its sensors are.

beside

# %%
# Here is the truth, from the first lines of the file:

print("".join(path.read_text(encoding="utf-8").splitlines(keepends=True)[:4]))
found = fit.machine
print(f"found: {1e-3 * found.rotor.stiffness:.3f} kN/m, {found.rotor.damping:.2f} N*s/m")
print(f"       {1e6 * found.unbalances[0].moment:.1f} g mm at {np.degrees(found.unbalances[0].angle):.2f} deg")

# %%
# And how far off each number is, in its own standard deviations:

for number, name, true in (
    (0, "stiffness", 44654.0),
    (1, "damping", 68.37),
    (2, "unbalance", 594e-6),
    (3, "angle", np.pi / 6),
):
    off = float((fit.data["value"][number] - true) / fit.data["uncertainty"][number])
    print(f"{name}: {off:+.1f}")
    assert abs(off) < 3.0

# %%
# Exercises
# ---------
#
# 1. Leave out ``slow_roll``. How far is each of the four parameters off, in its own standard deviations?
# 2. Use only the speeds below 500 rpm: ``MeasuredOrders(orders, steady=False, highest="500 rpm")``. Which parameters are
#    lost first, and how does the report say it?
# 3. Give ``fit.machine`` a balancer, as in tutorial 1, and find its border speeds. You have got from a logger to a
#    design.
