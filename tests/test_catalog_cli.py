"""The catalog on the command line: what it prints is what the functions return."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys

import pytest
from click.testing import CliRunner
from typer.main import get_command

from autobalancer.catalog.product_tables import blend, fluid, fluids, friction, materials, suitable_bearings
from autobalancer.cli.main import app as whole
from autobalancer.errors import AutobalancerError, CatalogError, UnitError
from autobalancer.laws.capabilities import capability

app = get_command(whole).commands["catalog"]  # type: ignore[attr-defined]
RUNNER = CliRunner(env={"COLUMNS": "160"})


def run(*arguments: str) -> str:
    result = RUNNER.invoke(app, list(arguments), catch_exceptions=False)
    assert result.exit_code == 0
    return re.sub(r"\x1b\[[0-9;]*m", "", result.output)  # some terminals are given colors


def test_bearings_prints_what_suitable_bearings_finds() -> None:
    answer = json.loads(run("bearings", "--unbalance", "594 g*mm", "--max-outer", "80 mm", "--json", "--limit", "0"))
    found = suitable_bearings(594e-6, max_outer=0.08)
    assert [row["bearing"]["designation"] for row in answer] == [choice.bearing.designation for choice in found]
    assert [row["count"] for row in answer] == [choice.count for choice in found]


def test_bearings_without_an_unbalance_lists_all() -> None:
    assert len(json.loads(run("bearings", "--json", "--limit", "0"))) == 412
    assert "412 bearings, 20 shown" in run("bearings")


def test_bearings_marks_reconstructed_rows() -> None:
    text = run("bearings", "--unbalance", "594 g*mm", "--max-outer", "80 mm")
    assert "6207 *" in text
    assert "reconstructed" in text


def test_bearings_takes_material_and_fluid() -> None:
    plain = json.loads(run("bearings", "--limit", "1", "--json"))[0]["largest_capability"]
    heavy = json.loads(run("bearings", "--limit", "1", "--json", "--material", "tungsten"))[0]["largest_capability"]
    wet = json.loads(run("bearings", "--limit", "1", "--json", "--fluid", "water"))[0]["largest_capability"]
    assert heavy / plain == pytest.approx(19300.0 / 7860.0, rel=1e-12)
    assert wet / plain == pytest.approx(1.0 - fluid("water").density / 7860.0, rel=1e-12)


def test_fluids_lists_every_fluid_and_leaves_open_what_is_unknown() -> None:
    answer = json.loads(run("fluids", "--temperature", "40 degC", "--json"))
    assert [row["name"] for row in answer] == [entry.name for entry in fluids()]
    by_name = {row["name"]: row for row in answer}
    assert by_name["silicone oil 20"]["viscosity"] == fluid("silicone oil 20", 313.15).viscosity
    assert by_name["Ravenol 80W"]["viscosity"] is None
    assert "not known at 40 degC" in run("fluids", "--temperature", "40 degC")


def test_fluid_shows_one_fluid_with_its_source() -> None:
    text = run("fluid", "glycerol 50 wt%", "--temperature", "20 degC")
    assert "1126.2 kg/m^3" in text
    assert "Cheng (2008)" in text
    assert json.loads(run("fluid", "water", "--json"))["density"] == fluid("water").density


def test_blend_prints_the_share() -> None:
    arguments = ("blend", "silicone oil 1", "silicone oil 50", "--viscosity", "5 mm^2/s")
    expected = blend("silicone oil 1", "silicone oil 50", 5e-6)
    assert f"{100.0 * expected.fraction:.2f} % of silicone oil 1 by mass" in run(*arguments)
    assert json.loads(run(*arguments, "--json"))["fraction"] == expected.fraction


def test_materials_prints_densities() -> None:
    assert len(json.loads(run("materials", "--json"))) == len(materials())
    assert "7860" in run("materials")


def test_capability_prints_what_the_law_says() -> None:
    arguments = ("capability", "--orbit-radius", "77 mm", "--ball-diameter", "12.3 mm")
    answer = json.loads(run(*arguments, "--count", "2", "--fluid", "silicone oil 20", "--json"))
    assert answer["capability"] == capability(0.077, 0.0123, 7860.0, 2, fluid_density=955.0)
    assert answer["largest_useful_count"] == 20
    assert "with 20 balls; room for 39" in run(*arguments)


@pytest.mark.parametrize("command", ["bearings", "fluids", "fluid", "blend", "materials", "friction", "capability"])
def test_every_help_has_an_example(command: str) -> None:
    assert f"Example: autobalancer catalog {command}" in run(command, "--help")


@pytest.mark.parametrize(
    ("arguments", "error"),
    [
        (("bearings", "--unbalance", "5 kg"), UnitError),
        (("bearings", "--material", "unobtainium"), CatalogError),
        (("fluid", "silicone oil 0.65", "--temperature", "40 degC"), CatalogError),
        (("capability", "--orbit-radius", "77 kg", "--ball-diameter", "12 mm"), UnitError),
    ],
)
def test_a_users_error_is_an_error_of_the_package(arguments: tuple[str, ...], error: type[AutobalancerError]) -> None:
    result = RUNNER.invoke(app, list(arguments))
    assert isinstance(result.exception, error)


def test_a_users_error_ends_with_code_2_and_one_line() -> None:
    start = "from autobalancer.cli import app; app()"
    command = [sys.executable, "-c", start, "catalog", "fluid", "silicon oil 20"]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "NO_COLOR": "1"})
    assert done.returncode == 2
    assert done.stderr.startswith("autobalancer: no fluid is called 'silicon oil 20'")
    assert "Traceback" not in done.stderr


def test_the_catalog_loads_neither_scipy_nor_pint_before_it_needs_them() -> None:
    code = (
        "import sys, autobalancer as ab; ab.catalog.fluids(); ab.catalog.bearings(); ab.catalog.materials();"
        "ab.catalog.fluid('silicone oil 5');"
        "assert not {'scipy', 'pint', 'xarray', 'numba'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_every_coefficient_of_friction_names_its_source_and_what_it_was_found_on() -> None:
    found = friction()
    listed = json.loads(run("friction", "--json"))
    assert [entry["name"] for entry in listed] == [entry.name for entry in found]
    text = run("friction")
    for entry, row in zip(found, listed, strict=True):
        assert entry.name in text
        assert entry.source
        assert entry.conditions
        assert 0.0 < entry.rolling_resistance < 1.0
        assert row["adherence"] is None or row["adherence"] >= entry.rolling_resistance  # as a race demands it
        assert row["rolling_resistance"] == entry.rolling_resistance
    assert [entry.rolling_resistance for entry in found] == sorted(entry.rolling_resistance for entry in found)
