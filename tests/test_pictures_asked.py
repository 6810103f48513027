"""Pictures say what they draw when they are given something else, and open files."""

from __future__ import annotations

from pathlib import Path

import pytest
import xarray as xr
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.public_names import NAMES

OF_RACES = ["run_up", "race", "orbit"]
OF_CHAMBERS = ["chamber_run", "chamber_arrangement"]
OF_OTHERS = {"drag_laws", "machine"}  # draw laws and machines, not results


@pytest.fixture(scope="module")
def short_run() -> xr.Dataset:
    return ab.simulate(ab.example("design"), duration=0.05, save=[ab.Samples()], progress=False)


@pytest.fixture(scope="module")
def short_chamber_run() -> xr.Dataset:
    return xr.Dataset({"body_position": ("time", [0.0])}, {"time": [0.0]}, {"outcome": "finished"})


@pytest.mark.parametrize("name", [name for name in NAMES["plot"] if name not in OF_OTHERS])
def test_every_picture_refuses_a_machine_and_says_what_it_draws(name: str) -> None:
    with pytest.raises(QuestionError, match=rf"^plot\.{name}: given a machine; it draws a (run|result of [a-z]+)"):
        getattr(ab.plot, name)(ab.example("design"))


@pytest.mark.parametrize("name", OF_RACES)
def test_a_picture_of_races_names_those_of_a_deep_chamber(name: str, short_chamber_run: xr.Dataset) -> None:
    with pytest.raises(QuestionError, match=rf"plot\.{name}: given a run of deep chambers; .* plot\.chamber_run"):
        getattr(ab.plot, name)(short_chamber_run)


@pytest.mark.parametrize("name", OF_CHAMBERS)
def test_a_picture_of_a_deep_chamber_names_those_of_races(name: str, short_run: xr.Dataset) -> None:
    with pytest.raises(QuestionError, match=rf"plot\.{name}: given a run of balls in races; .* plot\.run_up"):
        getattr(ab.plot, name)(short_run)


def test_a_picture_opens_the_file_of_a_run_or_a_result(tmp_path: Path, short_run: xr.Dataset) -> None:
    ab.save_run(short_run, tmp_path / "run.nc")
    assert ab.plot.race(tmp_path / "run.nc").axes
    ab.save_run(ab.rotor.modes(ab.example("rigid_rotor")), tmp_path / "modes.nc")
    assert ab.plot.modes(str(tmp_path / "modes.nc")).axes
    with pytest.raises(QuestionError, match=r"plot\.run_up: given a result that is no run"):
        ab.plot.run_up(tmp_path / "modes.nc")
    with pytest.raises(QuestionError, match=r"plot\.modes: given a run; this is not a result of rotor\.modes"):
        ab.plot.modes(short_run)


def test_the_command_draws_whatever_a_file_holds(tmp_path: Path) -> None:
    vary = {"unbalances[1].mass": {"distribution": "normal", "standard_deviation": "5 %"}}
    asked = {"machine": ab.example("discoidal"), "members": 20, "duration": "0.2 s", "vary": vary}
    study = ab.study(asked, progress=False)
    kinds = {"study": "study, shares, distribution, scatter, rest-positions", "drives": "sensitivity"}
    kinds["eigenvalues"] = "eigenvalues"
    ab.save_run(study, tmp_path / "study.nc")
    ab.save_run(ab.sensitivity(study, "peak_deflection"), tmp_path / "drives.nc")
    ab.save_run(ab.stability.eigenvalues(ab.example("discoidal"), "900:1200 rpm:3"), tmp_path / "eigenvalues.nc")
    for name, there in kinds.items():
        told = CliRunner().invoke(
            app, ["plot", str(tmp_path / f"{name}.nc"), "--out", str(tmp_path / f"{name}.png"), "--kind", "picture"]
        )
        assert (tmp_path / f"{name}.png").exists(), told.output
        told = CliRunner().invoke(app, ["plot", str(tmp_path / f"{name}.nc"), "--kind", "race"])
        assert f"there are {there}" in " ".join(told.output.split())
