"""Equal balls that pass through each other, in one place."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.errors import QuestionError
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from autobalancer.simulation.record import Samples
from autobalancer.studies.stepped_response import stepped_response

RPM = math.pi / 30.0
SPEED = 480.0  # above the critical speed of 250 rad/s, where balls in one place are driven apart


def one_washer(name: str = "rodrigues_rig_point_balls") -> Machine:
    """The rig of Rodrigues et al. (2011) with its least unbalance."""
    machine = rig(name)
    for path, value in (
        ("unbalances[1].moment", 1.28e-5),
        ("unbalances[1].angle", "282 deg"),
        ("unbalances[2].misalignment", 4.8e-5),
    ):
        machine = ab.with_parameter(machine, path, value)
    return machine


def planar(**balls: Any) -> Machine:
    """Isotropic planar rotor at a speed above its critical one, with two balls that may lie in one place."""
    return Machine.model_validate(
        {
            "name": "two balls in one place",
            "axis": "vertical",
            "rotor": {"kind": "planar", "mass": 10.0, "stiffness": 625e3, "damping": 400.0},
            "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": SPEED}},
            "unbalances": [{"moment": 3e-4}],
            "balancers": [
                {
                    "races": [
                        {
                            "orbit_radius": 0.1,
                            "collisions": False,
                            "drag": {"law": "viscous", "damping": 2e-4},
                            "balls": [{"count": 2, "mass": 3e-3, "diameter": 9e-3} | balls],
                        }
                    ]
                }
            ],
            "run": {"duration": 4.0},
        }
    )


def in_line(turn: float = math.pi) -> Machine:
    """Both balls begin at the light side (pi) or the heavy side (0) of the rotor."""
    return planar(start_angles=[turn, turn])


SWEEP: dict[str, Any] = {"dwell": 0.5, "window": 0.25, "stations": ["B1", "B2"]}


@pytest.mark.slow
def test_balls_that_met_below_the_critical_speed_part_above_it_and_balance() -> None:
    speeds = np.arange(600.0, 4501.0, 30.0) * RPM
    alone = stepped_response(one_washer(), speeds[-1:], start="fixed", dwell=8.0, window=0.25, stations=["B1", "B2"])
    settled = float(alone["amplitude"][-1])
    found = stepped_response(one_washer(), speeds, **SWEEP)
    assert float(found["amplitude"][-1]) == pytest.approx(settled, rel=0.05)
    assert found.attrs["mass_spread"] == 1e-6
    assert found.attrs["remarks"] == []
    equal = stepped_response(one_washer(), speeds, **SWEEP, mass_spread=0.0)
    assert float(equal["amplitude"][-1]) > 2.0 * settled
    assert np.ptp(equal["least_ball_angle_in_rotor"].values[-1]) == 0.0
    assert float(equal["parting_rate"][-1]) > 0.0
    assert "although this state is unstable" in " ".join(equal.attrs["remarks"])


@pytest.mark.slow
def test_the_balls_of_the_rig_touch_and_need_no_spread() -> None:
    machine = one_washer("rodrigues_rig")
    balls = machine.balancers[0].races[0].balls[0]
    assert float(balls.mass or 0.0) == pytest.approx(
        7800.0 * math.pi / 6.0 * float(balls.diameter or 0.0) ** 3, rel=0.01
    )
    found = stepped_response(machine, np.arange(600.0, 4501.0, 30.0) * RPM, **SWEEP)
    alone = stepped_response(machine, [4500.0 * RPM], start="fixed", dwell=8.0, window=0.25, stations=["B1", "B2"])
    assert float(found["amplitude"][-1]) == pytest.approx(float(alone["amplitude"][-1]), rel=0.05)
    assert found.attrs["mass_spread"] == 0.0


def test_balls_that_may_pass_through_each_other_may_start_in_one_place() -> None:
    run = ab.simulate(in_line())
    assert np.ptp(run["ball_angle_in_rotor"].values[0]) == 0.0
    assert run.attrs["mass_spread"] == 1e-6
    assert np.ptp(np.asarray(ab.run_measures(run)["final_ball_angle_to_unbalance"])) > math.radians(60.0)
    assert float(run["residual_unbalance"][-1]) < 0.02 * float(run["unbalance"][-1])


def test_equal_balls_in_one_place_never_part_and_the_run_says_that_they_should() -> None:
    run = ab.simulate(in_line(), mass_spread=0.0)
    assert np.ptp(run["ball_angle_in_rotor"].values[-1]) == 0.0
    assert "balls 1 and 2 lie in one place although this state is unstable" in " ".join(run.attrs["remarks"])
    below = ab.with_parameter(in_line(0.0), "drive.profile.speed", 100.0)
    assert "in one place" not in " ".join(ab.simulate(below, mass_spread=0.0).attrs["remarks"])


def test_the_rate_at_which_balls_part_is_that_at_which_a_small_gap_grows() -> None:
    found = stepped_response(in_line(), [SPEED], dwell=3.0, window=0.5, mass_spread=0.0, tolerance=1e-10)
    rate = float(found["parting_rate"][0])
    angle = float(found["least_ball_angle_in_rotor"][0, 0])
    # a small distance put between them grows by that rate
    times = np.linspace(0.0, 0.9, 10)
    apart = planar(start_angles=[angle - 5e-7, angle + 5e-7])
    place = np.array([float(found[f"synchronous_{key}"][0, 0]) for key in "xy"])
    velocity = SPEED * np.array([-place[1], place[0]])
    apart = ab.with_parameter(apart, "start", {"deflection": tuple(place), "velocity": tuple(velocity)})
    run = ab.simulate(apart, duration=0.9, save=Samples(10), tolerance=1e-12, mass_spread=0.0)
    gap = run["ball_angle_in_rotor"].values @ [-1.0, 1.0]
    late = times > 0.55  # the other root, of -11 1/s, has died
    assert np.polyfit(times[late], np.log(gap[late]), 1)[0] == pytest.approx(rate, rel=1e-3)


def test_the_order_of_the_masses_follows_from_the_seed() -> None:
    def moments(seed: int, **more: float) -> list[float]:
        run = ab.simulate(in_line(), duration=0.01, seed=seed, **more)
        return list(run["ball_moment"].values)

    equal = moments(0, mass_spread=0.0)
    assert equal[0] == equal[1] == pytest.approx(3e-4)
    drawn = [moments(seed) for seed in range(8)]
    assert all(abs(one - other) == pytest.approx(3e-10, rel=1e-6) for one, other in drawn)
    assert all(0.5 * sum(pair) == pytest.approx(3e-4, rel=1e-12) for pair in drawn)
    assert {one > other for one, other in drawn} == {True, False}
    assert moments(3) == drawn[3]
    with pytest.raises(QuestionError, match="mass_spread: given -1"):
        ab.simulate(in_line(), duration=0.01, mass_spread=-1.0)


def test_commands_say_that_balls_lie_in_one_place_where_they_cannot_stay(tmp_path: Any) -> None:
    ab.save_machine(in_line(), tmp_path / "line.toml")
    said = CliRunner().invoke(
        app, ["simulate", str(tmp_path / "line.toml"), "--out", str(tmp_path / "r.nc"), "--mass-spread", "0"]
    )
    assert said.exit_code == 0
    assert "balls 1 and 2 lie in one place" in " ".join(said.output.split())
    ask = [
        "stepped-response",
        str(tmp_path / "line.toml"),
        "--speeds",
        f"{SPEED:g} rad/s",
        "--dwell",
        "0.3 s",
        "--window",
        "0.1 s",
    ]
    said = CliRunner().invoke(app, [*ask, "--mass-spread", "0", "--out", str(tmp_path / "s.nc")])
    assert said.exit_code == 0, said.output
    assert "at 1 of 1 speeds" in " ".join(said.output.split())
