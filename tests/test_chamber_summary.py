"""What can be said of a chamber before it runs, against closed forms."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from tests.references.chamber_machines import small_machine
from typer.testing import CliRunner

from autobalancer.assembly.chamber_assembly import contact_time
from autobalancer.cli.main import app
from autobalancer.errors import MachineError
from autobalancer.files.machine_file import save_machine
from autobalancer.laws.capabilities import capability, chamber_capability
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.simulation.chamber.chamber_summary import chamber_summary

BALLS = {"count": 3, "density": 7800.0, "total_mass": 1.0}


def free_rotor(stiffness: tuple[float, float], **rotor: float) -> ChamberMachine:
    """A rotor on two supports at ±0.2 m with a light body, stiff along the axis; no offsets."""
    along = {"stiffness": [1e5, *stiffness], "damping": [0.0, 10.0, 10.0]}
    described: dict[str, Any] = {
        "body": {"freedom": "free", "mass": 1e-6, "inertia": [1e-9, 1e-9, 1e-9]},
        "supports": [{"position": [x, 0.0, 0.0], **along} for x in (0.2, -0.2)],
        "rotor": {"mass": 10.0, "polar_inertia": 0.05, "transverse_inertia": 0.2, "bearings": [0.1, -0.1]} | rotor,
    }
    return small_machine(**described)


@pytest.mark.parametrize("count", [1, 2, 5, 8, 13])
def test_a_single_layer_has_the_capability_of_a_race(count: int) -> None:
    radius, size, density = 0.1, 0.012, 7800.0
    mass = density * math.pi / 6.0 * (2.0 * size) ** 3
    found = chamber_capability(radius, 2.02 * size, [(count, size, mass)])
    assert found == pytest.approx(capability(radius - size, 2.0 * size, density, count), rel=1e-12)


def test_balls_beside_each_other_along_the_axis_add_up() -> None:
    one = chamber_capability(0.1, 0.02, [(3, 0.01, 0.03)])
    assert chamber_capability(0.1, 0.08, [(12, 0.01, 0.03)]) == pytest.approx(4.0 * one, rel=1e-12)
    assert chamber_capability(0.1, 0.2, [(10, 0.01, 0.03)]) == pytest.approx(10 * 0.03 * 0.09, rel=1e-12)


def test_a_full_ring_balances_nothing_and_the_next_layer_something() -> None:
    size = 0.1 * math.sin(math.pi / 10.0) / (1.0 + math.sin(math.pi / 10.0))  # ten balls fill the wall
    assert chamber_capability(0.1, 2.0 * size, [(10, size, 0.1)]) == pytest.approx(0.0, abs=1e-12)
    inner = 0.1 - size * (1.0 + math.sqrt(3.0))
    assert chamber_capability(0.1, 2.0 * size, [(11, size, 0.1)]) == pytest.approx(0.1 * inner, rel=1e-12)


@pytest.mark.parametrize(("count", "size", "depth"), [(14, 0.025, 0.3), (40, 0.025, 0.1), (11, 0.02, 0.04)])
def test_equal_balls_balance_the_same_in_one_group_or_in_many(count: int, size: float, depth: float) -> None:
    whole = chamber_capability(0.1, depth, [(count, size, 0.1)])
    assert chamber_capability(0.1, depth, [(1, size, 0.1)] * count) == pytest.approx(whole, rel=1e-12)
    parts = [(2, size, 0.1), (count - 5, size, 0.1), (3, size, 0.1)]
    assert chamber_capability(0.1, depth, parts) == pytest.approx(whole, rel=1e-12)


def test_a_ring_of_as_many_sizes_as_balls_is_filled_and_the_rest_lies_within() -> None:
    balls = [(1, 0.02 + 1e-6 * i, 0.1) for i in range(15)]
    alike = chamber_capability(0.1, 0.04, [(15, 0.02, 0.1)])
    assert alike > 0.005
    assert chamber_capability(0.1, 0.04, balls) == pytest.approx(alike, rel=2e-3)


def test_two_sizes_side_by_side_balance_with_their_resultant() -> None:
    found = chamber_capability(0.1, 0.02, [(1, 0.01, 0.03), (1, 0.005, 0.004)])
    between = math.asin(0.01 / 0.09) + math.asin(0.005 / 0.095)
    assert found == pytest.approx(abs(0.03 * 0.09 + 0.004 * 0.095 * np.exp(1j * between)), rel=1e-12)


def test_critical_speeds_of_a_rotor_that_tilts_split_by_the_gyroscopic_moment() -> None:
    found = chamber_summary(free_rotor((1e4, 1e4)))
    lateral, forward = math.sqrt(2e4 / 11.0), math.sqrt(2e4 * 0.04 / (0.2 - 0.05))
    np.testing.assert_allclose(found.critical_speeds, [lateral, forward], rtol=1e-5)
    np.testing.assert_allclose(found.damping_ratios[0], 20.0 / (2.0 * lateral * 11.0), rtol=1e-3)
    apart = chamber_summary(free_rotor((1e4, 1.0001e4)))
    backward = math.sqrt(2e4 * 0.04 / (0.2 + 0.05))
    assert len(apart.critical_speeds) == 4
    assert min(abs(speed - backward) for speed in apart.critical_speeds) < 1e-2


def test_the_critical_speeds_of_a_planar_body_count_the_balls() -> None:
    found = chamber_summary(small_machine(supports=[{"position": [0, 0, 0], "stiffness": [0, 3e4, 6e4]}]))
    np.testing.assert_allclose(found.critical_speeds, np.sqrt(np.array([3e4, 6e4]) / 121.0), rtol=1e-9)
    assert found.total_mass == pytest.approx(121.0)
    assert chamber_summary(small_machine(body={"freedom": "fixed"})).critical_speeds == ()


def test_contact_time_and_step_are_those_of_a_run() -> None:
    found = chamber_summary(small_machine())
    run = simulate_chamber(small_machine(), duration=0.002, settle=False)
    assert found.contact_time == run.attrs["contact_time"] == contact_time(small_machine())
    assert run.attrs["step"] == pytest.approx(1e-3 / math.ceil(1e-3 / found.step), rel=1e-12)


def test_what_cannot_balance_is_told() -> None:
    assert chamber_summary(small_machine()).warnings == ()
    weak = chamber_summary(small_machine(unbalances=[{"moment": "0.2 kg*m"}]))
    assert "of 200 kg mm" in weak.warnings[0]
    assert "is fixed" in chamber_summary(small_machine(body={"freedom": "fixed"})).warnings[0]
    slow = {"kind": "speed", "profile": {"kind": "constant", "speed": 5.0}}
    assert "below the critical speeds" in chamber_summary(small_machine(drive=slow)).warnings[0]
    couple = [{"moment": 0.01, "position": 0.1}, {"moment": 0.01, "angle": math.pi, "position": -0.1}]
    found = chamber_summary(small_machine(unbalances=couple))
    assert found.couple_unbalance == pytest.approx(2e-3)
    assert found.unbalance == pytest.approx(0.0, abs=1e-12)
    assert "does not feel the couple" in found.warnings[0]
    many = [{"radius": 0.1, "depth": 0.05, "balls": [BALLS | {"count": 5000, "total_mass": 50.0}]}]
    with pytest.raises(MachineError, match=r"at most \d+ do"):
        chamber_summary(small_machine(chambers=many))


def test_check_prints_what_the_summary_says(tmp_path: Any) -> None:
    path = save_machine(small_machine(), tmp_path / "small.toml")
    found = chamber_summary(path)
    shown = CliRunner().invoke(app, ["check", str(path)], env={"COLUMNS": "200"}).output
    assert f"{100 * 3 / found.chambers[0].room:.3g} % filled" in shown
    assert f"{found.capability / 0.06:.3g} times the unbalance" in shown
    told = json.loads(CliRunner().invoke(app, ["check", str(path), "--json"]).output)
    assert told["step"] == found.step
    refused = CliRunner().invoke(app, ["eigenvalues", str(path)])
    assert refused.exit_code == 2
    assert "there are check, simulate, plot and animate, and for many runs chamber amplitudes" in " ".join(
        refused.output.split()
    )
