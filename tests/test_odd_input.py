"""Numbers that were hardly meant as they stand are read as they are, and said aloud."""

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.cli.main import app
from autobalancer.files.machine_file import balls_in_chambers, load_machine
from autobalancer.machine.keys import bare_numbers
from autobalancer.simulation.chamber.chamber_summary import chamber_summary
from autobalancer.simulation.remarks import input_notes
from autobalancer.studies.design.design import designs_dataset
from autobalancer.studies.design.design_file import read_spec

DISCOIDAL = Path("examples/machines/discoidal.toml")
RACE = "balancers[1].races[1]"
SLIPS: dict[str, tuple[Any, str]] = {
    "rotor.stiffness": (44.654, 'was read in N/m, since a number without a unit is SI; write it with its unit, "44.654 kN/m"'),
    "drive.profile": ({"kind": "constant", "speed": 1200}, "drive.profile.speed = 1200 was read in rad/s, which is 11459 rpm"),
    f"{RACE}.balls[1].start_angles": ([1.0, 250], f"{RACE}.balls[1].start_angles[2] = 250 was read in rad, which is 14324 deg"),
    "rotor.damping_ratio": (4.0, 'was read as 400 %; write it with its unit, "4 %" if that is meant'),
    f"{RACE}.orbit_radius": (5, f"{RACE}.orbit_radius = 5 was read in m"),
    f"{RACE}.eccentricity": (0.05, '"0.05 um" if that is meant'),
    f"{RACE}.fluid.temperature": (25.0, "which is -248.15 degC"),
    f"{RACE}.balls[1]": ({"count": 2, "mass": 20, "material": "steel"}, f"{RACE}.balls[1].mass = 20 was read in kg"),
    "unbalances": ([{"moment": 594}], 'unbalances[1].moment = 594 was read in kg*m'),
}  # fmt: skip


@pytest.mark.parametrize("path", SLIPS)
def test_a_number_that_was_meant_in_another_unit_is_said_as_it_was_read(path: str) -> None:
    value, wanted = SLIPS[path]
    found = bare_numbers(with_value_at(ab.load_machine(DISCOIDAL), path, value))
    assert len(found) == 1
    assert wanted in found[0]


def test_the_same_number_with_its_unit_is_not_mentioned() -> None:
    machine = ab.load_machine(DISCOIDAL)
    for path, value in (
        ("drive.profile", {"kind": "constant", "speed": "1200 rad/s"}),
        (f"{RACE}.orbit_radius", "5 m"),
    ):
        assert bare_numbers(with_value_at(machine, path, value)) == ()


def test_usual_numbers_in_si_are_not_mentioned() -> None:
    machine = ab.load_machine(DISCOIDAL)
    usual = {
        "rotor.mass": 12.0,
        "rotor.stiffness": 44654.0,
        f"{RACE}.orbit_radius": 0.077,
        "unbalances": [{"moment": 6e-4}],
    }
    for path, value in usual.items():
        machine = with_value_at(machine, path, value)
    machine = with_value_at(machine, "drive.profile", {"kind": "constant", "speed": 125.66})
    assert bare_numbers(machine) == ()


def test_no_sample_machine_has_a_number_that_is_odd() -> None:
    for path in sorted(Path("examples/machines").glob("*.toml")):
        machine = load_machine(path)
        assert bare_numbers(machine) == (), path.name
        if isinstance(machine, ab.machine.Machine):
            assert input_notes(machine, None if machine.run is None else machine.run.duration) == (), path.name


def test_check_and_run_say_it_once_each(tmp_path: Path) -> None:
    text = DISCOIDAL.read_text(encoding="utf-8").replace('stiffness = "44.654 kN/m"', "critical_speed = 600")
    (tmp_path / "slip.toml").write_text(text, encoding="utf-8")
    for command in (["check"], ["simulate", "--duration", "10 ms", "--out", str(tmp_path / "a.nc")]):
        said = CliRunner().invoke(app, [command[0], str(tmp_path / "slip.toml"), *command[1:]])
        assert said.exit_code == 0
        assert " ".join((said.stdout + said.stderr).split()).count("600 was read in rad/s, which is 5729.6 rpm") == 1


