"""Laws and joints of one's own on the command line: a file that it is told to load, and machine files that name what is in it."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
import tomli_w
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import MachineError
from autobalancer.files.examples import example_text
from autobalancer.machine import Drag, FrictionLaw, Joint
from autobalancer.machine import plugins as leaves

RUNNER = CliRunner()
MACHINES = Path("examples/machines")
OWN = '''
from typing import ClassVar, Literal

import numpy as np

import autobalancer as ab
from autobalancer.machine import Drag, FrictionLaw, PointJoint


class Dimpled(Drag):
    """Dimpled balls."""

    law: Literal["dimpled"] = "dimpled"
    interface: ClassVar[int] = 1

    def curve(self, ball):
        return self.listed()[0]

    @classmethod
    def listed(cls):
        return (ab.laws.sampled_drag_law(lambda re: 387 / re + 0.4, name="dimpled", source="our rig"),)


class Foot(PointJoint):
    """A foot under the middle of a housing."""

    kind: Literal["foot"] = "foot"
    interface: ClassVar[int] = 1

    def matrices(self, speed):
        k = np.diag([5e4, 5e4, 3e5, 2600.0, 2600.0, 700.0])
        return k, 1.5e-3 * k


class Soap(FrictionLaw):
    """Soap on the wall."""

    kind: Literal["soap"] = "soap"
    interface: ClassVar[int] = 1

    @staticmethod
    def coefficient(at, own):
        return 0.3 * at.sliding * at.slip / (abs(at.slip) + at.slip_speed)
'''


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(leaves, "_registered", dict(leaves._registered))
    path = tmp_path / "own_laws.py"
    path.write_text(OWN, encoding="utf-8")
    return path


def told(*words: str | Path) -> str:
    found = RUNNER.invoke(app, [str(word) for word in words])
    assert found.exit_code == 0, found.output
    return found.output


def written(path: Path, data: dict[str, object]) -> Path:
    path.write_text(tomli_w.dumps(data), encoding="utf-8")
    return path


def test_a_drag_law_from_a_file_is_listed_and_used(own: Path, tmp_path: Path) -> None:
    rows = json.loads(told("--load", own, "catalog", "drag-laws", "--reynolds", "1000", "--json"))
    (found,) = (row for row in rows if row["name"] == "dimpled")
    assert found["coefficient"] == pytest.approx([0.787], rel=1e-4)
    data = tomllib.loads((MACHINES / "discoidal.toml").read_text(encoding="utf-8"))
    data["balancers"][0]["races"][0]["drag"] = {"law": "dimpled"}
    machine, out = written(tmp_path / "m.toml", data), tmp_path / "run.nc"
    told("--load", own, "simulate", machine, "--duration", "0.5 s", "--out", out)
    assert ab.load_run(out).attrs["drag_law"] == "dimpled"


def test_a_friction_law_from_a_file_lets_balls_slide_longer(own: Path, tmp_path: Path) -> None:
    data = tomllib.loads((MACHINES / "resolved_balls.toml").read_text(encoding="utf-8"))
    spins = []
    for law in ({}, {"friction_law": {"kind": "soap"}}):
        race = data["balancers"][0]["races"][0]
        race["resolved"] = {key: value for key, value in race["resolved"].items() if key != "start_gap"} | law
        machine, out = written(tmp_path / "m.toml", data), tmp_path / f"run{len(spins)}.nc"
        told("--load", own, "simulate", machine, "--duration", "0.5 s", "--out", out)
        spins.append(ab.load_run(out)["ball_spin"].values)
    assert np.isfinite(spins[1]).all()
    assert np.abs(spins[0][-1] - spins[1][-1]).max() > 1e-6


def test_a_joint_from_a_file_carries_a_rig(own: Path, tmp_path: Path) -> None:
    data = tomllib.loads(example_text("discoidal_rig"))
    data["rotor"]["joints"][-1] = {"kind": "foot", "between": ["base", "ground"], "position": 0.0}
    machine = written(tmp_path / "rig.toml", data)
    rows = told("--load", own, "modes", machine, "--speed", "0 rpm", "--json")
    assert len(json.loads(rows)) > 0


def test_an_installed_package_brings_its_laws_and_joints(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = own.parent / "own_laws-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: own-laws\nVersion: 1.0\n")
    words = {Drag: "dimpled", FrictionLaw: "soap", Joint: "foot"}
    groups = [f"[autobalancer.{base.family}]\n{word} = own_laws:{word.title()}\n" for base, word in words.items()]
    (folder / "entry_points.txt").write_text("".join(groups))
    monkeypatch.syspath_prepend(str(own.parent))
    for base, word in words.items():
        leaf = leaves.find(base, word)
        assert (leaf.__module__, leaf.word()) == ("own_laws", word)
        assert issubclass(leaf, base)
    with pytest.raises(MachineError, match="given 'soap'; must be one of"):
        leaves.find(Joint, "soap")


def test_without_its_file_a_law_is_refused_with_what_to_do(tmp_path: Path) -> None:
    data = tomllib.loads((MACHINES / "discoidal.toml").read_text(encoding="utf-8"))
    data["balancers"][0]["races"][0]["drag"] = {"law": "dimpled"}
    found = RUNNER.invoke(app, ["check", str(written(tmp_path / "m.toml", data))])
    assert found.exit_code == 2
    assert "drag.law: given 'dimpled'" in " ".join(found.output.split())
    assert "--load FILE" in " ".join(found.output.split())


def test_an_option_after_the_command_that_stands_before_it_is_refused_with_its_place(own: Path) -> None:
    found = RUNNER.invoke(app, ["check", "--load", str(own), "m.toml"])
    assert found.exit_code == 2
    assert "--load stands before the command: autobalancer --load ... check" in " ".join(found.output.split())
    assert "stands before" not in RUNNER.invoke(app, ["check", "--lod", str(own), "m.toml"]).output
