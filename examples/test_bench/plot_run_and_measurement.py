"""
A run beside its measurement
============================

A rig is measured while it runs up: two displacement sensors with noise, and a tacho. Its true damping is not that of the machine
file. The run of the file beside the signals shows it, and a fit to the run-up finds it.
"""

import autobalancer as ab

MACHINE = """name = "small rig"
axis = "vertical"
rotor = { kind = "planar", mass = "10 kg", stiffness = "1 MN/m", damping = "300 N*s/m" }
drive = { kind = "speed", profile = { kind = "ramp", start = "150 rad/s", end = "600 rad/s", duration = "0.25 s" } }
unbalances = [{ moment = "400 g*mm" }]
run = { duration = "0.3 s" }
[[balancers]]
[[balancers.races]]
orbit_radius = "100 mm"
drag = { law = "viscous", damping = "1e-3 N*m*s" }
balls = [{ count = 2, mass = "3 g", density = "7800 kg/m^3", start_angles = ["60 deg", "200 deg"] }]
"""
machine = ab.parse_machine(MACHINE)
rig = ab.with_parameter(machine, "rotor.damping", "450 N*s/m")

# %%
# What the logger writes of the rig.

sensors = [ab.measure.Sensor("displacement", direction=way, noise="40 dB") for way in ("x", "y")]
measured = ab.measure.record(ab.simulate(rig, save=ab.Samples(1201)), [*sensors, ab.measure.Tacho()], "4 kHz", seed=1)

# %%
# The run of the machine file beside it.

both = ab.compare(ab.simulate(machine, save=ab.Samples(1201)), measured)
print(both)
ab.plot.answer(both)

# %%
# The damping with which the run-up is the measured one.

found = ab.measure.fit_run_up(machine, measured, {"rotor.damping": ("50 N*s/m", "2 kN*s/m")})
print(found.report())

# %%
# Afterwards only the noise is left.

after = ab.compare(ab.simulate(found.machine, save=ab.Samples(1201)), measured)
print(after)
ab.plot.answer(after)
