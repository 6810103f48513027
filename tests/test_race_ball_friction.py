"""Rolling balls of one race that rub where they touch."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.references.race_runs import states_of
from tests.references.resolved import chamber
from tests.references.standing_races import BOTTOM, DENSITY, DIAMETER, GRAVITY, ORBIT, standing

import autobalancer as ab
from autobalancer.assembly.system import assemble
from autobalancer.errors import MachineError
from autobalancer.kernels.balls.guided import touch
from autobalancer.kernels.system import BALLS
from autobalancer.laws.impacts import touching_balls
from autobalancer.machine import Contact, Machine, Race
from autobalancer.simulation.record import Samples

RADIUS, WALL = 0.5 * DIAMETER, ORBIT + 0.5 * DIAMETER
MASS = DENSITY * math.pi / 6.0 * DIAMETER**3
WEIGHT = MASS * GRAVITY * ORBIT
HALF = math.asin(RADIUS / ORBIT)  # half the angle between two balls that touch
LEVER = WALL / ORBIT / math.cos(HALF)  # torque of friction over friction and the torque that presses the balls
WAVES: list[list[dict[str, float]]] = [[], [{"order": 2, "amplitude": 1e-12}]]  # the shorter and the longer equations


def pair(friction: float, **changes: Any) -> dict[str, Any]:
    return {"restitution": 0.3, "friction": friction, **changes}


@pytest.mark.parametrize("radii", [(0.005, 0.005), (0.006, 0.003), (0.002, 0.009)])
def test_arms_and_slip_are_those_of_two_rigid_balls_that_roll_on_the_wall(radii: tuple[float, float]) -> None:
    orbits, rates = [WALL - r for r in radii], (3.0, -1.7)
    apart = math.acos((orbits[0] ** 2 + orbits[1] ** 2 - sum(radii) ** 2) / (2.0 * orbits[0] * orbits[1]))
    outward = [1.0, cmath.exp(1j * apart)]
    centers = [o * n for o, n in zip(orbits, outward, strict=True)]
    along = (centers[1] - centers[0]) / sum(radii)
    contact = centers[0] + radii[0] * along
    surface = []
    for center, n, radius, orbit, rate in zip(centers, outward, radii, orbits, rates, strict=True):
        spin = -orbit * rate / radius
        wall = 1j * orbit * rate * n + 1j * spin * radius * n
        assert abs(wall) < 1e-15  # it rolls
        surface.append(1j * orbit * rate * n + 1j * spin * (contact - center))
    slip = ((surface[0] - surface[1]) * (-1j * along).conjugate()).real
    found = touching_balls((orbits[0], orbits[1]), radii)
    assert found.arms[0] * rates[0] + found.arms[1] * rates[1] == pytest.approx(slip, rel=1e-12)
    assert found.arms == pytest.approx([2.0 * WALL * radii[1 - i] / sum(radii) for i in range(2)], rel=1e-12)
    assert found.outward == pytest.approx(
        [-(along * n.conjugate()).real * s for n, s in zip(outward, (1, -1), strict=True)]
    )
    for orbit, n in zip(orbits, outward, strict=True):
        assert 1.0 / found.force == pytest.approx(orbit * (along * (1j * n).conjugate()).real, rel=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_friction_between_balls_never_feeds_energy_in(seed: int) -> None:
    random = np.random.default_rng(seed)
    sizes = random.uniform(0.006, 0.014, 4)
    balls = [
        {"diameter": d, "density": DENSITY, "start_angles": [a]}
        for d, a in zip(sizes, (0.0, 0.3, 0.6, 0.9), strict=True)
    ]
    torques = []
    for friction in (0.0, 0.4):
        contact = pair(friction, stiffness=1e5)
        machine = standing(axis="vertical", orbit_radius=None, race_radius=WALL, balls=balls, contact=contact)
        system, state = assemble(machine).system, np.zeros(BALLS + 8)
        state[BALLS : BALLS + 4] = np.cumsum([0.0, *(sizes[1:] + sizes[:-1]) / (2.0 * ORBIT)]) * 0.97
        state[BALLS + 4 :] = np.random.default_rng(seed).uniform(-3.0, 3.0, 4)
        touch.py_func(state, system)
        torques.append(system.guided.contact.copy())
    rubbing = torques[1] - torques[0]
    assert np.abs(rubbing).max() > 0.01 * np.abs(torques[0]).max() > 0.0
    assert rubbing @ state[BALLS + 4 :] < 0.0


@pytest.mark.parametrize("harmonics", WAVES)
def test_an_impact_takes_from_both_balls_what_friction_and_impulse_say(harmonics: list[dict[str, float]]) -> None:
    friction, speeds = 0.2, [6.0, 2.0]
    contact = pair(friction, restitution=0.5, slip_speed=1e-4)
    machine = standing(axis="vertical", angles=[0.0, 0.5], speeds=speeds, contact=contact, harmonics=harmonics)
    found = states_of(machine, np.array([0.0, 0.4]), tolerance=1e-11)[-1]
    closing = speeds[0] - speeds[1]
    assert found[9] - found[8] == pytest.approx(0.5 * closing, rel=0.01)  # friction takes as much from either
    impulse = 0.5 * (closing + found[9] - found[8])
    assert sum(speeds) - found[8] - found[9] == pytest.approx(2.0 * friction * LEVER * impulse, rel=1e-6)


@pytest.mark.parametrize("sizes", [[0.01, 0.02], [0.02, 0.01]])
def test_friction_takes_from_each_of_two_unequal_balls_what_its_arm_says(sizes: list[float]) -> None:
    friction, speeds = 0.2, [6.0, 2.0]
    balls = [
        {"diameter": d, "density": DENSITY, "start_angles": [a], "start_speeds": [v]}
        for d, a, v in zip(sizes, (0.0, 0.5), speeds, strict=True)
    ]
    contact = pair(friction, restitution=0.5, slip_speed=1e-4)
    machine = standing(axis="vertical", orbit_radius=None, race_radius=WALL, balls=balls, contact=contact)
    found = states_of(machine, np.array([0.0, 0.4]), tolerance=1e-11)[-1]
    inertias = [ball.inertia for ball in assemble(machine).balls]
    gains = [inertias[i] * (found[8 + i] - speeds[i]) for i in range(2)]
    orbits, total = [WALL - 0.5 * d for d in sizes], 0.5 * sum(sizes)
    half = math.acos((orbits[0] ** 2 + total**2 - orbits[1] ** 2) / (2.0 * orbits[0] * total))
    lever = orbits[0] * math.sin(half)  # of the force along the line of centers, the same for both
    rub = [friction * WALL * sizes[1 - i] / total / lever for i in range(2)]
    assert gains[0] / -(1.0 + rub[0]) == pytest.approx(gains[1] / (1.0 - rub[1]), rel=1e-6)


def test_two_balls_pressed_together_by_their_weight_creep_as_friction_lets_them() -> None:
    friction, slow, beta, angle = 0.5, 1e-4, 1e-3, 0.02
    assert math.tan(angle) < friction * LEVER * math.tan(HALF)
    found = states_of(
        standing(angles=[angle - HALF, angle + HALF], beta=beta, contact=pair(friction, slip_speed=slow)),
        np.array([0.0, 1.0]),
        tolerance=1e-11,
    )[-1]
    place = 0.5 * (found[6] + found[7]) - BOTTOM
    pressed = WEIGHT * math.cos(place) * math.sin(HALF)

    def left(rate: float) -> float:
        rub = friction * LEVER * pressed * math.tanh(2.0 * WALL * rate / slow)
        return WEIGHT * math.sin(place) * math.cos(HALF) + beta * rate + rub

    assert found[8] == pytest.approx(brentq(left, -1.0, 1.0, xtol=1e-15), rel=1e-3)
    assert found[9] == pytest.approx(found[8], rel=1e-3)
    free = states_of(standing(angles=[angle - HALF, angle + HALF], beta=beta, contact=pair(0.0)), np.array([0.0, 1.0]))[
        -1
    ]
    assert abs(0.5 * (free[6] + free[7]) - BOTTOM) < 0.9 * angle < 0.999 * place


def _statics(friction: float, beta: float, speed: float) -> float:
    """Angle from the lowest point at which a pair stands still in space in a race that turns slowly."""

    def left(place: float) -> float:
        pressed = WEIGHT * math.cos(place) * math.sin(HALF)
        return WEIGHT * math.sin(place) * math.cos(HALF) - beta * speed - friction * LEVER * pressed

    return float(brentq(left, 0.0, 1.5, xtol=1e-14))


@pytest.mark.parametrize("harmonics", WAVES)
def test_a_pair_in_a_slowly_turned_race_stands_where_weight_drag_and_friction_balance(
    harmonics: list[dict[str, float]],
) -> None:
    friction, beta, speed = 0.4, 2e-4, 1.0
    angles = [0.05 - HALF, 0.05 + HALF]
    contact = pair(friction, slip_speed=1e-3)
    machine = standing(angles=angles, speeds=[-speed] * 2, speed=speed, beta=beta, contact=contact, harmonics=harmonics)
    found = states_of(machine, np.array([0.0, 8.0]), tolerance=1e-9)[-1]
    place = 0.5 * (found[6] + found[7]) + found[4] - BOTTOM
    assert place == pytest.approx(_statics(friction, beta, speed), rel=1e-4)
    assert place > 1.4 * _statics(0.0, beta, speed)


def test_guided_balls_rub_like_resolved_ones_that_do_not_slip() -> None:
    """Angle and force on the wall of a pair in a slowly turned race; the resolved balls know nothing of the formula."""
    friction, beta, speed = 0.3, 1e-4, 3.0
    start = _statics(friction, beta, speed) + BOTTOM
    balls = {"count": 2, "mass": MASS, "diameter": DIAMETER, "start_speeds": [-speed] * 2}
    balls["start_angles"] = [start - HALF, start + HALF]
    race = {"drag": {"law": "viscous", "damping": beta}}
    law = {"restitution": 0.2, "sliding_friction": 2.0, "slip_speed": 2e-3, "stiffness": 2e4}
    one = chamber(speed=speed, axis="horizontal", balls=balls, race=race, ball_friction=friction, **law)
    guided = {"contact": pair(friction, slip_speed=2e-3), "resolved": None, "friction": {"rolling_resistance": 1e-12}}
    other = chamber(speed=speed, axis="horizontal", balls=balls, race=race | guided)
    runs = [ab.simulate(machine, duration=0.6, save=Samples(300), tolerance=1e-10) for machine in (one, other)]
    angles, forces = (
        [values.isel(time=slice(-150, None)).mean("time").values for values in pairs]
        for pairs in (
            [run.ball_angle_in_rotor + run.rotor_angle for run in runs],
            [run.ball_normal_force for run in runs],
        )
    )
    np.testing.assert_allclose(angles[0], angles[1], atol=1e-5)
    np.testing.assert_allclose(forces[0], forces[1], rtol=2e-3)
    assert abs(forces[0][1] - forces[0][0]) > 0.02 * forces[0][0]


def test_elastic_balls_that_rub_only_lose_energy() -> None:
    contact = {"restitution": 1.0, "friction": 0.2}
    machine = standing(angles=[-1.0, 0.8, 2.0], speeds=[3.0, 6.0, -5.0], contact=contact)
    found = states_of(machine, np.linspace(0.0, 3.0, 1501), tolerance=1e-11)
    gaps = np.diff(np.column_stack([found[:, 6:9], found[:, 6] + 2.0 * math.pi]), axis=1)
    energies = 0.7 * MASS * ORBIT**2 * (found[:, 9:12] ** 2).sum(axis=1) + WEIGHT * np.sin(found[:, 6:9]).sum(axis=1)
    energies = energies[gaps.min(axis=1) > 2.0 * HALF]
    assert np.diff(energies).max() < 1e-7 * np.ptp(energies)
    assert np.ptp(energies) > 0.3 * WEIGHT


def test_without_friction_nothing_of_it_is_there() -> None:
    runs = [
        states_of(standing(angles=[-0.4, 0.3], beta=1e-4, contact=contact), np.linspace(0.0, 2.0, 21))
        for contact in ({"restitution": 0.3}, pair(0.0))
    ]
    np.testing.assert_array_equal(runs[0], runs[1])


def test_friction_between_balls_that_cannot_rub_is_refused() -> None:
    def race(**more: Any) -> Race:
        ball = {"mass": 0.01, "diameter": 0.01, "motion": more.pop("motion", "rolling")}
        return Race(orbit_radius=0.1, drag={"law": "viscous", "damping": 0.0}, balls=[ball], contact=pair(0.2), **more)

    race()
    with pytest.raises(MachineError, match="set motion = 'rolling'"):
        race(motion="point")
    resolved = {"stiffness": 1e5, "restitution": 0.5, "sliding_friction": 0.1, "slip_speed": 0.01}
    with pytest.raises(MachineError, match=r"resolved\.ball_friction"):
        race(resolved=resolved)
    with pytest.raises(MachineError, match="slip_speed: has no effect without friction"):
        Contact(restitution=0.5, slip_speed=0.01)


def test_the_borders_say_that_they_do_not_count_friction_between_balls() -> None:
    machine = ab.load_machine("examples/machines/discoidal.toml")
    rubbing: Machine = ab.with_parameter(machine, "balancers[1].races[1].contact", pair(0.2))
    for described, said in ((machine, False), (rubbing, True)):
        notes = {border.name: border.note for border in ab.stability.borders(described)}
        assert ("friction between balls" in notes["release speed"]) == said
        assert ("friction between balls" in notes["capture speed"]) == said
