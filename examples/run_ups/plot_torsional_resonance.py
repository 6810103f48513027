"""
A run-up past a torsional resonance
===================================

An asynchronous motor drives a rotor through an elastic coupling. The shafts meet at a small angle, so that the coupling twists
twice per turn by itself. At half the torsional frequency this is in resonance: the coupling carries four times the rated
torque of the motor, and the deflection of the rotor shows nothing of it.
"""

# %%
# The drive train has one torsional mode. The Campbell diagram shows it as a dotted line: twice the speed meets it long before
# the critical speed of bending does.

import matplotlib.pyplot as plt
import numpy as np

import autobalancer as ab

machine = ab.example("coupled_drive")
print(ab.rotor.torsional_modes(machine))
ab.plot.campbell(ab.rotor.campbell(machine, "0:3000 rpm:31", harmonics=[1, 2]))

# %%
# A run-up. The torque of the coupling swings most soon after the speed passed 1384 rpm; the deflection is greatest later, at the
# critical speed of bending.

run = ab.simulate(machine, save=ab.Samples(12001))
rpm = run["speed"].values * 30.0 / np.pi

figure, (above, middle, below) = plt.subplots(3, 1, sharex=True, figsize=(8.0, 6.5), layout="constrained")
above.plot(run["time"], rpm)
above.set_ylabel("rotor speed (rpm)")
middle.plot(run["time"], run["link_torque"].sel(link="motor"), lw=0.6)
middle.set_ylabel("torque of the coupling (N m)")
below.plot(run["time"], run["deflection"] * 1e6)
below.set_ylabel("deflection (µm)")
below.set_xlabel("time (s)")

# %%
# The steady response at each speed is larger, because the run-up passes too fast for it to build up.

response = ab.rotor.torsional_response(machine, "200:3000 rpm:400")
ab.plot.answer(response)

# %%
# In numbers:

(critical,) = ab.rotor.torsional_critical_speeds(machine, harmonics=[2])["critical_speed"].values
passing = (run["time"] > 0.5) & (run["time"] < 1.6)  # after the start, before bending
swing = (
    np.abs(run["link_torque"].sel(link="motor") - run["link_torque"].sel(link="motor").mean())
    .where(passing, 0.0)
    .values
)
at, greatest = rpm[int(swing.argmax())], float(swing.max())
steady = float(response["link_torque"].sel(link="motor", harmonic=2.0).max())
print(f"torsional critical speed {critical * 30.0 / np.pi:.0f} rpm, greatest torque of the run-up at {at:.0f} rpm")
print(f"steady torque there: {steady:.1f} N m beside the mean; the motor has a rated torque of 7 N m")
assert abs(at / (critical * 30.0 / np.pi) - 1.0) < 0.1
assert 0.5 * steady < greatest < 2.0 * steady
