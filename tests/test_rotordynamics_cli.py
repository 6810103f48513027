"""``autobalancer modes`` and ``autobalancer response`` as a user types them."""

from __future__ import annotations

import json
import math
import re
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
import typer
from tests.references.pictures import size_of
from tests.test_rotordynamics_modes import MACHINES, RIG
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.results.store import load_run
from autobalancer.rotordynamics.campbell import campbell, critical_speeds, modes
from autobalancer.rotordynamics.response import response_peaks

RIG_FILE = files("autobalancer") / "catalog" / "data" / "rigs" / "rodrigues_rig.toml"
RPM = math.pi / 30.0


def say(*words: str, code: int = 0) -> str:
    answer = CliRunner().invoke(app, list(words))
    assert answer.exit_code == code, answer.output
    return answer.output


def test_modes_prints_frequencies_and_critical_speeds() -> None:
    text = say("modes", str(RIG_FILE), "--speed", "1200 rpm")
    assert "natural frequencies at 1200 rpm" in text
    for name in ("cylindrical y", "cylindrical x", "conical y", "conical x"):
        assert name in text
    for speed in critical_speeds(RIG)["critical_speed"].values / RPM:
        assert f"{speed:.5g}" in text
    assert "rad/s" in say("modes", str(RIG_FILE), "--speed-unit", "rad/s", "--frequency-unit", "rad/s")


def test_modes_as_json_are_those_of_the_python_interface() -> None:
    found = json.loads(say("modes", str(RIG_FILE), "--speed", "100 rad/s", "--json"))
    expected = modes(RIG, 100.0)
    assert found["speed"] == 100.0
    assert found["frequency"] == expected["frequency"].values.tolist()
    assert found["whirl"] == expected["whirl"].values.tolist()
    assert len(found["critical_speeds"]["critical_speed"]) == 4
    bare = json.loads(say("modes", str(RIG_FILE), "--no-balls", "--json"))
    assert bare["frequency"][0] > json.loads(say("modes", str(RIG_FILE), "--json"))["frequency"][0]


def test_a_campbell_diagram_goes_to_picture_and_file(tmp_path: Path) -> None:
    text = say(
        "campbell", str(RIG_FILE), "--speeds", "0 rpm:6000 rpm:41", "--plot", str(tmp_path / "c.svg"), "--out",
        str(tmp_path / "c.nc"),
    )  # fmt: skip
    assert "written" in text
    assert "Campbell diagram" in (tmp_path / "c.svg").read_text()
    expected = campbell(RIG, np.linspace(0.0, 6000.0 * RPM, 41))
    kept = load_run(tmp_path / "c.nc")
    assert kept["frequency"].values == pytest.approx(expected["frequency"].values)
    found = json.loads(say("campbell", str(RIG_FILE), "--speeds", "0:6000 rpm:41", "--json"))
    assert found["intersection_speed"] == pytest.approx(kept["intersection_speed"].values)


def test_shapes_are_drawn(tmp_path: Path) -> None:
    say("modes", str(MACHINES / "discoidal.toml"), "--plot", str(tmp_path / "m.png"))
    assert size_of(tmp_path / "m.png") == (1320, 420)


def test_response_prints_the_peaks_between_the_speeds(tmp_path: Path) -> None:
    text = say(
        "response", str(RIG_FILE), "--speeds", "600rpm:5500rpm:400", "--station", "B1", "--station", "B2", "--plot",
        str(tmp_path / "bode.png"), "--out", str(tmp_path / "r.nc"),
    )  # fmt: skip
    peaks = response_peaks(RIG, 600.0 * RPM, 5500.0 * RPM, ["B1", "B2"])
    assert peaks.sizes["peak"] == 4
    for speed in peaks["peak_speed"].values / RPM:
        assert f"{speed:.5g}" in text
    kept = load_run(tmp_path / "r.nc")
    assert list(kept["station"].values) == ["B1", "B2"]
    assert kept.sizes["speed"] == 400


