"""Kernels are compiled once, and do the same as when interpreted."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

SECOND = """
import autobalancer as ab
from autobalancer.machine import Machine
from autobalancer.simulation.sampling import Envelope, LastRevolutions, Samples
from autobalancer.simulation.events import Event
rotor = {"mass": 10.0, "stiffness": 6e5, "damping": 80.0, "inertia": 0.05}
drive = {"kind": "torque", "torque": 3.0}
machine = Machine(name="second", axis="vertical", rotor=rotor, unbalances=[{"moment": 4e-4}], drive=drive)
run = ab.simulate(machine, duration=1.0, save=[Samples(30), Envelope(5), LastRevolutions(1, 8)],
                  events=[Event("speed", 20.0)])
print("values", [float(v).hex() for v in run.x.values[-3:]], run.attrs["steps"])
"""


def fresh_process(**environment: str) -> str:
    done = subprocess.run(
        [sys.executable, "-c", SECOND], env=os.environ | environment, capture_output=True, text=True, check=True
    )
    return done.stdout


def test_a_second_process_compiles_nothing() -> None:
    fresh_process()
    said = fresh_process(NUMBA_DEBUG_CACHE="1")
    assert "data loaded from" in said
    assert "data saved to" not in said
    assert "index saved to" not in said
    loaded = [line for line in said.splitlines() if "data loaded from" in line]
    assert any("planar" in line for line in loaded)
    assert any("advance" in line for line in loaded)


@pytest.mark.parametrize(
    "asked",
    [
        "simulate('examples/machines/rigid_rotor.toml', duration=0.05)",
        "simulate('docs/machines/real_race.toml', duration=0.05)",
        "basin('examples/machines/discoidal.toml', 100.0, random=2, hold=0.1)",
    ],
)
def test_a_second_process_compiles_nothing_for_other_rotors_races_and_questions(asked: str) -> None:
    process = [sys.executable, "-c", f"import autobalancer as ab; print(ab.{asked})"]

    def said(**environment: str) -> str:
        here = {"env": os.environ | environment, "cwd": Path(__file__).parents[1]}
        return subprocess.run(process, **here, capture_output=True, text=True, check=True).stdout  # type: ignore[call-overload]

    said()
    again = said(NUMBA_DEBUG_CACHE="1")
    assert "data loaded from" in again
    assert "data saved to" not in again


def test_kernels_compiled_before_the_newest_change_in_any_kernel_are_forgotten(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Numba would keep a stepper although a function compiled into it has changed."""
    from autobalancer.kernels.cache import compiled_before, forget_outdated

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    folder = tmp_path / "integrators_0123"
    folder.mkdir()
    old, new = folder / "runge_kutta.advance-1.py311.nbi", folder / "guided_balls.planar-2.py311.nbi"
    foreign = folder / "someone.else-3.py311.nbi"
    for path in (old, new, foreign):
        path.touch()
    for path in (old, foreign):
        os.utime(path, (1e9, 1e9))
    assert compiled_before()
    forget_outdated()
    assert not compiled_before()
    assert [old.exists(), new.exists(), foreign.exists()] == [False, True, True]


def test_interpreted_kernels_do_the_same_as_compiled_ones() -> None:
    compiled, interpreted = fresh_process(), fresh_process(NUMBA_DISABLE_JIT="1")
    values = [[float.fromhex(word.strip("[',]")) for word in said.split()[1:4]] for said in (compiled, interpreted)]
    np.testing.assert_allclose(values[0], values[1], rtol=1e-9, atol=1e-16)
    assert compiled.split()[-1] == interpreted.split()[-1]
