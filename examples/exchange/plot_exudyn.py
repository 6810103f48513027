"""
Balls as an object of Exudyn
============================

A machine whose frame moves far, or whose parts are connected in ways that no rotor model has, is a multibody system of
Exudyn. The balancer is one more object of it: an ``ObjectGenericODE2`` with user functions, which shares the node of the rotor
and has the ball angles as coordinates of its own. Any solver of Exudyn takes it, explicit or implicit.

With the accelerations a of the shaft the element is F = force - mass a and phi'' = push - lean a, which is a mass matrix and a
force over both nodes.
"""

# %%
# The balancer, and the machine for the comparison.

import exudyn
import matplotlib.pyplot as plt
import numpy as np
from exudyn import utilities as of

import autobalancer as ab
from autobalancer.machine import Machine

MASS, MOMENT, SPEED, STIFFNESS, DAMPING, END = 5.0, 1.5e-3, 150.0, (4e4, 6e4), 120.0, 0.3

race = {"orbit_radius": 0.06, "drag": {"law": "viscous", "damping": 2e-4}, "collisions": False}
race["balls"] = [{"count": 2, "mass": 0.03, "motion": "point", "start_angles": [0.5, 3.0]}]
machine = Machine.model_validate({
    "name": "rotor", "axis": "vertical",
    "rotor": {"mass": MASS, "stiffness": STIFFNESS, "damping": DAMPING},
    "unbalances": [{"moment": MOMENT}],
    "balancers": [{"races": [race]}],
    "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": SPEED}},
})  # fmt: skip
element = ab.balancer_element(machine)
count = element.state.size // 2

# %%
# The rotor in Exudyn: a mass on springs, driven at a given speed, with the force of its unbalance.

system = exudyn.SystemContainer().AddSystem()
shaft = system.AddNode(of.NodePoint())
rotor = system.AddObject(of.MassPoint(mass=MASS, nodeNumber=shaft))
ground = system.AddMarker(of.MarkerNodeCoordinate(nodeNumber=system.AddNode(of.NodePointGround()), coordinate=0))
for coordinate, stiffness in enumerate(STIFFNESS):
    marker = system.AddMarker(of.MarkerNodeCoordinate(nodeNumber=shaft, coordinate=coordinate))
    system.AddObject(of.CoordinateSpringDamper(markerNumbers=[ground, marker], stiffness=stiffness, damping=DAMPING))
system.AddLoad(
    of.Force(
        markerNumber=system.AddMarker(of.MarkerNodePosition(nodeNumber=shaft)),
        loadVectorUserFunction=lambda system, t, load: [
            MOMENT * SPEED**2 * np.cos(SPEED * t), MOMENT * SPEED**2 * np.sin(SPEED * t), 0.0,
        ],
    )
)  # fmt: skip

# %%
# The balls: coordinates x, y, z of the shaft, then the ball angles.


def forms(t: float, q: list[float], rates: list[float]) -> tuple[np.ndarray, ...]:
    """What the element does at an instant."""
    at, moving = np.array(q), np.array(rates)
    balls = np.concatenate([at[3:], moving[3:]])
    return element.forms(t, np.concatenate([at[:2], moving[:2]]), np.array([SPEED * t, SPEED]), balls)


def masses(system: object, t: float, item: int, q: list[float], rates: list[float]) -> np.ndarray:
    """The mass matrix over shaft and balls."""
    _, mass, _, lean = forms(t, q, rates)
    matrix = np.eye(3 + count)
    matrix[:3, :3] = 0.0
    matrix[:2, :2], matrix[3:, :2] = mass[:2, :2], lean[:, :2]
    return matrix


def forces(system: object, t: float, item: int, q: list[float], rates: list[float]) -> np.ndarray:
    """The forces of the balls on the shaft, and their own."""
    force, _, push, _ = forms(t, q, rates)
    return np.concatenate([force[:2], [0.0], push])


balls = system.AddNode(
    of.NodeGenericODE2(
        numberOfODE2Coordinates=count,
        referenceCoordinates=[0.0] * count,
        initialCoordinates=element.state[:count].tolist(),
        initialCoordinates_t=element.state[count:].tolist(),
    )
)
system.AddObject(
    of.ObjectGenericODE2(
        nodeNumbers=[shaft, balls], massMatrix=np.eye(3 + count),
        forceUserFunction=forces, massMatrixUserFunction=masses,
    )
)  # fmt: skip
sensors = [
    system.AddSensor(
        of.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=exudyn.OutputVariableType.Coordinates)
    )
    for node in (shaft, balls)
]
system.Assemble()

# %%
# An explicit Runge-Kutta pair with fixed steps of 0.1 ms.

settings = exudyn.SimulationSettings()
settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = 3000, END
settings.timeIntegration.verboseMode = 0
settings.solution.sensors.writePeriod = END / 100
settings.solution.file.write = False
system.SolveDynamic(settings, solverType=exudyn.DynamicSolverType.RK44)
place, angles = (np.array(system.GetSensorStoredData(sensor)) for sensor in sensors)

# %%
# The same machine by :func:`autobalancer.simulate`.

run = ab.simulate(machine, duration=END, save=ab.SampleTimes(place[:, 0].tolist()), tolerance=1e-10)
ours = run["x"].values + 1j * run["y"].values
miss = np.abs(place[:, 1] + 1j * place[:, 2] - ours).max()
away = np.abs(angles[:, 1:] - run["ball_angle_in_rotor"].values).max()
print(f"greatest difference of the deflection {1e6 * miss:.3g} um of {1e6 * np.abs(ours).max():.3g} um, "
      f"of the ball angles {away:.2g} rad")  # fmt: skip
assert miss < 1e-6 * np.abs(ours).max()
assert away < 1e-6

figure, (above, below) = plt.subplots(2, 1, sharex=True, layout="constrained")
above.plot(place[:, 0], 1e3 * place[:, 1:3], label=["x of Exudyn", "y"])
above.plot(place[:, 0], 1e3 * np.transpose([ours.real, ours.imag]), "k:", label=["simulate", "_"])
above.set_ylabel("deflection, mm")
above.legend(ncols=3, loc="lower center", bbox_to_anchor=(0.5, 1.0))
below.plot(angles[:, 0], angles[:, 1:], label="balls of Exudyn")
below.plot(place[:, 0], run["ball_angle_in_rotor"].values, "k:")
below.set_xlabel("time, s")
below.set_ylabel("ball angle in the rotor, rad")
plt.show()
