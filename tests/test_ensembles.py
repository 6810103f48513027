"""Ensembles: thousands of members of one machine, each as it would be alone."""

from __future__ import annotations

import json
import re
import signal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import MachineError, QuestionError
from autobalancer.kernels.system import BALLS
from autobalancer.machine.path import dimension_of
from autobalancer.random_numbers import wilson_interval
from autobalancer.results.measure_table import PER_BALL
from autobalancer.studies.ensemble import members as follow
from autobalancer.studies.ensemble.columns import columns_of
from autobalancer.studies.ensemble.layout import ASKABLE, Plan
from autobalancer.studies.ensemble.members import Members, with_starts, without_start_angles

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
STALL, PINS = MACHINES / "stall_and_release.toml", MACHINES / "variant_pins.toml"
END, TOLERANCE = 1.0, 1e-6
DRAG = [1e-4, 2e-4, 4e-4]


def alone(machine: Any, seed: int = 0, end: float = END) -> Any:
    """An ordinary run that keeps what a member keeps."""
    return ab.simulate(
        machine, duration=end, seed=seed, tolerance=TOLERANCE, save=[ab.Envelope(20), ab.LastRevolutions()]
    )


def members(machine: Any, columns: Any, **more: Any) -> Any:
    return ab.ensemble(machine, columns, duration=END, tolerance=TOLERANCE, bins=20, keep_states=True, **more)


def same(found: Any, number: int, run: Any) -> None:
    """The member is the run, digit for digit."""
    measured = ab.run_measures(run)
    assert found["steps"].values[number] == run.attrs["steps"]
    for name in ("peak_deflection", "peak_speed", "time_near_peak", "residual_vibration"):
        assert found[name].values[number] == float(measured[name]), name
    if "final_ball_angle_to_unbalance" in measured:
        assert found[PER_BALL].values[number].tolist() == measured["final_ball_angle_to_unbalance"].values.tolist()
    end = found["final_state"].values[number][BALLS : BALLS + run.sizes["ball"]]
    assert end == pytest.approx(run["envelope_ball_angle_in_rotor"].values[-1], rel=1e-13)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("drag", DRAG[:2]),
        ("unbalance", [3e-4, "6000 g*mm"]),
        ("unbalance", [0.0, 3e-4]),
        ("rotor.mass", [9.0, 11.0]),
        ("damping", [80.0, 150.0]),
        ("ball_mass", [2e-3, 3e-3]),
        ("drive.gain", [0.8, 1.2]),
        ("balancers[1].races[1].orbit_radius", [0.09, 0.11]),
    ],
)
def test_a_member_is_the_run_of_its_machine_digit_for_digit(name: str, values: list[Any]) -> None:
    found = members(STALL, {name: values})
    for number, value in enumerate(values):
        same(found, number, alone(ab.with_parameter(ab.load_machine(STALL), name, value)))


def test_start_angles_and_speeds_are_columns_too() -> None:
    columns = {"ball_angle[1]": ["10 deg", 0.35], "ball_angle[2]": 3.0, "ball_speed": [0.0, -5.0]}
    found = members(STALL, columns)
    machine = with_starts(ab.load_machine(STALL), {"ball_angle[1]": 0.35, "ball_angle[2]": 3.0, "ball_speed": -5.0})
    same(found, 1, alone(machine))
    assert found["start_ball_angle_in_rotor"].values[1] == pytest.approx([0.35, 3.0])


def test_seeds_draw_the_starts_as_an_ordinary_run_does() -> None:
    text = STALL.read_text().replace('start_angles = ["60 deg", "-110 deg"]', "")
    found = members(ab.load_machine(STALL), {"drag": DRAG[:2]}, seeds=2, seed=7)
    assert found["seed"].values.tolist() == [7, 8, 7, 8]
    free = ab.parse_machine(text)
    same(found, 3, alone(ab.with_parameter(free, "drag", DRAG[1]), seed=8))


