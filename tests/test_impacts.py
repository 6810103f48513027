"""Impacts that runs note: how many, how fast, and what they dissipate."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.references.chamber_machines import free_machine
from tests.references.standing_races import BOTTOM, DENSITY, DIAMETER, ORBIT, ROLLING, standing
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError

MASS = DENSITY * math.pi / 6.0 * DIAMETER**3
HALF = math.asin(0.5 * DIAMETER / ORBIT)
LEFT = 0.8


def _between_partitions(**contact: float) -> xr.Dataset:
    """A ball that runs to and fro between two partitions, at first at 5 rad/s, in a run that lasts 2.5 s."""
    machine = standing(
        axis="vertical", angles=[0.5 * math.pi], speeds=[5.0], partitions={"count": 2, "angle": BOTTOM},
        contact={"restitution": LEFT, **contact},
    )  # fmt: skip
    return ab.simulate(machine, duration=2.5, tolerance=1e-10)


def test_every_impact_on_a_partition_has_its_time_and_its_speed() -> None:
    run = _between_partitions()
    speeds = 5.0 * LEFT ** np.arange(4)
    way = math.pi - 2.0 * HALF
    times = (0.5 * way + np.concatenate([[0.0], way * np.cumsum(1.0 / LEFT ** np.arange(1, 4))])) / 5.0
    count = int((times < 2.5).sum())
    across = ORBIT * math.cos(HALF)  # speed across the partition over that of the ball angle
    assert run.sizes["impact"] == count >= 3
    # a contact lasts a twentieth of the shortest period of the machine
    np.testing.assert_allclose(run["impact_time"], times[:count], atol=1e-2)
    np.testing.assert_allclose(run["impact_speed"], across * speeds[:count], rtol=1e-4)
    energies = 0.5 * ROLLING * MASS * ORBIT**2 * speeds[:count] ** 2
    np.testing.assert_allclose(run["impact_loss"], energies * (1.0 - LEFT**2), rtol=2e-4)
    assert run["impact_partner"].values.tolist() == [0] * count
    measured = ab.run_measures(run)
    assert float(measured["impact_power"]) == pytest.approx(energies.sum() * (1.0 - LEFT**2) / 2.5, rel=2e-4)
    assert float(measured["impacts"]) == count
    assert float(measured["greatest_impulse"]) == pytest.approx(
        ROLLING * MASS * ORBIT**2 / across**2 * across * 5.0 * (1.0 + LEFT), rel=1e-4
    )


def test_two_balls_that_meet_lose_the_energy_that_their_impact_says() -> None:
    machine = standing(axis="vertical", angles=[0.0, 0.5], speeds=[2.0, -1.0], contact={"restitution": 0.3})
    run = ab.simulate(machine, duration=0.4, tolerance=1e-10)
    speed = run["ball_speed_in_rotor"].values
    energy = 0.5 * ROLLING * MASS * ORBIT**2 * (speed**2).sum(axis=1)
    assert run["impact_speed"].values == pytest.approx([3.0 * ORBIT * math.cos(HALF)], rel=1e-4)
    assert float(run["impact_loss"][0]) == pytest.approx(energy[0] - energy[-1], rel=2e-4)
    assert (int(run["impact_ball"][0]), int(run["impact_partner"][0])) == (1, 2)
    assert "impact_time" not in ab.simulate(machine, duration=0.1, hold_balls=True)


def test_a_resolved_ball_that_falls_bounces_with_the_restitution_of_the_wall() -> None:
    law = {"stiffness": 1e6, "restitution": LEFT, "sliding_friction": 0.0, "slip_speed": 1e-3, "start_gap": 0.02}
    run = ab.simulate(standing(angles=[0.0], resolved=law), duration=0.4, tolerance=1e-9)
    speeds = run["impact_speed"].values
    assert speeds[0] == pytest.approx(math.sqrt(2.0 * 9.80665 * 0.02), rel=1e-3)
    np.testing.assert_allclose(speeds[1:4] / speeds[:3], LEFT, rtol=3e-3)  # steps before an impact take gravity along
    assert set(run["impact_partner"].values.tolist()) == {-1}


def test_a_resolved_ball_hits_a_partition_only_where_it_stands() -> None:
    """One partition, a ball that starts beside it and passes the place opposite to it, where nothing is."""
    law = {"stiffness": 1e6, "restitution": LEFT, "sliding_friction": 0.0, "slip_speed": 1e-3}
    machine = standing(
        axis="vertical", angles=[0.5], speeds=[8.0], resolved=law, partitions={"count": 1, "angle": BOTTOM},
        contact={"restitution": LEFT},
    )  # fmt: skip
    way = 2.0 * math.pi - HALF - 0.5
    run = ab.simulate(machine, duration=1.3 * way / 8.0)
    (hit,) = np.flatnonzero(run["impact_partner"].values == 0)
    assert float(run["impact_time"][hit]) == pytest.approx(way / 8.0, rel=1e-2)
    assert float(run["impact_speed"][hit]) == pytest.approx(8.0 * ORBIT * math.cos(HALF), rel=1e-2)


def test_balls_of_a_chamber_count_their_impacts() -> None:
    gap = 0.5 * DIAMETER + 2e-5
    balls = {
        "count": 2, "density": DENSITY, "diameter": DIAMETER, "velocities": [[0.0, 0.5, 0.0], [0.0, -0.3, 0.0]],
        "positions": [[0.0, -gap, 0.0], [0.0, gap, 0.0]],
    }  # fmt: skip
    machine = free_machine(
        body={"freedom": "fixed"}, chambers=[{"radius": 0.06, "depth": 0.1, "balls": [balls]}],
        contact={"restitution": LEFT, "friction": 0.0, "rolling_arm": 0.0},
    )  # fmt: skip
    run = ab.simulate(machine, duration=0.02, sample=1e-3)
    assert float(run["impact_speeds"].sum()) == pytest.approx(0.8, rel=1e-3)
    assert float(run["impact_energies"].sum()) == pytest.approx(0.25 * MASS * 0.8**2, rel=2e-3)
    measured = ab.run_measures(run, last=0.005).sel(stage="transient")
    assert float(measured["impact_speed"]) == pytest.approx(0.8, rel=1e-3)
    assert float(measured["impact_rate"]) == pytest.approx(1.0 / 0.014, rel=1e-9)  # one up to the sample before the end
    assert float(measured["impact_power"]) * 0.014 == pytest.approx(0.25 * MASS * 0.8**2 * (1.0 - LEFT**2), rel=5e-3)


def test_a_sweep_measures_impacts_as_a_run_does() -> None:
    machine = standing(
        axis="vertical", angles=[0.5 * math.pi], speeds=[5.0], partitions={"count": 2, "angle": BOTTOM},
        contact={"restitution": LEFT},
    )  # fmt: skip
    path = "balancers[1].races[1].contact.restitution"
    swept = ab.sweep(machine, {path: [0.4, LEFT]}, duration=2.5, tolerance=1e-8, progress=False, workers=1)
    one = ab.run_measures(ab.simulate(machine, duration=2.5))
    for name in ("impacts", "impact_speed", "impact_power", "late_impact_rate"):
        assert float(swept[name][1]) == pytest.approx(float(one[name]), rel=1e-6), name
    assert int(swept["impacts"][0]) < int(swept["impacts"][1])


def test_impacts_are_drawn_kept_and_measured_on_the_command_line(tmp_path: Path) -> None:
    run = _between_partitions()
    figure = ab.plot.answer(run, "impacts")

    dots = [line for line in figure.axes[1].lines if line.get_marker() == "."]
    assert sum(len(line.get_xdata()) for line in dots) == run.sizes["impact"]
    file = tmp_path / "run.nc"
    ab.save_run(run, file)
    shown = CliRunner().invoke(app, ["run-measures", str(file)])
    assert "impact_power" in shown.output
    picture = tmp_path / "impacts.png"
    assert CliRunner().invoke(app, ["plot", str(file), "--kind", "impacts", "--out", str(picture)]).exit_code == 0
    assert picture.exists()
    quiet = ab.simulate(standing(axis="vertical", angles=[0.0, 2.0]), duration=0.1)
    assert quiet.sizes["impact"] == 0
    ab.save_run(quiet, file)
    assert ab.load_run(file).sizes["impact"] == 0
    with pytest.raises(QuestionError, match="of balls that hit something; of this result there are run_up"):
        ab.plot.answer(quiet, "impacts")
