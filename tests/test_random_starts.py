"""Random starts on machines whose balls need not come to rest: an end is the verdict on its run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.system import start_angles
from autobalancer.catalog.resolve import resolve
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.random_numbers import generator
from autobalancer.studies.ensemble.members import with_starts
from autobalancer.studies.random_starts import driven_to, long_enough

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
SPEED = 125.66  # rad/s, 1200 rpm; ten times the critical speed of the drum


def _drum(moment: str = "125000 g*mm", **race: object) -> Machine:
    """A drum of 25 kg on soft supports of 2 Hz, with gravity in its plane."""
    balls = [{"count": 16, "diameter": "24 mm", "density": "7800 kg/m^3", "start_angles": [0.4 * i for i in range(16)]}]
    drag = {"law": "viscous", "damping": "5e-3 N*m*s"}
    return Machine.model_validate(
        {
            "name": "drum",
            "axis": "horizontal",
            "rotor": {
                "kind": "planar",
                "mass": "25 kg",
                "stiffness": "3950 N/m",
                "damping": "60 N*s/m",
                "inertia": 1.0,
            },
            "unbalances": [{"moment": moment}],
            "balancers": [{"races": [{"orbit_radius": "250 mm", "balls": balls, "drag": drag} | race]}],
            "drive": {"kind": "torque", "torque": "1 N*m"},
        }
    )


def test_a_horizontal_drum_balances_from_every_start_and_gravity_alone_is_left() -> None:
    found = ab.basin(_drum(), SPEED, random=4, hold=10.0)
    assert float(found["share"].sel(end="balanced")) == 1.0
    assert float(found["share_low"].sel(end="balanced")) == pytest.approx(4.0 / (4.0 + 1.959964**2))  # Wilson at n of n
    assert float(found["unbalance"]) == pytest.approx(0.125)
    assert found["residual_unbalance"].values.max() < 0.01 * 0.125
    middle = float(found["vibration_quantile"].sel(quantile=0.5))
    assert middle == pytest.approx(float(np.median(found["vibration"])))
    assert np.unique(found["vibration"]).size == 4  # every start is another one


def test_each_start_is_the_ordinary_run_of_its_seed_with_the_verdict_of_that_run() -> None:
    machine = driven_to(_drum(), SPEED, 0.0)
    found = ab.basin(_drum(), SPEED, random=2, seed=7, hold=10.0)
    run = ab.simulate(machine, duration=10.0, seed=int(found["seed"][1]), tolerance=1e-6)
    assert ab.verdict(run).word == found.attrs["states"][int(found["state"][1])]
    assert ab.verdict(run).residual == pytest.approx(float(found["residual_unbalance"][1]), rel=0.02)


def test_every_start_leaves_what_exceeds_the_capability() -> None:
    capability = ab.check(_drum()).capability
    moment = 1.5 * capability
    found = ab.basin(_drum(f"{moment} kg*m"), SPEED, random=3, hold=10.0)
    assert float(found["share"].sel(end="partly balanced")) == 1.0
    # contact gives way: balls pressed together are up to 0.6 % closer than balls side by side
    assert found["residual_unbalance"].values == pytest.approx(moment - capability, rel=0.01)


def test_without_gravity_the_verdicts_are_those_of_the_planar_rule() -> None:
    discoidal = ab.load_machine(MACHINES / "discoidal.toml")
    planar = ab.basin(discoidal, SPEED, random=6)
    horizontal = with_value_at(with_value_at(discoidal, "axis", "horizontal"), "gravity", 1e-9)
    found = ab.basin(horizontal, SPEED, random=6)
    assert "stalled" in planar.attrs["states"]
    assert "stalled" not in found.attrs["states"]
    for word in ("balanced", "partly balanced", "not balanced"):
        assert float(found["share"].sel(end=word)) == float(planar["verdict_share"].sel(verdict=word))


def test_a_ball_that_no_axis_names_starts_where_the_seed_puts_it_where_ends_are_verdicts_too() -> None:
    place = "balancers[1].races[1].balls[1].start_angles"
    free, axis = with_value_at(_two_balls(), place, None), {"ball_angle[1]": [2.0, 2.5]}
    drawn = start_angles(resolve(free), generator(4))
    known = with_value_at(free, place, drawn)
    one, other = (ab.basin(machine, SPEED, axis, seed=4, hold=1.0) for machine in (free, known))
    assert one["vibration"].values == pytest.approx(other["vibration"].values, rel=1e-12)
    elsewhere = ab.basin(free, SPEED, axis, seed=5, hold=1.0)
    assert one["vibration"].values != pytest.approx(elsewhere["vibration"].values, rel=1e-6)


def test_two_planes_balance_above_both_critical_speeds_and_make_it_worse_below() -> None:
    machine = ab.load_machine(MACHINES / "two_plane_rotor.toml")
    above = ab.basin(machine, "4000 rpm", random=2)
    below = ab.basin(machine, "500 rpm", random=2)
    assert float(above["verdict_share"].sel(verdict="balanced")) == 1.0
    assert float(below["verdict_share"].sel(verdict="worse than without balls")) == 1.0
    slowest = -ab.stability.equilibria(machine, "4000 rpm")["growth_rate"].values
    assert long_enough(machine, 418.9) == pytest.approx(10.0 / slowest[slowest > 0.0].min(), rel=1e-3)


def test_the_last_unbalance_counts_from_the_start() -> None:
    schedule = {"time": [5.0, 5.0], "factor": [0.0, 1.0]}
    late = with_value_at(_drum(), "unbalances[1].schedule", schedule)
    found, steady = (ab.basin(machine, SPEED, random=2, hold=2.0) for machine in (late, _drum()))
    assert found["vibration"].values == pytest.approx(steady["vibration"].values)


def test_the_picture_has_bars_of_verdicts_and_both_distributions() -> None:
    found = ab.basin(_drum(), SPEED, random=3, hold=10.0)
    figure = ab.plot.answer(found)
    bars, residual, vibration = figure.axes
    assert [text.get_text() for text in bars.get_yticklabels()] == ["balanced"]
    assert residual.get_xlabel() == "residual unbalance (g mm)"
    assert vibration.get_xlabel() == "vibration (µm)"
    assert np.sort(found["vibration"]) * 1e6 == pytest.approx(np.asarray(vibration.lines[0].get_xdata(), float))


def test_a_slow_run_up_stalls_from_every_start_and_a_fast_one_balances_most() -> None:
    machine = with_value_at(ab.load_machine(MACHINES / "stall_and_release.toml"), "unbalances[1].mass", 4.5e-3)
    slow, fast = (ab.basin(machine, 330.0, random=8, acceleration=rate, hold=20.0) for rate in (5.0, 5000.0))
    assert float(slow["share"].sel(end="worse than without balls")) == 1.0
    assert float(slow["moving_share"]) == float(slow["stalled_share"]) == 1.0  # stalled balls circle in the rotor
    assert np.isnan(slow["residual_unbalance"]).all(), "the resultant of balls that circle is no residual"
    assert float(slow["unbalance"]) == pytest.approx(4.5e-3 * float(machine.unbalances[0].radius))
    assert "balls still move at the end of 100 % of the runs, stalled in 100 %" in slow.remarks()
    assert any(text.startswith("residual unbalance: none, in each run a ball is stalled") for text in slow.remarks())
    rests = np.isfinite(fast["residual_unbalance"].values)
    assert int(fast["residual_starts"]) == rests.sum()
    assert float(fast["residual_quantile"][2]) == fast["residual_unbalance"].values[rests].max()
    assert float(fast["share"].sel(end="balanced")) > 0.5
    assert slow.attrs["released"] == "after run-ups"
    held = ab.simulate(driven_to(machine, 330.0, 66.0), duration=66.0, hold_balls=True)
    assert float(slow["peak_without_balls"]) == pytest.approx(
        float(ab.run_measures(held, "peak_deflection")["deflection"]), rel=0.01
    )
    assert float(slow["peak_deflection"].min()) > float(fast["peak_deflection"].max())
    assert float(slow["peak_quantile"].sel(quantile=1.0)) == float(slow["peak_deflection"].max())


@pytest.mark.parametrize("acceleration", [None, 100.0])
def test_the_machine_of_the_worst_start_repeats_its_run(acceleration: float | None, tmp_path: Path) -> None:
    found = ab.basin(_drum(), SPEED, random=3, seed=4, acceleration=acceleration, hold=3.0)
    worst = found.attrs["worst"]
    by = "peak_deflection" if acceleration and (found["state"] == 0).all() else "vibration"
    assert found.attrs["worst_by"] == by
    assert float(found[by][worst]) == float(found[by].max())
    ab.save_machine(ab.worst_start(found), tmp_path / "worst.toml")
    run = ab.simulate(tmp_path / "worst.toml", seed=int(found["seed"][worst]), tolerance=1e-6)
    assert float(run["time"][-1]) == pytest.approx(
        float(found.attrs["hold"]) + (SPEED / 100.0 if acceleration else 0.0)
    )
    places = ab.run_measures(run, "vibration")["greatest"].values
    assert places.max() == pytest.approx(float(found["vibration"][worst]), rel=1e-6)


def test_the_worst_start_of_a_planar_machine_keeps_the_angles_that_were_drawn() -> None:
    found = ab.basin(MACHINES / "discoidal.toml", SPEED, random=5, hold=0.2)
    machine = ab.worst_start(found)
    drawn = found["start_ball_angle_in_rotor"].values[np.argmax(found["final_deflection"].values)]
    assert machine.balancers[0].races[0].balls[0].start_angles == pytest.approx(tuple(drawn))
    run = ab.simulate(machine)
    assert run["ball_angle_in_rotor"].values[0] == pytest.approx(drawn)
    assert float(run["speed"][-1]) == pytest.approx(SPEED)
    with pytest.raises(QuestionError, match="not a result of basin"):
        ab.worst_start(run)


def test_the_picture_of_run_ups_has_the_peaks_beside_the_one_without_balls() -> None:
    found = ab.basin(_drum(), SPEED, random=3, acceleration=100.0, hold=2.0)
    peaks = ab.plot.answer(found).axes[-1]
    assert peaks.get_xlabel() == "greatest deflection on the way (mm)"
    assert np.sort(found["peak_deflection"]) * 1e3 == pytest.approx(np.asarray(peaks.lines[0].get_xdata(), float))
    assert np.asarray(peaks.lines[1].get_xdata(), float) == pytest.approx(1e3 * float(found["peak_without_balls"]))


def test_below_the_speed_at_which_balls_fall_a_note_says_that_they_are_guided() -> None:
    found = ab.basin(_drum(), SPEED, random=2, acceleration=20.0, hold=1.0)
    assert "59.8 rpm" in " ".join(found.attrs["remarks"])  # sqrt(g/r)
    assert "would make balls fall" not in " ".join(ab.basin(_drum(), SPEED, random=2, hold=1.0).attrs["remarks"])


def _two_balls() -> Machine:
    balls = [{"count": 2, "diameter": "24 mm", "density": "7800 kg/m^3", "start_angles": [0.4, 3.0]}]
    return with_value_at(_drum("4000 g*mm"), "balancers[1].races[1].balls", balls)


def test_a_map_over_starts_with_gravity_is_of_ordinary_runs_and_equal_balls_can_change_places() -> None:
    machine, angles = _two_balls(), [0.0, 1.5, 3.0]
    found = ab.basin(machine, SPEED, {"ball_angle[1]": angles, "ball_angle[2]": angles}, hold=1.0)
    states = found["state"].values
    assert (states == states.T).all()
    assert found["residual_unbalance"].values[0, 2] == pytest.approx(found["residual_unbalance"].values[2, 0], rel=1e-5)
    assert found.attrs["overlapping"] == 3  # a ball on the other
    assert [found.attrs["states"][number] for number in np.diag(states)] == ["overlapping start"] * 3
    assert float(found["share"].sum()) == pytest.approx(1.0)
    own = with_starts(driven_to(machine, SPEED, 0.0, drawn=False), {"ball_angle[1]": 1.5, "ball_angle[2]": 3.0})
    run = ab.simulate(own, duration=1.0, tolerance=1e-6, save=[ab.Envelope(500), ab.LastRevolutions()])
    assert found.attrs["states"][states[1, 2]] == ab.verdict(run).word
    assert found["peak_deflection"].values[1, 2] == float(ab.run_measures(run)["peak_deflection"])


def test_a_map_over_accelerations_has_the_run_up_of_each() -> None:
    machine, rates = _two_balls(), [40.0, 20.0]
    found = ab.basin(machine, SPEED, {"acceleration": rates}, hold=0.5)
    alone = ab.basin(machine, SPEED, {"ball_angle[1]": [0.4]}, acceleration=20.0, hold=0.5)
    assert found["acceleration"].values.tolist() == rates
    assert found["peak_deflection"].values[1] == alone["peak_deflection"].values[0]
    assert found["peak_deflection"].values[0] != found["peak_deflection"].values[1]


def test_starts_that_cannot_be_and_questions_without_a_verdict_are_refused_with_what_to_do() -> None:
    with pytest.raises(QuestionError, match=r"no axis 'ball_angle\[3\]'; there are ball_angle\[1\] to ball_angle\[2\]"):
        ab.basin(_two_balls(), SPEED, {"ball_angle[3]": [0.0, 1.0]})
    with pytest.raises(QuestionError, match="no unbalance"):
        ab.basin(_drum("0 g*mm"), SPEED, random=2, hold=1.0)


def test_for_a_deep_chamber_the_command_with_seeds_is_named() -> None:
    for chamber in (MACHINES / "deep_chamber.toml", ab.load_machine(MACHINES / "deep_chamber.toml")):
        with pytest.raises(QuestionError, match=r"chamber amplitudes FILE .* --seeds 50"):
            ab.basin(chamber, SPEED, random=2)  # type: ignore[arg-type]


def test_the_command_prints_shares_with_their_interval_and_what_is_left(tmp_path: Path) -> None:
    path = tmp_path / "drum.toml"
    ab.save_machine(_drum(), path)
    asked = ["basin", str(path), "--speed", "1200 rpm", "--random", "2", "--hold", "10 s"]
    table = CliRunner().invoke(app, asked)
    assert table.exit_code == 0, table.output
    assert "balanced  100.00  34.24" in " ".join(table.output.split("\n")).replace("   ", "  ")
    assert "in this interval with a probability of 95 %" in " ".join(table.output.split())
    answer = json.loads(CliRunner().invoke(app, [*asked, "--json"]).output)
    assert answer["worst_start"]["number"] in (1, 2)
    assert answer["share"]["balanced"] == 1.0
    assert answer["vibration"]["1.0"] < 0.1 * answer["vibration_without_balls"]


def test_the_command_keeps_the_worst_start_and_says_how_to_run_it_again(tmp_path: Path) -> None:
    path, worst = tmp_path / "drum.toml", tmp_path / "worst.toml"
    ab.save_machine(_drum(), path)
    asked = ["basin", str(path), "--speed", "1200 rpm", "--hold", "2 s", "--acceleration", "100 rad/s^2"]
    told = CliRunner().invoke(app, [*asked, "--random", "2", "--worst", str(worst)])
    assert told.exit_code == 0, told.output
    text = " ".join(told.output.split())
    assert "2 runs, random starts of seed 0; none puts balls on top of each other" in text
    assert "greatest deflection on the way, after run-ups: median" in text
    number = int(text.partition("worst start: number ")[2][0])
    assert number in (1, 2)
    assert f"run it again: autobalancer simulate {worst} --seed {number - 1}" in text
    assert ab.load_machine(worst).description.startswith(f"Start {number} of 2 random starts")
    short = CliRunner().invoke(app, [*asked[:4], "--hold", "3 s", "--random", "1"])
    assert "give a longer --hold" in " ".join(short.output.split())
    assert ab.load_machine(worst).drive.profile.kind == "ramp"
    refused = CliRunner().invoke(app, [*asked, "--x", "ball_angle[1]=0 deg:90 deg:2", "--worst", str(worst)])
    assert "--worst: the worst is one of random starts" in refused.output + str(refused.exception)
