"""The commands as a user types them."""

from __future__ import annotations

import json
import pkgutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
COMMAND = [sys.executable, "-m", "autobalancer"]


def run(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([*COMMAND, *arguments], cwd=cwd, capture_output=True, text=True, check=False)


def test_from_machine_file_to_pictures(tmp_path: Path) -> None:
    machine = str(MACHINES / "discoidal.toml")
    answer = run("simulate", machine, "--duration", "3 s", "--out", "run.nc", "--json", cwd=tmp_path)
    assert answer.returncode == 0, answer.stderr
    found = json.loads(answer.stdout)
    assert found["outcome"] == "finished"
    assert found["measures"]["peak_deflection"] == float(
        ab.run_measures(ab.load_run(tmp_path / "run.nc"), "peak_deflection")["deflection"]
    )
    drawn = CliRunner().invoke(app, ["plot", str(tmp_path / "run.nc"), "--out", str(tmp_path / "pictures")])
    assert drawn.exit_code == 0, drawn.output
    assert len(list((tmp_path / "pictures").glob("*.png"))) == 3


def test_check_says_the_same_as_the_python_interface() -> None:
    answer = CliRunner().invoke(app, ["check", str(MACHINES / "discoidal.toml"), "--json"])
    found, expected = json.loads(answer.stdout), ab.check(MACHINES / "discoidal.toml")
    assert found["critical_speeds"] == list(expected.critical_speeds)
    assert [border["speed"] for border in found["borders"]] == [border.speed for border in expected.borders]


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize(
    ("place", "duration", "outcome"),
    [
        ("autobalancer.simulation.steppers.Stepper.advance", 1e6, "interrupted"),  # while it runs
        ("autobalancer.simulation.run.run_dataset", 0.01, "finished"),  # when its result is put together
        ("os.fsync", 0.01, "finished"),  # while its file is written
    ],
)
def test_ctrl_c_at_any_place_keeps_what_was_computed_in_a_whole_file(
    place: str, duration: float, outcome: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    module, _, name = place.rpartition(".")
    called = getattr(pkgutil.resolve_name(module), name)

    def pressed(*arguments: Any) -> Any:
        with suppress(KeyboardInterrupt):  # so does Numba with what is raised while it reads arguments
            signal.raise_signal(signal.SIGINT)
        return called(*arguments)

    monkeypatch.setattr(place, pressed)
    machine, out = str(MACHINES / "stall_and_release.toml"), tmp_path / "long.nc"
    answer = CliRunner().invoke(app, ["simulate", machine, "--duration", f"{duration} s", "--out", str(out)])
    assert answer.exit_code == 130, answer.output
    kept = ab.load_run(out)
    assert kept.attrs["outcome"] == outcome
    assert 0.0 < kept.attrs["end_time"] <= duration
    assert kept.attrs["end_time"] == duration or outcome == "interrupted"
    assert kept.sizes["time"] >= 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["simulate", "MACHINE", "--duration", "5 kg"], "a quantity in s is wanted"),
        (["plot", "none.nc"], "none.nc: no such file"),
        (["eigenvalues", "MACHINE", "--speeds", "fast"], "fast"),
        (["basin", "MACHINE", "--speed", "1200 rpm"], "one or two axes"),
    ],
)
def test_what_a_user_can_mend_ends_with_code_2_and_a_message(arguments: list[str], message: str) -> None:
    machine = str(MACHINES / "discoidal.toml")
    answer = CliRunner().invoke(app, [machine if word == "MACHINE" else word for word in arguments])
    assert answer.exit_code == 2
    assert message in answer.stderr
    assert "Traceback" not in answer.output


def test_a_file_that_is_missing_ends_a_process_with_code_2_and_a_message(tmp_path: Path) -> None:
    answer = run("simulate", "none.toml", cwd=tmp_path)
    assert answer.returncode == 2
    assert "none.toml: no such file" in answer.stderr
    assert "Traceback" not in answer.stderr


def test_every_command_has_an_example_in_its_help(tmp_path: Path) -> None:
    import typer

    names = dict(typer.main.get_command(app).commands)  # type: ignore[attr-defined]
    assert {"check", "simulate", "plot", "animate", "eigenvalues", "borders", "map", "basin", "receptance"} <= set(
        names
    )
    for name, command in names.items():
        assert hasattr(command, "commands") or "Example: autobalancer" in command.help, name


def test_a_command_loads_no_library_that_it_does_not_use(tmp_path: Path) -> None:
    machine = "examples/machines/discoidal.toml"
    strangers = {"dask", "distributed", "pint", "matplotlib", "scipy.optimize", "scipy.interpolate", "rich.progress"}
    for words, heavy in (
        (["--help"], {"numpy", "pydantic", "numba", "scipy", "xarray"}),
        (["check", machine], {"pandas", "xarray", "pint", "matplotlib", "netCDF4"}),
        (["simulate", machine, "--duration", "0.1 s", "--out", str(tmp_path / "run.nc")], strangers),
    ):
        code = (
            f"import sys; sys.argv = ['autobalancer', *{words}]\nfrom autobalancer.__main__ import main\ntry: main()\n"
        )
        code += f"except SystemExit: pass\nprint(sorted({heavy} & set(sys.modules)), file=sys.stderr)"
        answer = subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=Path(__file__).parents[1]
        )
        assert answer.stderr.strip().splitlines()[-1] == "[]"


def test_importing_the_package_is_light_and_without_side_effects(tmp_path: Path) -> None:
    heavy = "numpy numba xarray pint pydantic matplotlib scipy"
    code = f"import sys, autobalancer; print([m for m in '{heavy}'.split() if m in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert answer.stdout.strip() == "[]"


def test_every_public_name_can_be_imported() -> None:
    for name in ab.__all__:
        assert getattr(ab, name) is not None
    assert sorted(ab.__all__) == ab.__all__


@pytest.mark.parametrize(
    ("file", "old", "new", "message"),
    [
        ("docs/machines/real_race.toml", "height", "# height", "height: missing; the flow in the race needs it"),
        (
            "examples/machines/resolved_balls.toml",
            'stiffness = "1000 kN/m"',
            'stiffness = "1 N/m"',
            "the wall is compressed by",
        ),
        (
            "docs/machines/real_race.toml",
            "rolling_resistance = 0.005, adherence = 0.006 }",
            "rolling_resistance = 5, adherence = 6 } # ",
            "far below 1",
        ),
    ],
)
def test_check_refuses_what_a_run_would_refuse(file: str, old: str, new: str, message: str, tmp_path: Path) -> None:
    text = (MACHINES.parents[1] / file).read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "machine.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    answer = CliRunner().invoke(app, ["check", str(tmp_path / "machine.toml")])
    assert answer.exit_code == 2
    assert message in " ".join(answer.output.split())
