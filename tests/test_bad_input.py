"""Machine files with slips, and files made to do harm: each is refused in words, at once."""

from __future__ import annotations

import os
import random
import re
import time
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.api import check as summary
from autobalancer.cli import app
from autobalancer.cli import measured as balls
from autobalancer.cli import rotor as flow
from autobalancer.errors import MachineError, QuestionError, UnitError
from autobalancer.files.examples import example_text
from autobalancer.files.machine_file import load_machine, parse_machine
from autobalancer.files.samples import write_example
from autobalancer.machine import Machine, Unbalance
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.units import to_si

ROOT = Path(__file__).parents[1]
RACE = (ROOT / "docs/machines/real_race.toml").read_text(encoding="utf-8")


DISCOIDAL = (ROOT / "examples/machines/discoidal.toml").read_text(encoding="utf-8")
CHAMBER = (ROOT / "examples/machines/deep_chamber.toml").read_text(encoding="utf-8")


def refused(text: str) -> str:
    with pytest.raises(MachineError) as reason:
        parse_machine(text, "m.toml", folder=ROOT / "docs/machines")
    return str(reason.value)


def test_an_excitation_or_a_joint_without_its_kind_is_told_which_kinds_there_are() -> None:
    before, _, after = RACE.partition("[[excitations]]")
    told = refused(before + "[[excitations]]" + after.replace('kind = "base_motion"', "", 1))
    assert "excitations[1]: given" in told
    assert "'kind', which must be one of 'base_motion', 'recorded_base_motion', 'force', 'recorded_force'" in told
    told = refused(example_text("discoidal_rig").replace('kind = "lock"', "", 1))
    assert "joints[1]: given" in told
    assert "one of 'bearing', 'bushing', 'dashpot', 'lock'" in told


@pytest.mark.parametrize(
    "text",
    [
        *(
            "1 9**9**9**9 m",
            "1 m**9**9**9",
            "1 m*(9**9**8)",
            "1 m^9^9^9",
            "1 (((m**9)**9)**9)/(((km**9)**9)**9)",
            "1 9 m",
        ),
        *("1 " + "k" * 40_000, "9" * 50_000 + " m", "1" + " " * 10_000 + "m m", "1 " + "(" * 70, "1 m" + "*m" * 38),
    ],
)
def test_a_quantity_that_would_be_worked_out_for_ever_is_refused_at_once(text: str) -> None:
    begin = time.process_time()
    with pytest.raises(UnitError) as reason:
        to_si(text, "m")
    assert time.process_time() - begin < 2.0
    assert len(str(reason.value)) < 400


def test_units_with_powers_brackets_and_superscripts_are_still_read() -> None:
    for text, unit, value in (
        ("3 g/(cm^3)", "kg/m^3", 3000.0),
        ("1 kg·m²", "kg*m^2", 1.0),
        ("2 m^-0.5 s^-2", "m^-0.5*s^-2", 2.0),
        ("6 1/min", "1/s", 0.1),
        ("1 (m/s)**2", "m^2/s^2", 1.0),
    ):
        assert to_si(text, unit) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize("number", [10**400, -(10**400), 10**5000, 1e308 * 10, float("nan")], ids=range(5))
def test_a_number_beyond_all_bounds_is_no_quantity(number: float) -> None:
    with pytest.raises(UnitError, match=r"given .{1,80}, which is not a finite number"):
        to_si(number, "m")


@pytest.mark.parametrize("given", ["²x3", "3x²", "x", "3x3x3"])
def test_a_raised_digit_is_no_count(given: str) -> None:
    for count, option in ((flow._points, "--points"), (balls._size, "--size")):
        with pytest.raises(QuestionError, match=f"{option}: given '{given}'"):
            count(given)


def with_value(text: str, entry: str, value: Any) -> str:
    """A machine file with one entry replaced."""
    changed, count = re.subn(rf"(?<![\w.]){entry} = [^\n]*", lambda _: f"{entry} = {value}", text, count=1)
    assert count == 1
    return changed


@pytest.mark.parametrize("count", [10**6, 10**9, 10**30, 10**4000], ids=range(4))
def test_more_balls_than_anybody_has_are_refused_before_they_are_made(count: int) -> None:
    begin = time.process_time()
    for file, told in (
        (DISCOIDAL, "balancers: given .* balls in all; at most 1000"),
        (CHAMBER, "chambers: given .* balls"),
    ):
        assert re.search(told, refused(with_value(file, "count", count)))
    data = tomllib.loads(DISCOIDAL)
    data["balancers"][0]["races"][0]["balls"][0]["count"] = count
    with pytest.raises(MachineError, match="count: given"):
        Machine(**data)
    assert time.process_time() - begin < 2.0


