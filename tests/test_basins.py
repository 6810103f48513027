"""Which end state follows from which start."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.assembly.parameters import with_parameter
from autobalancer.errors import QuestionError

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
DISCOIDAL = MACHINES / "discoidal.toml"


def test_above_its_border_the_discoidal_rotor_balances_from_every_start() -> None:
    found = ab.basin(DISCOIDAL, 125.0, random=60, seed=3)
    assert float(found["share"].sel(end="balanced")) == 1.0
    assert float(found["final_deflection"].max()) < 1e-7
    assert 0.9 < float(found["share_low"].sel(end="balanced")) < 1.0


def test_below_its_critical_speed_the_balls_end_coincident_on_the_heavy_side() -> None:
    found = ab.basin(DISCOIDAL, 40.0, random=20)
    assert float(found["share"].sel(end="coincident")) == 1.0
    assert float(np.abs(np.angle(np.exp(1j * found["final_ball_angle_in_rotor"].values))).max()) < 0.3


def test_above_the_critical_speed_a_slow_run_up_stalls_the_balls_and_a_fast_one_does_not() -> None:
    machine = with_parameter(ab.load_machine(MACHINES / "stall_and_release.toml"), "unbalances[1].mass", 4.5e-3)
    found = ab.basin(machine, 330.0, {"acceleration": [5.0, 5000.0]}, hold=20.0)
    names = [found.attrs["states"][number] for number in found["state"].values]
    assert names == ["stalled", "balanced"]


def test_the_result_does_not_depend_on_the_number_of_threads() -> None:
    angles = np.linspace(-3.0, 3.0, 14)
    axes = {"ball_angle[1]": angles, "ball_angle[2]": angles}
    one, two = (ab.basin(DISCOIDAL, 100.0, axes, workers=workers) for workers in (1, 2))
    assert np.array_equal(one["state"], two["state"])
    assert np.array_equal(one["final_ball_angle_in_rotor"], two["final_ball_angle_in_rotor"])


def test_the_compiled_loop_ends_where_a_single_simulation_ends() -> None:
    machine = with_parameter(
        ab.load_machine(DISCOIDAL), "drive", {"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}}
    )
    run = ab.simulate(machine, duration=20.0)
    start = [np.deg2rad(40.0), np.deg2rad(250.0)]
    found = ab.basin(machine, 100.0, {"ball_angle[1]": start[:1], "ball_angle[2]": start[1:]})
    np.testing.assert_allclose(
        found["final_ball_angle_in_rotor"].values.ravel(), run["ball_angle_in_rotor"].values[-1], atol=2e-4
    )


def test_the_picture_shows_every_end_state_with_its_share(tmp_path: Path) -> None:
    angles = np.linspace(-3.0, 3.0, 6)
    found = ab.basin(DISCOIDAL, 100.0, {"ball_angle[1]": angles, "ball_angle[2]": angles})
    figure = ab.plot_basin(found)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert any(label.startswith("balanced") for label in labels)
    assert "deg" in figure.axes[0].get_xlabel()
    ab.save_run(found, tmp_path / "basin.nc")
    assert ab.load_run(tmp_path / "basin.nc")["state"].equals(found["state"])


@pytest.mark.parametrize(
    ("axes", "random", "message"),
    [
        ({}, 0, "one or two axes"),
        ({"ball_angle[3]": [0.0]}, 0, "no axis"),
        ({"acceleration": [-1.0]}, 0, "greater than zero"),
        ({"ball_angle[1]": []}, 0, "finite numbers"),
    ],
)
def test_questions_without_sense_are_refused(axes: dict[str, list[float]], random: int, message: str) -> None:
    with pytest.raises(QuestionError, match=message):
        ab.basin(DISCOIDAL, 100.0, axes, random=random)
