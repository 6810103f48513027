"""Studies: what scatters does so as it should, chunks make no difference, and nothing finished is lost."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.stats
import xarray as xr
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.cli.terminal.sheet import sheet_csv
from autobalancer.errors import DurationWarning, QuestionError, RangeWarning, unwarned, warn
from autobalancer.random_numbers import wilson_interval
from autobalancer.stability.averaged import averaged_plane, damping_share
from autobalancer.studies.study.study_file import read_study
from autobalancer.studies.study.study_spec import (
    Discrete,
    LogNormal,
    Normal,
    Tolerance,
    Triangular,
    Uniform,
    interval,
    shares,
)

ROOT = Path(__file__).parents[1]
MACHINE = str(ROOT / "examples/machines/discoidal.toml")
MASS = {"distribution": "normal", "standard_deviation": "5 %"}
SHORT: dict[str, Any] = {"machine": MACHINE, "duration": "0.5 s", "members": 40, "vary": {"unbalances[1].mass": MASS}}
U = (np.arange(2000) + 0.5) / 2000


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        (Normal(mean=3.0, standard_deviation=2.0), scipy.stats.norm(3.0, 2.0)),
        (Normal(mean=3.0, standard_deviation=2.0, low=2.0, high=4.5), scipy.stats.truncnorm(-0.5, 0.75, 3.0, 2.0)),
        (Uniform(low=-1.0, high=4.0), scipy.stats.uniform(-1.0, 5.0)),
        (LogNormal(median=2.0, factor=1.3), scipy.stats.lognorm(np.log(1.3), scale=2.0)),
        (Triangular(low=1.0, mode=2.0, high=4.0), scipy.stats.triang(1.0 / 3.0, 1.0, 3.0)),
        (Tolerance(nominal=10.0, plus=0.3, minus=0.3), scipy.stats.truncnorm(-3.0, 3.0, 10.0, 0.1)),
    ],
)
def test_a_distribution_has_the_quantiles_of_its_formula(ours: Any, theirs: Any) -> None:
    np.testing.assert_allclose(ours.at(U), theirs.ppf(U), rtol=1e-9)


def test_discrete_values_come_as_often_as_their_weights_say() -> None:
    found = Discrete(values=(1.0, 2.0, 5.0), weights=(1.0, 2.0, 1.0)).at(U)
    assert [float((found == value).mean()) for value in (1.0, 2.0, 5.0)] == [0.25, 0.5, 0.25]


@pytest.mark.parametrize("plan", ["random", "sobol", "latin_hypercube", "sensitivity"])
def test_a_sample_is_the_same_in_pieces(plan: Any) -> None:
    whole = shares(plan, 7, 3, np.arange(2000), 2000)
    pieces = [shares(plan, 7, 3, np.arange(first, min(first + 77, 2000)), 2000) for first in range(0, 2000, 77)]
    assert np.array_equal(whole, np.concatenate(pieces))
    assert not np.array_equal(whole, shares(plan, 8, 3, np.arange(2000), 2000))
    np.testing.assert_allclose(whole.mean(axis=0), 0.5, atol=0.03)


def test_more_members_leave_the_first_ones_as_they_are() -> None:
    few, many = (shares("sobol", 1, 4, np.arange(100), total) for total in (100, 5000))
    assert np.array_equal(few, many)


def test_the_interval_of_a_quantile_covers_it_as_often_as_it_says() -> None:
    draws = np.random.default_rng(1).exponential(size=(2000, 150))
    true = -np.log(1.0 - 0.9)
    covered = np.mean([low <= true <= high for _, low, high in (interval("quantile", row, 0.9) for row in draws)])
    assert 0.945 <= covered <= 0.985  # whole ranks cover a little more than 95 %


def of_function(values: Any, inputs: list[str]) -> xr.Dataset:
    count = values.size
    data = xr.Dataset({"f": ("member", values)}, attrs={"inputs": inputs, "plan": "sensitivity"})
    return data.assign_coords(point=("member", np.ones(count, int)), draw=("member", np.arange(count)))


def test_the_interval_of_a_rank_correlation_covers_it_as_often_as_it_says() -> None:
    random, strength, count = np.random.default_rng(3), 0.5, 60
    true = 6.0 / np.pi * np.arcsin(0.5 * strength)  # of two normal numbers (Pearson 1907)
    a, b = random.normal(size=(2, 400 * count))
    study = of_function(strength * a + np.sqrt(1.0 - strength**2) * b, ["a"]).assign_attrs(plan="random")
    apart = {"a": ("member", a), "point": ("member", np.repeat(np.arange(400), count))}
    found = ab.sensitivity(study.assign_coords(apart), "f")
    covered = (found["rank_correlation_low"] <= true) & (true <= found["rank_correlation_high"])
    assert 0.92 <= covered.mean() <= 0.98  # 0.95 within three standard deviations of 400 draws


def test_sobol_indices_of_the_ishigami_function() -> None:
    count = 4096
    x = np.pi * (2.0 * shares("sensitivity", 0, 3, np.arange(5 * count), 5 * count) - 1.0)
    f = np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    found = ab.sensitivity(of_function(f, ["x1", "x2", "x3"]), "f")
    np.testing.assert_allclose(found["first"], [0.3139, 0.4424, 0.0], atol=0.01)  # Ishigami and Homma (1990)
    np.testing.assert_allclose(found["total"], [0.5576, 0.4424, 0.2437], atol=0.01)
    for name, exact in (("first", [0.3139, 0.4424, 0.0]), ("total", [0.5576, 0.4424, 0.2437])):
        assert np.all((found[f"{name}_low"] <= exact) & (exact <= found[f"{name}_high"]))


def test_sobol_indices_of_the_averaged_border_are_those_of_its_formula() -> None:
    scatter = {"stiffness": Uniform(low=30e3, high=60e3), "damping": Uniform(low=15.0, high=60.0)}
    vary = {name: {"distribution": "uniform", "low": one.low, "high": one.high} for name, one in scatter.items()}
    asked = {"machine": MACHINE, "plan": "sensitivity", "members": 256, "vary": vary, "results": ["averaged border"]}
    found = ab.study(asked)
    machine = ab.load_machine(MACHINE)
    rotor, share = machine.rotor, damping_share(averaged_plane(machine))
    k, b = np.meshgrid(*(one.at(U[::20]) for one in scatter.values()), indexing="ij")
    s = share * k / rotor.stiffness_xy[0] * rotor.damping_xy[0] / b
    border = np.sqrt(
        k * (1.0 + s) / (1.0 - s)
    )  # over that of the mass, which is the same for all; Spannan (2021), (4.74)
    first = [border.mean(axis=1).var() / border.var(), border.mean(axis=0).var() / border.var()]
    assert list(found.attrs["inputs"]) == list(scatter)
    assert min(first) > 0.1, "both count"
    indices = ab.sensitivity(found, "averaged_border")
    np.testing.assert_allclose(indices["first"], first, atol=0.02)
    np.testing.assert_allclose(indices["total"], 1.0 - np.array(first[::-1]), atol=0.02)


def test_the_balanced_share_is_that_of_the_unbalances_within_the_capability() -> None:
    capability = ab.study({**SHORT, "results": ["capability"], "members": 1})["capability"].values[0]
    moment = {"distribution": "uniform", "low": 0.5 * capability, "high": 1.5 * capability}
    machine = ab.with_parameter(ab.load_machine(MACHINE), "unbalances", ({"moment": 1e-4},))
    found = ab.study({"machine": machine, "members": 150, "vary": {"unbalances[1].moment": moment}})
    share, low, high = found.share_of(found["residual_share"] < 1e-3)
    assert low <= 0.5 <= high, share
    within = found["unbalances_1_moment"] < 0.99 * capability
    assert np.all(found["residual_share"].values[within] < 1e-3)


def test_it_stops_when_the_interval_is_narrow_enough() -> None:
    stop = {"of": "peak_deflection", "relative": 0.05}
    found = ab.study({**SHORT, "members": 5000, "stop": stop})
    assert found.attrs["stopped_by"] == "confidence"
    assert 100 <= found.sizes["member"] < 1000
    values = found["peak_deflection"].values
    assert 1.96 * values.std(ddof=1) / np.sqrt(values.size) <= 0.05 * values.mean()


def test_impossible_machines_are_refused_drawn_again_or_recorded() -> None:
    wide = {**SHORT, "vary": {"rotor.mass": {"distribution": "normal", "mean": "2 kg", "standard_deviation": "2 kg"}}}
    with pytest.raises(
        QuestionError, match=r"[12]\d.* % of the first 40 members cannot be built; the first: .*rotor.mass = -"
    ):
        ab.study(wide)
    again = ab.study({**wide, "impossible": "truncate"})
    assert again["rotor_mass"].min() > 0.0
    assert 0 < (again["drawn_again"] > 0).sum() < 20
    kept = ab.study({**wide, "impossible": "record"})
    assert set(kept["outcome"].values) == {"finished", "impossible"}
    assert np.all((kept["outcome"] == "impossible") == (kept["rotor_mass"] <= 0.0))


def test_correlated_inputs_have_their_correlation() -> None:
    names = ["stiffness", "rotor.mass"]
    joint = {"names": names, "mean": [3500.0, 7.5], "covariance": [[1e4, 16.0], [16.0, 0.04]]}
    drawn = read_study({"machine": MACHINE, "joint": [joint], "results": ["capability"]}).columns(0, 4000, {})
    k, m = (drawn.parameters[name] for name in names)
    np.testing.assert_allclose(np.cov(k, m), joint["covariance"], rtol=0.08)
    assert ab.sensitivity(ab.study({**SHORT, "vary": SHORT["vary"] | {"rotor.mass": MASS}}), "peak_deflection")


def test_every_draw_has_its_own_start_and_every_point_the_same_ones() -> None:
    found = ab.study({**SHORT, "members": 3, "vary": {"viscosity": ["10 mm^2/s", "50 mm^2/s"]}})
    starts = found["start_ball_angle_in_rotor"].values.reshape(3, 2, 2)  # draws, points, balls
    assert np.array_equal(starts[:, 0], starts[:, 1])
    assert len({tuple(row) for row in starts[:, 0]}) == 3


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"machin": 1}, "machin: unknown key; did you mean 'machine'"),
        ({"members": 0}, "members: given 0; must be 1 or more"),
        ({"vary": {"viscosit": [1]}}, "vary.viscosit: .*did you mean 'viscosity'"),
        (
            {"vary": {"rotor.mass": {"distribution": "gauss"}}},
            'vary."rotor.mass".distribution: given .gauss.; must be one',
        ),
        ({"vary": {"rotor.mass": {**MASS, "sd": 1}}}, "sd: unknown key"),
        ({"vary": {"rotor.mass": {**MASS, "low": "9 kg", "high": "8 kg"}}}, "low must be below high"),
        ({"vary": {"plateau": MASS}}, "mean: missing, and the machine has no single value"),
        ({"vary": {"temperature": MASS}}, "a share of an absolute temperature says little"),
        (
            {"stop": {"of": "peak", "half_width": 1}},
            "stop.of: given 'peak'; this study has balanced, stalled, peak_deflection",
        ),
        ({"stop": {"of": "balanced", "half_width": 0.1, "relative": 0.1}}, "one of them"),
        ({"plan": "sobol", "stop": {"of": "balanced", "half_width": 0.1}}, "intervals are those of independent draws"),
        ({"results": ["speed"]}, "results: given 'speed'; must be one of 'run'"),
        ({"correlation": [{"between": ["stiffness", "x"], "value": 0.5}]}, "'stiffness' has no distribution"),
        ({"vary": {}, "starts": "machine"}, "nothing varies"),
        (
            {"vary": {"rotor.mass": {"distribution": "discrete", "values": ["9 kg"], "weights": ["a"]}}},
            r"weights\[1\]: given .a.; must be a number",
        ),
        (
            {"joint": [{"names": ["rotor.mass"], "covariance": [[1.0]], "mean": [1, 2]}]},
            r"joint\[1\].mean: .* list of 1",
        ),
    ],
)
def test_a_fault_in_a_study_is_named_with_its_key(changed: dict[str, Any], said: str) -> None:
    with pytest.raises(QuestionError, match=said):
        ab.study({**SHORT, **changed})


@pytest.mark.slow
def test_the_balanced_share_of_a_monte_carlo_is_that_of_the_basin_map() -> None:
    speed, count = 330.0, 16
    machine = ab.load_machine(ROOT / "examples/machines/stall_and_release.toml")
    machine = ab.with_parameter(machine, "balancers[1].races[1].collisions", False)
    middle = (np.arange(count) + 0.5) / count
    other, wide = machine.balancers[0].races[0].balls[0].start_angles[1], 0.1  # rad; nearer balls would overlap
    first, last = other + wide, other + 2.0 * np.pi - wide
    angles, speeds = first + (last - first) * middle, -speed * middle  # at rest in space to at rest in the rotor
    found = ab.basin(machine, speed, {"ball_angle[1]": angles.tolist(), "ball_speed": speeds.tolist()})
    stalled = found["state"].values == found.attrs["states"].index("stalled")
    exact, neighbors = stalled.mean(), stalled[:, 1:] != stalled[:, :-1]
    assert 0.03 < exact < 0.5
    profile = {"kind": "constant", "speed": speed}
    held = ab.with_parameter(machine, "drive", {"kind": "speed", "profile": profile})
    vary = {
        "ball_angle[1]": {"distribution": "uniform", "low": first, "high": last},
        "ball_speed": {"distribution": "uniform", "low": -speed, "high": 0.0},
    }
    asked = {"machine": held, "members": 700, "starts": "machine", "duration": "10 s", "vary": vary}
    share, low, high = (members := ab.study(asked)).share_of(~members["balanced"].values)
    # a cell of the map that the border crosses may be wrong by half of it, at random
    doubt = np.sqrt(neighbors.sum()) * 0.5 / stalled.size
    assert low - doubt <= exact <= high + doubt, (share, exact)


def test_only_members_that_share_no_number_tell_how_sure_a_share_is() -> None:
    vary = {"unbalances[1].mass": MASS, "rotor.mass": MASS}
    found = ab.study({**SHORT, "plan": "sensitivity", "members": 8, "vary": vary})
    counted = found.counted()
    of_one = len(found.attrs["inputs"]) + 2
    assert (found.sizes["member"], counted.sum()) == (8 * of_one, 16)
    for name in ("unbalances_1_mass", "rotor_mass"):
        assert np.unique(found[name].values[counted]).size == 16  # the two of a base sample, and no other
        assert np.unique(found[name].values).size == 16
    row = {column.head: column.values[0] for column in found.columns()}
    low, high = wilson_interval(np.array([found["balanced"].values[counted].sum()]), 16)
    assert row["members"] == 16
    assert (row["95 % from"], row["95 % to"]) == pytest.approx((100.0 * low[0], 100.0 * high[0]))
    assert any("16 members" in text for text in found.remarks())


def test_runs_for_indices_that_pass_for_independent_make_intervals_too_narrow_as_the_page_says() -> None:
    inputs, bases = 4, 20_000
    share = np.random.default_rng(1).normal(size=(bases, 2, inputs))
    both = [share[:, 0], share[:, 1]]
    hybrids = [np.where(np.arange(inputs) == one, both[1], both[0]) for one in range(inputs)]
    sums = np.stack([run.sum(axis=1) for run in (*both, *hybrids)], axis=1)
    true = sums.mean(axis=1).std()
    said = sums.std() / np.sqrt(inputs + 2)
    assert true / said == pytest.approx(np.sqrt((inputs**2 + 4) / (inputs + 2)), rel=0.02)


def test_a_study_says_that_its_balls_leave_the_range_of_their_drag_law_as_a_run_does() -> None:
    found = ab.study(SHORT)
    with pytest.warns(RangeWarning):
        run = ab.simulate(MACHINE, duration="0.5 s", seed=1)
    assert found.attrs["drag_warning"].split("reaches")[0] == run.attrs["drag_warning"].split("reaches")[0] != ""
    assert any(text.startswith("range of the drag law") for text in found.remarks())
    given = ab.example("stall_and_release")  # its drag is a number
    none = ab.study({"machine": given, "duration": "0.5 s", "members": 4, "vary": {"rotor.mass": MASS}})
    assert none.attrs["drag_warning"] == ""


def test_the_sensitivity_to_a_single_input_is_found_in_a_file_too_and_says_what_it_leaves_out(tmp_path: Path) -> None:
    ab.save_run(ab.study(SHORT), tmp_path / "study.nc")
    driven = ab.sensitivity(ab.load_run(tmp_path / "study.nc"), "peak_deflection")
    assert driven["input"].values.tolist() == ["unbalances_1_mass"]
    assert "random starts" in driven.remarks()[0]


def test_what_is_unwarned_in_one_thread_is_warned_of_in_another() -> None:
    import threading

    inside, left = threading.Event(), threading.Event()

    def quiet() -> None:
        with unwarned():
            warn("silenced", RangeWarning)
            inside.set()
            left.wait(60.0)

    def both() -> None:
        thread = threading.Thread(target=quiet)
        thread.start()
        inside.wait(60.0)
        warn("heard", RangeWarning)
        left.set()
        thread.join()
        warn("heard after", RangeWarning)

    with pytest.warns(RangeWarning) as seen:
        both()
    assert [str(one.message) for one in seen] == ["heard", "heard after"]
    with pytest.warns(RangeWarning, match="another class"), unwarned(DurationWarning):
        warn("of another class", RangeWarning)


@pytest.mark.parametrize("option", ["--sensitivity", "--quantity"])
def test_a_quantity_that_the_study_will_not_have_is_refused_before_it_runs(option: str, tmp_path: Path) -> None:
    file = tmp_path / "own.toml"
    varied = '[vary.viscosity]\ndistribution = "uniform"\nlow = "1 mm^2/s"\nhigh = "2 mm^2/s"\n'
    file.write_text(f'machine = "{MACHINE}"\nduration = "0.5 s"\n{varied}')
    words = ["study", str(file), option, "peak_deflexion", "--folder", str(tmp_path / "parts"), "--plot", "x.png"]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 2
    assert not (tmp_path / "parts").exists()
    assert f"{option}: given 'peak_deflexion'; did you mean 'peak_deflection'?" in " ".join(answer.stderr.split())


@pytest.mark.parametrize(
    ("more", "words", "said"),
    [
        (
            "members = 30\n[vary]\nstiffness = ['40 kN/m']\n",
            ["--sensitivity", "peak_deflection"],
            "only starts are random here",
        ),
        (
            "members = 9\n[vary.viscosity]\ndistribution = 'uniform'\nlow = '1 mm^2/s'\nhigh = '2 mm^2/s'\n",
            ["--sensitivity", "peak_deflection"],
            "members: given 9; at least 20",
        ),
        (
            "[vary]\nstiffness = ['40 kN/m']\ndamping = ['10 N*s/m']\ncount = [1, 2]\n",
            ["--plot", "x.png"],
            "has 3 parameters, and two can be drawn",
        ),
        ("members = 9\n[vary]\ncount = [2]\n", ["--scheduler", "tcp://127.0.0.1:1"], "scheduler: "),
        (f"members = 1\n[vary]\ncount = {[2] * 101 + [300]}\n", [], "0.98 % of the first 102 members cannot be built"),
    ],
)
def test_what_a_study_could_say_at_its_end_only_is_refused_before_and_leaves_no_folder(
    more: str, words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autobalancer.studies.study.study.run_chunk", None)
    monkeypatch.setattr("autobalancer.studies.study.study.WAIT", 0.1)
    file = tmp_path / "own.toml"
    file.write_text(f'machine = "{MACHINE}"\nduration = "0.5 s"\n{more}')
    out = ["--out", str(tmp_path / "own.nc"), "--folder", str(tmp_path / "parts")]
    answer = CliRunner().invoke(app, ["study", str(file), *out, *words])
    assert answer.exit_code == 2
    assert said in " ".join(answer.stderr.split())
    assert {path.name for path in tmp_path.iterdir()} == {"own.toml"}


def test_json_of_a_study_has_the_interval_of_each_share_and_all_in_si(tmp_path: Path) -> None:
    file, out = tmp_path / "own.toml", tmp_path / "own.nc"
    machine = ROOT / "examples/machines/stall_and_release.toml"
    file.write_text(f'machine = "{machine}"\nmembers = 3\n[vary]\ndrag = ["0.03 N*mm*s", "0.15 N*mm*s"]\n')
    words = ["study", str(file), "--out", str(out), "--folder", str(tmp_path / "parts")]
    answer = json.loads(CliRunner().invoke(app, [*words, "--json"]).stdout)
    found = ab.load_run(out)
    points = [found.isel(member=np.flatnonzero(found["point"].values == point)) for point in np.unique(found["point"])]
    counts = {name: np.array([int(one[name].sum()) for one in points]) for name in ("balanced", "stalled")}
    assert (counts["balanced"] != counts["stalled"]).all()
    for name, count in counts.items():
        row = [answer[key] for key in (name, f"{name}, 95 % from", f"{name}, 95 % to")]
        np.testing.assert_allclose(row, [count / 3, *wilson_interval(count, 3)], rtol=1e-12, atol=1e-15)
    peaks = [one["peak_deflection"].values for one in points]
    assert answer["peak deflection"] == pytest.approx(np.median(peaks, axis=1), rel=1e-12)
    assert answer["peak deflection, 95 % below"] == pytest.approx(np.quantile(peaks, 0.95, axis=1), rel=1e-12)
    assert answer["drag"] == pytest.approx([3e-5, 1.5e-4])
    head = next(csv.reader(io.StringIO(sheet_csv(found.columns()))))
    assert len(set(head)) == len(head) == len(answer) - 2  # all but the names of the file
    assert "stalled, 95 % to [%]" in head


def test_the_release_speed_of_theory_and_the_break_away_speed_of_the_runs_stand_beside_each_other() -> None:
    asked = {"machine": ab.example("stall_and_release"), "members": 2, "results": ["run", "release speed"]}
    found = ab.study({**asked, "vary": {"drag": [1.4685e-4]}})
    theory, runs = found["release_speed"].values, found["break_away_speed"].values
    assert theory == pytest.approx(383.0, rel=1e-3)
    # of balls that run up in 15 s: later by the time, I / beta, that drag takes to speed up a ball
    later = 500.0 / 15.0 * 1.4 * 2.5e-4 * 0.1 / 1.4685e-4
    assert ((runs > theory + 1.0) & (runs < theory + 2.0 * later)).all()


def test_a_study_says_the_median_of_the_ratios_of_its_passages_to_those_with_held_balls() -> None:
    machine = ab.example("stall_and_release")
    vary = {
        "drag": [2e-4],
        "unbalance": {"distribution": "uniform", "low": "50 g*mm", "high": "400 g*mm"},
        "damping": {"distribution": "uniform", "low": "5 N*s/m", "high": "60 N*s/m"},
    }
    found = ab.study({"machine": machine, "members": 5, "seed": 1, "vary": vary})
    ratios = []
    for peak, size, damping in zip(found["peak_deflection"].values, found["unbalance"], found["damping"], strict=True):
        one = ab.with_parameter(ab.with_parameter(machine, "unbalance", float(size)), "damping", float(damping))
        ratios.append(peak / float(ab.run_measures(ab.simulate(one, hold_balls=True))["peak_deflection"]))
    middle, most = np.median(ratios), int(np.argmax(ratios))
    of_median_peak = ratios[found["peak_deflection"].argsort().values[2]]
    assert of_median_peak > 2.0 * middle  # the run with the median peak is no measure of the others
    said = str(found.attrs["passage_text"])
    assert "in 5 of 5 members" in said
    assert f"median {middle:.3g} times" in said
    assert f"at most {ratios[most]:.3g} times (member {most + 1})" in said
    assert said in found.remarks()
    points = ab.study(
        {"machine": machine, "members": 2, "seed": 1, "vary": vary | {"unbalance": ["100 g*mm", "0.1 kg*m"]}}
    )
    words = str(points.attrs["passage_text"])
    assert "worse at 1 of 2 points; at the worst of these, unbalance 100 g mm: the" in words
    assert " of this point)" in words
    springs = {"machine": machine, "members": 20, "vary": {"drag": [2e-4]}, "duration": "0.02 s"}  # before the passage
    early = ab.study(springs)
    assert float(early.attrs["passage_ratio"]) == pytest.approx(1.0, abs=0.05)
    assert "of 15 members" in early.attrs["passage_text"]
