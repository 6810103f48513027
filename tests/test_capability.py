"""What a race of balls can compensate: closed form against the sum, limits, order, and refusals."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.api import check as summary
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_race_machine
from autobalancer.laws.capabilities import (
    ball_capability,
    ball_mass,
    capability,
    half_sector,
    largest_count,
    largest_useful_count,
    needed_count,
    potential_ratio,
)

MACHINES = Path(__file__).parent.parent / "examples" / "machines"
RACE = (0.077, 0.0123)
STEEL = 7860.0


def sum_over_balls(count: int, alpha: float) -> float:
    """Spannan (2021), eq. (2.3), term by term."""
    odd = 1.0 + sum(2.0 * math.cos((j - 1) * alpha) * (j % 2) for j in range(2, count + 1))
    even = sum(2.0 * math.cos((j - 1) * alpha) * ((j - 1) % 2) for j in range(2, count + 1))
    return (count % 2) * odd + ((count - 1) % 2) * even


@pytest.mark.parametrize("alpha", [0.012, 0.0801, 0.27, 0.5])
def test_the_closed_form_is_the_sum_over_the_balls(alpha: float) -> None:
    counts = range(1, math.floor(math.pi / alpha) + 1)
    literal = [sum_over_balls(n, alpha) for n in counts]
    assert potential_ratio(list(counts), alpha) == pytest.approx(literal, rel=1e-9, abs=1e-10)


def test_the_closed_form_is_the_vector_sum_of_touching_balls() -> None:
    alpha = half_sector(*RACE)
    for count in (2, 7, 20):
        places = 2.0 * alpha * (np.arange(count) - 0.5 * (count - 1))
        assert potential_ratio(count, alpha) == pytest.approx(abs(np.exp(1j * places).sum()), rel=1e-13)


def test_very_small_balls_add_up_like_masses_in_one_point() -> None:
    assert potential_ratio(5, 0.0) == 5.0
    assert potential_ratio(5, 1e-5) == pytest.approx(5.0, rel=1e-8)


def test_a_full_race_balances_nothing() -> None:
    alpha = math.pi / 24.0
    assert potential_ratio(24, alpha) == pytest.approx(0.0, abs=1e-13)


def test_many_small_balls_reach_the_resultant_of_half_a_ring() -> None:
    line_density = 2.0  # kg per meter of orbit: half a ring has the first moment 2 * line_density * radius^2
    diameter = 1e-5
    density = line_density * diameter / (math.pi / 6.0 * diameter**3)
    assert capability(0.1, diameter, density) == pytest.approx(2.0 * line_density * 0.1**2, rel=1e-6)


def test_one_ball_has_the_moment_of_its_effective_mass() -> None:
    effective = math.pi / 6.0 * RACE[1] ** 3 * (STEEL - 960.0)
    assert ball_mass(RACE[1], STEEL, fluid_density=960.0) == pytest.approx(effective, rel=1e-14)
    expected = pytest.approx(effective * RACE[0], rel=1e-14)
    assert ball_capability(*RACE, STEEL, fluid_density=960.0) == expected
    assert capability(*RACE, STEEL, 1, fluid_density=960.0) == expected


def test_capability_grows_up_to_the_useful_count_and_falls_beyond() -> None:
    useful, room = largest_useful_count(*RACE), largest_count(*RACE)
    values = [capability(*RACE, STEEL, n) for n in range(1, room + 1)]
    assert np.all(np.diff(values[:useful]) > 0.0)
    assert np.all(np.diff(values[useful - 1 :]) < 0.0)
    assert capability(*RACE, STEEL) == max(values)


def test_each_further_ball_contributes_less() -> None:
    alpha = half_sector(*RACE)
    gains = np.diff(potential_ratio(np.arange(largest_count(*RACE) + 1), alpha))
    assert np.all(np.diff(gains) < 0.0)


@pytest.mark.parametrize("ratio", np.linspace(0.01, 0.99, 99).tolist())
def test_the_useful_count_is_the_best_of_all_that_fit(ratio: float) -> None:
    race = (1.0, 2.0 * ratio)
    best = max(range(1, largest_count(*race) + 1), key=lambda n: round(capability(*race, STEEL, n), 9))
    assert largest_useful_count(*race) == best


def test_the_next_lower_integer_is_one_ball_short() -> None:
    race = (0.0415, 0.020638)  # half an orbit holds 6.24 balls of this size; 6.6 of the next
    assert largest_useful_count(*race) == 6
    short = (1.0, 2.0 * math.sin(math.pi / 2.0 / 6.6))
    assert largest_useful_count(*short) == 7
    assert capability(*short, STEEL, 7) > capability(*short, STEEL, 6)


def test_balls_that_just_touch_all_around_fit() -> None:
    for count in (2, 3, 12, 200):
        assert largest_count(1.0, 2.0 * math.sin(math.pi / count)) == count


def test_the_needed_count_is_the_first_that_reaches_the_unbalance() -> None:
    for count in range(2, largest_useful_count(*RACE) + 1):
        reached = capability(*RACE, STEEL, count)
        assert needed_count(reached, *RACE, STEEL) == count
        if count > 2:
            assert needed_count(0.999 * capability(*RACE, STEEL, count - 1), *RACE, STEEL) == count - 1


def test_one_ball_is_never_enough_because_it_cannot_hide() -> None:
    assert needed_count(1e-3 * ball_capability(*RACE, STEEL), *RACE, STEEL) == 2


def test_an_unbalance_beyond_the_race_is_refused_with_the_greatest_capability() -> None:
    greatest = capability(*RACE, STEEL)
    with pytest.raises(QuestionError, match=f"{greatest:g} kg m"):
        needed_count(1.01 * greatest, *RACE, STEEL)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((-0.077, 0.0123, STEEL), "orbit_radius = -0.077 m"),
        ((0.077, 0.0, STEEL), "ball_diameter = 0.0 m"),
        ((0.077, math.nan, STEEL), "ball_diameter = nan m"),
        ((0.077, 0.16, STEEL), "at most 0.154 m"),
        ((0.077, 0.0123, -1.0), "ball_density = -1.0"),
        ((0.077, 0.0123, STEEL, 0), "room for 1 to 39"),
        ((0.077, 0.0123, STEEL, 40), "room for 1 to 39"),
        ((0.077, 0.0123, STEEL, 2.5), "given count = 2.5"),
        ((0.077, 0.0123, STEEL, True), "given count = True"),
    ],
)
def test_impossible_races_are_refused_in_words(arguments: tuple[float, ...], words: str) -> None:
    with pytest.raises(QuestionError, match=words):
        capability(*arguments)  # type: ignore[arg-type]


def test_floating_balls_are_refused() -> None:
    with pytest.raises(QuestionError, match="float in a fluid of 1500"):
        capability(*RACE, 1410.0, fluid_density=1500.0)
    with pytest.raises(QuestionError, match="fluid_density = -1"):
        capability(*RACE, STEEL, fluid_density=-1.0)


def test_a_race_and_its_plane_have_one_capability_that_of_touching_balls() -> None:
    found = summary(MACHINES / "two_plane_rotor.toml")
    ball = math.pi / 6.0 * 0.010**3 * 7800.0 * 0.050
    touching = 2.0 * ball * math.cos(math.asin(0.005 / 0.050))
    for race, plane in zip(found.races, found.stations, strict=True):
        assert race.capability == pytest.approx(touching, rel=1e-9)
        assert plane.capability == race.capability


def test_an_unbalance_for_which_balls_would_overlap_says_so() -> None:
    machine = load_race_machine(MACHINES / "discoidal.toml")
    possible, points = summary(machine).races[0].capability, 2.0 * float(resolve(machine)[0].moment)
    assert possible < points
    note = {b.name: b.note for b in ab.stability.borders(machine, 0.5 * (possible + points))}["exact border"]
    assert "would have to overlap" in note
    assert "overlap" not in {b.name: b.note for b in ab.stability.borders(machine, 0.999 * possible)}["exact border"]