def test_balls_so_small_that_millions_fill_their_chamber_are_refused() -> None:
    data = tomllib.loads(CHAMBER)
    (group,) = data["chambers"][0]["balls"]
    del group["total_mass"]
    group["diameter"] = "1e-4 mm"
    with pytest.raises(MachineError, match="of them would fill the chamber; take larger balls"):
        ChamberMachine(**data)


def test_lists_texts_and_files_of_any_length_are_refused_in_a_few_words(tmp_path: Path) -> None:
    head, tail = DISCOIDAL[: DISCOIDAL.index("[[balancers]]")], DISCOIDAL[DISCOIDAL.index("[drive]") :]
    balancer = DISCOIDAL[len(head) : -len(tail)]
    race, balls = balancer.index("[[balancers.races]]"), balancer.index("[[balancers.races.balls]]")
    large, endless, pipe = tmp_path / "large.toml", Path("/dev/zero"), tmp_path / "pipe"
    os.mkfifo(pipe)
    large.write_text(DISCOIDAL + "#" * 10_000_000)
    for text, told in (
        (head + balancer * 101 + tail, "balancers: given a list of 101 entries; at most 100"),
        (head + balancer[:race] + balancer[race:] * 101 + tail, "races: given a list of 101 entries; at most 100"),
        (head + balancer[:balls] + balancer[balls:] * 1001 + tail, "balls: given a list of 1001 entries; at most 1000"),
        (with_value(DISCOIDAL, "name", '"' + "x" * 9000 + '"'), "name: given a text of 9000 characters"),
        (DISCOIDAL + "x = " + "[" * 100 + "]" * 100, "more than 20 deep"),
        ("x = " + "[" * 5000 + "]" * 5000, "not valid TOML"),
        (with_value(DISCOIDAL, "count", "9" * 5000), "not valid TOML"),
        ("".join(f"k{i} = 1\n" for i in range(500)) + DISCOIDAL, "k19: unknown key"),
    ):
        answer = refused(text)
        assert told in answer
        assert len(answer) < 4000
    for path, told in ((large, "larger than 10 MB"), (endless, "a device or a pipe"), (pipe, "a device or a pipe")):
        with pytest.raises(MachineError, match=f"{path}: is {told}"):
            load_machine(path)


@pytest.mark.parametrize(
    ("file", "entry", "value"),
    [
        *((DISCOIDAL, "density", f'"{value}"') for value in ("1e300 kg/m^3", "1e12 kg/m^3", "1e-310 kg/m^3")),
        *((DISCOIDAL, "orbit_radius", f'"{value}"') for value in ("9e18 m", "1e300 m", "1e-20 m")),
        *((DISCOIDAL, "duration", f'"{value}"') for value in ("1e-310 s", "1e300 s")),
        (DISCOIDAL, "start_angles", '["1e300 rad", 0.0]'),
        (DISCOIDAL, "diameter", '"1e-9 mm"'),
        (DISCOIDAL, "width", '"10 m"'),
        (DISCOIDAL, "name", '""'),
        (DISCOIDAL, "name", r'"pump\u001b[2J"'),
        (DISCOIDAL, "name", r'"a\nb"'),
        (CHAMBER, "depth", '"1e300 m"'),
    ],
)
def test_what_no_machine_can_be_is_refused(file: str, entry: str, value: str) -> None:
    told = refused(with_value(file, entry, value))
    assert entry in told
    assert "\x1b" not in told


