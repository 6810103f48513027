"""Exact stability of balls with forces on them: springs along the race, magnets and others that are leaves."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq
from tests.references.rates import rates_at
from tests.references.two_balls import specials
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.system import assemble, steady
from autobalancer.cli.main import app
from autobalancer.kernels.balls.planar import planar
from autobalancer.machine import Machine
from autobalancer.simulation.record import Samples
from autobalancer.stability.host.stations import in_plane, stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.linearized import modes
from autobalancer.stability.states.rest_states import balanced_of, state_vector, states_of

SPEED, STIFFNESS = 110.0, 0.02  # rad/s, N/m
RACE = "balancers[1].races[1]"
PLAIN = ab.example("discoidal")


def with_springs(stiffness: float = STIFFNESS, machine: Machine = PLAIN, **keys: Any) -> Machine:
    """A machine with springs along its first race."""
    return ab.with_parameter(machine, f"{RACE}.forces", [{"kind": "race_springs", "stiffness": stiffness} | keys])


def compiled(machine: Machine, speed: float, state: np.ndarray) -> np.ndarray:
    """The compiled equations of a planar machine at a state of the vector field."""
    system = assemble(machine, rotating=True, contact=False).system
    full = np.concatenate([state[:4], [0.0, speed], state[4:]])
    rates = rates_at(planar, 0.0, full, system._replace(drive=steady(speed, machine.unbalances[0].vector)))
    return np.delete(rates, [4, 5])


def test_the_vector_field_is_that_of_the_compiled_equations() -> None:
    machine = with_springs(2.0, free_length="50 mm")
    field, random = Field(in_plane(machine), SPEED), np.random.default_rng(1)
    start = [float(a) for a in machine.balancers[0].races[0].balls[0].start_angles]
    for _ in range(5):
        state = np.concatenate([1e-4 * random.normal(size=2), 1e-2 * random.normal(size=2), np.zeros(4)])
        state[4:] = [*(start + 0.3 * random.normal(size=2)), *(5.0 * random.normal(size=2))]
        expected = compiled(machine, SPEED, state)
        np.testing.assert_allclose(field(state), expected, rtol=0.0, atol=1e-11 * np.abs(expected).max())


def test_its_derivatives_are_those_of_its_values() -> None:
    machine = with_springs(0.5)
    field, random = Field(in_plane(machine), SPEED), np.random.default_rng(2)
    sizes = np.array([1e-4, 1e-4, 1e-2, 1e-2, 1.0, 1.0, 10.0, 10.0])
    state = sizes * random.normal(size=8)
    u, v = (1e-2 * sizes * random.normal(size=8) for _ in range(2))

    def difference(function: Any) -> np.ndarray:
        a, b, c, d = (function(state + h * v) for h in (-2.0, -1.0, 1.0, 2.0))
        return (a - 8.0 * b + 8.0 * c - d) / 12.0

    # forces are differentiated by differences of their values, which leave fewer digits from order to order
    for obtained, expected, close in (
        (field.jacobian(state) @ v, difference(field), 1e-8),
        (field.second(state, u, v), difference(lambda x: field.jacobian(x) @ u), 1e-5),
        (field.third(state, u, v), difference(lambda x: field.second(x, u, u)), 1e-3),
    ):
        np.testing.assert_allclose(obtained, expected, rtol=0.0, atol=close * np.abs(expected).max())


def test_a_spring_that_pulls_no_ball_along_its_race_changes_nothing() -> None:
    radial = ab.with_parameter(
        PLAIN, f"{RACE}.forces", [{"kind": "radial_spring", "stiffness": 50.0, "free_length": 0.01}]
    )
    found, plain = ab.stability.equilibria(radial, SPEED), ab.stability.equilibria(PLAIN, SPEED)
    assert found["name"].values.tolist() == plain["name"].values.tolist()
    for name in ("deflection", "growth_rate", "eigenvalue_real", "eigenvalue_imag"):
        np.testing.assert_allclose(found[name], plain[name], rtol=1e-7, atol=1e-7, err_msg=name)


def test_whether_forces_push_balls_depends_on_no_machine_that_was_asked_about_before() -> None:
    def with_pins(release_speed: float) -> Machine:
        pins = {"kind": "pins", "count": 6, "hold": 0.01, "reach": "10 mm", "release_speed": release_speed}
        return ab.with_parameter(PLAIN, f"{RACE}.forces", [pins])

    assert in_plane(with_pins(200.0)).forces is not None
    assert in_plane(with_pins(0.5)).forces is None  # at no speed at which it is tried


def closed_form(machine: Machine, speed: float, stiffness: float) -> float:
    """Half the angle between two equal balls with springs along the race, on an undamped planar rotor.

    Both stand at pi +- d from the unbalance U, so that the rotor whirls by Z = w^2 (U - 2 s cos d)/(k - M w^2) along it. This
    turns each ball away from the other by s w^2 Z sin d, less than zero, the springs by K R^2 (2 pi - 4 d).
    """
    p = in_plane(machine)
    (s, _), (orbit, _), unbalance = p.moment, p.orbit, abs(p.unbalance)
    dynamic = float(p.model.stiffness[0][0, 0] - p.model.mass[0, 0] * speed**2)

    def miss(half: float) -> float:
        whirl = speed**2 * (unbalance - 2.0 * s * math.cos(half)) / dynamic
        return float(s * speed**2 * whirl * math.sin(half) + stiffness * orbit**2 * (2.0 * math.pi - 4.0 * half))

    return float(brentq(miss, math.acos(unbalance / (2.0 * s)), 0.5 * math.pi - 1e-9, xtol=1e-14))


def undamped(machine: Machine) -> Machine:
    return ab.with_parameter(
        ab.with_parameter(machine, "rotor.damping", 0.0), f"{RACE}.drag", {"law": "viscous", "damping": 0.0}
    )


def test_springs_do_not_let_the_rotor_balance_completely() -> None:
    """Spannan (2021), pp. 13-14, in words; here against the closed form of two balls."""
    residuals = []
    for speed in (110.0, 220.0, 2000.0, 4000.0):
        machine = undamped(with_springs())
        found = ab.stability.equilibria(machine, speed)
        (place,) = np.flatnonzero(found["name"].values == "balanced")
        angles = found["ball_angle_in_rotor"].values[place]
        half = closed_form(machine, speed, STIFFNESS)
        np.testing.assert_allclose(np.sort(np.abs(angles - math.pi)), half, rtol=1e-9)
        moment = float(in_plane(machine).moment[0])
        left = abs(in_plane(machine).unbalance) - 2.0 * moment * math.cos(half)
        assert float(found["residual_unbalance"][place]) == pytest.approx(left, rel=1e-7)
        residuals.append(left)
        assert float(found["deflection"][place]) > 0.0
    assert residuals[3] / residuals[2] == pytest.approx(
        0.25, rel=0.02
    )  # what is left falls with the square of the speed


def test_without_dissipation_balls_on_springs_oscillate_and_no_state_of_least_energy_grows() -> None:
    machine = undamped(with_springs())
    st = in_plane(machine)
    for state in states_of(st, SPEED):
        values, _ = modes(st, SPEED, state)
        for value in values:  # energy is kept in the frame of the rotor: with every eigenvalue its negative is one
            assert np.abs(values + value).min() < 1e-6 * SPEED
        if state.name == "balanced":
            assert np.abs(values.real).max() < 1e-6 * SPEED


def test_on_a_rotor_that_is_held_two_balls_swing_on_their_springs_as_two_masses_do() -> None:
    stiffness = 20.0
    machine = ab.with_parameter(with_springs(stiffness), "rotor.stiffness", "1e12 N/m")
    st = in_plane(machine)
    state = next(state for state in states_of(st, 10.0) if abs(abs(state.angles[1] - state.angles[0]) - math.pi) < 1e-3)
    inertia, drag = float(st.inertia[0]), float(st.drag[0])
    values, _ = modes(st, 10.0, state)
    for wanted in np.roots(
        [inertia, drag, 4.0 * stiffness * float(st.orbit[0]) ** 2]
    ):  # of the angle between the balls
        assert np.abs(values - wanted).min() < 1e-5 * abs(wanted)


@pytest.mark.parametrize(
    "force",
    [
        {"kind": "race_springs", "stiffness": STIFFNESS, "free_length": "30 mm"},
        {"kind": "magnets", "force_at_contact": 0.05, "reach": "5 mm", "radius": "60 mm", "count": 3},
        {"kind": "pins", "count": 6, "hold": 0.01, "reach": "10 mm", "release_speed": 200.0},
    ],
    ids=["springs", "magnets", "pins"],
)
def test_in_every_state_the_compiled_equations_rest_and_their_jacobian_has_its_eigenvalues(force: Any) -> None:
    machine = ab.with_parameter(ab.with_parameter(PLAIN, f"{RACE}.forces", [force]), f"{RACE}.collisions", False)
    st = in_plane(machine)
    states = states_of(st, SPEED)
    assert {"balanced"} < {state.name for state in states}
    sizes = np.array([1e-4, 1e-4, 1e-2, 1e-2, 1e-2, 1e-2, 1.0, 1.0])
    for state in states:
        here = state_vector(st, SPEED, state.angles)
        started = ab.with_parameter(machine, f"{RACE}.balls[1].start_angles", tuple(state.angles.tolist()))
        assert np.abs(compiled(started, SPEED, here)).max() < 1e-9 * SPEED**2
        columns = []
        for number, size in enumerate(sizes):
            way = np.zeros(8)
            way[number] = size
            a, b, c, d = (compiled(started, SPEED, here + k * way) for k in (-2.0, -1.0, 1.0, 2.0))
            columns.append((a - 8.0 * b + 8.0 * c - d) / (12.0 * size))
        numeric = np.linalg.eigvals(np.array(columns).T)
        for value in modes(st, SPEED, state)[0]:
            assert np.abs(numeric - value).min() < 1e-6 * SPEED


def test_without_unbalance_a_border_with_forces_says_nothing_of_what_is_left() -> None:
    machine = ab.with_parameter(with_springs(0.01), "unbalances", [])
    (border,) = ab.stability.borders(machine, only=("exact border",))
    assert math.isfinite(border.speed)
    assert "leave" not in border.note


def test_the_exact_border_is_the_first_hopf_point_and_follows_the_springs_from_the_plain_one() -> None:
    (plain,) = ab.stability.borders(PLAIN, only=("exact border",))
    (weak,) = ab.stability.borders(with_springs(1e-6), only=("exact border",))
    assert weak.speed == pytest.approx(plain.speed, rel=1e-5)
    machine = with_springs(0.01)
    (border,) = ab.stability.borders(machine, only=("exact border",))
    assert border.speed < plain.speed - 0.5  # springs help just above the critical speed
    assert "at this speed the balls reduce the deflection of" in border.note
    found = ab.stability.branches(
        machine, "speed", border.speed + 0.3, border.speed - 0.3, orbits=False, largest_step=0.5
    )
    assert set(found["name"].values) == {"balanced"}
    assert specials(found, "Hopf")[0]["special_parameter"] == pytest.approx(border.speed, rel=1e-8)


@pytest.mark.parametrize(("speed", "grows"), [(63.0, True), (66.0, False)])
def test_on_either_side_of_the_border_a_run_moves_as_its_eigenvalues_say(speed: float, grows: bool) -> None:
    machine = ab.with_parameter(with_springs(0.01), "drive.profile", {"kind": "constant", "speed": speed})
    st = in_plane(machine)
    state = balanced_of(st, speed)[0]
    here = state_vector(st, speed, state.angles)
    jacobian = Field(st, speed).jacobian(here)
    assert (np.linalg.eigvals(jacobian).real.max() > 0.0) == grows
    swing = 1e-6 * np.array([0.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0])
    angles = tuple((state.angles + swing[4:6]).tolist())
    machine = ab.with_parameter(machine, f"{RACE}.balls[1].start_angles", angles)
    start = {"deflection": tuple(here[:2].tolist()), "velocity": tuple(here[2:4].tolist())}
    machine = machine.model_copy(update={"start": machine.start.model_copy(update=start)})
    run = ab.simulate(machine, duration=1.0, save=Samples(51), tolerance=1e-12, mass_spread=0.0)
    values, vectors = np.linalg.eig(jacobian)
    motion = (
        vectors[4:6] @ (np.linalg.solve(vectors, swing)[:, None] * np.exp(values[:, None] * run["time"].values))
    ).real
    away = run["ball_angle_in_rotor"].values - state.angles
    np.testing.assert_allclose(away, motion.T, rtol=0.0, atol=1e-3 * np.abs(motion).max())


def test_two_planes_with_springs_on_a_tilting_race_rest_in_the_compiled_equations() -> None:
    machine = ab.example("two_plane_rotor")
    for number in (1, 2):
        path = f"balancers[{number}].races[1].forces"
        machine = ab.with_parameter(machine, path, [{"kind": "race_springs", "stiffness": 0.05}])
    for form in ("deflection", "full"):
        st = stations(ab.with_parameter(machine, "tilting_races", form))
        (state,) = [one for one in balanced_of(st, 300.0) if modes(st, 300.0, one)[0].real.max() < 0.0]
        assert np.abs(Field(st, 300.0)(state_vector(st, 300.0, state.angles))).max() < 1e-9 * 300.0**2
        assert 1e-7 < np.abs(state.whirl).max() < 1e-5  # springs leave something, balls balance most of it


def test_what_is_not_known_with_forces_says_so() -> None:
    machine = with_springs()
    notes = {border.name: border.note for border in ab.stability.borders(machine)}
    assert "computed for balls without forces only" in notes["exact border, worst case"]
    assert "without forces on the balls only" in notes["averaged border"]
    assert "ignores forces on the balls" in notes["release speed"]
    assert "ignores" not in notes["exact border"]
    assert "ignores forces on the balls" in ab.check(machine).friction.note


def test_the_command_line_answers_with_forces(tmp_path: Path) -> None:
    file = tmp_path / "springs.toml"
    ab.save_machine(with_springs(0.01), file)
    answer = CliRunner().invoke(
        app, ["eigenvalues", str(file), "--speeds", "700 rpm:800 rpm:2"], env={"COLUMNS": "200"}
    )
    assert answer.exit_code == 0, answer.output
    assert "stable" in answer.output
    answer = CliRunner().invoke(app, ["borders", str(file)], env={"COLUMNS": "200"})
    assert "the balls reduce the deflection of" in answer.output
