"""Runs, maps, curves and other results say in a few lines what an engineer asks first, also when read back from a file."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import autobalancer as ab
from autobalancer.results.answers import run as runs
from autobalancer.results.answers.answer import FORMS
from autobalancer.results.answers.kinds import HOMES

DISCOIDAL, RIGID, DEEP = ab.example("discoidal"), ab.example("rigid_rotor"), ab.example("deep_chamber")
RPM = np.pi / 30.0
HAMMER = ab.catalog.example_path("discoidal_hammer")
TIME = np.linspace(0.0, 2.0, 400)


@pytest.fixture(scope="module")
def balanced() -> xr.Dataset:
    return ab.simulate(DISCOIDAL, progress=False)


def test_a_run_says_how_it_ended_whether_it_is_balanced_and_its_main_numbers(balanced: xr.Dataset) -> None:
    first, *lines = repr(balanced).splitlines()
    assert first == f"{DISCOIDAL.name}: run, reached 160 s"
    facts = {line[:20].strip(): line[20:].strip() for line in lines}
    peak, speed = (float(ab.run_measures(balanced, "peak_deflection")[name]) for name in ("deflection", "speed"))
    assert facts["greatest deflection"] == f"{1e3 * peak:.3g} mm at {speed / RPM:.3g} rpm, from the rest position"
    assert facts["verdict"].startswith(f"{ab.verdict(balanced).word}: ")
    assert facts["speed"].startswith("0 to 1200 rpm")
    assert facts["balls"] == "2 in 1 race"
    assert "of 594 g mm" in facts["residual unbalance"]
    assert len(lines) < 16
    assert "<td>verdict</td>" in balanced._repr_html_()


def test_a_run_without_balancing_and_a_run_that_is_not_over_say_so() -> None:
    held = repr(ab.simulate(DISCOIDAL, hold_balls=True, duration=0.1, progress=False))
    assert "spread evenly and held" in held
    assert "no verdict" in held
    stopped = repr(ab.simulate(DISCOIDAL, duration=100.0, max_steps=5, progress=False))
    assert "steps" in stopped.splitlines()[0]
    deep = repr(ab.simulate(DEEP, duration=0.01, progress=False))
    assert deep.startswith("Deep chamber: run, reached 0.01 s")
    assert "50 in 1 deep chamber" in deep


def test_a_run_is_still_a_dataset_and_a_piece_without_times_is_shown_as_xarray_does(balanced: xr.Dataset) -> None:
    assert isinstance(balanced, xr.Dataset)
    assert isinstance(balanced["x"], xr.DataArray)
    again = pickle.loads(pickle.dumps(balanced))
    assert (type(again), repr(again)) == (type(balanced), repr(balanced))
    assert repr(balanced.copy(deep=True)) == repr(balanced)
    assert repr(balanced.sel(time=slice(0.0, 60.0))).startswith(DISCOIDAL.name)
    assert "verdict" in repr(balanced[["x", "y"]])
    both = xr.concat([balanced.isel(time=slice(0, 9)), balanced.isel(time=slice(9, None))], "time", data_vars="minimal")
    assert both["x"].size == balanced["x"].size
    for part in (balanced.isel(time=-1, turn=-1, bin=-1), balanced.drop_attrs(), balanced.max()):
        assert repr(part).startswith("<xarray.")


def test_the_samples_of_a_long_run_are_not_read_for_a_few_lines(
    balanced: xr.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(runs, "READ", balanced.nbytes - 1)
    assert "verdict" not in repr(balanced).replace("ab.verdict", "")


def test_a_map_says_its_axes_the_stable_share_and_where_the_machine_is() -> None:
    found = ab.stability.map(DISCOIDAL, {"speed": "600:1500 rpm:7", "viscosity": "1:100 mm^2/s:5:log"}, borders=3)
    said = repr(found)
    assert "rotor speed, 600 to 1500 rpm (7 values)" in said
    share = 100.0 * float((found["growth_rate"] < 0.0).mean())
    assert f"35 points, 35 with a balanced state, {share:.3g} % of them stable" in said
    assert "rotor speed 1200 rpm, kinematic viscosity of the fluid 20 mm²/s; stable at the nearest point" in " ".join(
        said.split()
    )
    far = ab.stability.map(DISCOIDAL, {"speed": "100:300 rpm:3", "viscosity": "1:2 mm^2/s:2"}, borders=0)
    assert "outside of the map" in repr(far)
    assert repr(far.isel(speed=0)).startswith("<xarray.")


def test_a_border_curve_shows_speeds_in_rpm_and_never_where_there_is_no_border() -> None:
    found = ab.stability.border_curve(DISCOIDAL, "viscosity", "1:100 mm^2/s:12:log")
    assert np.isinf(found["averaged_border"].values[0])
    first, *_, last = (line.split() for line in repr(found).splitlines() if line[:1].isdigit())
    assert first[:2] == ["1", "never"]
    assert float(last[3]) == pytest.approx(float(found["exact_border"].values[-1]) / RPM, rel=1e-5)
    highest = float(found["exact_border"].max())
    assert f"exact border: highest {highest / RPM:.5g} rpm" in repr(found)
    assert len(repr(found).splitlines()) < 24


def test_a_stepped_response_names_its_greatest_amplitude_and_what_the_balls_do() -> None:
    found = ab.stepped_response(DISCOIDAL, "600:1200 rpm:3", dwell=0.05, window=0.05, direction="both")
    greatest = float(found["amplitude"].sel(direction="up").max())
    assert f"up: greatest amplitude {1e6 * greatest:.3g} µm" in repr(found)
    assert {"balls up", "balls down"} <= {column.head for column in found.columns()}


@cache
def short_run() -> xr.Dataset:
    return ab.simulate(DISCOIDAL, duration=0.3, save=[ab.Samples(50), ab.Envelope(20)], progress=False)


@cache
def deep_run() -> xr.Dataset:
    return ab.simulate(DEEP, duration=0.02, progress=False)


SPEEDS = "600:1200 rpm:3"
SMALL: dict[str, Callable[[], xr.Dataset]] = {  # of public functions that give a dataset, but of those that take long
    "simulate": short_run,
    "simulate, deep chamber": deep_run,
    "run_measures": lambda: ab.run_measures(short_run()),
    "deflection_envelope": lambda: ab.run_measures(short_run(), "deflection_envelope"),
    "peak_deflection": lambda: ab.run_measures(short_run(), "peak_deflection"),
    "sweep": lambda: ab.sweep(DISCOIDAL, {"viscosity": ["5 mm^2/s"]}, duration=0.1, progress=False),
    "compare": lambda: ab.compare({"one": DISCOIDAL}, duration=0.1),
    "basin": lambda: ab.basin(DISCOIDAL, "90 rad/s", random=4, hold=0.1),
    "stepped_response": lambda: ab.stepped_response(DISCOIDAL, SPEEDS, dwell=0.05, window=0.05),
    "stability.eigenvalues": lambda: ab.stability.eigenvalues(DISCOIDAL, SPEEDS),
    "stability.equilibria": lambda: ab.stability.equilibria(DISCOIDAL, 90.0),
    "stability.border_curve": lambda: ab.stability.border_curve(DISCOIDAL, "viscosity", "1:100 mm^2/s:2:log"),
    "stability.map": lambda: ab.stability.map(DISCOIDAL, {"speed": SPEEDS, "viscosity": ["1 mm^2/s"]}, borders=0),
    "stability.branches": lambda: ab.stability.branches(DISCOIDAL, "speed", 64.0, 66.0, orbits=False),
    "rotor.modes": lambda: ab.rotor.modes(RIGID),
    "rotor.campbell": lambda: ab.rotor.campbell(RIGID, "0:6000 rpm:9"),
    "rotor.critical_speeds": lambda: ab.rotor.critical_speeds(RIGID),
    "rotor.response": lambda: ab.rotor.response(RIGID, "600:6000 rpm:9"),
    "rotor.response_peaks": lambda: ab.rotor.response_peaks(RIGID, "600 rpm", "6000 rpm"),
    "rotor.whirl_orbits": lambda: ab.rotor.whirl_orbits(RIGID, "1200 rpm"),
    "chamber.collision_statistics": lambda: ab.run_measures(deep_run(), "collision_statistics"),
    "chamber.balls_unbalance": lambda: ab.run_measures(deep_run(), "balls_unbalance"),
    "measure.load_receptance": lambda: ab.measure.load_receptance(HAMMER),
    "measure.decay_rate": lambda: ab.measure.decay_rate(TIME, np.exp(-2.0 * TIME) * np.cos(60.0 * TIME)),
    "measure.equilibrium_angle": lambda: ab.measure.equilibrium_angle(ab.example("equilibrium_angle")),
}


def test_what_a_measure_means_is_said_once_for_all_balls() -> None:
    names, _, _, _, meanings = (column.cells() for column in ab.run_measures(short_run()).columns())
    said = [meaning != "" for name, meaning in zip(names, meanings, strict=True) if name == "greatest_ball_speed"]
    assert said == [True, False]


@pytest.mark.parametrize("name", SMALL)
def test_a_result_shows_itself_and_comes_back_from_a_file_as_what_it_was(name: str, tmp_path: Path) -> None:
    found = SMALL[name]()
    assert "<xarray" not in repr(found)
    assert repr(found).splitlines()[-1]
    assert len(repr(found).splitlines()) < 60
    assert "<details>" in found._repr_html_()
    again = ab.load_run(ab.save_run(found, tmp_path / "result.nc"))
    assert (type(again), repr(again)) == (type(found), repr(found))
    for key, value in found.attrs.items():
        assert str(np.asarray(again.attrs[key]).tolist()) == str(np.asarray(value).tolist()), key  # nan is nan
        assert isinstance(again.attrs[key], list) == isinstance(value, (list, tuple)), key
    assert again.drop_attrs().identical(found.drop_attrs())


def test_a_run_of_an_earlier_version_shows_itself_too(balanced: xr.Dataset, tmp_path: Path) -> None:
    balanced.to_netcdf(tmp_path / "old.nc", engine="netcdf4")
    assert repr(ab.load_run(tmp_path / "old.nc")) == repr(balanced)
    unknown = balanced.assign_attrs(answer="FromTheFuture")
    unknown.to_netcdf(tmp_path / "new.nc", engine="netcdf4")
    assert repr(ab.load_run(tmp_path / "new.nc")).startswith("<xarray.")


def test_every_kind_of_answer_can_be_read_back() -> None:
    source = Path(ab.__file__).parent
    classes = [
        (path.relative_to(source).with_suffix("").as_posix().replace("/", "."), *found.groups())
        for path in source.rglob("*.py")
        for found in re.finditer(r"^class (\w+)\((\w+)", path.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    kinds = {"Answer": "results.answers.answer"}
    while below := {name: home for home, name, base in classes if base in kinds and name not in kinds}:
        kinds |= below
    del kinds["Answer"]
    assert kinds == HOMES, "each class stands in the table of results/answers/kinds.py, by which a file is read back"
    forms = {name for path in source.rglob("*.py") for name in re.findall(r'^FORMS\["(\w+)"\]', path.read_text(), re.M)}
    given = {name for path in source.rglob("*.py") for name in re.findall(r'Answer\.of\(.*"(\w+)"\)', path.read_text())}
    assert given | {"Measured", "Ranges"} <= forms == set(FORMS)
    assert not forms & set(HOMES)


def test_lengths_side_by_side_have_one_unit_and_frequencies_are_in_hertz() -> None:
    orbits = ab.rotor.whirl_orbits(RIGID, "1200 rpm")
    assert {column.unit for column in orbits.columns() if column.head.startswith("semi")} == {"mm"}
    decay = SMALL["measure.decay_rate"]()
    (shown,) = (column for column in decay.columns() if column.head == "frequency")
    assert shown.unit == "Hz"
    assert float(shown.values[0]) == pytest.approx(float(decay["frequency"][0]) / (2.0 * np.pi))


@pytest.mark.parametrize(
    ("shown", "said"),
    [
        (lambda: ab.catalog.bearings(), "... and 388 more"),
        (lambda: ab.catalog.fluids(), "silicone oil 20"),
        (lambda: ab.catalog.materials(), "7860"),
        (lambda: ab.catalog.friction(), "rolling resistance"),
        (lambda: ab.laws.drag_laws(), "free_sphere"),
        (lambda: ab.stability.averaged_border(DISCOIDAL), "averaged border: 612.92 rpm"),
        (
            lambda: ab.stability.stable_windows(DISCOIDAL, "1500 rpm"),
            "stable from 621.47 rpm (65.08 rad/s) to 1500 rpm",
        ),
        (lambda: ab.stability.held_by_friction(ab.example("real_race")), "friction at 1200 rpm"),
        (lambda: ab.rotor.equivalent_planar(RIGID), "taken: modal"),
        (lambda: ab.verdict(short_run()), "no verdict: "),
    ],
)
def test_what_is_no_dataset_shows_itself_in_a_few_lines_too(shown: Callable[[], object], said: str) -> None:
    text = repr(shown())
    assert said in text
    assert len(text.splitlines()) < 60
    assert max(map(len, text.splitlines())) < 200