@pytest.mark.parametrize(
    "name", ["rigid_rotor", "real_race", "resolved_balls", "variant_partitions", "two_plane_rotor"]
)
def test_a_member_of_every_kind_of_rotor_and_ball_is_its_run(name: str) -> None:
    machine = ab.load_machine(MACHINES / f"{name}.toml")
    end = 0.2
    found = ab.ensemble(
        machine, {"unbalances[1].angle": [0.1, 0.2]}, duration=end, tolerance=TOLERANCE, bins=20, keep_states=True
    )
    same(found, 1, alone(ab.with_parameter(machine, "unbalances[1].angle", 0.2), end=end))


DISCOIDAL, RACE, RIGID, TWO_PLANES = (
    MACHINES / f"{name}.toml" for name in ("discoidal", "real_race", "rigid_rotor", "two_plane_rotor")
)
FIRST_RACE, HEAVY = "balancers[1].races[1]", [7000.0, 7500.0, 8000.0]
TIMES = ["0 s", "4 s", "60 s"], ["0 s", "6 s", "80 s"], ["0 s", "7 s", "90 s"]


@pytest.mark.parametrize(
    ("columns", "seeds", "machine"),
    [
        ({"drag": [1e-4, 2e-4, 3e-4], "unbalances[1].mass": [2e-3, 4e-3, 5e-3]}, None, STALL),
        ({"balancers[1].races[1].drag.damping": [1e-4, 2e-4, 3e-4], "unbalance": [2e-4, 3e-4, 4e-4]}, None, STALL),
        ({"drag": [1e-4, 2e-4]}, 3, STALL),
        (
            {"ball_angle[1]": [0.1, 0.2, 5.0], "ball_angle[2]": [1.0, 4.0, 2.0], "ball_speed[1]": [0.0, 1.0, 2.0]},
            None,
            STALL,
        ),
        ({"viscosity": ["10 mm^2/s", 2e-5, 3e-5], "unbalances[1].mass": [2e-3, 4e-3, 5e-3]}, 2, DISCOIDAL),
        (
            {"balancers[1].races[1].drag.cd_times_re": [300.0, 350.0, 400.0], "drive.profile.time": TIMES},
            None,
            DISCOIDAL,
        ),
        ({"rotor.mass": [9.0, 10.0, 12.0], "stiffness": [1e5, 6e5, 9e6], "unbalance": [2e-4, 3e-4, 4e-4]}, None, STALL),
        ({"damping": [80.0, 90.0, 100.0], "drag": [1e-4, 2e-4, 3e-4], "rotor.inertia": [0.04, 0.05, 0.06]}, 2, STALL),
        ({"temperature": ["15 degC", "25 degC", "35 degC"], "rotor.mass": [12.0, 12.2, 12.4]}, 2, DISCOIDAL),
        ({f"{FIRST_RACE}.eccentricity": [0.0, 1e-5, 2e-5], f"{FIRST_RACE}.balls[1].density": HEAVY}, 2, DISCOIDAL),
        ({"rolling_resistance": [1e-4, 2e-4, 3e-4]}, 2, RACE),
        ({"ball_diameter": [0.012, 0.0121, 0.0122], "unbalances[1].angle": [0.1, 0.2, 0.3]}, 2, DISCOIDAL),
        ({f"{FIRST_RACE}.orbit_radius": [0.09, 0.1, 0.11]}, None, STALL),
        ({"unbalances[1].angle": [0.1, 0.2, 0.3], "drag": [1e-4, 2e-4, 3e-4]}, None, RIGID),
        ({"drive.profile.duration": [5.0, 6.1, 7.3], "unbalances[1].moment": [1e-4, 2e-4, 3e-4]}, None, RIGID),
        ({"ball_mass": [3e-3, 4e-3, 5e-3], "rotor.supports[1].stiffness": [1e5, 1.1e5, 1.2e5]}, 2, RIGID),
        ({"rotor.supports[2].damping": [50.0, 60.0, 70.0], "unbalances[1].moment": [1e-4, 2e-4, 3e-4]}, 2, RIGID),
        ({f"{FIRST_RACE}.balls[1].density": HEAVY, "ball_angle[1]": [0.0, 1.0, 4.0]}, None, TWO_PLANES),
        ({"ball_diameter": [0.009, 0.01, 0.011], "unbalances[2].couple": [1e-5, 2e-5, 3e-5]}, 2, TWO_PLANES),
        ({f"{FIRST_RACE}.eccentricity": [0.0, 1e-5, 2e-5], "rotor.mass": [4.9, 5.0, 5.1]}, None, TWO_PLANES),
    ],
)
def test_numbers_that_follow_an_assembled_member_are_those_of_an_assembly(
    columns: Any, seeds: int | None, machine: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = without_start_angles(ab.load_machine(machine)) if seeds else ab.load_machine(machine)
    given = columns_of(machine, columns)
    drawn = None if seeds is None else np.arange(seeds)
    asked, made = Members(machine, given, drawn, 0, "member"), list[int]()
    ready = asked.ready
    monkeypatch.setattr(asked, "ready", lambda number, *given: made.append(number) or ready(number, *given))
    blocks = []
    for quick in (True, False):
        (group,) = asked._sorted(Plan(END, 1e-6, 20, 100), "refuse", follow=quick)[0].all
        words = group.words(range(len(group.numbers)), places := group.places())
        blocks.append(np.tile(group.fresh, (asked.count, 1)))
        blocks[-1][np.ix_(group.numbers, places)] = words
    assert (blocks[0] == blocks[1]).all()
    sample = (
        [0, 0, 1] if given.parameters else [0, 1]
    )  # assembled all the same, so that members that follow are compared
    assert made == [*sample, *range(asked.count)]


@pytest.mark.parametrize("columns", [{"count": [2, 3, 4]}, {"rotor.stiffness": [4e4, [4e4, 5e4], 5e4]}])
def test_members_that_differ_in_more_than_numbers_are_assembled(columns: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of balls says how many numbers a run has, and the axes depend on whether the springs are alike."""
    _are_assembled(DISCOIDAL, columns, monkeypatch)


def test_members_whose_fluid_differs_are_assembled_where_forces_know_the_mass_of_balls(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    _are_assembled(PINS, {"temperature": ["20 degC", "30 degC", "40 degC"]}, monkeypatch)


def _are_assembled(path: Path, columns: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    machine, made = ab.load_machine(path), list[int]()
    asked = Members(machine, columns_of(machine, columns), None, 0, "member")
    ready = asked.ready
    monkeypatch.setattr(asked, "ready", lambda number, *given: made.append(number) or ready(number, *given))
    asked.sorted(Plan(END, 1e-6, 20, 100), "refuse")
    assert {0, 1, 2} <= set(made)


def test_a_member_that_would_follow_wrongly_is_assembled(monkeypatch: pytest.MonkeyPatch) -> None:
    right = members(STALL, {"drag": DRAG})
    monkeypatch.setattr(follow, "words_of", lambda values: np.full(values.size, 4607182418800017408))  # 1.0
    wrong = members(STALL, {"drag": DRAG})
    assert wrong["peak_deflection"].equals(right["peak_deflection"])


def test_a_member_in_long_steps_is_its_run_too() -> None:
    found = members(STALL, {"rotor.mass": [9.0, 11.0]}, method="exponential_collocation")
    machine = ab.with_parameter(ab.load_machine(STALL), "rotor.mass", 11.0)
    run = ab.simulate(
        machine,
        duration=END,
        tolerance=TOLERANCE,
        method="exponential_collocation",
        save=[ab.Envelope(20), ab.LastRevolutions()],
    )
    same(found, 1, run)
    assert found.attrs["lanes"] == run.attrs["lanes"]


@pytest.mark.parametrize(
    ("machine", "columns", "end"),
    [(STALL, {"drag": DRAG}, END), (RIGID, {"drag": DRAG}, 0.2), (RACE, {"rolling_resistance": DRAG}, 0.1)],
)
def test_two_threads_give_the_bits_of_one(machine: Path, columns: Any, end: float) -> None:
    one, two = (
        ab.ensemble(
            machine, columns, duration=end, tolerance=TOLERANCE, bins=20, keep_states=True, workers=workers, seeds=2
        )
        for workers in (1, 2)
    )
    for name in one.data_vars:
        assert one[name].equals(two[name]), name


@pytest.mark.parametrize(
    ("machine", "columns", "end"),
    [
        (DISCOIDAL, {"viscosity": ["10 mm^2/s", "50 mm^2/s"], "unbalances[1].mass": [5e-3, 6e-3]}, END),
        (RACE, {"rolling_resistance": [1e-4, 3e-4]}, 0.1),
        (RIGID, {"unbalances[1].angle": [0.1, 0.2], "drag": DRAG[:2]}, 0.2),
    ],
)
def test_a_member_that_is_only_described_is_its_run_digit_for_digit(machine: Path, columns: Any, end: float) -> None:
    found = ab.ensemble(machine, columns, duration=end, tolerance=TOLERANCE, bins=20, keep_states=True)
    own = ab.load_machine(machine)
    for name, values in columns.items():
        own = ab.with_parameter(own, name, values[1])
    same(found, 1, alone(own, end=end))


def test_a_table_says_the_columns_with_their_units(tmp_path: Path) -> None:
    table = tmp_path / "members.csv"
    table.write_text(
        "unbalance [g*mm], ball_angle[1] [deg], ball_angle[2] [deg], seed\n300, 10, 100, 3\n500, 20, 200, 4\n"
    )
    found = ab.ensemble(STALL, table, duration=0.05)
    assert found["unbalance"].dims == ("member",)
    assert found.coords["seed"].values.tolist() == [3, 4]
    assert found["ball_angle_2"].values == pytest.approx(np.deg2rad([100.0, 200.0]))
    table.write_text("unbalance\n300\n")
    with pytest.raises(
        QuestionError, match=r"numbers without a unit; write it in the first line, such as unbalance \[kg\*m\]"
    ):
        ab.ensemble(STALL, table, duration=0.05)


def test_an_impossible_member_is_named_before_anything_runs() -> None:
    columns = {"drag": [1e-4, -1e-4], "unbalance": [1e-4, 2e-4]}
    with pytest.raises(QuestionError, match=r"member 2, variation with drag = -0.0001, unbalance = 0.0002"):
        ab.ensemble(STALL, columns, duration=END)
    columns = {"rotor.mass": [9.0, -1.0, 11.0]}
    with pytest.raises(MachineError, match=r"member 2, variation with rotor.mass = -1"):
        ab.ensemble(STALL, columns, duration=END)


@pytest.mark.parametrize(
    ("name", "values", "told"),
    [
        ("rotor.supports[1].stiffness", [1e5, 1.1e5, -1.0], "rotor.supports"),
        ("ball_diameter", [0.01, 0.011, 0.2], "balancers"),
        ("unbalances[1].moment", [1e-4, 2e-4, -3e-4], "unbalances"),
    ],
)
def test_an_impossible_member_on_a_rotor_that_tilts_is_named_too(name: str, values: list[float], told: str) -> None:
    with pytest.raises(MachineError, match=rf"member 3, variation with {re.escape(name)} = {values[2]:g}.*{told}"):
        ab.ensemble(TWO_PLANES, {name: values}, duration=0.01)
    found = ab.ensemble(TWO_PLANES, {name: values}, duration=0.01, impossible="record")
    assert found["outcome"].values.tolist() == ["finished", "finished", "impossible"]


def test_an_impossible_member_can_be_recorded_while_the_others_run() -> None:
    found = ab.ensemble(STALL, {"rotor.mass": [9.0, -1.0, 11.0]}, duration=0.05, impossible="record")
    assert found["outcome"].values.tolist() == ["finished", "impossible", "finished"]
    assert "rotor.mass = -1" in str(found["reason"].values[1])
    assert np.isnan(found["peak_deflection"].values[1])
    assert found["peak_deflection"].values[2] > 0.0
    assert float(found.shares()["count"].sum()) == 2


def test_a_member_that_stops_is_recorded_and_the_others_go_on() -> None:
    found = ab.ensemble(STALL, {"ball_speed[1]": [500.0, 0.0]}, duration=0.5, max_steps=40)
    assert found["outcome"].values.tolist() == ["budget spent", "finished"]


def test_an_interrupted_ensemble_keeps_what_is_done() -> None:
    def stop(done: int, total: int) -> None:
        if done == 2:
            raise KeyboardInterrupt

    found = ab.ensemble(STALL, {"drag": DRAG}, duration=0.05, workers=1, progress=stop, keep_on_interrupt=True)
    assert found.attrs["outcome"] == "interrupted"
    assert found["outcome"].values.tolist() == ["finished", "finished", "not run"]
    with pytest.raises(KeyboardInterrupt):
        ab.ensemble(STALL, {"drag": DRAG}, duration=0.05, workers=1, progress=stop)
    swept = ab.sweep(STALL, {"drag": DRAG}, duration=0.05, workers=1, progress=stop, keep_on_interrupt=True)
    assert swept["outcome"].values.tolist() == ["finished", "finished", "not run"]
    assert np.isnan(swept["peak_deflection"].values[2])


@pytest.mark.usefixtures("ctrl_c")
def test_an_ensemble_that_is_interrupted_while_members_are_made_ready_runs_those_that_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    varied = Members.varied

    def pressed(self: Members, row: int) -> Any:
        if row == 3:
            signal.raise_signal(signal.SIGINT)
        return varied(self, row)

    before = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(Members, "varied", pressed)
    masses = {"rotor.mass": [9.0, 9.5, 10.0, 10.5, 11.0, 11.5]}
    found = ab.ensemble(STALL, masses, duration=0.05, measures=["peak_deflection"], keep_on_interrupt=True)
    assert found.attrs["outcome"] == "interrupted"
    assert found["outcome"].values.tolist() == ["finished"] * 4 + ["not run"] * 2  # the fourth was not left half done
    assert np.isfinite(found["peak_deflection"].values).tolist() == [True] * 4 + [False] * 2
    with pytest.raises(KeyboardInterrupt):
        ab.ensemble(STALL, masses, duration=0.05)
    assert signal.getsignal(signal.SIGINT) is before


def test_measures_that_are_asked_for_have_the_bits_of_all_measures_and_the_ends_stay() -> None:
    def found(measures: list[str] | None) -> Any:
        return members(STALL, {"drag": DRAG[:2]}, measures=measures)

    whole, ends = found(None), found([])
    assert set(whole) - set(ends) == {*ASKABLE, "balanced"}
    assert ends["final_state"].equals(whole["final_state"])
    assert ends.classes().tolist() == ["finished"] * 2
    for asked in (
        ["settling_time"],
        ["residual_share", "support_force"],
        ["vibration", "verdict"],
        ["impacts", PER_BALL],
    ):
        some = found(asked)
        assert set(some) - set(ends) - {"balanced"} == set(asked)
        assert all(some[name].equals(whole[name]) for name in some), asked
    with pytest.raises(QuestionError, match="measures: given 'vibrations'; must be a list of"):
        found(["vibrations"])


def test_more_than_memory_holds_is_refused_with_the_number_that_fits(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    many = np.linspace(0.0, 1.0, 1000)
    monkeypatch.setattr("autobalancer.memory.free_memory", lambda: 1e6)
    for what, question in (
        ("members", lambda: ab.ensemble(STALL, seeds=100_000)),
        ("starts", lambda: ab.basin(STALL, 300.0, random=10**12)),
        ("starts", lambda: ab.basin(STALL, 300.0, {"ball_angle[1]": many, "ball_angle[2]": many})),
        ("points", lambda: ab.stability.map(STALL, {"speed": 300.0 + many, "drag": 1e-6 + many})),
        ("starts", lambda: ab.report(STALL, tmp_path / "r.html", starts=10**9)),
    ):
        with pytest.raises(QuestionError, match=rf"at most \d+ {what} fit"):
            question()


@pytest.mark.parametrize(
    ("columns", "told"),
    [
        ({"drag": []}, "'drag' is empty"),
        ({"drag": [1e-4, 2e-4], "damping": [1.0, 2.0, 3.0]}, "same length"),
        ({"dragg": [1e-4]}, "no such name"),
        ({"ball_angle[3]": [0.0]}, r"ball_angle\[1\] to ball_angle\[2\]"),
        ({"ball_angle[1]": [np.nan]}, "must be finite"),
        ({"seed": [1.5]}, "must be a whole number"),
        ({"seed": [1, None]}, "member 2, 'seed': given None"),
        ({"run.duration": [0.5, 2.0]}, "the runs have one duration"),
        ([1.0], "must be names with their values"),
    ],
)
def test_columns_that_make_no_sense_are_refused(columns: dict[str, Any], told: str) -> None:
    with pytest.raises(QuestionError, match=told):
        ab.ensemble(STALL, columns, duration=END)


@pytest.mark.parametrize(
    "more", [{"seeds": 2.5}, {"seeds": 0}, {"workers": 0}, {"bins": 1.5}, {"max_steps": -1}], ids=str
)
def test_counts_are_whole_numbers_from_one(more: dict[str, Any]) -> None:
    with pytest.raises(QuestionError, match=rf"{next(iter(more))}: given .*; must be a whole number from 1"):
        ab.ensemble(STALL, {"drag": [1e-4]}, duration=END, **more)


@pytest.mark.parametrize(
    ("name", "values", "told"),
    [
        ("rotor.mass", ["9 kg", "-5 kg"], -5.0),
        ("drag", ["1e-4 N*m*s", "-1e-4 N*m*s"], -1e-4),
    ],
)
def test_impossible_members_in_words_are_recorded_with_their_numbers(name: str, values: list[str], told: float) -> None:
    found = ab.ensemble(STALL, {name: values}, duration=0.05, impossible="record")
    assert found["outcome"].values.tolist() == ["finished", "impossible"]
    assert float(found[dimension_of(name)][1]) == told


def test_an_oil_that_is_not_known_at_a_temperature_makes_an_impossible_member() -> None:
    columns = {"temperature": ["25 degC", "200 degC"], "viscosity": ["1 mm^2/s", "1 mm^2/s"]}
    found = ab.ensemble(DISCOIDAL, columns, duration=0.05, impossible="record")
    assert found["outcome"].values.tolist() == ["finished", "impossible"]
    assert str(found["reason"].values[1]).startswith("member 2, variation with temperature = 200 degC")


def test_the_interval_of_a_share_is_that_of_wilson() -> None:
    low, high = wilson_interval(np.array([8]), 10)  # Newcombe (1998): 0.4901 to 0.9433
    assert (low[0], high[0]) == pytest.approx((0.4902, 0.9433), abs=1e-4)


def test_an_ensemble_shows_shares_and_is_read_back_as_what_it_is(tmp_path: Path) -> None:
    found = ab.ensemble(STALL, {"drag": [1e-4, 2e-4]}, seeds=2, duration=0.05)
    assert "ensemble of 4 members" in repr(found)
    assert "95 % from" in repr(found)
    path = tmp_path / "ensemble.nc"
    ab.save_run(found, path)
    again = ab.load_run(path)
    assert type(again) is type(found)
    assert repr(again) == repr(found)
    found["residual_unbalance"].values[1:] = 1e-6  # a run of 50 ms has none
    said = next(text for text in found.remarks() if text.startswith("residual unbalance"))
    assert said.endswith(" (3 of 4 members; none where a ball is stalled or goes round in the rotor)")
    assert any(text.startswith("greatest deflection at 'rotor': median") for text in found.remarks())


def test_the_command_writes_the_ensemble_and_says_the_shares(tmp_path: Path) -> None:
    out, picture = tmp_path / "e.nc", tmp_path / "e.png"
    words = ["ensemble", str(STALL), "--column", "drag=1e-4,2e-4 N*m*s", "--seeds", "2", "--duration", "50 ms"]
    answer = CliRunner().invoke(app, [*words, "--out", str(out), "--plot", str(picture)])
    assert answer.exit_code == 0, answer.output
    assert "no verdict" in answer.output
    said = " ".join(answer.output.split())
    remarks = ab.load_run(out).remarks()
    assert all(text.split(" rpm")[0] in said for text in remarks)  # speeds are in one unit here
    assert out.exists()
    assert picture.exists()
    answer = CliRunner().invoke(app, [*words, "--out", str(out), "--json"])
    assert json.loads(answer.output)["share"]["no verdict"]["count"] == 4
