"""Parameters that change together: in maps, border curves, branches and sweeps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.references.two_balls import specials

import autobalancer as ab
from autobalancer.assembly.quantities import value_of, with_quantity
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import load_race_machine
from autobalancer.machine.path import axis_attributes
from autobalancer.plots.style import quantity_axis
from autobalancer.stability.host.stations import stations

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
STALL = with_quantity(load_race_machine(MACHINES / "stall_and_release.toml"), "unbalance", 1.6e-4)  # balls: 2.5e-4
TWO_PLANES = load_race_machine(MACHINES / "two_plane_rotor.toml")
BOTH = "ball_mass & drag"


def heavier(factor: float) -> ab.machine.Machine:
    """The machine with heavier balls and drag in proportion, one after the other."""
    return with_quantity(
        with_quantity(STALL, "ball_mass", factor * value_of(STALL, "ball_mass")),
        "drag",
        factor * value_of(STALL, "drag"),
    )


def test_joined_quantities_keep_their_proportion() -> None:
    mass = value_of(STALL, "ball_mass")
    changed = with_quantity(STALL, BOTH, 1.5 * mass)
    for name in ("ball_mass", "drag"):
        assert value_of(changed, name) == pytest.approx(1.5 * value_of(STALL, name), rel=1e-14)
    pair = "unbalances[1].moment & unbalances[2].couple"
    changed = with_quantity(TWO_PLANES, pair, "50 g*mm")
    assert changed.unbalances[0].moment == pytest.approx(5e-5)
    assert changed.unbalances[1].couple == pytest.approx(0.5 * TWO_PLANES.unbalances[1].couple)
    text = "mass of a ball (in proportion: drag torque of a ball over its speed)"
    assert axis_attributes(BOTH) == {"long_name": text, "units": "kg"}


def test_a_map_and_a_border_curve_over_joined_quantities_are_those_of_the_machines() -> None:
    mass = value_of(STALL, "ball_mass")
    found = ab.stability.map(STALL, {"speed": [300.0, 400.0], BOTH: [mass, 2.0 * mass]}, borders=0)
    curve = ab.stability.border_curve(STALL, BOTH, [mass, 2.0 * mass], only=["exact border"])
    for number, factor in enumerate((1.0, 2.0)):
        machine = heavier(factor)
        rates = ab.stability.eigenvalues(machine, [300.0, 400.0])["growth_rate"].values
        np.testing.assert_allclose(found["growth_rate"][:, number], rates, rtol=1e-9)
        (border,) = (one.speed for one in ab.stability.borders(machine) if one.name == "exact border")
        assert float(curve["exact_border"][number]) == pytest.approx(border, rel=1e-9)
    assert "ball_mass_and_drag" in found.dims


def test_the_hopf_point_along_joined_quantities_is_where_the_exact_border_is_the_speed() -> None:
    mass = value_of(STALL, "ball_mass")
    found = ab.stability.branches(STALL, BOTH, mass, 3.0 * mass, speed=280.0, orbits=False)
    points = specials(found, "Hopf")
    assert points  # the border rises from 273 to 286 rad/s
    for point in points:
        rate = ab.stability.eigenvalues(heavier(float(point["special_parameter"]) / mass), [280.0])["growth_rate"]
        assert abs(float(rate[0])) < 1e-7


def test_what_cannot_be_in_proportion_is_refused_by_name() -> None:
    with pytest.raises(QuestionError, match=r"'viscosity' has no single value"):
        with_quantity(STALL, "ball_mass & viscosity", 1e-3)
    with pytest.raises(QuestionError, match="no such name"):
        with_quantity(STALL, "ball_mass & speed", 1e-3)
    with pytest.raises(QuestionError, match="is not a parameter"):
        ab.stability.map(STALL, {"speed": [300.0], "ball_mass & colour": [1e-3]}, borders=0)


@pytest.mark.slow
def test_all_unbalances_of_a_rotor_that_tilts_change_together() -> None:
    twice = with_quantity(TWO_PLANES, "unbalance", "200 g*mm")
    np.testing.assert_allclose(stations(twice).load, 2.0 * stations(TWO_PLANES).load, rtol=1e-14)
    assert value_of(twice, "unbalance") == pytest.approx(2e-4)
    found = ab.stability.map(TWO_PLANES, {"unbalance": [1e-4, 1.2e-4], "speed": [160.0, 180.0, 250.0]}, borders=2)
    for number, size in enumerate((1e-4, 1.2e-4)):
        machine = with_quantity(TWO_PLANES, "unbalance", size)
        rates = ab.stability.eigenvalues(machine, [160.0, 180.0, 250.0])["growth_rate"].values
        np.testing.assert_allclose(found["growth_rate"][number], rates, rtol=1e-8)
    curve = ab.stability.border_curve(TWO_PLANES, "unbalance", [1e-4, 1.2e-4], only=["exact border"])
    (border,) = (one.speed for one in ab.stability.borders(machine) if one.name == "exact border")
    assert float(curve["exact_border"][1]) == pytest.approx(border, rel=1e-9)
    couple = TWO_PLANES.model_copy(update={"unbalances": TWO_PLANES.unbalances[1:]})
    with pytest.raises(QuestionError, match="no resultant"):
        with_quantity(couple, "unbalance", 1e-4)
    with pytest.raises(QuestionError, match="planar rotor"):
        ab.stability.border_curve(TWO_PLANES, "unbalance")


@pytest.mark.parametrize(
    ("name", "path", "symbol"),
    [
        ("viscosity", "balancers[1].races[1].fluid.viscosity", r"\nu"),
        ("drag", "balancers[1].races[1].drag.damping", r"\beta"),
        ("ball_mass", "balancers[2].races[1].balls[1].mass", "m"),
        ("unbalance", "unbalances[1].moment", "U"),
        ("stiffness", "rotor.stiffness", "k"),
    ],
)
def test_an_axis_has_unit_and_symbol_of_the_key_by_plain_name_and_by_path(name: str, path: str, symbol: str) -> None:
    plain, full = axis_attributes(name), axis_attributes(path)
    assert plain["symbol"] == full["symbol"] == symbol
    assert plain["units"] == full["units"] != ""
    axis = xr.DataArray([1.0, 2.0], dims=name, attrs=plain)
    assert f", ${symbol}$ (" in quantity_axis(axis, "rpm").label
