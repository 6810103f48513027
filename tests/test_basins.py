"""Which end state follows from which start."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.stability.host.stations import plane

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
DISCOIDAL = MACHINES / "discoidal.toml"
TWO_PLANES = ab.load_machine(MACHINES / "two_plane_rotor.toml")


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
    machine = with_value_at(ab.load_machine(MACHINES / "stall_and_release.toml"), "unbalances[1].mass", 4.5e-3)
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
    machine = with_value_at(
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
    figure = ab.plot.answer(found)
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert any(label.startswith("balanced") for label in labels)
    assert "(°)" in figure.axes[0].get_xlabel()
    ab.save_run(found, tmp_path / "basin.nc")
    assert ab.load_run(tmp_path / "basin.nc")["state"].equals(found["state"])


def _rough(adherence: float) -> Machine:
    friction = {"rolling_resistance": 0.5 * adherence, "adherence": adherence}
    return with_value_at(ab.load_machine(DISCOIDAL), "balancers[1].races[1].friction", friction)


def test_balls_that_friction_keeps_off_their_places_are_held_and_neither_balanced_nor_in_line() -> None:
    found = ab.basin(_rough(1e-4), 125.0, random=24, seed=3)
    assert float(found["share"].sel(end="held by friction")) > 0.9
    assert float(found["share"].sum()) == pytest.approx(1.0)
    p = plane(_rough(1e-4))
    angles = found["final_ball_angle_in_rotor"].values
    left = np.abs(p.unbalance + (p.moment * np.exp(1j * angles)).sum(axis=1))
    assert found["residual_unbalance"].values == pytest.approx(left)
    assert float(found["residual_quantile"].sel(quantile=0.5)) == pytest.approx(float(np.median(left)))
    whirl = left * 125.0**2 / abs(p.dynamic_stiffness(125.0))
    assert found["final_deflection"].values == pytest.approx(whirl, rel=1e-9)
    worst = found["final_deflection"][found.attrs["worst"]]
    assert float(found["deflection_quantile"].sel(quantile=1.0)) == pytest.approx(float(worst), rel=1e-12)
    assert found.attrs["remarks"] == []


def test_the_command_says_that_held_by_friction_is_no_verdict(tmp_path: Path) -> None:
    ab.save_machine(_rough(1e-4), tmp_path / "rough.toml")
    asked = ["basin", str(tmp_path / "rough.toml"), "--speed", "1200 rpm", "--random", "20"]
    said = " ".join(CliRunner().invoke(app, asked, catch_exceptions=False).output.split())
    assert (
        "held by friction: the balls rest where friction stops them, near balance or far from it; see the verdict"
        in said
    )
    assert said.index("see the verdict") < said.index("verdict: balanced")


def test_on_a_real_race_balls_end_where_they_do_on_a_smooth_one_after_a_run_up_and_with_the_last_unbalance() -> None:
    """Friction of 1e-12 takes the equations of any rotor, whose unbalance stands apart from that of the planar one."""
    schedule = {"time": [0.0, 1.0], "factor": [0.2, 1.0]}
    axes = {"acceleration": [100.0, 200.0]}
    smooth, rough = (
        ab.basin(machine, 100.0, axes, hold=4.0)
        for machine in (ab.load_machine(DISCOIDAL), with_value_at(_rough(1e-12), "unbalances[1].schedule", schedule))
    )
    for name, accuracy in (("final_ball_angle_in_rotor", 1e-6), ("final_deflection", 1e-9)):
        np.testing.assert_allclose(rough[name].values, smooth[name].values, rtol=0.0, atol=accuracy)


def test_with_much_friction_no_start_balances_and_without_any_the_result_says_that_balls_are_ideal() -> None:
    stuck = ab.basin(_rough(0.01), 125.0, random=40)
    assert float(stuck["share"].sel(end="balanced")) == 0.0
    worse = stuck["verdict_share"].sel(verdict=["not balanced", "worse than without balls"])
    assert float(worse.sum()) > 0.4
    ideal = ab.basin(DISCOIDAL, 125.0, random=20)
    assert float(ideal["verdict_share"].sel(verdict="balanced")) == 1.0
    assert "ideal balls" in " ".join(ideal.attrs["remarks"])


def test_the_picture_of_random_starts_with_friction_shows_the_distribution_of_the_residual() -> None:
    found = ab.basin(_rough(3e-4), 125.0, random=40, hold=5.0)  # too short for some
    figure = ab.plot.answer(found)
    states, verdicts, residual = figure.axes
    assert states.get_yticklabels()[0].get_text() == "held by friction"
    resting = found["state"].values == found.attrs["states"].index("held by friction")
    of = f"of the {resting.sum()} of 40 starts that end at rest"
    assert 0 < int(found["quantile_starts"]) == resting.sum() < 40
    drawn = {
        text.get_text(): bar.get_width() for text, bar in zip(verdicts.get_yticklabels(), verdicts.patches, strict=True)
    }
    words = found["verdict_share"].to_series() * 100.0
    assert drawn == pytest.approx(words[words > 0.0].to_dict())
    assert residual.get_xlabel().startswith(f"residual unbalance {of}")
    assert f"residual unbalance {of}, released" in " ".join(str(found).split())
    steps = residual.lines[0].get_xdata()
    assert np.allclose(np.sort(found["residual_unbalance"].values[resting]) * 1e6, np.asarray(steps))


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


def test_a_map_says_how_many_starts_overlap_and_the_verdicts_on_the_others() -> None:
    angles = np.array([0.0, 0.1, 1.0])  # balls of 12.3 mm on 76.95 mm take 0.16 rad
    found = ab.basin(_rough(3e-4), 125.0, {"ball_angle[1]": angles, "ball_angle[2]": angles})
    assert found.attrs["overlapping"] == 5
    texts = ab.plot.answer(found).legends[0]
    assert "overlapping start: 5 of 9, not counted" in [text.get_text() for text in texts.get_texts()]
    shares = {str(word): float(found["verdict_share"].sel(verdict=word)) for word in found["verdict"].values}
    assert sum(shares.values()) == pytest.approx(1.0)  # of the four that are possible
    title = texts.get_title().get_text()
    assert title.startswith("Verdict: ")
    assert all(f"{word} {100 * share:.3g} %" in title for word, share in shares.items() if share > 0.0)


def test_random_starts_never_overlap_and_are_kept() -> None:
    found = ab.basin(DISCOIDAL, 125.0, random=20)
    first, second = found["start_ball_angle_in_rotor"].values.T
    apart = np.abs(np.angle(np.exp(1j * (first - second))))
    assert apart.min() > 2.0 * np.arcsin(0.5 * 12.3 / 76.95)
    assert found.attrs["overlapping"] == 0


def test_every_start_of_two_planes_above_their_border_leaves_nothing_in_either_plane() -> None:
    found = ab.basin(TWO_PLANES, 300.0, random=4)
    assert float(found["share"].sel(end="balanced")) == 1.0
    assert found["plane"].values.tolist() == ["lower", "upper"]
    names = found.attrs["plane_states"]
    assert {names[number] for number in found["plane_state"].values.ravel()} == {"balanced"}
    needed = ab.stability.equilibria(TWO_PLANES, 300.0)["required_moment"]
    np.testing.assert_allclose(found["plane_unbalance"], needed.values.ravel(), rtol=1e-9)
    assert (found["plane_residual_unbalance"] / found["plane_unbalance"]).values.max() < 1e-3
    np.testing.assert_allclose(found["plane_residual_unbalance"].sum("plane"), found["residual_unbalance"], rtol=1e-12)


def test_a_map_over_two_planes_ends_where_single_runs_end() -> None:
    speed = 300.0
    axes = {"ball_angle[1]": [0.5, 2.5], "ball_angle[3]": [1.0]}
    machine = with_value_at(TWO_PLANES, "drive.profile", {"kind": "constant", "speed": speed})
    found = ab.basin(machine, speed, axes)
    for place, first in enumerate(axes["ball_angle[1]"]):
        moved = machine
        for number, angle in ((1, first), (2, 1.0)):
            path = f"balancers[{number}].races[1].balls[1].start_angles"
            own = machine.balancers[number - 1].races[0].balls[0].start_angles
            moved = with_value_at(moved, path, (angle, float(own[1])))
        run = ab.simulate(moved, duration=60.0, mass_spread=0.0)
        apart = found["final_ball_angle_in_rotor"].values[place, 0] - run["ball_angle_in_rotor"].values[-1]
        assert np.abs(np.angle(np.exp(1j * apart))).max() < 1e-3


def test_balls_of_two_planes_just_above_their_border_balance_or_one_plane_stalls() -> None:
    angles = np.deg2rad([-135.0, 0.0])
    found = ab.basin(TWO_PLANES, 180.0, {"ball_angle[1]": angles, "ball_angle[3]": [np.deg2rad(-18.0)]})
    ends = [found.attrs["states"][number] for number in found["state"].values.ravel()]
    assert ends == ["stalled", "balanced"]
    names = np.array(found.attrs["plane_states"])[found["plane_state"].values[:, 0]].tolist()
    assert names == [["oscillating", "stalled"], ["balanced"] * 2]  # balls of the other plane lose a turn now and then
    assert "stalled" in [text.get_text().split(" ")[0] for text in ab.plot.answer(found).legends[0].get_texts()]


def test_the_command_prints_end_states_and_residual_of_each_plane() -> None:
    asked = ["basin", str(MACHINES / "two_plane_rotor.toml"), "--speed", "300 rad/s", "--random", "2"]
    table = CliRunner().invoke(app, asked, catch_exceptions=False).output
    assert "plane lower: balanced 100 %; residual unbalance at rest" in " ".join(table.split())
    answer = json.loads(CliRunner().invoke(app, [*asked, "--json"], catch_exceptions=False).output)
    assert set(answer["planes"]) == {"lower", "upper"}
    assert answer["planes"]["upper"]["share"] == {"balanced": 1.0}
    assert answer["quantile_starts"] == {"count": 2, "of": 2, "which": "starts that end at rest"}


def test_a_start_that_a_whole_turn_has_twice_is_counted_once() -> None:
    found = ab.basin(DISCOIDAL, 125.0, {"ball_angle[1]": "-180:180 deg:4"})
    np.testing.assert_allclose(np.degrees(found["ball_angle_1"]), [-180.0, -60.0, 60.0], atol=1e-9)
