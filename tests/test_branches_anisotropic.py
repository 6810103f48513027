"""Steady states on anisotropic supports: the equations over half a turn, their branches, special points and curves."""

from __future__ import annotations

import numpy as np
import pytest
from tests.test_stability_stations import ONE, TWO, Group, machine, same_spectrum

from autobalancer.stability.host.stations import stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.floquet import exponents_of
from autobalancer.stability.states.state import state_vector
from autobalancer.stability.states.stations import states_of
from autobalancer.stability.states.swinging import swinging

UNEVEN = (2.2e4, 1.8e4)


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