def test_response_at_one_speed_says_how_the_stations_whirl(tmp_path: Path) -> None:
    for kind, size in (("orbits", (1500, 630)), ("axis", (1230, 720))):
        text = say("response", str(RIG_FILE), "--speeds", "1675 rpm", "--plot", str(tmp_path / "o.png"), "--kind", kind)
        assert re.search(r"B1 +backward", text)
        assert re.search(r"disk +forward", text)
        assert size_of(tmp_path / "o.png") == size


def test_response_as_json_is_that_of_the_python_interface() -> None:
    arguments = (
        "--speeds",
        "10:100 rad/s:4",
        "--station=-20 mm",
        "--unbalance",
        "10 g*mm",
        "--balls",
        "--quantity",
        "velocity",
    )
    found = json.loads(say("response", str(RIG_FILE), *arguments, "--json"))
    expected = ab.rotor.response(RIG, np.linspace(10, 100, 4), [-0.02], 1e-5, balls=True, quantity="velocity")
    assert found["speed"] == expected["speed"].values.tolist()
    assert found["semi_major"] == expected["semi_major"].values.tolist()
    assert found["quantity"] == "velocity"


def test_a_planar_machine_has_a_response_in_its_plane() -> None:
    found = json.loads(say("response", str(MACHINES / "discoidal.toml"), "--speeds", "10:100 rad/s:4", "--json"))
    assert found["station"] == ["annulus of the disc"]
    assert found["position"] == [None]


def test_a_range_without_a_count_has_as_many_speeds_as_curves_need() -> None:
    short, whole = (
        json.loads(say("response", str(MACHINES / "discoidal.toml"), "--speeds", text, "--json"))["speed"]
        for text in ("10:100 rad/s", "10:100 rad/s:401")
    )
    assert short == whole
    short, whole = (
        json.loads(say("eigenvalues", str(MACHINES / "discoidal.toml"), "--speeds", text, "--json"))["growth_rate"]
        for text in ("60:100 rad/s", "60:100 rad/s:401")
    )
    assert short == whole


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("modes", "none.toml"), "no such file"),
        (("modes", "RIG", "--speed", "-5 rad/s"), "given -5 rad/s"),
        (("modes", "RIG", "--speed", "5 kg"), "rad/s"),
        (("campbell", "RIG", "--speeds", "0:9 rpm"), "without the number of values"),
        (("campbell", "RIG", "--speeds", "0:9 rpm:1"), "at least two"),
        (("modes", "RIG", "--modes", "0"), "given 0"),
        (("modes", "RIG", "--speed-unit", "knots"), "is not one of 'rpm'"),
        (("response", "RIG", "--speeds", "100:50 rpm:5"), "must ascend"),
        (("response", "RIG", "--speeds", "-1:50 rpm"), "given '-1:50 rpm'; must ascend"),
        (("response", "RIG", "--speeds", "50 rpm", "--station", "B9"), "no station is named 'B9'"),
        (("response", "RIG", "--speeds", "50 rpm", "--quantity", "jerk"), "given 'jerk'"),
        (("response", "RIG", "--speeds", "50 rpm", "--kind", "bode"), "orbits or axis"),
        (("response", "RIG", "--speeds", "10:50 rpm:5", "--kind", "axis"), "bode or polar"),
    ],
)
def test_what_a_user_can_mend_ends_with_code_2_and_a_message(
    words: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    answer = CliRunner().invoke(app, [str(RIG_FILE) if word == "RIG" else word for word in words])
    assert answer.exit_code == 2
    assert message in " ".join(answer.output.split())


def test_the_commands_are_registered_with_an_example() -> None:
    group = typer.main.get_command(app)
    assert {"modes", "campbell", "response"} <= set(group.commands)  # type: ignore[attr-defined]
    for name in ("modes", "campbell", "response"):
        assert f"Example: autobalancer {name}" in group.commands[name].help  # type: ignore[attr-defined]
