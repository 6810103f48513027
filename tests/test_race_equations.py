"""Balls on races of any shape, with rolling resistance, against energies differentiated by computer algebra."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.references.race_runs import states_from, states_of
from tests.references.races import races
from tests.references.rates import rates_at

from autobalancer.assembly.system import Assembly, assemble
from autobalancer.kernels.balls.on_stations import guided_rough
from autobalancer.machine import Machine


def random_race(random: np.random.Generator, *, dissipation: bool = True) -> dict[str, Any]:
    """Oval, waviness and eccentricity together, with rolling resistance; equal balls."""
    u = random.uniform
    race: dict[str, Any] = {
        "orbit_radius": u(0.08, 0.12),
        "collisions": False,
        "drag": {"law": "viscous", "damping": u(1e-5, 1e-3) if dissipation else 0.0},
        "eccentricity": u(0.0, 5e-3),
        "eccentricity_angle": u(-3.0, 3.0),
        "harmonics": [{"order": k, "amplitude": u(-2e-3, 2e-3), "angle": u(-3.0, 3.0)} for k in (1, 2, 3)],
        "balls": [{"count": int(random.integers(1, 4)), "diameter": u(0.008, 0.015), "density": 7800.0}],
    }
    if dissipation:
        race["friction"] = {"rolling_resistance": u(0.0, 0.05)}
        race["fluid"] = {"density": u(700.0, 1200.0), "viscosity": 1e-5}
    return race


def random_machine(random: np.random.Generator, drive: str = "torque", *, dissipation: bool = True) -> Machine:
    """An anisotropic rotor that a torque or a prescribed speed turns."""
    u = random.uniform
    drives: dict[str, Any] = {
        "torque": {"kind": "torque", "torque": u(-5.0, 5.0) if dissipation else 0.0},
        "speed": {"kind": "speed", "profile": {"kind": "ramp", "end": 200.0, "duration": 20.0}},
    }
    return Machine(
        name="random",
        axis=str(random.choice(["vertical", "horizontal"])),
        rotor={
            "mass": u(2.0, 20.0),
            "stiffness": [u(1e4, 1e6), u(1e4, 1e6)],
            "damping": [u(0.0, 200.0), u(0.0, 200.0)] if dissipation else 0.0,
            "inertia": u(0.02, 0.5),
        },
        unbalances=[{"moment": u(1e-4, 1e-3), "angle": u(-3.0, 3.0)}],
        balancers=[{"races": [random_race(random, dissipation=dissipation)]}],
        drive=drives[drive],
        start={"speed": u(20.0, 60.0), "rotor_angle": u(-3.0, 3.0)} if drive == "torque" else {},
    )


def random_state(random: np.random.Generator, count: int) -> np.ndarray:
    u = random.uniform
    host = [*u(-1e-3, 1e-3, 2), *u(-0.3, 0.3, 2), u(-3.0, 3.0), u(50.0, 300.0)]
    return np.concatenate([host, u(-3.0, 3.0, count), u(-30.0, 30.0, count)])


def rates(assembly: Assembly, state: np.ndarray, time: float = 0.0) -> np.ndarray:
    """Derivative by the compiled equations, every ball rolling the way it moves."""
    count = len(assembly.balls)
    assembly.system.guided.mode = np.sign(state[6 + count : 6 + 2 * count])
    return rates_at(guided_rough, time, state, assembly.system)


def normal_forces(assembly: Assembly) -> np.ndarray:
    return assembly.system.guided.normal.copy()


@pytest.mark.parametrize("drive", ["torque", "speed"])
@pytest.mark.parametrize("seed", range(15))
def test_balls_on_a_wavy_race_move_by_the_lagrangian_of_their_path(seed: int, drive: str) -> None:
    random = np.random.default_rng(seed)
    machine = random_machine(random, drive)
    assembly, reference = assemble(machine, rotating=False), races(machine)
    for _ in range(4):
        state = random_state(random, len(assembly.balls))
        turning = 0.0 if drive == "torque" else 10.0
        if drive == "speed":
            state[5] = 10.0 * 3.0
        time = 3.0
        expected, found = reference.rates(state, time, turning), rates(assembly, state, time)
        q, v = reference.split(state)
        normal = reference.accelerations(q, v, time, turning)[1]
        if normal.min() <= 0.0:  # the reference rubs under a negative normal force too
            continue
        n = len(assembly.balls)
        for group in (slice(0, 2), slice(2, 4), slice(4, 6), slice(6, 6 + n), slice(6 + n, None)):
            scale = np.abs(expected[group]).max()
            np.testing.assert_allclose(found[group], expected[group], rtol=0.0, atol=2e-11 * scale)
        np.testing.assert_allclose(normal_forces(assembly), normal, rtol=1e-9, atol=1e-9 * normal.max())


@pytest.mark.parametrize("seed", range(6))
def test_nothing_dissipative_keeps_the_energy(seed: int) -> None:
    random = np.random.default_rng(100 + seed)
    machine = random_machine(random, dissipation=False)
    reference, found = races(machine), states_of(machine, np.linspace(0.0, 1.0, 101))
    energies = np.array([reference.energy(*reference.split(state)) for state in found])
    kinetic = 0.5 * machine.rotor.inertia * found[0][5] ** 2
    np.testing.assert_allclose(energies, energies[0], rtol=0.0, atol=1e-8 * kinetic)
    assert np.ptp(found[:, 6]) > 0.02  # the balls do move


@pytest.mark.parametrize("seed", range(4))
def test_what_friction_drag_and_supports_take_is_what_the_energy_loses(seed: int) -> None:
    random = np.random.default_rng(200 + seed)
    machine = random_machine(random)
    reference = races(machine)
    k = len(reference.numbers)
    assembly = assemble(machine, rotating=False)
    assembly.state[5] = 80.0
    assembly.state[6 + k : 6 + 2 * k] = np.linspace(40.0, 50.0, k)
    start = assembly.state.copy()

    def extended(_time: float, y: np.ndarray) -> np.ndarray:
        q, v = reference.split(y[:-2])
        return np.concatenate([reference.rates(y[:-2]), reference.power_lost(q, v)])

    path = solve_ivp(extended, (0.0, 0.05), [*start, 0.0, 0.0], method="DOP853", rtol=1e-11, atol=1e-13)
    (lost, rubbed) = path.y[-2:, -1]
    end = states_from(assembly, np.array([0.05]))[0]
    np.testing.assert_allclose(end, path.y[:-2, -1], rtol=1e-7, atol=1e-9)
    before, after = (reference.energy(*reference.split(s)) for s in (start, end))
    assert rubbed > 0.0
    assert before - after == pytest.approx(lost + rubbed, rel=1e-6)
