"""The planar machine as a multibody model of MuJoCo: bodies and joints there, no equation of ours."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from tests.references.motion import motion
from tests.references.runs import states_at

from autobalancer.machine import Machine

mujoco = pytest.importorskip("mujoco")

MASS, INERTIA, UNBALANCE, ARM, BALL = 9.995, 0.05, 5e-4, 0.1, 2.5e-3
STEP = 2e-5


def model(
    *,
    stiffness: tuple[float, float],
    damping: tuple[float, float],
    beta: float,
    angles: tuple[float, float],
    offset: float = 0.0,
    gravity: float = 0.0,
    brake: float = 0.0,
    added: float = 0.0,
) -> str:
    """Host on two sliding joints, rotor on a hinge, each ball a point mass at the end of a hinged arm.

    ``added`` is inertia of the arms alone, as a virtual mass makes it; the spring along y carries the rotor's weight.
    """
    center = UNBALANCE / MASS
    about_center = INERTIA - MASS * center**2
    ball = "".join(
        f"""
        <body pos="{offset!r} 0 0">
          <joint name="ball{i}" type="hinge" axis="0 0 1" damping="{beta!r}" armature="{added!r}" ref="0"/>
          <inertial pos="{ARM} 0 0" mass="{BALL}" diaginertia="1e-15 1e-15 1e-15"/>
        </body>"""
        for i in range(len(angles))
    )
    return f"""
    <mujoco>
      <option timestep="{STEP}" integrator="RK4" gravity="0 {-gravity!r} 0"><flag contact="disable"/></option>
      <worldbody>
        <body>
          <joint name="x" type="slide" axis="1 0 0" stiffness="{stiffness[0]}" damping="{damping[0]}"/>
          <joint name="y" type="slide" axis="0 1 0" stiffness="{stiffness[1]}" damping="{damping[1]}"
                 springref="{MASS * gravity / stiffness[1]!r}"/>
          <joint name="rotor" type="hinge" axis="0 0 1" damping="{brake!r}"/>
          <inertial pos="{center!r} 0 0" mass="{MASS}"
                    diaginertia="{about_center!r} {about_center!r} {about_center!r}"/>{ball}
        </body>
      </worldbody>
    </mujoco>"""


def run_mujoco(text: str, angles: tuple[float, float], speed: float, torque: float, times: np.ndarray) -> np.ndarray:
    """x, y, rotor angle and ball angles at these times (multiples of the step)."""
    system = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(system)
    data.qpos[3:] = angles
    data.qvel[2] = speed
    data.qfrc_applied[2] = torque
    rows = [data.qpos.copy()]
    for a, b in pairwise(times):
        mujoco.mj_step(system, data, nstep=round((b - a) / STEP))
        rows.append(data.qpos.copy())
    return np.array(rows)


def machine(
    *,
    stiffness: tuple[float, float],
    damping: tuple[float, float],
    beta: float,
    angles: tuple[float, float],
    speed: float,
    torque: float,
    offset: float = 0.0,
    gravity: float = 0.0,
    brake: float = 0.0,
    added: float = 0.0,
) -> Machine:
    """The same in the words of the package; ``added`` as a fluid of hardly any buoyancy and much virtual mass."""
    race: dict[str, Any] = {
        "orbit_radius": ARM,
        "eccentricity": offset,
        "drag": {"law": "viscous", "damping": beta},
    }
    balls = {"count": 2, "mass": BALL, "motion": "point", "start_angles": list(angles)}
    if added:
        volume = np.pi / 6 * 0.01**3
        density = 1e-6
        balls["diameter"] = 0.01
        race["fluid"] = {
            "density": density,
            "viscosity": 1e-6,
            "virtual_mass": added / (density * volume * ARM**2),
        }
    return Machine(
        name="as in MuJoCo",
        axis="horizontal" if gravity else "vertical",
        gravity=gravity,
        rotor={"mass": MASS, "stiffness": list(stiffness), "damping": list(damping), "inertia": INERTIA},
        unbalances=[{"moment": UNBALANCE}],
        balancers=[{"races": [race | {"balls": [balls], "collisions": False}]}],
        drive={"kind": "torque", "torque": torque, "damping": brake},
        start={"speed": speed},
    )


CASES: dict[str, dict[str, Any]] = {
    "run-up through resonance": {"speed": 150.0, "torque": 8.0, "brake": 5e-3},
    "unequal supports": {"stiffness": (6.25e5, 5.2e5), "damping": (100.0, 140.0), "speed": 230.0, "torque": 1.0},
    "race off center": {"offset": 1.5e-3, "speed": 300.0, "torque": -2.0},
    "gravity": {"gravity": 9.81, "speed": 20.0, "torque": 6.0},
    "virtual mass": {"added": 7e-6, "speed": 240.0, "torque": 0.5},
}


@pytest.mark.parametrize("name", CASES)
def test_mujoco_moves_the_same_machine_in_the_same_way(name: str) -> None:
    case = {
        "stiffness": (6.25e5, 6.25e5),
        "damping": (100.0, 100.0),
        "beta": 1.5e-4,
        "angles": (1.0, -1.9),
    } | CASES[name]
    times = np.linspace(0.0, 1.2, 121)
    body = {key: value for key, value in case.items() if key not in ("speed", "torque")}
    theirs = run_mujoco(model(**body), case["angles"], case["speed"], case["torque"], times)
    ours = motion(machine(**case), states_at(machine(**case), times))
    assert np.abs(theirs[:, :2]).max() > 2e-5
    assert np.ptp(theirs[:, 3]) > 1.0  # the balls travel
    np.testing.assert_allclose(ours.deflection, theirs[:, :2], rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(ours.rotor_angle, theirs[:, 2], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(ours.angles, theirs[:, 3:], rtol=0.0, atol=1e-8)