def test_a_chamber_machine_is_asked_too() -> None:
    machine = balls_in_chambers("docs/machines/chamber.toml")
    odd = machine.model_copy(
        update={"chambers": (machine.chambers[0].model_copy(update={"radius": 75.0}), *machine.chambers[1:])}
    )
    assert any("radius = 75 was read in m" in text for text in bare_numbers(odd))
    assert not any("was read in" in text for text in chamber_summary(machine).warnings)


def test_many_slips_do_not_fill_the_screen() -> None:
    machine = ab.load_machine(DISCOIDAL)
    for path, (value, _) in SLIPS.items():
        machine = with_value_at(machine, path, value)
    found = bare_numbers(machine)
    assert len(found) == 6
    assert found[-1].startswith("and 2 more")


@pytest.mark.parametrize(
    ("profile", "when"),
    [
        ({"kind": "ramp", "end": "1200 rpm", "duration": "60 s", "delay": "2 s"}, "ends at 62 s"),
        (
            {"kind": "dwell", "speeds": ["0 rpm", "20 rad/s"], "hold": "50 s", "acceleration": "1 rad/s^2"},
            "ends at 120 s",
        ),
        (
            {"kind": "hill", "end": "1200 rpm", "half_time": "30 s", "exponent": 2},
            "has come 95 % of its way at 130.77 s",
        ),
    ],
)
def test_a_run_that_ends_before_its_run_up_is_said(profile: dict[str, Any], when: str) -> None:
    machine = with_value_at(ab.load_machine(DISCOIDAL), "drive.profile", profile)
    short, long = (with_value_at(machine, "run.duration", seconds) for seconds in (61.0, 131.0))
    assert any(when in text for text in ab.check(short).warnings)
    assert not any("speed profile" in text for text in ab.check(long).warnings)
    early = ab.verdict(ab.simulate(long, duration=0.1))
    assert any("the run lasts 0.1 s" in text and when in text for text in early.notes)


def test_a_mass_beside_which_the_balls_are_nothing_is_said_as_it_was_read() -> None:
    machine = ab.example("discoidal")
    found = input_notes(with_value_at(machine, "rotor.mass", 8000.0), None)
    assert len(found) == 1
    assert "rotor.mass = 8000 was read in kg" in found[0]
    assert '"8000 g" if that is meant' in found[0]
    assert input_notes(with_value_at(machine, "rotor.mass", "8000 kg"), None) == ()
    assert all(input_notes(ab.example(name), None) == () for name in ("discoidal", "rigid_rotor", "equilibrium_angle"))


def test_a_specification_of_a_design_says_how_it_was_read_too() -> None:
    given = {
        "machine": DISCOIDAL,
        "operation": {"speed": [125.0, 1200], "run_up": "60 s", "hold": "20 s"},
        "limits": {"peak_deflection": 1.3},
        "space": {"outer": 1.5, "wall": "200 mm"},
        "candidates": {"orbit_radius": {"from": 0.07, "to": 77}},
    }
    spec = read_spec(given)
    assert (spec.limits["peak_deflection"], spec.space.wall) == (1.3, 0.2)
    speed, limit, size = spec.remarks
    assert speed.startswith("operation.speed[2] = 1200 was read in rad/s, which is 11459 rpm")
    assert limit.startswith("limits.peak_deflection = 1.3 was read in m")
    assert '"1.3 mm" if that is meant' in limit
    assert size.startswith("candidates.orbit_radius.to = 77 was read in m")
    assert designs_dataset(spec, [], "so far").attrs["remarks"] == list(spec.remarks)
