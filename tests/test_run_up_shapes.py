"""Run-ups of another shape: what they are, and what a temporary reduction of the speed does to balls that friction stops."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.assembly.drive_train import corners
from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine import Reduction

MACHINE = str(Path(__file__).parents[1] / "examples/machines/discoidal.toml")
ASKED: dict[str, Any] = {
    "machine": MACHINE,
    "members": 12,
    "duration": "110 s",
    "run_up": {"speed": "1200 rpm", "rate": "40 rpm/s", "before_reduction": "10 s", "reduced_for": "15 s"},
    "vary": {"rolling_resistance": 5e-4, "run_up.reduced": ["1200 rpm", "800 rpm"]},
}


def test_a_run_up_waits_where_it_should() -> None:
    shape = Reduction(peak=100.0, reduced=60.0, end=120.0, acceleration=10.0, hold_peak=3.0, hold_reduced=2.0)
    waits = shape.model_copy(update={"dwell": 50.0, "hold_dwell": 7.0})
    plain = [(0.0, 0.0), (10.0, 100.0), (13.0, 100.0), (17.0, 60.0), (19.0, 60.0), (25.0, 120.0)]
    assert corners(shape) == plain
    assert corners(waits) == [(0.0, 0.0), (5.0, 50.0), (12.0, 50.0), *((t + 7.0, w) for t, w in plain[1:])]
    with pytest.raises(MachineError, match="hold_dwell: needs 'dwell'"):
        Reduction(peak=100.0, reduced=60.0, end=120.0, acceleration=10.0, hold_dwell=2.0)


def test_a_reduction_to_the_same_speed_is_none() -> None:
    found = ab.study({**ASKED, "members": 3, "vary": {"run_up.reduced": ["1200 rpm"]}})
    plain = {"speed": "1200 rpm", "rate": "40 rpm/s"}
    other = ab.study({**ASKED, "members": 3, "run_up": plain, "vary": {}})
    # corners where nothing happens change steps, not the motion
    np.testing.assert_allclose(found["peak_deflection"].values, other["peak_deflection"].values, rtol=1e-4)
    np.testing.assert_allclose(
        found["ball_angle_to_unbalance"].values, other["ball_angle_to_unbalance"].values, atol=1e-3
    )


def test_a_reduction_towards_the_critical_speed_lowers_the_scatter_of_rest_positions() -> None:
    found = ab.study(ASKED)
    left = found["residual_unbalance"].values.reshape(12, 2)
    assert np.ptp(left, axis=0)[1] < 0.5 * np.ptp(left, axis=0)[0]
    assert np.median(left[:, 1]) < 0.5 * np.median(left[:, 0])
    figure = ab.plot.answer(found, "rest_positions")
    assert [axes.get_title() for axes in figure.axes] == ["reduced 1200 rpm", "reduced 800 rpm"]
    dots = [line.get_offsets() for line in figure.axes[1].collections]
    drawn = np.stack([np.asarray(one)[:, 0] for one in dots], axis=1)
    np.testing.assert_allclose(drawn, found["ball_angle_to_unbalance"].values.reshape(12, 2, 2)[:, 1])


def test_a_fan_holds_the_peaks_of_its_members_and_the_way_down_mirrors_the_speed() -> None:
    plain = {"machine": MACHINE, "duration": "10 s", "members": 5, "vary": {"unbalances[1].mass": ["3 g", "6 g"]}}
    fan, found = ab.envelopes(plain, point=2, bins=500), ab.study(plain)
    own = found["peak_deflection"].values[found["point"].values == 2]
    np.testing.assert_allclose(fan["below_100"].max(), own.max(), rtol=1e-12)
    assert np.all(np.diff([fan[f"below_{percent}"] for percent in (5, 25, 50, 75, 95, 100)], axis=0) >= 0.0)
    both = ab.envelopes(plain, point=2, bins=500, coast_down=True)
    edges = np.concatenate([[0.0], both["speed"].values])  # at the ends of the intervals
    np.testing.assert_allclose(edges, edges[::-1], atol=1e-9)
    assert float(both["time"][-1]) == pytest.approx(20.0, abs=0.03)
    band = ab.plot.answer(fan).axes[1].lines[0]
    assert band.get_label() == "median"
    with pytest.raises(QuestionError, match="point: given 3; the grid has 1 to 2"):
        ab.envelopes(plain, point=3)


def test_balls_are_stalled_below_their_release_speed_and_not_above_it() -> None:
    machine = str(Path(MACHINE).with_name("stall_and_release.toml"))
    release = next(one.speed for one in ab.stability.borders(machine) if one.name == "release speed")
    speeds = [0.85 * release, 1.15 * release]
    drive = {"speed": speeds[0], "rate": 40.0}
    asked = {"machine": machine, "members": 6, "duration": "20 s", "run_up": drive, "vary": {"run_up.speed": speeds}}
    found = ab.study({**asked, "vary": {**asked["vary"], "drag": ["1.4685e-4 N*m*s", "1.6e-4 N*m*s"]}})
    own = found.isel(member=np.flatnonzero(found["drag"].values == found["drag"].values[0]))
    stalled = own["stalled"].values.reshape(6, 2)
    assert stalled[:, 0].all()
    assert not stalled[:, 1].any()
    column = next(column for column in found.columns() if column.head == "stalled")
    assert sorted(map(float, column.values)) == [0.0, 0.0, 100.0, 100.0]
    share = 100.0 * found["stalled"].values.mean()
    assert any(f"stalled at the end: a ball or the rotor in {share:.3g} %" in text for text in found.remarks())
    all_of_them = found.isel(member=own["member"].values[::2] - 1).remarks()
    assert any("100 % of the members (95 % from 61 to 100 %)" in text for text in all_of_them)
    texts = [text.get_text() for text in ab.plot.answer(found, quantity="stalled").axes[0].texts]
    assert "100\n61 to 100" in texts  # of six, Wilson (1927)
    assert found.attrs["base_machine"] == ab.machine_text(ab.load_machine(machine))


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"run_up": {"speed": "1200 rpm"}}, "run_up.rate: missing"),
        ({"run_up": {"speed": "1200 rpm", "rat": 1.0}}, "run_up.rat: unknown key; did you mean 'rate'"),
        ({"duration": "70 s"}, "duration: the run-up takes up to 75 s, and runs end after 70 s"),
        ({"vary": {"run_up.reducd": [1.0]}}, "vary.run_up.reducd: unknown key; did you mean 'reduced'"),
        ({"show": ["residual"]}, "show: given 'residual'; this study has balanced,"),
        (
            {"sudden_unbalance": {"speed": 100.0, "before": 1.0, "after": 1.0, "moment": 1e-4}},
            "sudden_unbalance: give it or .run_up.",
        ),
    ],
)
def test_a_fault_in_the_shape_is_named(changed: dict[str, Any], said: str) -> None:
    with pytest.raises(QuestionError, match=said):
        ab.study({**ASKED, **changed})
