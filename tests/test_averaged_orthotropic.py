"""The averaged border on orthotropic supports in closed form: its limits and symmetries, and against the eigenvalue problem."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from tests.references.averaged import averaged_growth_rate, balanced_growth_rate, balanced_growth_rates, growth_rates
from tests.test_averaged import a_plane, balanced, lopsided, unequal

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.stability.averaged import (
    explicit_averaged_border,
    greatest_g,
    minimum_drag,
    speed_windows,
    stable_ranges,
)
from autobalancer.stability.host.stations import Plane
from autobalancer.stability.maps.exact import averaged_border_of

AT_135 = balanced(0.75 * math.pi, -0.75 * math.pi)


def random_planes(count: int, seed: int = 0) -> list[Plane]:
    """Two balls, critical speeds up to a ratio of two, damping ratios of 0.1 to 30 %, of every third alike in x and y."""
    random, found = np.random.default_rng(seed), []
    for number in range(count):
        dampings = 2000.0 * 10.0 ** random.uniform(-3.0, -0.5, 2)
        both = (dampings[0], dampings[number % 3 and 1])
        found.append(
            a_plane(s=10.0 ** random.uniform(-3.0, -0.2), stiffness=(1e5, 1e5 * random.uniform(1.0, 4.0)), damping=both)
        )
    return found


def g_of(p: Plane) -> float:
    return float((p.moment**2 / p.drag).sum())


def edges(p: Plane) -> list[float]:
    return [edge for one in stable_ranges(p) for edge in one]


@pytest.mark.parametrize("which", ["stiffness", "damping", "both"])
def test_where_the_supports_become_alike_the_border_becomes_that_of_isotropic_ones(which: str) -> None:
    p = a_plane(s=0.3)
    expected = explicit_averaged_border(p).speed
    for part in (1e-4, 1e-7, 1e-10):
        stiffness = (1e5, 1e5 * (1.0 + part * (which != "damping")))
        damping = (12.0, 12.0 * (1.0 + part * (which != "stiffness")))
        found = explicit_averaged_border(replace(p, stiffness=stiffness, damping=damping))
        assert found.speed == pytest.approx(expected, rel=max(1e-11, 5.0 * part))
    assert edges(p) == pytest.approx([expected, math.inf], rel=1e-12)
    assert greatest_g(p, 1e9) == pytest.approx(greatest_g(p, math.inf), rel=1e-12)


def test_an_exchange_of_x_and_y_changes_nothing() -> None:
    for p in random_planes(30):
        other = replace(p, stiffness=p.stiffness[::-1], damping=p.damping[::-1])
        assert edges(other) == pytest.approx(edges(p), rel=1e-9)
        assert greatest_g(other, 170.0) == pytest.approx(greatest_g(p, 170.0), rel=1e-12)


def test_supports_that_differ_in_damping_only_count_by_the_harmonic_mean() -> None:
    p = a_plane(s=0.05, damping=(60.0, 15.0))
    mean = 2.0 * 60.0 * 15.0 / 75.0
    alike = replace(p, damping=(mean, mean))
    assert explicit_averaged_border(p).speed == pytest.approx(explicit_averaged_border(alike).speed, rel=1e-12)
    assert minimum_drag(p, 150.0) == pytest.approx(minimum_drag(alike, 150.0), rel=1e-12)


def test_all_ranges_are_those_of_the_eigenvalue_problem_at_135_degrees() -> None:
    grid, several = np.geomspace(40.0, 2000.0, 400), 0
    for p in random_planes(60, seed=3):
        ranges = stable_ranges(p)
        inside = np.array([any(low < speed < high for low, high in ranges) for speed in grid])
        assert (inside == (growth_rates(p, grid, 0.0) < 0.0)).all()
        for edge in (edge for edge in edges(p) if math.isfinite(edge) and edge < 4000.0):
            below, above = (averaged_growth_rate(p, edge * (1.0 + side), AT_135) for side in (-1e-6, 1e-6))
            assert (below < 0.0) != (above < 0.0)
        several += len(ranges) > 1
    assert several > 10


def test_above_the_border_no_unbalance_is_unstable() -> None:
    spreads = np.linspace(0.0, 1.0, 21)
    for p in random_planes(60, seed=7):
        border = explicit_averaged_border(p).speed
        if math.isinf(border):
            continue
        speeds = np.repeat(border * np.array([1.0 + 1e-6, 1.01, 1.2, 2.0, 6.0]), spreads.size)
        assert (growth_rates(p, speeds, np.tile(spreads, 5)) < 1e-9 * border).all()


def test_light_balls_balance_wherever_the_forward_whirl_lags() -> None:
    for p in random_planes(20, seed=5):
        light = replace(p, drag=1e6 * p.drag)
        expected = [edge for one in speed_windows(p, damped=True) for edge in one]
        assert edges(light) == pytest.approx(expected, rel=1e-4)


def test_the_minimum_drag_is_that_of_the_eigenvalue_problem_at_135_degrees() -> None:
    for p in random_planes(30, seed=9):
        for speed in (1.02 * p.critical_speeds[-1], 1.5 * p.critical_speeds[-1], 900.0):
            if greatest_g(p, speed) == 0.0:
                continue
            drag = minimum_drag(p, speed)
            rates = [
                averaged_growth_rate(replace(p, drag=np.full(2, drag * f)), speed, AT_135) for f in (0.999999, 1.000001)
            ]
            assert rates[1] < 0.0 < rates[0]
        assert minimum_drag(p, 1e8) == pytest.approx(minimum_drag(p), rel=1e-5)


def test_a_rotor_that_is_free_along_one_direction_needs_half_the_drag() -> None:
    """Far from the resonance of the other direction only half of a whirl along one line is forward."""
    p = a_plane(stiffness=(1e5, 1e9), damping=(1.0, 1.0))
    assert minimum_drag(p, 130.0) == pytest.approx(
        0.5 * minimum_drag(replace(p, stiffness=(1e5, 1e5)), 130.0), rel=1e-3
    )


def test_the_averaged_border_of_a_machine_is_the_worst_case_over_its_unbalance() -> None:
    machine = ab.with_parameter(ab.example("discoidal"), "rotor.stiffness", ("40 kN/m", "50 kN/m"))
    (found,) = ab.stability.borders(machine, only=("averaged border",))
    scanned = ab.stability.averaged_border(machine, worst_case=True)
    assert found.speed == pytest.approx(scanned.speed, rel=1e-8)
    assert found.speed >= ab.stability.averaged_border(machine).speed
    assert "stable also" in found.note


def test_growth_rates_at_many_speeds_are_those_of_the_matrices() -> None:
    random = np.random.default_rng(1)
    speeds = np.geomspace(40.0, 900.0, 25)
    planes = (lopsided(), a_plane(), unequal(random, 5), a_plane(unbalance=4e-3), a_plane(3))
    for p in (replace(one, stiffness=(1e5, 1.7e5)) for one in planes):
        expected = np.array([balanced_growth_rate(p, speed) for speed in speeds])
        found = balanced_growth_rates(p, speeds)
        assert found == pytest.approx(expected, abs=1e-10, nan_ok=True)


def test_where_no_drag_is_enough_says_so() -> None:
    p = a_plane(stiffness=(1e5, 1.7e5))
    with pytest.raises(
        QuestionError, match=r"given 120 rad/s, where no drag is enough; must be in one of speed_windows"
    ):
        minimum_drag(p, 120.0)
    never = replace(p, damping=(12.0, 0.0))
    assert math.isinf(explicit_averaged_border(never).speed)
    assert math.isinf(averaged_border_of(never, True).speed)
