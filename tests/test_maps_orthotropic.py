"""Exact stability of balanced planar rotors on orthotropic supports, at many speeds at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from tests.test_averaged import a_plane, unequal

import autobalancer as ab
from autobalancer.stability.averaged import explicit_averaged_border
from autobalancer.stability.host.stations import Plane, of_plane
from autobalancer.stability.maps.balanced import EqualBalls, StationBalls, balanced_states
from autobalancer.stability.maps.exact import border_of, worst_case
from autobalancer.stability.states import ball_positions as right_angles
from autobalancer.stability.states.linearized import growth_rates

SPEEDS = np.array([31.0, 96.0, 104.0, 118.0, 131.0, 260.0, 900.0])


def orthotropic(count: int = 2) -> Plane:
    """Balls that are light on their feet: their inertia counts."""
    return a_plane(count, s=2.0, stiffness=(1e5, 1.7e5), damping=(60.0, 25.0))


def uneven(count: int, seed: int = 4) -> Plane:
    return replace(unequal(np.random.default_rng(seed), count), stiffness=(1e5, 1.7e5), damping=(60.0, 25.0))


def at(p: Plane, speeds: np.ndarray, angles: np.ndarray, neutral: int) -> np.ndarray:
    both = np.tile(angles, (speeds.size, 1))
    return np.asarray(growth_rates(p, speeds, both, np.full(speeds.size, neutral)))


@pytest.mark.parametrize("p", [orthotropic(), uneven(2), uneven(3)], ids=["equal", "unequal", "three"])
def test_rates_at_many_speeds_are_those_of_one_state_at_a_time(p: Plane) -> None:
    (member,) = balanced_states(p)
    assert member.route == "multipliers of a rotor at rest"
    st = of_plane(replace(p, capability=float(p.moment.sum())))
    one_by_one = StationBalls(st, route="multipliers").rates(SPEEDS)
    assert member.rates(SPEEDS) == pytest.approx(one_by_one, abs=1e-8)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_where_the_supports_become_alike_the_rates_become_those_of_the_polynomial(count: int) -> None:
    p = orthotropic(count)
    alike = replace(p, stiffness=(1e5, 1e5), damping=(60.0, 60.0))
    nearly = replace(p, stiffness=(1e5, 1e5 * (1.0 + 1e-11)), damping=(60.0, 60.0))
    for one, other in zip(balanced_states(nearly), balanced_states(alike), strict=True):
        assert isinstance(other, EqualBalls)
        assert one.rates(SPEEDS) == pytest.approx(other.rates(SPEEDS), abs=1e-8)


def test_an_exchange_of_x_and_y_changes_nothing() -> None:
    p = orthotropic()
    other = replace(p, stiffness=p.stiffness[::-1], damping=p.damping[::-1])
    assert balanced_states(other)[0].rates(SPEEDS) == pytest.approx(balanced_states(p)[0].rates(SPEEDS), abs=1e-8)


def test_equal_balls_count_through_the_size_of_their_double_angles_only() -> None:
    """Its direction is the instant at which half a turn begins, so wherever the balls stand two can stand for all."""
    random = np.random.default_rng(2)
    p = orthotropic(4)
    two = replace(orthotropic(), moment=np.sqrt(2.0) * p.moment[:2])
    two = replace(two, mass=p.mass)
    for _ in range(3):
        angles = random.uniform(0.0, 2.0 * np.pi, 4)
        share = abs(np.exp(2j * angles).sum()) / 4.0
        half = 0.5 * np.arccos(share)
        expected = at(two, SPEEDS, np.array([half, -half]), 0)
        assert at(p, SPEEDS, angles, 2) == pytest.approx(expected, abs=1e-8)


def test_of_many_balls_the_worst_and_the_best_positions_are_told_apart() -> None:
    machine = ab.with_parameter(ab.example("discoidal"), "count", 4)
    machine = ab.with_parameter(machine, "rotor.stiffness", ("40 kN/m", "50 kN/m"))
    worst, best = ab.stability.borders(machine, only=("exact border", "exact border, best case"))
    assert worst.speed > 1.001 * best.speed
    between = {"speed": [0.5 * (worst.speed + best.speed)], "viscosity": ["20 mm^2/s"]}
    rates = [
        float(ab.stability.map(machine, between, positions=name, borders=0)["growth_rate"].item())
        for name in ("worst", "best")
    ]
    assert rates[1] < 0.0 < rates[0]


def test_balls_at_right_angles_act_like_a_ring_that_is_alike_in_all_directions() -> None:
    """So seen in space nothing repeats: exponents of constant coefficients are those of the map over half a turn."""
    for p, angles in ((orthotropic(), (0.25, -0.25)), (orthotropic(4), (0.0, 0.5, 0.3, 0.8))):
        found = at(p, SPEEDS, np.pi * np.array(angles), p.moment.size - 2)
        assert right_angles.growth_rates(p, SPEEDS) == pytest.approx(found, abs=1e-8)


def test_the_exponents_at_right_angles_are_the_roots_of_one_polynomial() -> None:
    p = orthotropic(4)
    inertia, drag, coupling = float(p.inertia[0]), float(p.drag[0]), 0.5 * float((p.moment**2).sum())
    x, y = (Polynomial([k, b, p.mass]) for k, b in zip(p.stiffness, p.damping, strict=True))
    t4 = Polynomial([0.0, 0.0, 0.0, 0.0, 1.0])
    for speed in SPEEDS[:6]:
        a, slope = Polynomial([-inertia * speed**2, drag, inertia]), Polynomial([drag, 2.0 * inertia])
        whole = x * y * (a**2 + speed**2 * slope**2) - coupling * t4 * (x + y) * a + coupling**2 * t4**2
        found = np.sort_complex(right_angles.exponents(p, np.array([speed]))[0])
        assert found == pytest.approx(np.sort_complex(whole.roots().astype(complex)), abs=1e-7 * speed)


def test_no_unbalance_has_a_border_above_the_worst_case() -> None:
    p = a_plane(s=0.3, stiffness=(1e5, 1.7e5), damping=(300.0, 200.0))
    worst = worst_case(p)
    assert "|S2|/N = 0," in worst.note
    at_right_angles = border_of(balanced_states(replace(p, unbalance=2.0**0.5 * p.moment[0]))[0], p)
    assert at_right_angles.speed == pytest.approx(worst.speed, rel=1e-8)
    for share in (0.3, 1.2, 1.9):
        member = balanced_states(replace(p, unbalance=share * p.moment[0]))[0]
        assert border_of(member, p).speed < worst.speed


def test_the_worst_case_becomes_the_explicit_one_of_isotropic_supports() -> None:
    p = a_plane(s=0.3)
    nearly = replace(p, stiffness=(1e5, 1e5 * (1.0 + 1e-9)))
    assert worst_case(nearly).speed == pytest.approx(worst_case(p).speed, rel=1e-8)


def test_of_heavily_damped_light_balls_the_worst_case_is_the_averaged_border() -> None:
    for share, tolerance in ((1e-2, 2e-4), (1e-3, 3e-6)):
        p = a_plane(s=share, stiffness=(1e5, 1.7e5), damping=(60.0, 25.0))
        averaged, exact = explicit_averaged_border(p).speed, worst_case(p).speed
        assert exact > 1.001 * p.critical_speeds[-1]
        assert exact == pytest.approx(averaged, rel=tolerance)
