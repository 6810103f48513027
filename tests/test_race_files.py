"""Measured profiles in files beside the machine file."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from autobalancer.assembly.guided_balls import race_harmonics
from autobalancer.errors import MachineFileError
from autobalancer.files.machine_file import load_race_machine, machine_text, parse_machine

MACHINE = """
name = "measured"
axis = "vertical"
rotor = { kind = "planar", mass = 10, stiffness = 1e5, damping = 50 }
drive = { kind = "speed", profile = { kind = "constant", speed = 100 } }

[[balancers]]
[[balancers.races]]
orbit_radius = "80 mm"
drag = { law = "viscous", damping = 1e-4 }
balls = [{ diameter = "10 mm", material = "steel" }]
"""
ROUND = 'roundness = { file = "roundness.csv", harmonics = 5 }\n'
SHAKEN = '[[excitations]]\nkind = "recorded_base_motion"\nfile = "floor.csv"\n'


def written(folder: Path, extra: str, **files: str) -> Path:
    for name, text in files.items():
        (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    path = folder / "machine.toml"
    path.write_text(MACHINE + extra, encoding="utf-8")
    return path


def oval(count: int = 36, *, repeat: bool = False) -> str:
    angles = np.arange(count + repeat) * 360.0 / count + 5.0
    rows = [f"{a:.6f}, {20.0 * math.cos(2.0 * math.radians(a - 30.0)):.9f}" for a in angles]
    return "# measured with a stylus\nangle [deg], deviation [um]\n" + "\n".join(rows) + "\n"


@pytest.mark.parametrize("repeat", [False, True])
def test_a_roundness_profile_comes_from_a_file_with_units(tmp_path: Path, repeat: bool) -> None:
    machine = load_race_machine(written(tmp_path, ROUND, roundness=oval(repeat=repeat)))
    waves = race_harmonics(machine.balancers[0].races[0])
    expected = np.zeros((5, 2))
    expected[1] = 20e-6 * np.array([math.cos(math.radians(60.0)), math.sin(math.radians(60.0))])
    np.testing.assert_allclose(waves, expected, atol=1e-13)


def test_a_machine_with_files_is_complete_in_itself(tmp_path: Path) -> None:
    machine = load_race_machine(written(tmp_path, ROUND, roundness=oval()))
    assert ".csv" not in machine_text(machine)
    assert parse_machine(machine_text(machine)) == machine


def test_a_recorded_motion_comes_from_a_file_with_units(tmp_path: Path) -> None:
    table = "time [ms]; acceleration [mm/s^2]\n0; 0\n10; 2500,5\n20; 0\n"
    machine = load_race_machine(written(tmp_path, SHAKEN, floor=table))
    shake = machine.excitations[0]
    np.testing.assert_allclose(shake.time, [0.0, 0.01, 0.02])
    np.testing.assert_allclose(shake.acceleration, [0.0, 2.5005, 0.0])


@pytest.mark.parametrize(
    ("extra", "files", "message"),
    [
        (ROUND, {}, r"races\[1\]\.roundness\.file: .*roundness\.csv: no such file"),
        (ROUND, {"roundness": "angle, deviation\n0, 1\n"}, r"no column 'angle' with a unit; .* angle \[rad\], deviation \[m\]"),
        (ROUND, {"roundness": "angle [deg], deviation [s]\n0, 1\n1, 2\n"}, "unit of column 'deviation'"),
        (ROUND, {"roundness": "angle [deg], deviation [um]\n0, 1\n1, x\n"}, "line 3, column 'deviation': .* not a number"),
        (ROUND, {"roundness": "angle [deg], deviation [um]\n0, 1\n1\n"}, "line 3: 1 cells for 2 columns"),
        (ROUND, {"roundness": "angle [deg], deviation [um]\n0, 1\n90, 1\n200, 0\n300, 1\n"}, "equal steps of 90 deg"),
        (ROUND.replace("harmonics = 5", "deviations = [0]"), {"roundness": oval()}, "is read from 'file'; leave one of them out"),
        (SHAKEN.replace("recorded_base_motion", "force"), {}, "only the kinds 'recorded_base_motion', 'recorded_force'"),
        (SHAKEN, {"floor": "time [s], force [N]\n0, 1\n1, 0\n"}, "no column 'acceleration'"),
    ],
)  # fmt: skip
def test_a_profile_that_cannot_be_read_says_why(
    tmp_path: Path, extra: str, files: dict[str, str], message: str
) -> None:
    with pytest.raises(MachineFileError, match=message):
        load_race_machine(written(tmp_path, extra, **files))


def test_a_profile_in_a_file_must_be_closed_too(tmp_path: Path) -> None:
    rows = "\n".join(f"{10 * i}, {i}" for i in range(36))
    with pytest.raises(MachineFileError, match="not closed"):
        load_race_machine(written(tmp_path, ROUND, roundness=f"angle [deg], deviation [um]\n{rows}\n"))
