"""How machines and results show themselves in Python and in a notebook."""

from __future__ import annotations

import pytest

import autobalancer as ab
from autobalancer.errors import MachineError
from autobalancer.stability.border import Border, Borders

DISCOIDAL = ab.example("discoidal")


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
