"""The bearing table against the law behind it, the choice of a bearing, and the materials of balls."""

from __future__ import annotations

import math

import pytest

from autobalancer.catalog.product_tables import (
    TABLE_DENSITY,
    Bearing,
    bearing,
    bearings,
    material,
    materials,
    suitable_bearings,
)
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.laws.capabilities import capability, half_sector, largest_useful_count, potential_ratio

UNBALANCE = 594e-6


def floor_capability(entry: Bearing, fluid_density: float = 0.0) -> float:
    """Capability with the count of the source, the next integer below pi / (2 a)."""
    alpha = half_sector(entry.orbit_radius, entry.ball_diameter)
    count = math.floor(math.pi / 2.0 / alpha)
    return capability(entry.orbit_radius, entry.ball_diameter, TABLE_DENSITY, count, fluid_density=fluid_density)


def test_the_table_has_412_bearings_of_which_97_say_that_they_are_reconstructed() -> None:
    assert len(bearings()) == 412
    assert sum(entry.family == "deep_groove_SKF" for entry in bearings()) == 325
    doubtful = [entry for entry in bearings() if not entry.verified]
    assert len(doubtful) == 97
    assert all("reconstructed" in entry.remark for entry in doubtful)


def test_every_printed_capability_follows_from_the_law() -> None:
    for entry in bearings():
        assert floor_capability(entry) == pytest.approx(entry.capability_printed, rel=4.6e-3), entry.designation


def test_verified_rows_agree_with_air_around_the_balls_to_the_last_printed_digit() -> None:
    # half a unit of the third digit, for rows whose value was not computed from other columns
    for entry in bearings():
        if entry.verified:
            unit = 10.0 ** (math.floor(math.log10(entry.capability_printed)) - 2)
            deviation = floor_capability(entry, fluid_density=1.2) - entry.capability_printed
            assert abs(deviation) <= 0.5001 * unit, entry.designation


def test_the_nearest_integer_beats_the_lower_one_in_215_rows() -> None:
    gains = []
    for entry in bearings():
        alpha = half_sector(entry.orbit_radius, entry.ball_diameter)
        lower = math.floor(math.pi / 2.0 / alpha)
        best = largest_useful_count(entry.orbit_radius, entry.ball_diameter)
        gains.append(float(potential_ratio(best, alpha) / potential_ratio(lower, alpha)) - 1.0)
    assert sum(gain > 1e-12 for gain in gains) == 215
    assert max(gains) == pytest.approx(0.033, abs=5e-4)
    assert bearings()[gains.index(max(gains))].designation == "6403"
    assert min(gains) >= 0.0


def test_the_orbit_lies_between_bore_and_outer_diameter() -> None:
    for entry in bearings():
        assert entry.bore < 2.0 * entry.orbit_radius - entry.ball_diameter, entry.designation
        assert 2.0 * entry.orbit_radius + entry.ball_diameter < entry.outer, entry.designation
        assert entry.ball_diameter < entry.width, entry.designation


def test_known_doubts_are_visible() -> None:
    assert "1/32 in" in bearing("CSCC 120").remark
    assert "contradicts the designation" in bearing("CSCG 250").remark
    assert bearing("6204").remark == ""


def test_every_suitable_bearing_compensates_the_unbalance_with_the_fewest_balls() -> None:
    found = suitable_bearings(UNBALANCE, max_outer=0.08)
    assert found
    for choice in found:
        race = (choice.bearing.orbit_radius, choice.bearing.ball_diameter, TABLE_DENSITY)
        assert choice.capability == capability(*race, choice.count) >= UNBALANCE
        assert choice.count == 2 or capability(*race, choice.count - 1) < UNBALANCE
        assert choice.largest_capability >= choice.capability
        volume = math.pi / 6.0 * choice.bearing.ball_diameter**3
        assert choice.ball_mass == pytest.approx(choice.count * volume * TABLE_DENSITY, rel=1e-12)


def test_no_suitable_bearing_is_left_out() -> None:
    able = {
        entry.designation
        for entry in bearings()
        if capability(entry.orbit_radius, entry.ball_diameter, TABLE_DENSITY) >= UNBALANCE
    }
    assert {choice.bearing.designation for choice in suitable_bearings(UNBALANCE)} == able


def test_space_limits_hold_and_the_smallest_bearing_comes_first() -> None:
    found = suitable_bearings(UNBALANCE, max_outer=0.2, min_bore=0.05, max_width=0.02)
    assert found
    assert all(c.bearing.outer <= 0.2 and c.bearing.bore >= 0.05 and c.bearing.width <= 0.02 for c in found)
    order = [(choice.bearing.outer, choice.ball_mass) for choice in found]
    assert order == sorted(order)
    assert any(c.bearing.outer == 0.08 for c in suitable_bearings(UNBALANCE, max_outer=0.08))


def test_heavier_balls_and_thinner_fluids_widen_the_choice() -> None:
    steel = suitable_bearings(UNBALANCE, max_outer=0.08)
    carbide = suitable_bearings(UNBALANCE, max_outer=0.08, ball_density=14950.0)
    in_oil = suitable_bearings(UNBALANCE, max_outer=0.08, fluid_density=960.0)
    assert len(in_oil) < len(steel) < len(carbide)


def test_an_unbalance_beyond_all_bearings_finds_none() -> None:
    assert suitable_bearings(1e3) == ()


@pytest.mark.parametrize("limits", [{"max_outer": -1.0}, {"min_bore": 0.0}, {"max_width": math.nan}])
def test_impossible_spaces_are_refused(limits: dict[str, float]) -> None:
    with pytest.raises(QuestionError, match=next(iter(limits))):
        suitable_bearings(UNBALANCE, **limits)


def test_no_unbalance_is_no_question() -> None:
    with pytest.raises(QuestionError, match="unbalance"):
        suitable_bearings(0.0)


def test_a_misspelled_bearing_meets_its_neighbors() -> None:
    with pytest.raises(CatalogError, match="6207"):
        bearing("6207ETN9")
    assert bearing(" 6207 etn9 ").designation == "6207 ETN9"


def test_steel_has_the_density_of_the_bearing_table() -> None:
    assert material("Steel").density == TABLE_DENSITY
    assert all(entry.source and 1000.0 < entry.density < 20000.0 for entry in materials())


def test_a_misspelled_material_meets_its_neighbors() -> None:
    with pytest.raises(CatalogError, match="similar names: 'tungsten'"):
        material("tungstn")


def test_the_orbit_radius_can_be_limited() -> None:
    every = suitable_bearings(UNBALANCE)
    found = suitable_bearings(UNBALANCE, min_orbit="40 mm", max_orbit="50 mm")
    assert 0 < len(found) < len(every)
    assert found == tuple(entry for entry in every if 0.040 <= entry.bearing.orbit_radius <= 0.050)
