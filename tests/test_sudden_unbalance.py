"""An unbalance that appears at speed: what the rotor does at once, where the balls go, and that two runs are one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.errors import QuestionError

MACHINE = str(Path(__file__).parents[1] / "examples/machines/discoidal.toml")
SPEED, BEFORE, AFTER = 125.0, 40.0, 20.0
ADDED, ANGLE = 2e-4, 2.0  # kg m, rad
SUDDEN = {"moment": ADDED, "angle": ANGLE, "speed": SPEED, "before": BEFORE, "after": AFTER}
ASKED: dict[str, Any] = {"machine": MACHINE, "members": 3, "tolerance": 1e-9, "sudden_unbalance": SUDDEN}


def at_speed(schedule: dict[str, Any] | None) -> Any:
    """The machine at its speed, with the unbalance that is added."""
    machine = ab.load_machine(MACHINE)
    machine = ab.with_parameter(machine, "drive", {"kind": "speed", "profile": {"kind": "constant", "speed": SPEED}})
    own = {"moment": ADDED, "angle": ANGLE, **({"schedule": schedule} if schedule else {})}
    machine = ab.with_parameter(machine, "unbalances", (*machine.unbalances, own))
    return ab.with_parameter(machine, "balancers[1].races[1].balls[1].start_angles", None)


def test_the_two_joined_runs_are_one_run_with_a_jump() -> None:
    found = ab.study(ASKED)
    once = at_speed({"time": [BEFORE, BEFORE], "factor": [0.0, 1.0]})
    for member in range(3):
        run = ab.simulate(once, duration=BEFORE + AFTER, seed=member, tolerance=1e-9, save=[ab.Envelope(1500)])
        wanted = ab.run_measures(run)
        assert found["peak_deflection"].values[member] == pytest.approx(float(wanted["peak_after_jump"][0]), rel=1e-6)
        # settling is known to a bin: 20 s / 500 and 60 s / 1500
        assert found["settling_time"].values[member] == pytest.approx(
            float(wanted["settling_after_jump"][0]), abs=0.081
        )
        last = run["envelope_ball_angle_in_rotor"].values[-1]
        end = found["ball_angle_to_unbalance"].values[member]
        gone = (end - end[0]) - (last - last[0])
        np.testing.assert_allclose(np.exp(1j * gone), 1.0, atol=1e-5)
    assert found["balanced_before"].values.all()


def test_settled_balls_leave_the_rotor_to_the_added_unbalance_alone() -> None:
    held = {**SUDDEN, "after": 0.12}  # two turns of the rotor, in which balls in oil go nowhere
    found = ab.study({**ASKED, "sudden_unbalance": held, "members": 2})
    machine = ab.load_machine(MACHINE)
    critical = float(ab.rotor.critical_speeds(MACHINE)["critical_speed"][0])
    mass = machine.rotor.stiffness_xy[0] / critical**2
    damping, stiffness = machine.rotor.damping_xy[0], machine.rotor.stiffness_xy[0]
    forced = SPEED**2 * ADDED / (stiffness - mass * SPEED**2 + 1j * damping * SPEED)
    roots = np.roots([mass, damping, stiffness])
    free = np.linalg.solve(np.array([[1.0, 1.0], roots]), [-forced, -1j * SPEED * forced])
    time = np.linspace(0.0, 0.12, 20_000)
    motion = forced * np.exp(1j * SPEED * time) + (free * np.exp(time[:, None] * roots)).sum(axis=1)
    # the balls lag by a few degrees in that time: 1 % of the deflection
    np.testing.assert_allclose(found["peak_deflection"], np.abs(motion).max(), rtol=0.01)


def test_the_balls_come_to_rest_where_the_unbalance_with_the_added_one_is_balanced() -> None:
    found = ab.study(ASKED)
    states = ab.stability.equilibria(at_speed(None), SPEED)
    balanced = states.isel(state=int(np.argmin(states["residual_unbalance"].values)))
    wanted = np.sort(np.mod(balanced["ball_angle_in_rotor"].values, 2.0 * np.pi))
    both = ab.load_machine(MACHINE).unbalances[0].vector + ADDED * np.exp(1j * ANGLE)
    rest = np.sort(np.mod(found["ball_angle_to_unbalance"].values + np.angle(both), 2.0 * np.pi), axis=1)
    np.testing.assert_allclose(rest, np.tile(wanted, (3, 1)), atol=2e-3)
    assert found["balanced"].values.all()
    assert np.all(found["residual_unbalance"] < 1e-3 * ADDED)


def test_the_runs_before_do_not_know_of_what_comes_after() -> None:
    some = ab.study(ASKED)
    other = ab.study({**ASKED, "sudden_unbalance": {**SUDDEN, "moment": 1e-4, "angle": 4.0}})
    # not the same bits: the size of all unbalances sets the size of errors that steps allow
    name = "start_ball_angle_in_rotor"
    np.testing.assert_allclose(some[name].values, other[name].values, atol=1e-6)
    assert not np.array_equal(some["peak_deflection"], other["peak_deflection"])


def test_size_angle_and_speed_may_vary_by_the_names_of_the_table() -> None:
    angle = {"distribution": "uniform", "low": "0 deg", "high": "360 deg"}
    vary = {"sudden_unbalance.speed": ["1000 rpm", "1200 rpm"], "sudden_unbalance": {"angle": angle}}
    found = ab.study({**ASKED, "vary": vary})
    assert list(found.attrs["parameters"]) == ["drive.profile.speed", "unbalances[2].angle"]
    assert found.sizes["member"] == 6
    peaks = found["peak_deflection"].values.reshape(3, 2)
    assert np.ptp(peaks, axis=0).max() < 0.01 * peaks.max()  # whatever the angle, but for balls that begin to move
    assert np.all(peaks[:, 0] > peaks[:, 1])  # nearer to the critical speed
    assert any("from the moment at which the unbalance appears" in line for line in found.remarks())


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({**SUDDEN, "momen": 1}, "sudden_unbalance.momen: unknown key; did you mean 'moment'"),
        ({"moment": 1e-4, "speed": 100.0, "after": 1.0}, "sudden_unbalance.before: missing"),
        ({**SUDDEN, "after": "0 s"}, "sudden_unbalance.after: given '0 s'; must be greater than zero"),
        (3.0, "sudden_unbalance: given 3.0; must be a table"),
    ],
)
def test_a_fault_in_the_table_is_named(table: Any, said: str) -> None:
    with pytest.raises(QuestionError, match=said):
        ab.study({**ASKED, "sudden_unbalance": table})


def test_a_duration_besides_before_and_after_is_refused() -> None:
    with pytest.raises(QuestionError, match="no 'duration': it has 'before' and 'after'"):
        ab.study({**ASKED, "duration": "5 s"})
