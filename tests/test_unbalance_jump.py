"""After a jump of the unbalance a run says how far the rotor went and how long its balls took, apart from the run-up."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.machine import Machine

MASS, STIFFNESS, DAMPING, SPEED, MOMENT, JUMP = 10.0, 625e3, 100.0, 500.0, 5e-4, 4.2345


def thrown(**more: object) -> Machine:
    """A rotor that starts 2 mm off its place, and gets its unbalance when that has long decayed."""
    schedule = {"time": [JUMP, JUMP], "factor": [0.0, 1.0]}
    return Machine(
        name="thrown",
        axis="vertical",
        rotor={"kind": "planar", "mass": MASS, "stiffness": STIFFNESS, "damping": DAMPING},
        unbalances=[{"moment": MOMENT, "schedule": schedule}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": SPEED}},
        start={"deflection": [2e-3, 0.0]},
        run={"duration": 5.0},
        **more,
    )


def suddenly_loaded(time: np.ndarray) -> np.ndarray:
    """Deflection of the rotor at rest that gets a rotating force at time zero: forced whirl and two free ones."""
    forced = SPEED**2 * MOMENT / (STIFFNESS - MASS * SPEED**2 + 1j * DAMPING * SPEED)
    roots = np.roots([MASS, DAMPING, STIFFNESS])
    free = np.linalg.solve(np.array([[1.0, 1.0], roots]), [-forced, -1j * SPEED * forced])
    return np.abs(forced * np.exp(1j * SPEED * time) + (free * np.exp(time[:, None] * roots)).sum(axis=1))


def test_the_peak_after_a_jump_is_that_of_a_rotor_loaded_suddenly() -> None:
    before, after = ab.verdict(ab.simulate(thrown(), save=[ab.Envelope(100), ab.LastRevolutions()])).parts
    wanted = suddenly_loaded(np.linspace(0.0, 5.0 - JUMP, 200_000)).max()
    assert (before.begin, before.end, after.begin) == (0.0, JUMP, JUMP)
    assert before.peak is not None
    assert before.peak.deflection == pytest.approx(2e-3, rel=1e-6)
    assert after.peak is not None
    assert after.peak.deflection == pytest.approx(wanted, rel=1e-5)


@pytest.fixture(scope="module")
def lost() -> Machine:
    """A fan in balance that loses a blade at 5 s."""
    race = {
        "orbit_radius": 0.1,
        "drag": {"law": "viscous", "damping": 1e-3},
        "balls": [{"count": 2, "mass": "4 g", "material": "steel", "start_angles": ["110 deg", "250 deg"]}],
    }
    return Machine(
        name="fan",
        axis="vertical",
        rotor={"kind": "planar", "mass": 10.0, "stiffness": 625e3, "damping": 100.0},
        unbalances=[
            {"moment": "200 g*mm"},
            {"moment": "350 g*mm", "angle": "70 deg", "schedule": {"time": [5.0, 5.0], "factor": [0.0, 1.0]}},
        ],
        balancers=[{"races": [race]}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": "4800 rpm"}},
        run={"duration": 10.0},
    )


@pytest.fixture(scope="module")
def lost_run(lost: Machine) -> xr.Dataset:
    return ab.simulate(lost)


def test_what_is_said_of_the_time_before_a_jump_does_not_know_of_the_jump(lost: Machine, lost_run: xr.Dataset) -> None:
    before = ab.verdict(lost_run).parts[0]
    ended = ab.simulate(lost, duration=5.0)
    assert before.peak is not None
    assert before.settling is not None
    assert before.peak.deflection == pytest.approx(
        float(ab.run_measures(ended, "peak_deflection")["deflection"]), rel=1e-6
    )
    assert before.settling.duration == pytest.approx(float(ab.run_measures(ended, "settling_time").max()), abs=0.01)
    assert before.settling.counted_from == "start"


def test_settling_counts_from_the_jump_and_is_said(lost: Machine, lost_run: xr.Dataset, tmp_path: Path) -> None:
    found = ab.verdict(lost_run)
    after = found.parts[1].settling
    assert after is not None
    assert after.counted_from == "jump"
    assert after.duration == pytest.approx(after.settled_at - 5.0)
    assert 0.05 < after.duration < 2.0
    settled = ab.run_measures(lost_run, "settling_time")
    assert str(settled["counted_from"].values) == "jump"
    assert float(settled.max()) == pytest.approx(after.duration, abs=1e-9)
    numbers = ab.run_measures(lost_run)
    assert float(numbers["jump_time"][0]) == 5.0
    assert float(numbers["settling_after_jump"][0]) == pytest.approx(after.duration)
    assert found.parts[1].peak is not None
    assert float(numbers["peak_after_jump"][0]) == found.parts[1].peak.deflection
    ab.save_run(lost_run, tmp_path / "lost.nc")
    assert ab.verdict(ab.load_run(tmp_path / "lost.nc")).parts == found.parts
    ab.save_machine(lost, tmp_path / "lost.toml")
    said = CliRunner().invoke(app, ["simulate", str(tmp_path / "lost.toml"), "--out", str(tmp_path / "a.nc")]).stdout
    assert "unbalance jumps" in said
    assert "s after the jump" in " ".join(said.split())
    swept = ab.sweep(lost, {"rotor.mass": [10.0]})
    assert float(swept["settling_time"][0]) == pytest.approx(after.duration, abs=0.02)


def test_a_run_without_jumps_has_no_parts(lost: Machine) -> None:
    run = ab.simulate(lost, duration=0.1)
    assert ab.verdict(run).parts == ()
    assert "jump_time" not in ab.run_measures(run)
