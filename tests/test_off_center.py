"""Races off the axis: what they leave although the balls balance, and what is said where nobody gives an eccentricity."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.places import OffCenter, off_center, places_of
from autobalancer.assembly.system import assemble
from autobalancer.catalog.product_tables import ring_eccentricity
from autobalancer.catalog.resolve import resolve
from autobalancer.cli.main import app
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine import Machine

MACHINES = Path("examples/machines")
RACE = "balancers[1].races[1]"
BEARING = """
name = "balls in a bearing"
axis = "vertical"
rotor = { kind = "planar", mass = "8 kg", critical_speed = "900 rpm", damping_ratio = "4 %" }
unbalances = [{ moment = "500 g*mm" }]
drive = { kind = "speed", profile = { kind = "ramp", end = "4000 rpm", duration = "60 s" } }
[[balancers]]
[[balancers.races]]
bearing = "61832"
drag = { law = "viscous", damping = "2e-4 N*m*s" }
balls = [{ count = 2, material = "steel" }]
"""


def predicted(machine: Machine, speed: float) -> OffCenter:
    assembly = assemble(machine)
    found = off_center(places_of(machine, assembly), assembly.balls, speed)
    assert found is not None
    return found


def test_balls_in_an_eccentric_race_leave_what_is_predicted_without_a_run() -> None:
    machine = ab.load_machine(MACHINES / "eccentric_race.toml")
    found = predicted(machine, 593.13).planes[0]
    end = ab.verdict(ab.simulate(machine))
    assert found.eccentricity == pytest.approx(1e-4) == pytest.approx(end.places[0].vibration, rel=1e-6)
    assert found.residual == pytest.approx(end.residual, rel=1e-6)
    assert found.residual == pytest.approx(1e-4 * abs(10.015 - (625e3 + 593.13j * 100.0) / 593.13**2), rel=1e-12)
    assert "100 µm leaves a vibration of 100 µm and 824 g mm" in end.notes[-1]


def test_each_of_two_eccentric_races_keeps_its_own_vibration_and_residual() -> None:
    machine = ab.load_machine(Path("docs/machines/two_planes.toml"))  # tilting, with a table over the speed
    for path, value in (("[1].races[1].eccentricity", 20e-6), ("[2].races[1].eccentricity", 30e-6)):
        machine = ab.with_parameter(machine, f"balancers{path}", value)
    machine = ab.with_parameter(machine, "balancers[2].races[1].eccentricity_angle", "70 deg")
    run = ab.simulate(machine, duration=40.0, save=ab.LastRevolutions())
    found = predicted(machine, float(run["turn_speed"][-1]))
    left = ab.run_measures(run, "residual_unbalance")["residual"].values
    assert [plane.residual for plane in found.planes] == pytest.approx(left, rel=1e-4)
    assert ab.run_measures(run, "vibration")["greatest"].values[:2] == pytest.approx([20e-6, 30e-6], rel=1e-4)


def test_more_planes_than_a_rotor_has_motions_have_no_residual_of_their_own() -> None:
    machine = ab.load_machine(Path("docs/machines/two_planes.toml"))
    third = machine.balancers[1].model_copy(update={"station": 0.0})
    three = ab.with_parameter(machine, "balancers", (*machine.balancers, third))
    found = predicted(three, 400.0)
    assert np.isnan([plane.residual for plane in found.planes]).all()
    assert "unbalance" not in found.sentence


def test_check_says_what_a_typical_eccentricity_would_leave_until_one_is_given(tmp_path: Path) -> None:
    machine = ab.load_machine(MACHINES / "discoidal.toml")
    found = ab.check(machine).off_center
    assert found is not None
    assert not found.given
    w = found.speed
    wanted = 50e-6 * abs(12.2833 - (44654.0 + 68.37j * w) / w**2)  # a turned part may run out by 0.1 mm
    assert found.planes[0].residual == pytest.approx(wanted, rel=1e-5)
    said = CliRunner().invoke(app, ["check", str(MACHINES / "discoidal.toml")]).stdout
    assert "race eccentricity" in said
    assert "474 g mm" in said
    centered = ab.with_parameter(machine, f"{RACE}.eccentricity", 0.0)
    ab.save_machine(centered, tmp_path / "centered.toml")
    assert "race eccentricity" not in CliRunner().invoke(app, ["check", str(tmp_path / "centered.toml")]).stdout


def test_a_run_mentions_a_typical_eccentricity_only_where_it_matters() -> None:
    def said_of(machine: Machine, *, hold_balls: bool = False) -> str:
        run = ab.simulate(machine, duration=0.2, save=ab.LastRevolutions(), hold_balls=hold_balls)
        return next((text for text in run.attrs["remarks"] if text.startswith("race eccentricity")), "")

    plain = ab.load_machine(MACHINES / "stall_and_release.toml")
    plain = ab.with_parameter(plain, "drive.profile", {"kind": "constant", "speed": 600.0})
    assert "not given" in said_of(plain)
    heavy = ab.with_parameter(plain, "unbalances", [{"moment": "0.2 kg*m"}])  # whirls by 20 mm
    assert "eccentricity" not in said_of(heavy)
    assert "eccentricity" not in said_of(plain, hold_balls=True)
    told = said_of(plain)
    assert len(told) < 100
    assert "50 µm" in told


def test_a_standard_of_bearings_is_cited_for_bearings_only() -> None:
    plain = ab.load_machine(MACHINES / "stall_and_release.toml")
    race = predicted(plain, 600.0)
    assert race.planes[0].eccentricity == pytest.approx(50e-6)
    assert "ISO 492" not in race.sentence
    assert "ISO 2768-2" in race.sentence
    bearing = parse_machine(BEARING)
    race = predicted(bearing, 600.0)
    ball = resolve(bearing)[0]
    assert race.planes[0].eccentricity == ring_eccentricity(2.0 * ball.orbit_radius + ball.diameter)
    assert "ISO 492" in race.sentence
    assert "turned" not in race.sentence


@pytest.mark.parametrize(
    ("up_to", "inches"),
    [(30, 0.0006), (50, 0.0008), (80, 0.0010), (120, 0.0014), (150, 0.0016), (180, 0.0018), (250, 0.0020), (315, 0.0024),
     (400, 0.0028), (500, 0.0032), (630, 0.0039), (800, 0.0047)],
)  # fmt: skip
def test_the_run_out_of_rings_is_that_of_a_published_table_in_inches(up_to: float, inches: float) -> None:
    """Of consbrgs.com/technicaldata/383_bt.html, outer rings, tolerance class standard: less than 0.0001 inch away.

    That is half of the smallest step in the table; the source rounds 80 µm, 0.00315 inch, to 0.0032.
    """
    run_out = 2.0 * ring_eccentricity(1e-3 * up_to)
    assert run_out / 25.4e-3 == pytest.approx(inches, abs=1e-4)


def test_larger_bearing_rings_may_run_out_more() -> None:
    offsets = [ring_eccentricity(size) for size in (0.02, 0.05, 0.1, 0.166, 0.3, 5.0)]
    assert offsets == pytest.approx([7.5e-6, 10e-6, 17.5e-6, 22.5e-6, 30e-6, 60e-6])
