"""Rigid contact of guided balls: what it keeps, what it loses, and what soft contact tends to."""

from __future__ import annotations

import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.references.race_runs import states_from, states_of
from tests.references.rates import rates_at
from tests.references.standing_races import BOTTOM, DENSITY, DIAMETER, GRAVITY, ORBIT, standing

import autobalancer as ab
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.machine import Machine
from autobalancer.simulation.steppers import equations

TOUCH = 2.0 * math.asin(0.5 * DIAMETER / ORBIT)
RACE = "balancers[1].races[1]."
COUNT, MASS, STIFFNESS, INERTIA = 5, 1.0, 2e3, 0.01


def _free(restitution: float, **race: Any) -> Machine:
    """A rotor that nothing drives or brakes, on springs, with balls that nothing brakes."""
    balls = {
        "count": COUNT, "mass": 0.02, "diameter": DIAMETER, "start_angles": [0.0, 0.4, 1.1, 2.5, 4.0],
        "start_speeds": [9.0, -4.0, 2.0, -7.0, 3.0],
    }  # fmt: skip
    whole = {
        "orbit_radius": ORBIT, "drag": {"law": "viscous", "damping": 0.0}, "contact": {"restitution": restitution},
        "balls": [balls], **race,
    }  # fmt: skip
    return Machine(
        name="free rotor",
        axis="vertical",
        rotor={"mass": MASS, "stiffness": STIFFNESS, "damping": 0.0, "inertia": INERTIA},
        balancers=[{"races": [whole]}],
        drive={"kind": "torque", "torque": 0.0},
        start={"speed": 30.0, "deflection": [1e-3, -2e-3], "velocity": [0.05, 0.02]},
    )