def test_an_error_that_is_found_after_reading_names_the_file(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    data = tomllib.loads(DISCOIDAL)
    del data["balancers"][0]["races"][0]["width"]
    path.write_text(tomli_w.dumps(data))
    answer = CliRunner().invoke(app, ["annulus-flow", str(path)])
    assert answer.exit_code == 2, answer.output
    assert str(path) in answer.stderr


def test_a_chamber_of_a_kilometre_is_odd_and_a_large_tilt_of_the_principal_axis_refused() -> None:
    machine = parse_machine(with_value(DISCOIDAL, "height", '"1 km"'), "m.toml")
    assert isinstance(machine, Machine)
    assert any("races[1].height is 1e+06 mm beside balls of 12.3 mm" in note for note in summary(machine).warnings)
    usual = parse_machine(DISCOIDAL, "m.toml")
    assert isinstance(usual, Machine)
    assert not any("unit right" in note for note in summary(usual).warnings)
    with pytest.raises(MachineError, match="misalignment: given 3 rad; must be at most"):
        Unbalance(misalignment=3.0)


HOSTILE = (
    "0",
    "-1",
    "1e300",
    "1e-300",
    '""',
    '"x"',
    "[]",
    "[1, 2, 3]",
    "{}",
    "true",
    "nan",
    "inf",
    '"1 m"',
    '"1e9 kg"',
    "1e12",
)


@pytest.mark.parametrize("seed", range(4))
def test_a_file_with_any_value_replaced_is_read_or_refused(seed: int) -> None:
    drawn = random.Random(seed)
    files = sorted((ROOT / "examples/machines").glob("*.toml")) + sorted((ROOT / "docs/machines").glob("*.toml"))
    for _ in range(60):
        path = drawn.choice(files)
        lines = path.read_text(encoding="utf-8").splitlines()
        place = drawn.choice([i for i, line in enumerate(lines) if re.match(r"\w+ = ", line)])
        lines[place] = f"{lines[place].split('=')[0]}= {drawn.choice(HOSTILE)}"
        try:
            parse_machine("\n".join(lines), path.name, folder=path.parent)
        except MachineError as reason:
            assert path.name in str(reason)  # noqa: PT017
            assert len(str(reason)) < 4000  # noqa: PT017


def test_a_folder_a_machine_and_a_unit_too_many_are_named_in_words(tmp_path: Path) -> None:
    machine = write_example("design", tmp_path)[0]
    with pytest.raises(ab.errors.MachineFileError, match="is a folder; give the path of a file"):
        ab.check(tmp_path)
    with pytest.raises(
        ab.errors.ResultError, match=r"design\.toml: is no result but a machine file; 'autobalancer simulate"
    ):
        ab.load_run(machine)
    with pytest.raises(ab.errors.UnitError, match=r"a number without a unit is wanted here, such as 0\.02 or \"2 %\""):
        ab.units.to_si("40 N*s/m", "")


DOORS: dict[str, tuple[Any, str]] = {
    "parse_machine": (lambda: ab.parse_machine(None), "given a NoneType; wanted is the text of a file"),  # type: ignore[arg-type]
    "machine_text": (lambda: ab.machine_text(None), "machine: given a NoneType; wanted is a machine"),  # type: ignore[arg-type]
    "save_run": (lambda: ab.save_run("x", "y.nc"), "save_run: given a str; give a result"),  # type: ignore[arg-type]
    "load_run": (lambda: ab.load_run(None), r"path: given None \(NoneType\); give the path of a file"),  # type: ignore[arg-type]
    "load_machine": (lambda: ab.load_machine(3), r"path: given 3 \(int\); give the path of a file"),  # type: ignore[arg-type]
    "save_machine": (lambda: ab.save_machine(ab.example("design"), "a\0b.toml"), "has no zero character"),
    "run_measures": (lambda: ab.run_measures(None), "run_measures: given a NoneType; it measures a run"),  # type: ignore[arg-type]
    "verdict": (lambda: ab.verdict(3), "verdict: given a int; it measures a run"),  # type: ignore[arg-type]
    "save": (
        lambda: ab.simulate(ab.example("design"), duration="1 ms", save=None),
        r"save: given None; give Samples\(\)",
    ),
    "tolerance": (lambda: ab.simulate(ab.example("design"), tolerance="x"), "tolerance: given 'x'"),
}


@pytest.mark.parametrize("door", DOORS)
def test_an_argument_of_another_kind_is_refused_in_words(door: str) -> None:
    ask, words = DOORS[door]
    with pytest.raises(ab.errors.AutobalancerError, match=words):
        ask()


def test_more_new_samples_than_fit_into_the_memory_are_refused_before_they_are_made(tmp_path: Path) -> None:
    table = tmp_path / "a.csv"
    table.write_text("time [s],a [m/s^2]\n" + "".join(f"{k / 1000},{k % 7}\n" for k in range(50)))
    with pytest.raises(QuestionError, match=r"a.csv: resample: 4.9e\+13 samples need .* fit; take a lower rate"):
        ab.measure.load_signals(table, resample="1e15 Hz")
