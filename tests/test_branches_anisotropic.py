"""Steady states on anisotropic supports: the equations over half a turn, their branches, special points and curves."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.references.two_balls import DISCOIDAL, MACHINES, RACE, specials
from tests.test_stability_stations import ONE, TWO, Group, machine, same_spectrum

import autobalancer as ab
from autobalancer.api import simulate
from autobalancer.assembly.quantities import value_of, with_quantity, with_value_at
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine import (
    Balancer,
    Balls,
    Machine,
    PlanarRotor,
    PrescribedSpeed,
    Race,
    Unbalance,
    ViscousDrag,
)
from autobalancer.machine.drive import Constant
from autobalancer.simulation.record import Samples
from autobalancer.stability.branch_diagrams import bifurcation_curves, branches
from autobalancer.stability.host.stations import in_plane, stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.linearized import exponents_of, swinging
from autobalancer.stability.states.questions import eigenvalues
from autobalancer.stability.states.rest_states import state_vector, states_of

UNEVEN = (2.2e4, 1.8e4)
K = float(DISCOIDAL.rotor.stiffness)
BETA = value_of(DISCOIDAL, "drag")
TWO_PLANES = load_race_machine(MACHINES / "two_plane_rotor.toml")


def uneven(machine: Machine, share: float) -> Machine:
    """With stiffness that differs along x and y, by this share to both sides."""
    if isinstance(machine.rotor, PlanarRotor):
        return with_value_at(machine, "rotor.stiffness", (K * (1.0 - share), K * (1.0 + share)))
    for number, support in enumerate(machine.rotor.supports, 1):
        pair = ((1.0 - share) * support.stiffness, (1.0 + share) * support.stiffness)
        machine = with_value_at(machine, f"rotor.supports[{number}].stiffness", pair)
    return machine


def test_the_field_on_anisotropic_supports_is_that_a_quarter_turn_later_that_of_exchanged_ones() -> None:
    straight, crossed = (stations(machine(TWO, stiffness=k)) for k in (UNEVEN, UNEVEN[::-1]))
    theta, states = np.array([0.0, 0.3, 2.0]), np.random.default_rng(0).normal(size=(3, 16))
    states[:, :8] *= 1e-3
    first, later = Field(straight, 200.0, theta), Field(crossed, 200.0, theta + 0.5 * np.pi)
    np.testing.assert_allclose(first(states), later(states), rtol=1e-11, atol=1e-9)
    np.testing.assert_allclose(
        first(states), [Field(straight, 200.0, a)(s) for a, s in zip(theta, states, strict=True)]
    )
    assert np.abs(first(states) - Field(straight, 200.0, theta + 0.5 * np.pi)(states)).max() > 1.0


@pytest.mark.parametrize("tilting", ["deflection", "full"])
def test_over_half_a_turn_an_isotropic_rotor_has_its_states_and_eigenvalues(tilting: str) -> None:
    st, speed = stations(machine(TWO).model_copy(update={"tilting_races": tilting})), 230.0
    for guess in states_of(st, speed)[:4]:
        rest = state_vector(st, speed, guess.angles)
        cycle, state = swinging(st, speed, guess.angles, guess.freedom)
        np.testing.assert_allclose(cycle.around(state), np.tile(rest, (cycle.count, 1)), atol=1e-9)
        values = np.linalg.eigvals(Field(st, speed).jacobian(rest))
        half = np.pi / speed
        assert same_spectrum(np.exp(cycle.exponents(state) * half), np.exp(values * half)) < 1e-8


@pytest.mark.parametrize("groups", [ONE, TWO], ids=["one plane", "two planes"])
def test_over_half_a_turn_states_on_anisotropic_supports_have_the_multipliers_of_the_equations_in_space(
    groups: tuple[Group, ...],
) -> None:
    speed = 90.0
    st = stations(machine(groups, stiffness=UNEVEN))
    ways = []
    states = states_of(st, speed)
    for guess in (states[0], *states[-3:]):
        cycle, state = swinging(st, speed, guess.angles)
        ways.append(np.ptp(cycle.around(state)[:, cycle.rotor : cycle.rotor + cycle.balls], axis=0).max())
        expected = exponents_of(st, speed, guess)
        turn = 2.0 * np.pi / speed
        assert same_spectrum(np.exp(cycle.exponents(state) * turn), np.exp(expected * turn)) < 1e-8
        np.testing.assert_allclose(np.sort(cycle.exponents(state).real), np.sort(expected.real), atol=1e-8 * speed)
    assert max(ways) > 1e-5  # the balls swing but where all planes are at rest


def test_rates_of_change_over_half_a_turn_are_those_of_the_map() -> None:
    st, speed = stations(machine(ONE, stiffness=UNEVEN)), 90.0
    cycle, state = swinging(st, speed, states_of(st, speed)[0].angles)
    slopes = np.linalg.eigvals(cycle.jacobian(state))
    for value in cycle.exponents(state)[:6]:
        assert np.abs(slopes - value).min() < 1e-8 * speed


def test_derivatives_over_half_a_turn_are_those_of_its_values() -> None:
    st, speed = stations(machine(ONE, stiffness=UNEVEN)), 90.0
    cycle, state = swinging(st, speed, states_of(st, speed)[0].angles)
    random = np.random.default_rng(3)
    sizes = np.abs(state) + np.tile(np.repeat([1e-4, 1e-2, 0.1, 1.0], [4, 4, 2, 2]), cycle.count)
    u, v = sizes * random.normal(size=(2, state.size)) * 0.1

    def difference(function: object) -> np.ndarray:
        a, b, c, d = (function(state + h * v) for h in 0.1 * np.array([-2.0, -1.0, 1.0, 2.0]))  # type: ignore[operator]
        return np.asarray((a - 8.0 * b + 8.0 * c - d) / 1.2)

    for obtained, expected in (
        (cycle.jacobian(state) @ v, difference(cycle)),
        (cycle.second(state, u, v), difference(lambda x: cycle.jacobian(x) @ u)),
        (cycle.bent(state, u) @ v, cycle.second(state, u, v)),
        (cycle.third(state, u, v), difference(lambda x: cycle.second(x, u, u))),
    ):
        np.testing.assert_allclose(obtained, expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("machine", [DISCOIDAL, TWO_PLANES], ids=["planar", "two planes"])
def test_balance_on_anisotropic_supports_is_lost_in_a_hopf_point_at_the_exact_border(machine: Machine) -> None:
    machine = uneven(machine, 0.1)
    (border,) = (b.speed for b in ab.stability.borders(machine) if b.name == "exact border")
    found = branches(machine, "speed", 1.05 * border, 0.97 * border, largest_step=0.1)
    (point,) = specials(found, "Hopf")
    assert float(point["special_parameter"]) == pytest.approx(border, rel=1e-9)
    verdicts = found["verdict"].values[found["parameter"].values > border * (1.0 + 1e-9)]
    assert set(verdicts) == {"stable"}


@pytest.mark.slow
def test_special_points_on_nearly_isotropic_supports_are_those_of_isotropic_ones() -> None:
    for start, end, state in ((67.0, 64.0, "balanced"), (55.5, 56.6, "coincident")):
        machines = DISCOIDAL, uneven(DISCOIDAL, 1e-6)
        even, other = (
            branches(m, "speed", start, end, from_state=state, orbits=False, switch=False, largest_step=0.1)
            for m in machines
        )
        assert other["special_type"].values.tolist() == even["special_type"].values.tolist() != []
        for name in ("special_parameter", "special_frequency", "lyapunov_coefficient"):
            np.testing.assert_allclose(other[name], even[name], rtol=2e-6, atol=1e-14, err_msg=name)


def test_balance_ends_where_the_balls_just_make_up_for_the_unbalance_on_any_supports() -> None:
    found = branches(uneven(DISCOIDAL, 0.1), "unbalance", 9e-4, 1.2e-3, speed=100.0, largest_step=0.1)
    (point,) = specials(found, "pitchfork")
    most = float(in_plane(DISCOIDAL).moment.sum())
    assert float(point["special_parameter"]) == pytest.approx(most, rel=1e-11)
    follows = found.isel(point=np.flatnonzero(found["branch"].values == 2))
    beyond = follows["parameter"].values > most * (1.0 + 1e-9)
    assert set(follows["verdict"].values[beyond]) == {"stable"}
    assert float(follows["deflection_max"][-1]) > 1.05 * float(follows["deflection_min"][-1])  # an ellipse


def test_a_run_leaves_its_state_where_the_branch_turns_back() -> None:
    ball = DISCOIDAL.balancers[0].races[0].balls[0].model_copy(update={"count": 1, "start_angles": (0.0,)})
    machine = with_value_at(uneven(DISCOIDAL, 0.1), f"{RACE}.balls", (ball,))
    machine = with_value_at(machine, f"{RACE}.drag", {"law": "viscous", "damping": BETA})
    machine = with_value_at(machine, "unbalances[1].mass", 3e-3)
    found = branches(machine, "speed", 53.0, 57.0, from_state="coincident", switch=False)
    fold = float(specials(found, "fold")[0]["special_parameter"])
    last: list[np.ndarray] = []
    for speed in (fold - 0.05, fold + 0.05):
        profile = {"kind": "table", "time": (0.0, 30.0), "speed": (48.0, speed)}
        run = simulate(with_value_at(machine, "drive.profile", profile), duration=100.0, save=Samples(20001))
        last.append(run["ball_angle_in_rotor"].values[-1000:, 0])
        if speed < fold:
            deflection = np.hypot(run["x"], run["y"]).values[-1000:]
    there = branches(machine, "speed", 53.0, fold - 0.05, from_state="coincident", switch=False, largest_step=0.3).isel(
        point=-1
    )
    for name, values in (("ball_angle_in_rotor", last[0]), ("deflection", deflection)):
        assert float(values.min()) == pytest.approx(float(there[f"{name}_min"].max()), rel=1e-3)
        assert float(values.max()) == pytest.approx(float(there[f"{name}_max"].max()), rel=1e-3)
    assert abs(last[1][-1] - last[0][-1]) > math.pi  # it slips round in the rotor


def test_beyond_the_hopf_point_balls_swing_in_a_run_as_its_coefficient_says() -> None:
    machine = with_value_at(uneven(DISCOIDAL, 0.1), f"{RACE}.drag", {"law": "viscous", "damping": BETA})
    found = branches(machine, "speed", 70.0, 66.0, largest_step=0.1)
    (point,) = specials(found, "Hopf")
    assert str(point["criticality"].values) == "supercritical"
    speed = float(point["special_parameter"]) - 0.02
    rate = float(eigenvalues(machine, [speed])["growth_rate"][0])
    swing = math.sqrt(-rate / float(point["special_frequency"] * point["lyapunov_coefficient"]))
    angles = point["special_ball_angle_in_rotor_min"].values
    machine = with_value_at(machine, f"{RACE}.balls[1].start_angles", tuple(angles + np.array([swing, 0.0])))
    machine = with_value_at(machine, "drive.profile", {"kind": "constant", "speed": speed})
    run = simulate(machine, duration=8.0 / rate, save=Samples(20001), mass_spread=0.0)
    late = run["ball_angle_in_rotor"].values[-4000:]
    assert 0.5 * float(np.ptp(late, axis=0).max()) == pytest.approx(
        swing, rel=0.02
    )  # the rest is of the order of swing^2


def test_the_curve_of_hopf_points_on_anisotropic_supports_is_the_exact_border() -> None:
    machine = uneven(DISCOIDAL, 0.1)
    curve = bifurcation_curves(machine, "Hopf", "speed", 70.0, 60.0, "drag", BETA, 1.5 * BETA, largest_step=0.3)
    assert curve.sizes["point"] > 4
    for part in (curve.isel(point=0), curve.isel(point=-1)):
        other = with_value_at(machine, f"{RACE}.drag", {"law": "viscous", "damping": float(part["second_parameter"])})
        (border,) = (b.speed for b in ab.stability.borders(other) if b.name == "exact border")
        assert float(part["parameter"]) == pytest.approx(border, rel=1e-9)


@pytest.mark.slow
def test_the_curve_of_folds_on_anisotropic_supports_goes_through_the_folds_of_its_branches() -> None:
    machine = uneven(DISCOIDAL, 0.1)
    curve = bifurcation_curves(
        machine, "fold", "speed", 53.0, 56.0, "unbalance", 5.8e-4, 6.2e-4, from_state="coincident", largest_step=0.3
    )
    last = curve.isel(point=-1)
    other = with_quantity(machine, "unbalance", float(last["second_parameter"]))
    found = branches(other, "speed", 53.0, 56.0, from_state="coincident", switch=False, largest_step=0.1)
    assert float(last["parameter"]) == pytest.approx(float(specials(found, "fold")[0]["special_parameter"]), rel=1e-9)


@pytest.mark.slow
def test_beyond_a_period_doubling_a_ball_repeats_after_a_whole_turn_only() -> None:
    """On a race hardly larger than the deflection it would swing once a turn by itself; what holds it varies twice a turn."""
    ball = Balls(mass=0.01, motion="point", start_angles=(-0.1,))
    race = Race(orbit_radius=0.002, drag=ViscousDrag(damping=1e-7), balls=(ball,))
    machine = Machine(
        name="small race",
        axis="vertical",
        rotor=PlanarRotor(mass=10.0, stiffness=(0.85e5, 1.15e5), damping=150.0),
        unbalances=(Unbalance(moment=0.03),),
        balancers=(Balancer(races=(race,)),),
        drive=PrescribedSpeed(profile=Constant(speed=60.0)),
    )
    found = branches(machine, "speed", 58.0, 66.0, from_state="coincident", switch=False, largest_step=0.2)
    first, last = specials(found, "period doubling")
    assert float(first["special_frequency"]) == pytest.approx(float(first["special_parameter"]), rel=1e-9)
    for speed, doubled in ((59.0, False), (62.5, True)):
        assert (float(first["special_parameter"]) < speed < float(last["special_parameter"])) == doubled
        half = math.pi / speed
        run = simulate(with_value_at(machine, "drive.profile.speed", speed), duration=600.0 * half, save=Samples(60001))
        angle = run["ball_angle_in_rotor"].values[:, 0]
        apart = [float(np.abs(angle[-1000:] - angle[-1000 - 100 * k : -100 * k]).max()) for k in (1, 2)]
        assert apart[1] < 1e-5
        assert (apart[0] > 0.1) if doubled else (apart[0] < 1e-5)


def test_motions_with_a_second_frequency_are_refused_with_a_way_out() -> None:
    machine = uneven(DISCOIDAL, 0.1)
    with pytest.raises(QuestionError, match=r"two frequencies.*simulate"):
        branches(machine, "speed", 60.0, 70.0, from_state="stalled")
    found = branches(machine, "speed", 70.0, 66.0, largest_step=0.2)
    assert "two frequencies" in " ".join(found.remarks())


def test_a_parameter_that_would_make_x_and_y_alike_is_refused() -> None:
    machine = uneven(DISCOIDAL, 0.1)
    with pytest.raises(QuestionError, match=r"rotor.stiffness\[1\] & rotor.stiffness\[2\]"):
        branches(machine, "stiffness", 4e4, 5e4, speed=70.0)
    both = "rotor.stiffness[1] & rotor.stiffness[2]"
    assert branches(machine, both, 4.2e4, 4.3e4, speed=70.0, largest_step=0.3).sizes["point"] > 2