def _energy_and_momentum(assembly: Assembly, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Written anew from places and velocities; states are in axes at rest."""
    place, move = states[:, 0] + 1j * states[:, 1], states[:, 2] + 1j * states[:, 3]
    speed, n = states[:, 5], len(assembly.balls)
    energy = 0.5 * MASS * np.abs(move) ** 2 + 0.5 * INERTIA * speed**2 + 0.5 * STIFFNESS * np.abs(place) ** 2
    momentum = MASS * (np.conj(place) * move).imag + INERTIA * speed
    for k, ball in enumerate(assembly.balls):
        arm = ball.orbit_radius * np.exp(1j * (states[:, 4] + states[:, 6 + k]))
        velocity = move + 1j * (speed + states[:, 6 + n + k]) * arm
        spin = speed - ball.orbit_radius / ball.rolling_radius * states[:, 6 + n + k]
        energy += 0.5 * ball.mass * np.abs(velocity) ** 2 + 0.5 * ball.own_inertia * spin**2
        momentum += ball.mass * (np.conj(place + arm) * velocity).imag + ball.own_inertia * spin
    return energy, momentum


@pytest.mark.parametrize("general", [False, True])
@pytest.mark.parametrize("restitution", [1.0, 0.54, 0.0])
def test_a_free_rotor_keeps_its_angular_momentum_and_never_gains_energy(restitution: float, general: bool) -> None:
    assembly = assemble(_free(restitution), rotating=False, general=general)
    states = states_from(assembly, np.linspace(0.0, 1.0, 501), tolerance=1e-13)
    energy, momentum = _energy_and_momentum(assembly, states)
    np.testing.assert_allclose(momentum, momentum[0], rtol=2e-12)
    assert np.diff(energy).max() < 2e-12 * energy[0]
    if restitution == 1.0:
        np.testing.assert_allclose(energy, energy[0], rtol=2e-12)
    else:
        assert energy[-1] < 0.99 * energy[0]
    gaps = np.diff(np.column_stack([states[:, 6:11], states[:, 6] + 2.0 * math.pi]), axis=1)
    assert -1e-11 < gaps.min() - TOUCH < 5e-3


STALL = ab.load_machine("examples/machines/stall_and_release.toml")


def test_soft_contact_tends_to_rigid_contact_as_one_over_the_root_of_its_stiffness() -> None:
    """Up to before the release, from where the order of contacts decides."""
    times = np.linspace(0.0, 11.0, 111)
    rigid = states_of(STALL, times, tolerance=1e-9)
    misses = []
    for stiffness in (1e4, 1.6e5):
        contact = {"restitution": math.exp(-2.0), "stiffness": stiffness}
        soft = states_of(ab.with_parameter(STALL, RACE + "contact", contact), times, tolerance=1e-9)
        misses.append(np.abs(soft[:, 6:8] - rigid[:, 6:8]).max())
    assert misses[0] < 0.01
    assert misses[0] / misses[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("count", [3, 8])
@pytest.mark.parametrize("restitution", [0.0, 0.9])
def test_rows_that_chatter_come_to_rest_on_each_other_and_on_partitions(restitution: float, count: int) -> None:
    """Balls of unequal size, thrown into one half of a race that stands still, under their weight and drag."""
    sizes = 0.008 + 0.001 * (np.arange(count) % 3)
    angles = np.linspace(0.35, 2.6, count)
    balls = [
        {"diameter": d, "density": DENSITY, "start_angles": [BOTTOM + a], "start_speeds": [v]}
        for d, a, v in zip(sizes, angles, 4.0 * np.cos(5.0 * np.arange(count)), strict=True)
    ]
    machine = standing(
        orbit_radius=None, race_radius=ORBIT + 0.005, balls=balls, beta=5e-5,
        contact={"restitution": restitution}, partitions={"count": 2, "angle": BOTTOM},
    )  # fmt: skip
    assembly = assemble(machine, rotating=False)
    found = states_from(assembly, np.linspace(0.0, 25.0, 251), tolerance=1e-9)
    contacts = assembly.system.contacts
    np.testing.assert_array_equal(found[-1, 6 + count :], 0.0)
    heap = contacts.wall_low[0] + np.concatenate([[0.0], np.cumsum(contacts.touch[:-1])])
    np.testing.assert_allclose(found[-1, 6 : 6 + count], heap, rtol=0.0, atol=1e-9)
    gaps = np.diff(found[:, 6 : 6 + count], axis=1) - contacts.touch[:-1]
    assert gaps.min() > -1e-9
    # the torque of the lowest contact carries the weight of all along the race
    assert (assembly.system.ties.low[0], assembly.system.ties.joined[:-1].sum()) == (1, count - 1)
    weights = [ball.effective_mass * ball.orbit_radius * GRAVITY for ball in assembly.balls]
    carried = np.dot(weights, np.cos(found[-1, 6 : 6 + count]))
    assert assembly.system.ties.press_low[0] == pytest.approx(carried, rel=1e-6)


@pytest.mark.parametrize("share", [0.97, 1.03])
def test_a_row_of_balls_at_rest_holds_as_long_as_adherence_holds_all_of_them(share: float) -> None:
    """Three balls on a race that stands: those high up are held by those low down, and all of them roll together."""
    adherence = 0.3
    middle = math.atan(adherence)  # a single ball rolls from here on; of a row the middle counts, but for its pressure
    half = 2.0 * math.asin(0.5 * DIAMETER / ORBIT)
    angles = [share * middle - half, share * middle, share * middle + half]
    machine = standing(angles=angles, friction={"rolling_resistance": 1e-6, "adherence": adherence}, beta=1e-3)
    found = states_of(machine, np.linspace(0.0, 0.5, 51), tolerance=1e-9)
    rests = bool((found[:, 9:12] == 0.0).all())
    assert rests == (share < 1.0)
    if rests:
        assert math.tan(angles[-1]) > adherence  # the highest alone would roll
        alone = states_of(
            standing(angles=angles[-1:], friction={"rolling_resistance": 1e-6, "adherence": adherence}, beta=1e-3),
            np.array([0.0, 0.5]),
        )
        assert alone[-1, 7] != 0.0
    else:
        assert (found[-1, 9:12] < 0.0).all()


def test_a_race_full_of_balls_turns_as_one_ring() -> None:
    count = 6
    diameter = 2.0 * ORBIT * math.sin(math.pi / count)
    balls = {
        "count": count, "diameter": diameter, "density": DENSITY, "start_speeds": [3.0, 0.0, 1.0, 2.0, -1.0, 1.0],
        "start_angles": [2.0 * math.pi * k / count for k in range(count)],
    }  # fmt: skip
    beta, times = 1e-2, np.linspace(0.0, 1.0, 11)
    machine = standing(axis="horizontal", balls=[balls], beta=beta, contact={"restitution": 0.5})
    assembly = assemble(machine, rotating=False)
    found = states_from(assembly, times)
    rates = found[1:, 6 + count :]
    np.testing.assert_array_equal(rates, rates[:, :1] * np.ones(count))
    expected = np.exp(-beta / assembly.balls[0].inertia * times[1:])  # the weight of a full ring has no torque
    np.testing.assert_allclose(rates[:, 0], expected, rtol=1e-9)


def test_a_result_knows_the_normal_forces_of_balls_that_press_on_each_other() -> None:
    """Two balls at the bottom of a race that stands: between them F, and on the wall the weight of both."""
    half = math.asin(0.5 * DIAMETER / ORBIT)
    machine = standing(angles=[-half, half], friction={"rolling_resistance": 1e-9, "adherence": 1e-9})
    run = ab.simulate(machine, duration=0.2)
    mass = DENSITY * math.pi / 6.0 * DIAMETER**3
    pressing = mass * GRAVITY * math.tan(half)  # horizontal force between them
    expected = mass * GRAVITY * math.cos(half) + pressing * math.sin(half)
    np.testing.assert_allclose(run["ball_normal_force"].values[-1], expected, rtol=1e-6)


def _real(rotor: dict[str, Any], drive: dict[str, Any], tilting: bool, **race: Any) -> Machine:
    """Three unequal balls in one race, of which the first two touch, and another race."""
    balls = [
        {"diameter": d, "density": DENSITY, "start_angles": [a], "start_speeds": [v]}
        for d, a, v in ((0.01, 0.3, -2.0), (0.012, 0.42, -2.0), (0.008, 2.0, 1.0))
    ]
    whole = {"race_radius": ORBIT, "drag": {"law": "viscous", "damping": 1e-4}, "balls": balls} | race
    other = {"race_radius": 0.08, "drag": {"law": "viscous", "damping": 1e-4}, "balls": [balls[0]]}
    return Machine(
        name="real", axis="horizontal", gravity=GRAVITY, rotor=rotor, drive=drive,
        unbalances=[{"moment": 1e-4}], balancers=[{"races": [whole, other]} | ({"station": "upper"} if tilting else {})],
        **({"stations": [{"name": "upper", "position": 0.05}], "tilting_races": "full"} if tilting else {}),
        start={"deflection": [1e-3, 2e-3], "velocity": [0.1, -0.2]} | ({"speed": 40.0} if drive is TORQUE else {}),
    )  # fmt: skip


PLANE = {"mass": 2.0, "stiffness": 2e4, "damping": 5.0, "inertia": 0.01}
RIGID = {
    "kind": "rigid", "mass": 2.0, "transverse_inertia": 0.02, "polar_inertia": 0.01,
    "supports": [{"position": -0.1, "stiffness": 1e4, "damping": 3.0}, {"position": 0.12, "stiffness": [1e4, 2e4]}],
}  # fmt: skip
TORQUE, RAMP = (
    {"kind": "torque", "torque": 1.0},
    {"kind": "speed", "profile": {"kind": "ramp", "start": 40.0, "end": 90.0, "duration": 1.0}},
)
OVAL = {"harmonics": [{"order": 2, "amplitude": 1e-3}], "friction": {"rolling_resistance": 0.01}}


@pytest.mark.parametrize("drive", [TORQUE, RAMP])
@pytest.mark.parametrize(
    "race",
    [
        {},
        {"eccentricity": 1e-3, "eccentricity_angle": 0.7},
        OVAL,
        OVAL | {"contact": {"restitution": 0.5, "friction": 0.3}},
    ],
)
@pytest.mark.parametrize("rotor", ["planar", "general", "tilting"])
def test_the_one_row_of_balls_that_touch_is_that_of_each_ball_under_the_torque_of_the_contact(
    rotor: str, race: dict[str, Any], drive: dict[str, Any]
) -> None:
    tilts = rotor == "tilting"
    machine = _real(RIGID if tilts else PLANE, drive, tilts, **race)
    assembly = assemble(machine, rotating=False, general=rotor != "planar")
    system, state, n = assembly.system, assembly.state, len(assembly.balls)
    state[6 + 2 * n :] = [0.01, -0.02, 0.3, 0.2] if tilts else []
    system.guided.mode = np.where(state[6 + n : 6 + 2 * n] < 0.0, -1.0, 1.0)
    rates = equations(assembly).rates
    system.ties.joined[0], system.ties.follows[1], system.rigid.bound[0] = 1, 1, 2
    system.guided.bound[:2] = 1
    together = rates_at(rates, 0.0, state, system)
    press = float(system.ties.press[0])
    normals = system.guided.normal.copy()
    assert together[6 + n] == together[7 + n]
    assert abs(press) > 1e-6
    system.ties.joined[0], system.ties.follows[1], system.rigid.bound[0] = 0, 0, 0
    system.guided.bound[:2] = 0
    pair, own = system.contacts[0], assembly.balls
    rub = pair.rub * math.tanh((pair.arm * state[6 + n] + pair.arm_next * state[7 + n]) * pair.grip)
    system.guided.given[:2] = press * np.array([-1.0 - pair.arm * rub, 1.0 - pair.arm_next * rub])
    outward = [pair.out - rub / own[0].orbit_radius, pair.out_next + rub / own[1].orbit_radius]
    system.guided.given_out[:2] = press * np.array(outward)
    apart = rates_at(rates, 0.0, state, system)
    np.testing.assert_allclose(together, apart, rtol=1e-10, atol=1e-9)
    np.testing.assert_allclose(normals, system.guided.normal, rtol=1e-10, atol=1e-12)


CHANGES = """
from tests.references.standing_races import standing
from autobalancer.assembly.system import assemble
from autobalancer.kernels.balls.race_events import rigid_contact
from autobalancer.kernels.balls.rigid_torques import OWN_PULL, PULL
from autobalancer.kernels.integrators.integrator_state import PASS
from autobalancer.kernels.integrators.tableau import dormand_prince_8
from autobalancer.simulation.steppers import equations
from autobalancer.simulation.steppers import memory_for
assembly = assemble(standing(angles=[1.0, 1.5, 2.0]), rotating=False)
pair = (dormand_prince_8(), memory_for(assembly, 1.0, 1e-9, dormand_prince_8()))
margin = assembly.system.rigid.margin
for time in [0.5] * 40 + [0.6]:
    rigid_contact(PASS, time, equations(assembly).rates, assembly.system, pair)
    print(margin[PULL] / margin[OWN_PULL], end=" ")
"""


def test_what_counts_as_a_pull_grows_while_contacts_change_without_time_going_on() -> None:
    """By thirty changes at one instant nothing is widened, then by a factor of two for each, until time goes on (interpreted)."""
    done = subprocess.run(
        [sys.executable, "-c", CHANGES], env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, cwd=Path(__file__).parents[1],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    wider = [float(word) for word in done.stdout.split()]
    assert wider == [1.0] * 31 + [2.0**k for k in range(1, 10)] + [1.0]


def _pressed(contact: dict[str, Any], shift: float) -> Machine:
    """Two equal balls that press on one partition from both sides until the light place moves at 8 s."""
    steel = {"diameter": "10 mm", "material": "steel"}
    light = 1.0 + math.pi - 0.02
    return Machine(
        name="pressed",
        axis="vertical",
        rotor={"mass": 10.0, "stiffness": 1e5, "damping": 100.0},
        unbalances=[
            {"moment": 1.2e-3, "angle": light, "schedule": {"time": [8.0, 8.0], "factor": [1.0, 0.0]}},
            {"moment": 1.2e-3, "angle": light + shift, "schedule": {"time": [8.0, 8.0], "factor": [0.0, 1.0]}},
        ],
        balancers=[
            {
                "races": [
                    {
                        "race_radius": "0.1 m",
                        "drag": {"law": "viscous", "damping": 2e-4},
                        "partitions": {"count": 2, "angle": 1.0},
                        "contact": contact,
                        "balls": [steel | {"start_angles": [0.0]}, steel | {"start_angles": [2.2]}],
                    }
                ]
            }
        ],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 200.0}},
    )


@pytest.mark.parametrize("shift", [0.5, 2.5, -0.5])
@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_equal_balls_do_not_hold_each_other_through_a_partition(restitution: float, shift: float) -> None:
    hard, soft = (
        ab.simulate(_pressed(contact, shift), duration=14.0, tolerance=1e-9, save=ab.Samples(15))
        for contact in ({"restitution": restitution}, {"restitution": 0.2, "stiffness": 1e7})
    )
    before, after = (hard["ball_angle_in_rotor"].values[when] - 1.0 for when in (7, -1))
    assert before == pytest.approx([-0.05265, 0.05265], abs=3e-3), "both are beside the partition"
    assert after == pytest.approx(soft["ball_angle_in_rotor"].values[-1] - 1.0, abs=1e-4)
    assert np.abs(after - before).max() > 0.1, "one has left"


@pytest.mark.parametrize(
    ("diameters", "rolling", "adherence", "seed"), [((8, 10, 8, 10), 1e-4, 1.5e-4, 1), ((10, 8, 10), 3e-4, 3e-4, 3)]
)
def test_time_goes_on_where_touching_balls_just_loosen_one_that_rests(
    diameters: tuple[int, ...], rolling: float, adherence: float, seed: int
) -> None:
    race = {
        "race_radius": "0.1 m",
        "drag": {"law": "viscous", "damping": 1e-4},
        "friction": {"rolling_resistance": rolling, "adherence": adherence},
        "balls": [{"diameter": f"{size} mm", "material": "steel"} for size in diameters],
    }
    machine = Machine(
        name="rough",
        axis="vertical",
        rotor={"mass": 10.0, "stiffness": 1e5, "damping": 100.0},
        unbalances=[{"moment": 5e-4}],
        balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "ramp", "end": 300.0, "duration": 1.5}},
    )
    run = ab.simulate(machine, duration=4.0, seed=seed, max_steps=3000, save=ab.Samples(3))
    assert run.attrs["outcome"] == "finished"
