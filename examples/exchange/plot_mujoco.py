"""
Balls in a model of MuJoCo
==========================

A washing drum, a robot's spindle, a mill on its frame: the machine is a model of MuJoCo, and only the balancer is missing. It
comes as a callback. MuJoCo integrates the balls as activations of a user actuator, and gets the forces that they give the rotor.

Balls are as heavy for the rotor as their motion makes them, so their force depends on the acceleration that it causes. The
callback of the control knows all other forces and the mass matrix, and solves that small system; no step is lost.
"""

# %%
# The balancer is described as always. Its rotor is used for the comparison at the end; MuJoCo has its own.

import matplotlib.pyplot as plt
import mujoco
import numpy as np

import autobalancer as ab
from autobalancer.machine import Machine

MASS, INERTIA, MOMENT, TORQUE, GRAVITY = 5.0, 0.05, 1.5e-3, 12.0, 9.80665
STIFFNESS, DAMPING, STEP, END = (4e4, 6e4), 120.0, 1e-4, 0.3

race = {"orbit_radius": 0.06, "drag": {"law": "viscous", "damping": 2e-4}, "collisions": False}
race["balls"] = [{"count": 2, "mass": 0.03, "motion": "point", "start_angles": [0.5, 3.0]}]
machine = Machine.model_validate({
    "name": "drum", "axis": "horizontal",
    "rotor": {"mass": MASS, "stiffness": STIFFNESS, "damping": DAMPING, "inertia": INERTIA},
    "unbalances": [{"moment": MOMENT}],
    "balancers": [{"races": [race]}],
    "drive": {"kind": "torque", "torque": TORQUE},
})  # fmt: skip
element = ab.balancer_element(machine)
count = element.state.size // 2

# %%
# The model of MuJoCo: two slides with springs, a hinge, an unbalanced body. The spring along y carries its weight.

center = MOMENT / MASS
spin = INERTIA - MASS * center**2
model = mujoco.MjModel.from_xml_string(f"""
<mujoco>
  <option timestep="{STEP}" integrator="RK4" gravity="0 {-GRAVITY} 0"><flag contact="disable"/></option>
  <worldbody>
    <body>
      <joint name="x" type="slide" axis="1 0 0" stiffness="{STIFFNESS[0]}" damping="{DAMPING}"/>
      <joint name="y" type="slide" axis="0 1 0" stiffness="{STIFFNESS[1]}" damping="{DAMPING}"
             springref="{MASS * GRAVITY / STIFFNESS[1]}"/>
      <joint name="rotor" type="hinge" axis="0 0 1"/>
      <inertial pos="{center} 0 0" mass="{MASS}" diaginertia="{spin} {spin} {spin}"/>
    </body>
  </worldbody>
  <actuator><general name="balls" joint="rotor" dyntype="user" gaintype="fixed" gainprm="0" actdim="{2 * count}"/></actuator>
</mujoco>""")
data = mujoco.MjData(model)

# %%
# The two callbacks. ``mjcb_control`` comes after the passive forces and before the accelerations; ``mjcb_act_dyn`` passes on
# the rates of the balls. Of a model with more joints, ``rows`` is the Jacobian of the station and of the rotor's angle.

rows = np.eye(model.nv)
found = {"rates": np.zeros(2 * count)}


def forces(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Forces of the balls and the drive on the rotor."""
    known = np.zeros((1, model.nv))
    drive = np.array([0.0, 0.0, TORQUE])
    mujoco.mj_solveM(model, data, known, (data.qfrc_passive - data.qfrc_bias + drive)[None])
    mobility = np.zeros((model.nv, model.nv))
    mujoco.mj_solveM(model, data, mobility, rows)
    shaft = np.concatenate([data.qpos[:2], data.qvel[:2]])
    rotor = np.array([data.qpos[2], data.qvel[2]])
    force, rates = element.coupled(data.time, shaft, rotor, data.act, rows @ known[0], rows @ mobility.T)
    data.qfrc_applied[:] = drive + rows.T @ force
    found["rates"] = rates


def rates(model: mujoco.MjModel, data: mujoco.MjData, actuator: int) -> float:
    """Rates of the balls."""
    data.act_dot[:] = found["rates"]
    return 0.0


data.act[:] = element.state
mujoco.set_mjcb_control(forces)
mujoco.set_mjcb_act_dyn(rates)
motion, balls = [[0.0, 0.0, 0.0]], [element.state[:count]]
for _ in range(60):
    mujoco.mj_step(model, data, nstep=round(END / STEP / 60))
    motion.append(data.qpos.copy())
    balls.append(data.act[:count].copy())
mujoco.set_mjcb_control(None)
mujoco.set_mjcb_act_dyn(None)

# %%
# The same machine by :func:`autobalancer.simulate`.

times = np.linspace(0.0, END, 61)
run = ab.simulate(machine, duration=END, save=ab.SampleTimes(times.tolist()), tolerance=1e-10)
moved = np.array(motion)
miss = np.abs(moved[:, 0] + 1j * moved[:, 1] - (run["x"].values + 1j * run["y"].values)).max()
away = np.abs(np.array(balls) - run["ball_angle_in_rotor"].values).max()
print(f"greatest difference of the deflection {1e6 * miss:.3g} um of {1e6 * run['deflection'].values.max():.3g} um, "
      f"of the ball angles {away:.2g} rad")  # fmt: skip
assert miss < 1e-6 * run["deflection"].values.max()
assert away < 1e-6

figure, (above, below) = plt.subplots(2, 1, sharex=True, layout="constrained")
above.plot(times, 1e3 * moved[:, :2], label=["x of MuJoCo", "y"])
above.plot(times, 1e3 * np.transpose([run["x"].values, run["y"].values]), "k:", label=["simulate", "_"])
above.set_ylabel("deflection, mm")
above.legend()
below.plot(times, np.array(balls), label="balls of MuJoCo")
below.plot(times, run["ball_angle_in_rotor"].values, "k:")
below.set_xlabel("time, s")
below.set_ylabel("ball angle in the rotor, rad")
plt.show()
