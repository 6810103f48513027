"""
Balls as an FMU on a shaft of SciPy
===================================

The balls of a machine are exported as a functional mock-up unit, which any importer reads. Here the importer is FMPy and the
shaft is a few lines for SciPy; in its place may stand Simulink, a Modelica tool or a program of multibody dynamics.

What the balls do to the shaft depends on its accelerations: ``force = force_at_rest - mass * acceleration``. The unit gives both
parts, so that the host solves for the accelerations exactly, without an algebraic loop.
"""

# %%
# The machine is described as always, and its balls are exported. The rotor turns at a given speed that rises evenly.

import shutil
import tempfile
from pathlib import Path

import fmpy
import matplotlib.pyplot as plt
import numpy as np
from fmpy.fmi2 import FMU2Model
from scipy.integrate import solve_ivp

import autobalancer as ab
from autobalancer.machine import Machine

MASS, STIFFNESS, DAMPING, MOMENT, RATE, END = 5.0, 4e4, 60.0, 3e-4, 400.0, 0.6
race = {"orbit_radius": 0.06, "drag": {"law": "viscous", "damping": 2e-4}, "collisions": False}
race["balls"] = [{"count": 2, "mass": 0.005, "motion": "point", "start_angles": [0.5, 3.0]}]
machine = Machine.model_validate({
    "name": "spindle", "axis": "vertical",
    "rotor": {"mass": MASS, "stiffness": STIFFNESS, "damping": DAMPING},
    "unbalances": [{"moment": MOMENT}],
    "balancers": [{"races": [race]}],
    "drive": {"kind": "speed", "profile": {"kind": "ramp", "end": RATE * END, "duration": END}},
})  # fmt: skip
folder = Path(tempfile.mkdtemp())
written = ab.export(machine, folder / "balls.fmu", part="balancer", duration=END)
print(f"{(folder / 'balls.fmu').stat().st_size / 1e3:.0f} kB for {' and '.join(written.systems)}")

# %%
# The importer: value references by name, one instance for Model Exchange.

about = fmpy.read_model_description(str(folder / "balls.fmu"))
references = {variable.name: variable.valueReference for variable in about.modelVariables}
unpacked = fmpy.extract(str(folder / "balls.fmu"))
unit = FMU2Model(guid=about.guid, unzipDirectory=unpacked, modelIdentifier=about.modelExchange.modelIdentifier)
unit.instantiate()
unit.setupExperiment()
unit.enterInitializationMode()
unit.exitInitializationMode()
rows = [f"{axis} at balancer 1" for axis in "xy"]
moved = [references[f"{kind}[{row}]"] for kind in ("deflection", "velocity") for row in rows]
turned = [references[name] for name in ("rotor_angle", "speed", "rotor_acceleration")]
pushed = [references[f"acceleration[{row}]"] for row in rows]
force = [references[f"force_at_rest[{row}]"] for row in rows]
mass = [references[f"mass[{one},{other}]"] for one in rows for other in [*rows, "rotor angle"]]
rate = [references[f"der(state.ball_speed_in_rotor[{ball}])"] for ball in (1, 2)]
start = unit.getReal([references[f"ball_{kind}_in_rotor[{ball}]"] for kind in ("angle", "speed") for ball in (1, 2)])

# %%
# The shaft: deflection and velocity, and behind them the states of the balls.


def rates(time: float, state: np.ndarray) -> np.ndarray:
    angle, speed = 0.5 * RATE * time**2, RATE * time
    unit.setTime(time)
    unit.setContinuousStates((fmpy.fmi2.fmi2Real * 4)(*state[4:]), 4)
    unit.setReal(moved + turned, [*state[:4], angle, speed, RATE])
    matrix = np.reshape(unit.getReal(mass), (2, 3))
    turning = np.array([np.cos(angle), np.sin(angle)])
    across = np.array([-np.sin(angle), np.cos(angle)])
    own = -STIFFNESS * state[:2] - DAMPING * state[2:4] + MOMENT * (speed**2 * turning - RATE * across)
    loads = own + unit.getReal(force) - matrix[:, 2] * RATE
    acceleration = np.linalg.solve(MASS * np.eye(2) + matrix[:, :2], loads)
    unit.setReal(pushed, acceleration)
    return np.concatenate([state[2:4], acceleration, state[6:], unit.getReal(rate)])


times = np.linspace(0.0, END, 601)
found = solve_ivp(rates, (0.0, END), [0, 0, 0, 0, *start], "DOP853", times, rtol=1e-9, atol=1e-12).y
unit.terminate()
unit.freeInstance()
shutil.rmtree(unpacked)

# %%
# The run of the package does the same.

run = ab.simulate(machine, duration=END, save=ab.SampleTimes(tuple(times)), tolerance=1e-11)
for name, of_unit, ours in (
    ("deflection", found[0], run.x.values),
    ("ball 1", found[4], run.ball_angle_in_rotor.values[:, 0]),
):
    print(f"{name}: greatest difference {np.abs(of_unit - ours).max() / np.abs(ours).max():.1e} of its size")

figure, (above, below) = plt.subplots(2, sharex=True, figsize=(8, 5), layout="constrained")
above.plot(times, 1e3 * np.hypot(found[0], found[1]), label="shaft of SciPy, balls as an FMU")
above.plot(times, 1e3 * run.deflection, "--", label="autobalancer")
above.set(ylabel="deflection [mm]")
above.legend()
below.plot(times, np.degrees(found[4:6]).T)
below.plot(times, np.degrees(run.ball_angle_in_rotor), "k--")
below.set(xlabel="time [s]", ylabel="ball angle in the rotor [deg]")
plt.show()
