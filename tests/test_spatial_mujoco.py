"""A tilting rotor with balls as a multibody model of MuJoCo: bodies, joints and finite angles, no equation of ours."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from tests.references.spatial import split
from tests.references.spatial_machines import states_of

from autobalancer.machine import Machine

mujoco = pytest.importorskip("mujoco")

MASS, TRANSVERSE, POLAR = 5.0, 0.05, 0.03
HEIGHT = 0.02  # of the mass center above the middle of the supports
ARM, BALL, BETA = 0.09, 0.03, 2e-3  # heavy balls: m eps^2 is one part in a hundred and more of the inertias
STIFFNESS, DAMPING, REACH = (8e4, 1.1e5), (20.0, 30.0), 0.13
SPEED = 260.0
STATIONS = (0.05, 0.05, -0.03, -0.03)  # of the four balls, from the middle of the supports
ANGLES = (0.3, 0.3 + np.pi, 1.4, 1.4 + np.pi)  # the balls of a station balance each other
STEP = 4e-5


def moment_of(size: float, gravity: float) -> float:
    """None with gravity: the weight of an unbalance along a vertical axis is not in the package."""
    return 2e-4 * size if gravity == 0.0 else 0.0


def model(size: float, gravity: float, height: float, offset: float) -> str:
    """Two slides, two tilts, the spin, four arms; ``size`` scales the unbalances."""
    balls = "".join(
        f"""
        <body pos="{offset!r} 0 {z!r}">
          <joint name="ball{i}" type="hinge" axis="0 0 1" damping="{BETA!r}"/>
          <inertial pos="{ARM} 0 0" mass="{BALL}" diaginertia="1e-15 1e-15 1e-15"/>
        </body>"""
        for i, z in enumerate(STATIONS)
    )
    moment, couple = moment_of(size, gravity), 4e-5 * size
    inertia = f"{TRANSVERSE} {TRANSVERSE} {POLAR} 0 {-couple!r} 0"
    # a vertical rotor of the package has no weight that tilts it further: taken back here for the balls
    weight = BALL * gravity * sum(STATIONS)
    joints = "".join(
        f"""<joint name="{name}" type="slide" axis="{axis}" stiffness="{2 * k!r}" damping="{2 * c!r}"/>"""
        for name, axis, k, c in zip("xy", ("1 0 0", "0 1 0"), STIFFNESS, DAMPING, strict=True)
    ) + "".join(
        f"""<joint name="{name}" type="hinge" axis="{axis}" stiffness="{2 * k * REACH**2 + weight!r}"
            damping="{2 * c * REACH**2!r}"/>"""
        for name, axis, k, c in zip("ab", ("0 1 0", "-1 0 0"), STIFFNESS, DAMPING, strict=True)
    )
    return f"""
    <mujoco>
      <option timestep="{STEP}" integrator="RK4" gravity="0 0 {-gravity!r}"><flag contact="disable"/></option>
      <worldbody>
        <body>{joints}
          <joint name="rotor" type="hinge" axis="0 0 1"/>
          <inertial pos="{moment / MASS!r} 0 {height!r}" mass="{MASS}" fullinertia="{inertia}"/>{balls}
        </body>
      </worldbody>
    </mujoco>"""


def machine(size: float, gravity: float, height: float, offset: float, races: str) -> Machine:
    """The same in the words of the package; positions count from the mass center."""

    def balancer(first: int) -> dict[str, Any]:
        balls = {"count": 2, "mass": BALL, "motion": "point", "start_angles": list(ANGLES[first : first + 2])}
        race = {
            "orbit_radius": ARM,
            "eccentricity": offset,
            "drag": {"law": "viscous", "damping": BETA},
            "balls": [balls],
        }
        return {"station": STATIONS[first] - height, "races": [race]}

    return Machine(
        name="as in MuJoCo",
        axis="vertical",
        gravity=gravity,
        rotor={
            "kind": "rigid",
            "mass": MASS,
            "transverse_inertia": TRANSVERSE,
            "polar_inertia": POLAR,
            "supports": [
                {"position": z - height, "stiffness": list(STIFFNESS), "damping": list(DAMPING)}
                for z in (-REACH, REACH)
            ],
        },
        unbalances=[{"moment": moment_of(size, gravity), "station": 0.0}, {"couple": 4e-5 * size}],
        balancers=[balancer(0), balancer(2)],
        tilting_races=races,
        drive={"kind": "torque", "torque": 0.0},
        start={"speed": SPEED},
    )


def run_mujoco(text: str, times: np.ndarray) -> np.ndarray:
    """x, y of the middle of the supports, slopes, rotor angle and ball angles."""
    system = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(system)
    data.qpos[5:] = ANGLES
    data.qvel[4] = SPEED
    rows = [data.qpos.copy()]
    for a, b in pairwise(times):
        mujoco.mj_step(system, data, nstep=round((b - a) / STEP))
        rows.append(data.qpos.copy())
    found = np.array(rows)
    found[:, 4] += 0.5 * found[:, 2] * found[:, 3]  # spin after one rotation by (-b, a, 0), not after two
    return found[:, [0, 2, 1, 3, *range(4, 9)]]


TIMES = np.linspace(0.0, 0.4, 101)


def difference(size: float, races: str, gravity: float = 0.0, height: float = HEIGHT, offset: float = 0.0) -> Any:
    """Greatest differences of deflections, slopes, ball angles and rotor angle, each over its greatest change."""
    theirs = run_mujoco(model(size, gravity, height, offset), TIMES)
    case = machine(size, gravity, height, offset, races)
    ours = split(case, states_of(case, TIMES))[:, 0]
    ours[:, [0, 2]] -= height * ours[:, [1, 3]]
    free = np.zeros(9)
    free[4] = SPEED
    found = []
    for group in ([0, 2], [1, 3], [5, 6, 7, 8], [4]):
        change = theirs[:, group] - theirs[0, group] - np.outer(TIMES, free[group])
        found.append(np.abs(ours[:, group] - theirs[:, group]).max() / np.abs(change).max())
    return np.array(found)


def test_mujoco_moves_a_tilting_rotor_with_balls_in_the_same_way() -> None:
    assert difference(0.03, "full").max() < 1e-6


def test_what_is_left_of_the_difference_to_mujoco_falls_with_the_square_of_the_deflections() -> None:
    """So it is the linearization of the rotor, and nothing else."""
    large, middle, small = (difference(size, "full") for size in (0.2, 0.1, 0.05))
    assert large.max() < 1e-5
    np.testing.assert_allclose(np.log2(large / middle), 2.0, atol=0.2)
    # the rotor angle, which changes with the square itself, is lost in rounding at the smallest size
    np.testing.assert_allclose(np.log2(middle / small)[:3], 2.0, atol=0.1)


def test_mujoco_finds_the_weight_of_the_balls_along_a_vertical_axis() -> None:
    """The mass center in the middle of the supports; half of the balls weighs on a leaning race."""
    assert difference(0.03, "full", gravity=9.81, height=0.0).max() < 3e-6
    assert difference(0.03, "full", gravity=0.0, height=0.0).max() < 3e-6


def test_mujoco_moves_balls_in_races_off_center_in_the_same_way() -> None:
    assert difference(0.005, "full", offset=2e-5).max() < 3e-6


def test_balls_that_feel_deflections_only_move_differently_where_they_are_heavy() -> None:
    """The balls are some hundredths of the inertias here, and so is the difference."""
    assert 1e-2 < difference(0.03, "deflection").max() < 0.1
