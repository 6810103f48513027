"""What an engineer has in place of what the equations want: a bearing, a critical speed, a damping ratio."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.assembly.quantities import parameter_unit, value_of, with_quantity, with_value_at
from autobalancer.catalog.resolve import planar_rotor, resolve
from autobalancer.errors import MachineError, MachineFileError
from autobalancer.files.machine_file import machine_text, parse_machine
from autobalancer.machine import Balls, Machine, PlanarRotor
from autobalancer.rotordynamics.identify import identify
from autobalancer.rotordynamics.parameter_fit import FreeParameter, MeasuredCriticalSpeed

TEXT = """
name = "centrifuge"
axis = "vertical"
rotor = { kind = "planar", mass = "12 kg", ROTOR }
drive = { kind = "speed", profile = { kind = "ramp", end = "3000 rpm", duration = "60 s" } }
unbalances = [{ moment = "600 g*mm" }]
[[balancers]]
[[balancers.races]]
RACE
fluid = { name = "silicone oil 20" }
drag = { law = "sphere_on_plane", range = "whole" }
balls = [{ count = 2, BALLS }]
"""
SPRINGS = 'stiffness = "47.374 kN/m", damping = "60.3 N*s/m"'


def machine(rotor: str = SPRINGS, race: str = 'bearing = "16021"', balls: str = 'material = "steel"') -> Machine:
    return parse_machine(TEXT.replace("ROTOR", rotor).replace("RACE", race).replace("BALLS", balls))


def test_the_race_of_a_bearing_is_that_of_its_typed_sizes() -> None:
    typed = machine(race='orbit_radius = "66.25 mm"', balls='diameter = "13.494 mm", material = "steel"')
    assert resolve(machine()) == resolve(typed)
    assert 'bearing = "16021"' in machine_text(machine())
    assert parse_machine(machine_text(machine())) == machine()


def test_smaller_balls_in_the_ring_of_a_bearing_run_on_the_same_wall() -> None:
    small = resolve(machine(balls='diameter = "10 mm", material = "steel"'))[0]
    own = resolve(machine())[0]
    assert small.orbit_radius + small.radius == pytest.approx(own.orbit_radius + own.radius, rel=1e-14)
    narrow = machine(race='bearing = "16021"\norbit_radius = "60 mm"', balls='diameter = "10 mm", material = "steel"')
    assert resolve(narrow)[0].orbit_radius == 0.06, "what is typed counts"
    with pytest.raises(MachineFileError, match="larger than those of bearing 16021"):
        machine(balls='diameter = "14 mm", material = "steel"')


@pytest.mark.parametrize(
    ("race", "balls", "message"),
    [
        (
            'bearing = "16O21"',
            'material = "steel"',
            r"races\[1\].bearing: no bearing is called '16O21'; similar names: '16021'",
        ),
        ("", 'material = "steel"', "or the 'bearing' of the catalog"),
        ('orbit_radius = "66 mm"', 'material = "steel"', r"balls\[1\]: give two of .* or name the 'bearing'"),
        ('bearing = "16021"', "count = 99".replace("count = 99", 'mass = "3 g"'), "give two of"),
    ],
)
def test_a_race_without_what_it_needs_names_the_bearing(race: str, balls: str, message: str) -> None:
    with pytest.raises(MachineFileError, match=message):
        machine(race=race, balls=balls)


@pytest.mark.parametrize(
    "rotor",
    [
        'critical_speed = "600 rpm", damping_ratio = 0.04',
        'critical_speed = "600 rpm", damping_ratio = "4 %"',
        'critical_speed = "10 Hz", half_power_bandwidth = "8 %"',
        'critical_speed = "600 rpm", half_power_bandwidth = "48 rpm"',
        'critical_speed = ["600 rpm", "600 rpm"], damping_ratio = ["4 %", "4 %"]',
    ],
)
def test_critical_speed_and_damping_ratio_are_those_that_check_finds(rotor: str) -> None:
    found = machine(rotor)
    about = ab.check(found)
    assert about.critical_speeds == pytest.approx([20.0 * pi], rel=1e-13)
    assert about.damping_ratios == pytest.approx([0.04], rel=1e-13)
    mass = 12.0 + sum(ball.effective_mass for ball in resolve(found))
    springs = planar_rotor(found)
    assert springs.stiffness_xy == pytest.approx((mass * (20.0 * pi) ** 2,) * 2)
    assert springs.damping_xy == pytest.approx((2.0 * 0.04 * mass * 20.0 * pi,) * 2)
    assert parse_machine(machine_text(found)) == found
    assert 'critical_speed = "' in machine_text(found).replace('critical_speed = [\n    "', 'critical_speed = "')


def test_the_half_power_bandwidth_is_that_of_the_computed_resonance() -> None:
    """Of the compliance, at light damping: the points at 1/sqrt(2) of the peak are 2 D of the critical speed apart."""
    found = machine('critical_speed = "600 rpm", half_power_bandwidth = "2 %"')
    (k, _), (b, _) = planar_rotor(found).stiffness_xy, planar_rotor(found).damping_xy
    mass = k / (20.0 * pi) ** 2
    w = 20.0 * pi * np.linspace(0.95, 1.05, 200_001)
    height = 1.0 / np.abs(k - mass * w**2 + 1j * b * w)
    within = w[height >= height.max() / np.sqrt(2.0)]
    assert (within[-1] - within[0]) / (20.0 * pi) == pytest.approx(0.02, rel=1e-3)


def test_every_analysis_sees_the_same_springs() -> None:
    words = machine('critical_speed = "600 rpm", damping_ratio = 0.04')
    springs = planar_rotor(words)
    typed = with_value_at(words, "rotor", PlanarRotor(mass=12.0, stiffness=springs.stiffness, damping=springs.damping))
    assert [b.speed for b in ab.stability.borders(words)] == [b.speed for b in ab.stability.borders(typed)]
    runs = [ab.simulate(one, duration=0.2, seed=3) for one in (words, typed)]
    assert np.array_equal(runs[0]["x"].values, runs[1]["x"].values)
    held = [ab.simulate(one, duration=0.2, hold_balls=True) for one in (words, typed)]
    assert float(np.abs(held[0]["x"] - held[1]["x"]).max()) <= 1e-12 * float(np.abs(held[1]["x"]).max())
    shapes = [ab.rotor.modes(one)["frequency"].values for one in (words, typed)]
    assert shapes[0] == pytest.approx(shapes[1], rel=1e-13)


def test_springs_stay_when_something_else_is_changed() -> None:
    words = machine('critical_speed = "600 rpm", damping_ratio = 0.04')
    before = planar_rotor(words)
    for changed in (with_quantity(words, "ball_mass", "50 g"), with_value_at(words, "rotor.mass", "13 kg")):
        assert planar_rotor(changed).stiffness_xy == before.stiffness_xy
        assert planar_rotor(changed).damping_xy == before.damping_xy
    assert value_of(words, "stiffness") == value_of(words, "rotor.stiffness") == before.stiffness_xy[0]


def test_what_gives_the_springs_can_be_changed_by_its_path() -> None:
    words = machine('critical_speed = "600 rpm", damping_ratio = 0.04')
    faster = with_value_at(words, "rotor.critical_speed", "700 rpm")
    assert ab.check(faster).critical_speeds == pytest.approx([700.0 * pi / 30.0])
    assert ab.check(faster).damping_ratios == pytest.approx([0.04])
    stiff = with_value_at(words, "rotor.stiffness", "50 kN/m")
    assert planar_rotor(stiff).stiffness_xy == (5e4, 5e4)
    assert planar_rotor(stiff).damping_xy == planar_rotor(words).damping_xy
    back = with_value_at(with_value_at(words, "rotor.mass", "13 kg"), "rotor.critical_speed", "600 rpm")
    assert ab.check(back).critical_speeds == pytest.approx([20.0 * pi])
    assert parameter_unit(words, "rotor.critical_speed") == "rad/s"


@pytest.mark.parametrize("path", ["rotor.stiffness", "rotor.critical_speed"])
def test_either_can_be_identified(path: str) -> None:
    words = machine('critical_speed = "600 rpm", damping_ratio = 0.04')
    bounds = ("40 kN/m", "80 kN/m") if path == "rotor.stiffness" else ("500 rpm", "800 rpm")
    measured = MeasuredCriticalSpeed(650.0 * pi / 30.0, error=0.1, balls=True)
    found = identify(words, [FreeParameter(path, *bounds)], [measured])
    assert ab.check(found.machine).critical_speeds == pytest.approx([650.0 * pi / 30.0], rel=1e-6)


@pytest.mark.parametrize(
    ("rotor", "message"),
    [
        ('damping = "60 N*s/m"', "rotor.stiffness: missing; it has no default, give it or 'critical_speed'"),
        ('stiffness = "47 kN/m"', "rotor.damping: missing; .* give it or 'damping_ratio' or 'half_power_bandwidth'"),
        (f'{SPRINGS}, critical_speed = "600 rpm"', "rotor.critical_speed: given beside 'stiffness'"),
        (f"{SPRINGS}, damping_ratio = 0.02", "rotor.damping_ratio: given beside 'damping'"),
        ('critical_speed = "-600 rpm", damping_ratio = 0.02', "critical_speed: .* must be greater than zero"),
        ('critical_speed = "600 rpm", half_power_bandwidth = "4 kg"', "half_power_bandwidth: given '4 kg'"),
    ],
)
def test_exactly_one_way_to_springs_and_dampers_is_wanted(rotor: str, message: str) -> None:
    with pytest.raises(MachineFileError, match=message):
        machine(rotor)


def test_parts_made_in_python_follow_the_same_rules() -> None:
    rotor = PlanarRotor(mass=12.0, critical_speed="600 rpm", damping_ratio=0.02)
    assert rotor.isotropic
    with pytest.raises(MachineError, match="follows from the mass in motion"):
        _ = rotor.stiffness_xy
    assert Balls(count=2, material="steel").unsized
