"""How machines and results show themselves in Python and in a notebook."""

from __future__ import annotations

import copy
import csv
import sys
from inspect import signature
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.errors import MachineError
from autobalancer.plots.answer import PICTURES
from autobalancer.stability.border import Border, Borders

SAMPLES = Path(__file__).resolve().parent.parent / "examples" / "machines"
DISCOIDAL, RIGID = ab.example("discoidal"), ab.example("rigid_rotor")


def test_a_machine_shows_itself_in_a_line() -> None:
    shown = repr(DISCOIDAL)
    assert shown == str(DISCOIDAL)
    assert len(shown) < 200
    assert shown.startswith(
        "<Machine 'Discoidal rotor, planar stand-in': rotor: planar, vertical axis, balls: 2 in 1 race"
    )
    assert "<td>planar, vertical axis</td>" in DISCOIDAL._repr_html_()


def test_borders_are_a_tuple_that_shows_itself_as_a_table() -> None:
    found = ab.stability.borders(DISCOIDAL)
    assert isinstance(found, tuple)
    lines = repr(found).splitlines()
    assert lines[0].split() == ["border", "rad/s", "rpm", "note"]
    assert len(lines) == 1 + len(found)
    assert "<th>rpm</th>" in found._repr_html_()
    two = Borders([Border("exact border", float("inf"), "a < b"), Border("release speed", 100.0, "")])
    assert "never" in repr(two)
    assert "954.93" in repr(two)
    assert "a &lt; b" in two._repr_html_()


def test_a_summary_and_suitable_bearings_show_themselves_as_tables() -> None:
    shown = repr(ab.check(DISCOIDAL))
    assert shown.startswith("Discoidal")
    assert "critical speed" in shown
    assert max(map(len, repr(ab.catalog.suitable_bearings("600 g*mm", max_outer=0.2)).splitlines())) < 80
    assert "<th>bearing</th>" in ab.catalog.suitable_bearings("600 g*mm")._repr_html_()
    assert repr(ab.catalog.suitable_bearings("600 kg*m")) == "()"


def test_a_machine_that_is_changed_in_place_says_how_to_change_it() -> None:
    with pytest.raises(MachineError, match=r"Machine\.axis: given 'horizontal'; a machine is not changed in place"):
        DISCOIDAL.axis = "horizontal"
    with pytest.raises(MachineError, match=r"PlanarRotor\.mass: given 3"):
        DISCOIDAL.rotor.mass = 3


def test_answers_are_datasets_that_show_themselves_as_tables() -> None:
    modes = ab.rotor.modes(RIGID)
    assert isinstance(modes, xr.Dataset)
    first, head, row, *_ = repr(modes).splitlines()
    assert first == "Rigid rotor: natural frequencies at 0 rpm (0 rad/s)"
    assert head.split("  ")[0] == "mode"
    assert "frequency (Hz)" in head
    assert f"{float(modes['frequency'][0]) / (2.0 * np.pi):.5g}" in row
    assert "dataset in SI over mode (4)" in repr(modes)
    assert repr(modes).startswith(modes.told())
    assert "dataset in SI" not in modes.told()
    assert "<th>frequency (Hz)</th>" in modes._repr_html_()
    assert "xr-header" in modes._repr_html_(), "xarray's own view can be opened below the table"
    for found, text in (
        (ab.rotor.critical_speeds(RIGID), "cylindrical forward"),
        (ab.rotor.campbell(RIGID, "0:6000 rpm:13"), "4 branches from 0 rpm"),
        (ab.rotor.response(RIGID, "600:6000 rpm:9"), "lower bearing"),
        (ab.stability.equilibria(DISCOIDAL, 90.0), "coincident"),
        (ab.run_measures(ab.simulate(DISCOIDAL, duration=0.05, progress=False)), "peak_deflection"),
    ):
        assert text in repr(found)
        assert "<xarray" not in repr(found)


def test_a_part_of_an_answer_without_its_table_is_shown_as_xarray_does() -> None:
    modes = ab.rotor.modes(RIGID)
    for part in (modes.isel(mode=0), modes[["frequency"]], modes.drop_vars("whirl")):
        assert repr(part).startswith("<xarray.")
    assert repr(modes.drop_attrs()).startswith("<xarray."), "nothing says what it answers"
    assert repr(copy.deepcopy(modes)) == repr(modes.copy()) == repr(modes)
    assert len(repr(modes.isel(mode=[0] * 1000)).splitlines()) < 40


def test_python_and_the_command_line_show_the_same_table(tmp_path: Path) -> None:
    ab.save_machine(DISCOIDAL, tmp_path / "m.toml")
    said = CliRunner().invoke(app, ["eigenvalues", str(tmp_path / "m.toml"), "--speeds", "600:1200 rpm:7", "--csv"])
    lines = list(csv.reader(said.stdout.splitlines()))
    found = ab.stability.ranges(DISCOIDAL, ab.stability.eigenvalues(DISCOIDAL, "600:1200 rpm:7"))
    head, *rows = repr(found).splitlines()[: 1 + found.sizes["range"]]
    assert [cell.replace("[", "(").replace("]", ")") for cell in lines[0]] == [
        part.strip() for part in head.split("  ") if part
    ]
    assert [row.split()[2] for row in rows] == [line[2] for line in lines[1:]] == ["unstable", "stable"]


def test_a_sweep_shows_its_runs_and_branches_show_where_they_are_stable() -> None:
    swept = ab.sweep(DISCOIDAL, {"viscosity": ["5 mm^2/s", "20 mm^2/s"], "unbalance": ["594 g*mm"]}, duration="0.5 s")
    assert (swept.columns()[0].head, swept.columns()[0].unit) == ("kinematic viscosity of the fluid", "mm²/s")
    shown = [line for line in repr(swept).splitlines() if line[:1].isdigit()]
    assert [row.split()[:2] for row in shown] == [["5", "594"], ["20", "594"]]
    assert max(map(len, repr(swept).splitlines()[1:])) <= 130, "heads of a wide table are broken"
    assert repr(swept.isel(viscosity=0, unbalance=0)).startswith("<xarray.")
    branches = ab.stability.branches(DISCOIDAL, "speed", 64.0, 70.0, switch=False, orbits=False)
    assert "621.47 to 668.451" in repr(branches)
    assert branches.isel(point=branches["branch"].values == 2).branch_rows() == []
    for part in (branches.drop_attrs(), branches[["parameter"]]):
        assert repr(part).startswith("<xarray.")


class ZMQInteractiveShell:
    """What IPython calls the shell of a notebook."""


def test_in_a_notebook_machines_and_answers_show_a_picture_too(monkeypatch: pytest.MonkeyPatch) -> None:
    things = [
        DISCOIDAL,
        ab.load_machine(SAMPLES / "deep_chamber.toml"),
        Borders([Border("exact border", 61.0, ""), Border("release speed", float("inf"), "")]),
        ab.rotor.campbell(RIGID, "0:6000 rpm:13"),
    ]
    for thing in things:
        assert "<img" not in thing._repr_html_()
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=ZMQInteractiveShell, version_info=(9, 0)))
    for thing in things:
        shown = thing._repr_html_()
        assert '<img src="data:image/png;base64,iVBOR' in shown
        assert 'alt="' in shown
        assert "<table>" in shown


def test_every_picture_of_an_answer_needs_nothing_but_the_answer() -> None:
    assert len(PICTURES) > 60
    for name, picture in PICTURES.items():
        first, *others = signature(picture.draw).parameters.values()
        assert first.kind is not first.KEYWORD_ONLY
        assert all(other.default is not other.empty for other in others), name
