"""Fluids: laws against handbooks and limits, the tables of the source, blends, and refusals."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from reproductions.spannan2021.table_6_1 import COLD, HOT, double_log_from_vtc

from autobalancer.catalog.product_tables import FluidState, blend, fluid, fluids, rows
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.laws import viscosity
from autobalancer.laws import viscosity as glycerol
from autobalancer.laws import viscosity as mineral_oil
from autobalancer.laws import viscosity as water_and_air

SILICONE = rows("silicone_oils.csv")
KELVIN = 273.15


@pytest.mark.parametrize("row", SILICONE, ids=lambda row: row["nu_nominal_mm2_s"])
def test_the_printed_coefficients_follow_from_viscosity_and_vtc(row: dict[str, str]) -> None:
    p1, p2 = double_log_from_vtc(float(row["nu_nominal_mm2_s"]) * 1e-6, float(row["VTC"]))
    assert (round(p1, 3), round(p2, 3)) == (float(row["P1"]), float(row["P2"]))
    assert (p1, p2) == pytest.approx((float(row["P1_full"]), float(row["P2_full"])), abs=1e-5)


@pytest.mark.parametrize("row", SILICONE, ids=lambda row: row["nu_nominal_mm2_s"])
def test_silicone_oils_have_their_nominal_viscosity_and_vtc(row: dict[str, str]) -> None:
    name, nominal = f"silicone oil {row['nu_nominal_mm2_s']}", float(row["nu_nominal_mm2_s"]) * 1e-6
    assert fluid(name).viscosity == pytest.approx(nominal, rel=1e-12)
    drop = 1.0 - fluid(name, HOT).viscosity / fluid(name, COLD).viscosity
    assert drop == pytest.approx(float(row["VTC"]), abs=1e-5)


def test_the_double_log_line_passes_through_its_points() -> None:
    points = (300.0, 20e-6), (350.0, 5e-6)
    line = viscosity.double_log_through(*points)
    for temperature, nu in points:
        assert viscosity.viscosity_from_double_log(temperature, *line) == pytest.approx(nu, rel=1e-12)
    p1 = viscosity.double_log_from_slope(*points[0], line[1])
    assert p1 == pytest.approx(line[0], rel=1e-12)


def test_oils_become_thinner_and_lighter_with_temperature() -> None:
    temperatures = np.linspace(KELVIN, KELVIN + 100.0, 21)
    for entry in fluids():
        if entry.highest_temperature < 373.0 or entry.family == "air":
            continue
        states = [fluid(entry.name, t) for t in temperatures]
        assert np.all(np.diff([state.viscosity for state in states]) < 0.0), entry.name
        if entry.family != "water" and "no expansion" not in entry.remark:
            assert np.all(np.diff([state.density for state in states]) < 0.0), entry.name


def test_the_mass_stays_when_the_volume_expands() -> None:
    assert fluid("silicone oil 50", 323.15).density == pytest.approx(960.0 / (1.0 + 9.5e-4 * 25.0), rel=1e-12)
    assert viscosity.expanded_density(960.0, 9.5e-4, 298.15) == 960.0


def test_without_expansion_coefficient_the_density_stays_and_the_remark_says_so() -> None:
    warm = fluid("silicone oil 5", 323.15)
    assert warm.density == 920.0
    assert "no expansion coefficient" in warm.remark


# Dynamic viscosity [mPa s] at 20 degC of Segur and Oberstar (1951), Ind. Eng. Chem. 43, 2117
HANDBOOK_VISCOSITY = {0.2: 1.76, 0.4: 3.72, 0.5: 6.00, 0.6: 10.8, 0.8: 60.1, 0.9: 219.0, 1.0: 1410.0}
# Density [kg/m^3] at 20 degC of Bosart and Snoddy (1928), Ind. Eng. Chem. 20, 1377
HANDBOOK_DENSITY = {0.2: 1046.9, 0.5: 1126.3, 0.8: 1208.5, 1.0: 1261.1}


def test_half_glycerol_half_water_has_its_handbook_values() -> None:
    state = fluid("glycerol 50 wt%", 293.15)
    assert state.density == pytest.approx(1126.3, abs=0.2)
    assert state.density * state.viscosity == pytest.approx(6.00e-3, rel=2e-3)


@pytest.mark.parametrize("share", HANDBOOK_VISCOSITY)
def test_glycerol_viscosity_agrees_with_the_handbook(share: float) -> None:
    obtained = glycerol.glycerol_dynamic_viscosity(share, 293.15)
    assert obtained == pytest.approx(HANDBOOK_VISCOSITY[share] * 1e-3, rel=0.025)


@pytest.mark.parametrize("share", HANDBOOK_DENSITY)
def test_glycerol_density_agrees_with_the_handbook(share: float) -> None:
    assert glycerol.glycerol_density(share, 293.15) == pytest.approx(HANDBOOK_DENSITY[share], rel=5e-4)


def test_without_glycerol_the_mixture_is_water() -> None:
    t = np.linspace(KELVIN, KELVIN + 100.0, 41)
    assert glycerol.glycerol_density(0.0, t) == pytest.approx(water_and_air.water_density(t), rel=3e-4)
    thin = glycerol.glycerol_dynamic_viscosity(0.0, t)
    assert thin == pytest.approx(water_and_air.water_dynamic_viscosity(t), rel=7e-3)


def test_glycerol_and_water_contract_when_mixed() -> None:
    parts = 1.0 / (0.5 / glycerol.glycerol_density(1.0, 293.15) + 0.5 / glycerol.glycerol_density(0.0, 293.15))
    assert 1.005 < glycerol.glycerol_density(0.5, 293.15) / parts < 1.015


def test_volume_and_mass_fraction_name_the_same_mixture() -> None:
    share = float(glycerol.glycerol_mass_fraction(0.5))
    assert share == pytest.approx(1261.06 / (1261.06 + 998.05), rel=1e-5)
    by_volume = fluid("glycerol 50 vol%", 293.15)
    assert by_volume.viscosity == pytest.approx(fluid(f"glycerol {100.0 * share} wt%", 293.15).viscosity, rel=1e-12)


def test_water_and_air_have_their_handbook_values() -> None:
    assert fluid("water").density == pytest.approx(997.047, abs=0.003)
    assert water_and_air.water_dynamic_viscosity(298.15) == pytest.approx(8.900e-4, rel=1e-4)
    assert fluid("air", 288.15).density == pytest.approx(1.2250, abs=1e-4)
    assert fluid("air", 288.15).viscosity == pytest.approx(1.4607e-5, rel=1e-4)


@pytest.mark.parametrize("grade", mineral_oil.ISO_VG)
def test_iso_oils_have_at_40_degc_the_viscosity_they_are_named_after(grade: int) -> None:
    at_40 = fluid(f"ISO VG {grade}", KELVIN + 40.0).viscosity
    assert at_40 == pytest.approx(6.8e-6 if grade == 7 else grade * 1e-6, rel=1e-9)


@pytest.mark.parametrize("grade", mineral_oil.ISO_VG)
def test_iso_oils_have_the_viscosity_index_100(grade: int) -> None:
    hot = fluid(f"ISO VG {grade}", KELVIN + 100.0).viscosity
    assert mineral_oil.reference_viscosity(hot) == pytest.approx(mineral_oil.ISO_VG[grade], rel=1e-9)


# Basic values H [mm^2/s] against the viscosity at 100 degC, ASTM D2270, Table 1: one in each piece of the fit
REFERENCE = {
    2.5: 9.063, 4.0: 19.56, 4.8: 26.57, 6.0: 38.19, 6.8: 46.44, 7.4: 52.88, 8.2: 61.89, 10.0: 82.87, 13.0: 121.5,
    16.0: 164.6, 20.0: 229.5, 25.0: 320.9, 34.0: 509.6, 48.0: 863.0, 62.0: 1286.0,
}  # fmt: skip


@pytest.mark.parametrize("at_100", REFERENCE)
def test_the_reference_oil_meets_the_table_of_the_standard(at_100: float) -> None:
    assert mineral_oil.reference_viscosity(at_100 * 1e-6) == pytest.approx(REFERENCE[at_100] * 1e-6, rel=1.2e-3)


def test_the_reference_oil_of_the_viscosity_index_standard() -> None:
    # worked example of ASTM D2270: 8.86 mm^2/s at 100 degC has H = 69.48 mm^2/s
    assert mineral_oil.reference_viscosity(8.86e-6) == pytest.approx(69.48e-6, rel=1e-4)
    back = mineral_oil.viscosity_at_100_degc(mineral_oil.reference_viscosity(8.86e-6))
    assert back == pytest.approx(8.86e-6, rel=1e-9)


def test_the_reference_oil_is_continuous_where_its_pieces_meet() -> None:
    for joint in mineral_oil._ENDS:
        below, above = (mineral_oil.reference_viscosity((joint + step) * 1e-6) for step in (-1e-9, 0.0))
        assert below == pytest.approx(above, rel=2e-3)


def test_the_density_of_oil_has_the_expansion_of_the_petroleum_tables() -> None:
    assert mineral_oil.lubricating_oil_density(870.0, 288.15) == 870.0
    slope = math.log(mineral_oil.lubricating_oil_density(870.0, 289.15) / 870.0)
    assert slope == pytest.approx(-0.6278 / 870.0, rel=1e-3)


@pytest.mark.parametrize("row", rows("experiment_fluids.csv"), ids=lambda row: row["fluid"])
def test_the_fluids_of_the_experiment_are_in_the_catalog(row: dict[str, str]) -> None:
    wanted = (float(row["density_kg_m3"]), float(row["nu_mm2_s"]) * 1e-6)
    found = [fluid(entry.name) for entry in fluids() if entry.source.endswith("Table 6.3")]
    assert any((state.density, state.viscosity) == pytest.approx(wanted, rel=1e-9) for state in found)


def test_the_blends_of_the_experiment_come_out() -> None:
    expected = {2: 0.7280, 5: 0.5274, 10: 0.3756}
    for target, fraction in expected.items():
        mixed = blend("silicone oil 0.65", "silicone oil 50 (experiment)", target * 1e-6)
        assert mixed.fraction == pytest.approx(fraction, abs=5e-5)
        assert mixed.fluid.viscosity == target * 1e-6


def test_mixing_and_unmixing_are_inverse() -> None:
    thin, thick = (0.65e-6, 760.0), (50e-6, 950.0)
    for density in (None, 820.0):
        for share in np.linspace(0.0, 1.0, 11):
            nu = viscosity.blend_viscosity(share, thin, thick, density=density)
            assert viscosity.blend_fraction(nu, thin, thick, density=density) == pytest.approx(share, abs=1e-12)


def test_a_blend_is_the_same_from_either_side() -> None:
    one = blend("silicone oil 1", "silicone oil 50", 5e-6, 313.15)
    other = blend("silicone oil 50", "silicone oil 1", 5e-6, 313.15)
    assert one.fraction == pytest.approx(1.0 - other.fraction, abs=1e-12)
    assert one.fluid.density == pytest.approx(other.fluid.density, rel=1e-12)


def test_mass_shares_and_volume_shares_give_different_densities() -> None:
    mass = blend("silicone oil 0.65", "silicone oil 50 (experiment)", 5e-6)
    volume = blend("silicone oil 0.65", "silicone oil 50 (experiment)", 5e-6, basis="volume")
    assert mass.fluid.density == pytest.approx(839.3, abs=0.05)
    assert volume.fluid.density == pytest.approx(849.8, abs=0.05)


def test_measured_fluids_can_be_blended() -> None:
    measured = FluidState("oil from the shelf", 939.0, 23e-6, 298.15, "own measurement")
    mixed = blend("silicone oil 1", measured, 5e-6)
    assert 0.0 < mixed.fraction < 1.0
    with pytest.raises(QuestionError, match="give both at one temperature"):
        blend("silicone oil 1", measured, 5e-6, 313.15)


def test_names_do_not_mind_case_and_spacing() -> None:
    assert fluid("iso  vg 32") == fluid("ISO VG 32")
    assert fluid("Glycerol 62.5wt%").name == "glycerol 62.5 wt%"


@pytest.mark.parametrize(
    ("name", "temperature", "words"),
    [
        ("silicon oil 20", 298.15, "similar names: 'silicone oil 20'"),
        ("maple syrup and beer", 298.15, "no name is similar"),
        ("glycerol 120 wt%", 298.15, "no fluid is called"),
        ("silicone oil 0.65", 313.15, "known at 25 degC only, not at 40 degC"),
        ("silicone oil 23 (measured)", 293.15, "known at 25 degC only"),
        ("water", 25.0, "in K in Python|temperature is in K"),
        ("silicone oil 20", 400.0, "available from 0 degC to 100 degC"),
        ("air", math.nan, "not at nan degC"),
    ],
)
def test_unknown_fluids_and_temperatures_are_refused_in_words(name: str, temperature: float, words: str) -> None:
    with pytest.raises(CatalogError, match=words):
        fluid(name, temperature)


def test_what_does_not_mix_is_refused() -> None:
    with pytest.raises(QuestionError, match="no pair of oils"):
        blend("silicone oil 1", "ISO VG 32", 5e-6)
    with pytest.raises(QuestionError, match="no pair of oils"):
        blend("glycerol 10 wt%", "glycerol 90 wt%", 5e-6)
    with pytest.raises(QuestionError, match="mixtures of these liquids have"):
        blend("silicone oil 1", "silicone oil 50", 80e-6)
    with pytest.raises(QuestionError, match="'mass' or 'volume'"):
        blend("silicone oil 1", "silicone oil 50", 5e-6, basis="moles")  # type: ignore[arg-type]


def test_laws_refuse_what_lies_outside_their_range() -> None:
    refusals: list[Callable[[], object]] = [
        lambda: glycerol.glycerol_density(1.2, 293.15),
        lambda: glycerol.glycerol_dynamic_viscosity(0.5, 20.0),
        lambda: mineral_oil.iso_vg_viscosity(5, 313.15),
        lambda: mineral_oil.iso_vg_viscosity(32, 500.0),
        lambda: mineral_oil.reference_viscosity(1e-6),
        lambda: mineral_oil.viscosity_at_100_degc(1e-6),
        lambda: water_and_air.water_density(20.0),
        lambda: viscosity.double_log_through((300.0, 1e-6), (300.0, 2e-6)),
        lambda: viscosity.double_log_through((300.0, 1e-7), (350.0, 2e-6)),
        lambda: viscosity.blend_viscosity(1.5, (1e-6, 800.0), (2e-6, 900.0)),
    ]
    for refusal in refusals:
        with pytest.raises(QuestionError, match=r"given .*;"):
            refusal()


def test_every_fluid_names_its_source() -> None:
    names = [entry.name for entry in fluids()]
    assert len(names) == len(set(names))
    for entry in fluids():
        state = fluid(entry.name, max(entry.lowest_temperature, min(298.15, entry.highest_temperature)))
        assert state.source
        assert state.density > 0.0
        assert state.viscosity > 0.0
