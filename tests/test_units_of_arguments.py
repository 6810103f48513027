"""Every speed, unbalance and duration that a function takes may be a text with a unit."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import autobalancer as ab
from autobalancer.errors import UnitError
from autobalancer.files.rigs import rig

PLANAR = ab.load_machine(Path(__file__).parents[1] / "examples" / "machines" / "stall_and_release.toml")
RIG = rig("rodrigues_rig")
SPEED, UNBALANCE = "4000 rpm", "100 g*mm"
IN_SI = {
    SPEED: 418.879020478639,
    "1000 rpm": 104.71975511966,
    UNBALANCE: 1e-4,
    "3000 rpm": 314.159265358979,
    "0.2 s": 0.2,
    "0.1 s": 0.1,
}

CALLS: dict[str, Callable[[Callable[[str], Any]], Any]] = {
    "stable_windows": lambda q: ab.stable_windows(PLANAR, q(SPEED), unbalance=q(UNBALANCE)),
    "border_speeds": lambda q: ab.border_speeds(PLANAR, unbalance=q(UNBALANCE)),
    "equilibria": lambda q: ab.equilibria(PLANAR, q(SPEED), unbalance=q(UNBALANCE))["growth_rate"].values.tolist(),
    "eigenvalues": lambda q: str(ab.eigenvalues(PLANAR, [q(SPEED)], unbalance=q(UNBALANCE)).data_vars),
    "unbalance_response": lambda q: ab.unbalance_response(RIG, [q("3000 rpm"), q(SPEED)], unbalance=q(UNBALANCE))[
        "semi_major"
    ].values.tolist(),
    "response_peaks": lambda q: str(
        ab.response_peaks(RIG, lowest=q("1000 rpm"), highest=q("3000 rpm"), unbalance=q(UNBALANCE)).data_vars
    ),
    "eigenfrequencies": lambda q: ab.eigenfrequencies(RIG, q(SPEED))["frequency"].values.tolist(),
    "frequency_response": lambda q: ab.frequency_response(RIG, [q(SPEED)], dwell=q("0.2 s"), window=q("0.1 s"))[
        "amplitude"
    ].values.tolist(),
    "suitable_bearings": lambda q: len(ab.suitable_bearings(q(UNBALANCE))),
    "sweep": lambda q: ab.sweep(PLANAR, {"unbalances[1].mass": ["4 g"]}, duration=q("0.2 s"))[
        "peak_deflection"
    ].values.tolist(),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_text_with_a_unit_is_the_same_as_its_number(name: str) -> None:
    assert repr(CALLS[name](str)) == repr(CALLS[name](IN_SI.__getitem__))


@pytest.mark.parametrize("name", CALLS)
def test_what_is_no_such_quantity_is_refused_by_the_name_of_the_argument(name: str) -> None:
    def wrong(_: str) -> str:
        return "3 kg"

    with pytest.raises(UnitError, match=r"^[a-z_]+(\[1\])?: given '3 kg', but a quantity in "):
        CALLS[name](wrong)
