"""Machine files: what is read, what is refused and with which words, and that nothing is lost on the way back."""

from __future__ import annotations

import cmath
import copy
import json
import math
import pickle
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import in_author_units, with_author_springs
from autobalancer.catalog.resolve import planar_rotor, resolve
from autobalancer.cli.main import app
from autobalancer.errors import MachineError, MachineFileError, QuestionError, UnitError
from autobalancer.files.machine_file import load_machine, load_race_machine, machine_text, parse_machine, save_machine
from autobalancer.files.samples import sample_names
from autobalancer.machine import Balls, Friction, Machine, PlanarRotor, Unbalance
from autobalancer.machine.chamber import ChamberUnbalance
from autobalancer.machine.schema import Kind, file_schema, keys, other_kind
from autobalancer.units import WrittenFloat, from_si, to_si

ROOT = Path(__file__).resolve().parent.parent
FILES = sorted(
    path for path in (ROOT / "examples" / "machines").glob("*.toml") if isinstance(load_machine(path), Machine)
)
DISCOIDAL = tomllib.loads((ROOT / "examples" / "machines" / "discoidal.toml").read_text(encoding="utf-8"))
RACE = ("balancers", 0, "races", 0)
BALLS = (*RACE, "balls", 0)


def changed(path: tuple[str | int, ...], value: Any, data: dict[str, Any] = DISCOIDAL) -> dict[str, Any]:
    """A copy of the discoidal rig with one entry changed, or taken away with None."""
    data = copy.deepcopy(data)
    place: Any = data
    for step in path[:-1]:
        place = place[step]
    if value is None:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return data


def refusal(data: dict[str, Any] | str) -> str:
    """What the reader of machine.toml is told."""
    with pytest.raises(MachineFileError) as caught:
        parse_machine(data if isinstance(data, str) else tomli_w.dumps(data), "machine.toml")
    text = str(caught.value)
    assert text.startswith("machine.toml: ")
    return text


# reading ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_example_can_be_loaded(path: Path) -> None:
    machine = load_race_machine(path)
    assert machine.name
    assert machine.run is not None
    assert resolve(machine) or machine.liquid_rings


def test_quantities_become_si_numbers_and_remember_how_they_were_written() -> None:
    machine = parse_machine(tomli_w.dumps(DISCOIDAL))
    assert machine.rotor.stiffness == 44654.0
    assert machine.rotor.mass == 12.27
    assert isinstance(machine.rotor.mass, WrittenFloat)
    assert machine.rotor.mass.text == "12.27 kg"
    ball = machine.balancers[0].races[0].balls[0]
    assert ball.diameter == 0.0123
    assert ball.start_angles == pytest.approx((math.radians(40.0), math.radians(250.0)), rel=1e-15)
    assert machine.unbalances[0].size == pytest.approx(5.5e-3 * 0.108, rel=1e-15)


def test_an_unbalance_as_a_vector_points_to_its_angle_however_it_is_described() -> None:
    for kind in (Unbalance, ChamberUnbalance):
        three = kind(moment="3 g mm", angle="90 deg"), kind(mass="4 g", radius="1 mm"), kind(moment=5e-6, angle=-2.5)
        assert [one.vector for one in three] == pytest.approx([3e-6j, 4e-6, 5e-6 * cmath.exp(-2.5j)], abs=1e-19)
    assert Unbalance(couple="2 g mm^2", angle=1.0).vector == 0.0


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("10 Hz", "rad/s", 20.0 * math.pi),
        ("1200 rpm", "rad/s", 40.0 * math.pi),
        ("1 rev/s", "rad/s", 2.0 * math.pi),
        ("12.5 rad/s", "rad/s", 12.5),
        ("4.4 g", "kg", 4.4e-3),
        ("20 mm^2/s", "m^2/s", 2e-5),
        ("20 cSt", "m^2/s", 2e-5),
        ("594 g*mm", "kg*m", 5.94e-4),
        ("30 deg", "rad", math.pi / 6.0),
        ("25 degC", "K", 298.15),
        ("7.8 g/cm^3", "kg/m^3", 7800.0),
        ("44.654 kN/m", "N/m", 44654.0),
        ("2 min", "s", 120.0),
        ("-1.5e-1 mm", "m", -1.5e-4),
    ],
)
def test_a_quantity_is_read_in_any_unit_of_its_dimension(text: str, unit: str, value: float) -> None:
    assert to_si(text, unit) == pytest.approx(value, rel=1e-14)


def test_conversion_leaves_no_rounding_dust() -> None:
    assert to_si("20 mm^2/s", "m^2/s") == 2e-05
    assert to_si("12.3 mm", "m") == 0.0123
    assert from_si(40.0 * math.pi, "rad/s", "rpm") == pytest.approx(1200.0, rel=1e-14)


def test_a_plain_number_is_already_si() -> None:
    machine = parse_machine(tomli_w.dumps(changed(("rotor", "mass"), 12)))
    assert machine.rotor.mass == 12.0
    assert not isinstance(machine.rotor.mass, WrittenFloat)


def test_a_single_entry_counts_as_a_list_of_one() -> None:
    balls = Balls(diameter="10 mm", density=7800.0, start_angles="30 deg")
    assert balls.start_angles == (pytest.approx(math.pi / 6),)


def test_stiffness_may_be_one_value_or_one_for_each_direction() -> None:
    assert PlanarRotor(mass=1.0, stiffness="2 kN/m", damping=0.0).isotropic
    rotor = PlanarRotor(mass=1.0, stiffness=["2 kN/m", 3000.0], damping=[1.0, 1.0])
    assert rotor.stiffness_xy == (2000.0, 3000.0)
    assert not rotor.isotropic


# refusing ---------------------------------------------------------------------------------------------------------------

REFUSED: dict[str, tuple[tuple[str | int, ...], Any, tuple[str, ...]]] = {
    "unknown key": (
        ("rotor", "mas"),
        "1 kg",
        ("rotor.mas: unknown key; did you mean 'mass'?", "allowed here: critical_speed, damping"),
    ),
    "unknown key on top": (("rotr",), {}, ("rotr: unknown key; did you mean 'rotor'?", "unbalances")),
    "unknown key in capitals": (("rotor", "Stiffness"), 1.0, ("did you mean 'stiffness'?",)),
    "unknown key like no other": (("rotor", "colour"), 1.0, ("rotor.colour: unknown key; allowed here",)),
    "missing key": (("rotor", "mass"), None, ("rotor.mass: missing; it has no default",)),
    "missing part": (("drive",), None, ("drive: missing",)),
    "wrong dimension": (("rotor", "mass"), "12 mm", ("rotor.mass: given '12 mm'", "in kg", '"4.4 g"')),
    "no unit": (("rotor", "mass"), "12", ("rotor.mass: given '12' without a unit",)),
    "unknown unit": (("rotor", "mass"), "12 kgg", ("rotor.mass: 'kgg' is not a unit",)),
    "decimal comma": (("rotor", "mass"), "12,3 kg", ("decimal point", "12.3 kg")),
    "not a number": (("rotor", "mass"), float("nan"), ("rotor.mass: given nan", "not a finite number")),
    "infinite": (("rotor", "stiffness"), float("inf"), ("rotor.stiffness: given inf", "not a finite number")),
    "text that is not a number": (("rotor", "mass"), "nan kg", ("'nan kg'", "finite number")),
    "truth as number": (("rotor", "mass"), True, ("rotor.mass: given True",)),
    "negative mass": (("rotor", "mass"), "-1 kg", ("rotor.mass: given '-1 kg'", "greater than zero")),
    "no mass": (("rotor", "mass"), 0.0, ("rotor.mass: given 0.0", "greater than zero")),
    "negative damping": (("rotor", "damping"), -1.0, ("rotor.damping: given -1.0", "not be negative")),
    "three directions": (("rotor", "stiffness"), [1.0, 1.0, 1.0], ("rotor.stiffness: given 3 values",)),
    "unknown rotor": (("rotor", "kind"), "ghost", ("rotor.kind: given 'ghost'", "'planar'")),
    "unknown axis": (("axis",), "oblique", ("axis: given 'oblique'", "'vertical' or 'horizontal'")),
    "ball larger than race": ((*BALLS, "diameter"), "200 mm", ("balls[1]: a ball of 200 mm", "76.95 mm")),
    "ball larger than chamber": ((*BALLS, "diameter"), "15 mm", ("a ball of 15 mm", "width 13.8 mm")),
    "no balls": ((*RACE, "balls"), [], ("balancers[1].races[1].balls: given an empty list",)),
    "no races": (("balancers", 0, "races"), [], ("balancers[1].races: given an empty list",)),
    "count of zero": ((*BALLS, "count"), 0, ("balls[1].count: given 0",)),
    "half a ball": ((*BALLS, "count"), 1.5, ("balls[1].count: given 1.5",)),
    "an angle for one of two balls": ((*BALLS, "start_angles"), ["10 deg"], ("given 1 values for 2 balls",)),
    "overlapping start angles": (
        (*BALLS, "start_angles"),
        ["10 deg", "11 deg"],
        ("start_angles put two balls 1.00 deg apart", "they need 9.17 deg"),
    ),
    "overlapping across a full turn": (
        (*BALLS, "start_angles"),
        ["-1 deg", "359.5 deg"],
        ("start_angles put two balls 0.50 deg apart",),
    ),
    "too much said about a ball": ((*BALLS, "mass"), "5 g", ("diameter, mass and density", "leave one out")),
    "too little said about a ball": ((*BALLS, "density"), None, ("give two of 'diameter', 'mass' and 'density'",)),
    "both radii of a race": ((*RACE, "race_radius"), "80 mm", ("either 'orbit_radius'", "or 'race_radius'")),
    "drag without a fluid": ((*RACE, "fluid"), None, ("'cd_times_re' needs a fluid", "add 'fluid'")),
    "unknown drag law": ((*RACE, "drag", "law"), "magic", ("drag.law: given 'magic'", "'race_geometry'")),
    "floating ball": ((*BALLS, "density"), "500 kg/m^3", ("balls[1]: the ball", "floats", "displaces")),
    "unknown fluid": ((*RACE, "fluid", "name"), "honey", ("fluid.name: no fluid is called 'honey'", "catalog fluids")),
    "fluid given twice": ((*RACE, "fluid", "density"), 900.0, ("races[1].fluid: give either the 'name'",)),
    "unknown drive": (("drive", "kind"), "steam", ("drive.kind: given 'steam'", "'target_torque'")),
    "empty profile": (("drive", "profile", "time"), [], ("drive.profile: time: the profile is empty",)),
    "unequal lists in a profile": (("drive", "profile", "speed"), ["1 rpm"], ("given 3 times and 1 speeds",)),
    "time that stands still": (("drive", "profile", "time"), [0.0, 0.0, 1.0], ("time: must increase",)),
    "negative time": (("drive", "profile", "time"), [-1.0, 0.0, 1.0], ("drive.profile.time[1]: given -1.0",)),
    "torque without inertia": (("drive",), {"kind": "torque", "torque": 1.0}, ("rotor.inertia: missing",)),
    "start speed of a prescribed one": (("start",), {"speed": 1.0}, ("start.speed: the drive prescribes",)),
    "no duration": (("run", "duration"), "0 s", ("run.duration: given '0 s'", "greater than zero")),
    "unbalance given twice": (("unbalances", 0, "moment"), 1e-3, ("unbalances[1]: give either 'moment'",)),
    "unbalance without radius": (("unbalances", 0, "radius"), None, ("unbalances[1]: give either 'moment'",)),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_wrong_entry_is_refused_with_place_value_and_cure(name: str) -> None:
    path, value, words = REFUSED[name]
    told = refusal(changed(path, value))
    for word in words:
        assert word in told


def test_more_balls_than_fit_are_refused_with_the_angle_they_take() -> None:
    told = refusal(changed((*BALLS, "count"), 40, changed((*BALLS, "start_angles"), None)))
    assert "balancers[1].races[1].balls: 40 balls take 366.7 deg of 360 deg" in told


def test_as_many_balls_as_fit_are_accepted() -> None:
    machine = parse_machine(tomli_w.dumps(changed((*BALLS, "count"), 39, changed((*BALLS, "start_angles"), None))))
    assert len(resolve(machine)) == 39


def test_unknown_material_is_refused() -> None:
    data = changed((*BALLS, "material"), "unobtainium", changed((*BALLS, "density"), None))
    assert "balls[1].material: no material is called 'unobtainium'" in refusal(data)


def test_all_faults_of_a_file_are_told_at_once() -> None:
    data = changed(("rotor", "mass"), "-1 kg", changed(("axis",), "oblique", changed(("rotor", "mas"), 1.0)))
    told = refusal(data)
    for word in ("rotor.mas: unknown key", "axis: given 'oblique'", "rotor.mass: given '-1 kg'"):
        assert word in told


def test_text_that_is_not_toml_is_refused() -> None:
    assert "not valid TOML" in refusal("rotor = [")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(MachineFileError, match=r"nowhere\.toml: no such file"):
        load_race_machine(tmp_path / "nowhere.toml")


def test_a_folder_or_a_picture_is_not_a_machine_file(tmp_path: Path) -> None:
    with pytest.raises(MachineFileError, match="is a folder"):
        load_race_machine(tmp_path)
    (tmp_path / "picture.toml").write_bytes(b"\x89PNG\xff\xfe")
    with pytest.raises(MachineFileError, match=r"picture\.toml: is no text in UTF-8"):
        load_race_machine(tmp_path / "picture.toml")


def test_parts_built_in_python_are_refused_in_the_same_words() -> None:
    with pytest.raises(MachineError, match=r"PlanarRotor: mass: given -1; must be greater than zero"):
        PlanarRotor(mass=-1, stiffness=1.0, damping=0.0)
    with pytest.raises(UnitError, match="wanted here"):
        to_si("3 m", "kg")


def test_a_machine_cannot_be_changed_by_accident() -> None:
    machine = parse_machine(tomli_w.dumps(DISCOIDAL))
    with pytest.raises(MachineError, match="with_parameter"):
        machine.rotor.mass = 3.0  # type: ignore[misc]


# there and back ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_file_survives_being_read_and_written(path: Path, tmp_path: Path) -> None:
    machine = load_race_machine(path)
    saved = save_machine(machine, tmp_path / "deep" / "copy.toml")
    again = load_race_machine(saved)
    assert again == machine
    assert tomllib.loads(saved.read_text(encoding="utf-8")) == tomllib.loads(path.read_text(encoding="utf-8"))
    assert machine_text(again) == machine_text(machine)


def test_public_names_are_the_same_functions() -> None:
    assert ab.load_machine is load_machine
    assert ab.save_machine is save_machine


def quantity(unit: str, low: float, high: float, *others: tuple[str, float]) -> st.SearchStrategy[Any]:
    """A number in SI, or a text in this or another unit (with its factor)."""
    numbers = st.floats(low, high, allow_nan=False)
    texts = [numbers.map(lambda v, u=name, f=factor: f"{v / f!r} {u}") for name, factor in ((unit, 1.0), *others)]
    return st.one_of(numbers, *texts)


SPEEDS = quantity("rad/s", -500.0, 500.0, ("rpm", math.pi / 30), ("Hz", 2 * math.pi))
TIMES = quantity("s", 0.0, 100.0, ("min", 60.0), ("ms", 1e-3))
DURATIONS = quantity("s", 0.1, 100.0, ("min", 60.0))
ANGLES = quantity("rad", -10.0, 10.0, ("deg", math.pi / 180))
MASSES = quantity("kg", 1e-3, 50.0, ("g", 1e-3))
TEXTS = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc", "Zl", "Zp")), max_size=20)
ACCELERATIONS = quantity("rad/s^2", 0.1, 100.0, ("rpm/s", math.pi / 30))


def part(required: dict[str, Any], optional: dict[str, Any] | None = None) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries(required, optional=optional or {})


def table(kind: str | None, x: str, y: str, values: st.SearchStrategy[Any]) -> st.SearchStrategy[dict[str, Any]]:
    """Columns of equal length, the first increasing."""
    pairs = st.lists(st.tuples(st.integers(0, 100), values), min_size=1, max_size=5, unique_by=lambda pair: pair[0])
    tag = {"kind": kind} if kind else {}
    return pairs.map(
        lambda rows: tag | {x: [float(row[0]) for row in sorted(rows, key=lambda row: row[0])], y: [r[1] for r in rows]}
    )


PROFILES = st.one_of(
    part({"kind": st.just("constant"), "speed": SPEEDS}),
    part({"kind": st.just("ramp"), "end": SPEEDS, "duration": DURATIONS}, {"start": SPEEDS, "delay": TIMES}),
    table("table", "time", "speed", SPEEDS),
    part(
        {
            "kind": st.just("dwell"),
            "speeds": st.lists(SPEEDS, min_size=1, max_size=4),
            "hold": DURATIONS,
            "acceleration": ACCELERATIONS,
        }
    ),
    part(
        {"kind": st.just("hill"), "end": SPEEDS, "half_time": DURATIONS, "exponent": st.floats(1.0, 6.0)},
        {"start": SPEEDS},
    ),
    part(
        {"kind": st.just("reduction"), "peak": SPEEDS, "reduced": SPEEDS, "end": SPEEDS, "acceleration": ACCELERATIONS},
        {"start": SPEEDS, "hold_peak": TIMES, "hold_reduced": TIMES},
    ),
)
TORQUES = quantity("N*m", -10.0, 10.0, ("mN*m", 1e-3))
BRAKES = quantity("N*m*s", 0.0, 1.0)
DRIVES = st.one_of(
    part({"kind": st.just("torque"), "torque": TORQUES}, {"damping": BRAKES}),
    part({"kind": st.just("target_torque"), "profile": PROFILES, "gain": BRAKES}, {"damping": BRAKES}),
    table("torque_table", "speed", "torque", TORQUES),
    part({"kind": st.just("speed"), "profile": PROFILES}),
)
BALL_GROUPS = part(
    {
        "count": st.integers(1, 5),
        "diameter": quantity("m", 0.004, 0.012, ("mm", 1e-3)),
        "density": quantity("kg/m^3", 2000.0, 9000.0, ("g/cm^3", 1000.0)),
        "motion": st.sampled_from(["rolling", "point"]),
    }
)
FLUIDS = st.one_of(
    part({"density": quantity("kg/m^3", 1.0, 1500.0), "viscosity": quantity("m^2/s", 1e-7, 1e-3, ("mm^2/s", 1e-6))}),
    part(
        {"name": st.just("silicone oil 20")},
        {"temperature": quantity("K", 290.0, 310.0), "virtual_mass": st.floats(0, 2)},
    ),
)
RACES = part(
    {
        "race_radius": quantity("m", 0.05, 0.3, ("mm", 1e-3)),
        "fluid": FLUIDS,
        "drag": st.one_of(
            part({"law": st.just("viscous"), "damping": BRAKES}),
            part({"law": st.just("cd_times_re"), "cd_times_re": st.floats(1.0, 1000.0)}),
            st.just({"law": "sphere_on_plane"}),
        ),
        "balls": st.lists(BALL_GROUPS, min_size=1, max_size=3),
    },
    {"eccentricity": quantity("m", 0.0, 0.01, ("mm", 1e-3), ("um", 1e-6)), "eccentricity_angle": ANGLES},
)
SCHEDULES = table(None, "time", "factor", st.floats(0, 3))
UNBALANCES = st.one_of(
    part({"moment": quantity("kg*m", 0.0, 1e-2, ("g*mm", 1e-6))}, {"angle": ANGLES, "schedule": SCHEDULES}),
    part({"mass": MASSES, "radius": quantity("m", 0.01, 1.0, ("mm", 1e-3))}, {"angle": ANGLES}),
)
STIFFNESS = quantity("N/m", 1.0, 1e7, ("kN/m", 1e3))
MACHINES = part(
    {
        "name": TEXTS.filter(str.strip),
        "axis": st.sampled_from(["vertical", "horizontal"]),
        "rotor": part(
            {
                "kind": st.just("planar"),
                "mass": MASSES,
                "stiffness": st.one_of(STIFFNESS, st.lists(STIFFNESS, min_size=2, max_size=2)),
                "damping": quantity("N*s/m", 0.0, 1e3),
                "inertia": quantity("kg*m^2", 1e-6, 1.0, ("g*m^2", 1e-3)),
            }
        ),
        "drive": DRIVES,
    },
    {
        "description": TEXTS,
        "gravity": quantity("m/s^2", 0.0, 20.0),
        "unbalances": st.lists(UNBALANCES, max_size=3),
        "balancers": st.lists(part({"races": st.lists(RACES, min_size=1, max_size=2)}, {"name": TEXTS}), max_size=2),
        "run": part({"duration": DURATIONS}),
    },
)


@given(MACHINES)
@settings(max_examples=30, deadline=None)
def test_any_machine_survives_being_written_and_read(data: dict[str, Any]) -> None:
    machine = Machine(**data)
    text = machine_text(machine)
    again = parse_machine(text)
    assert again == machine
    assert machine_text(again) == text
    assert tomllib.loads(text) == data


def test_a_quantity_that_was_read_once_keeps_its_dimension() -> None:
    mass = to_si("4.4 g", "kg")
    assert to_si(mass, "kg") == 0.0044
    with pytest.raises(UnitError, match="a quantity in m is wanted"):
        to_si(mass, "m")


def test_a_missing_file_with_the_name_of_a_sample_is_pointed_to(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MachineFileError, match="no such file; 'autobalancer example discoidal' writes"):
        load_race_machine("examples/machines/discoidal.toml")
    with pytest.raises(MachineFileError, match=r"other\.toml: no such file$"):
        load_race_machine("examples/machines/other.toml")


MACHINES = [ab.catalog.example_path(name) for sort in ("machines", "rigs") for name in sample_names(sort)]
SCHEMA_TOO = ("annotated", "misfit", "chamber")  # the first two with single entries in place of lists


@pytest.mark.parametrize("kind", ["races", "chambers"])
def test_the_schema_accepts_every_sample_machine_and_refuses_what_cannot_be(kind: Kind) -> None:
    schema = Draft202012Validator(file_schema(kind))
    samples = [tomllib.loads(path.read_text()) for path in MACHINES]
    samples += [tomllib.loads((ROOT / "docs" / "machines" / f"{name}.toml").read_text()) for name in SCHEMA_TOO]
    own = [data for data in samples if ("chambers" in data) == (kind == "chambers")]
    assert len(own) >= 3
    for data in own:
        assert list(schema.iter_errors(data)) == []
        assert not schema.is_valid(data | {"color": "red"})
        assert not schema.is_valid(data | {"rotor": data["rotor"] | {"mass": -1.0}})
    assert "Parameters\\n" not in json.dumps(schema.schema)


@pytest.mark.parametrize("kind", ["design", "chamber_design", "study", "balancing", "measurements"])
def test_the_schema_and_the_keys_of_other_files_accept_their_samples(kind: Kind) -> None:
    schema = Draft202012Validator(file_schema(kind))
    paths = (
        ab.catalog.example_path(name) for sort in ("measurements", "studies", "designs") for name in sample_names(sort)
    )
    samples = [tomllib.loads(path.read_text(encoding="utf-8")) for path in paths if path.suffix == ".toml"]
    listed = {head: {key.name for key in found} for head, found in keys(kind=kind).items()}
    own = [data for data in samples if other_kind(data) == kind]
    assert own
    assert None not in map(other_kind, samples)
    for data in own:
        assert list(schema.iter_errors(data)) == []
        assert not schema.is_valid(data | {"color": "red"})
        assert set(data) <= listed[""]


def test_the_schema_takes_one_entry_for_a_list_where_the_reader_does() -> None:
    schema = Draft202012Validator(file_schema())
    data = tomllib.loads((ROOT / "examples" / "machines" / "rigid_rotor.toml").read_text())
    support = {"position": "0 mm", "stiffness": "100 kN/m", "damping": 0, "tilt_stiffness": "1 kN*m/rad"}
    single = data | {"rotor": data["rotor"] | {"supports": support}}
    assert Machine(**single).rotor == Machine(**single | {"rotor": single["rotor"] | {"supports": [support]}}).rotor
    assert list(schema.iter_errors(single)) == []
    assert not schema.is_valid(data | {"rotor": data["rotor"] | {"supports": []}})
    assert not schema.is_valid(data | {"rotor": data["rotor"] | {"supports": support | {"color": "red"}}})


def test_help_of_a_part_shows_unit_and_meaning_of_its_keys() -> None:
    assert "rolling_resistance : number, ≥ 0, default 0" in str(Friction.__doc__)
    assert "lever arm of the wall force" in str(Friction.__doc__)


def test_the_command_keys_shows_one_table_and_names_the_tables_there_are() -> None:
    shown = CliRunner().invoke(app, ["keys", "rotor"]).stdout
    assert "w_c = sqrt(k/M)" in shown
    assert not set("$`") & set(shown)
    (row,) = json.loads(CliRunner().invoke(app, ["keys", "run", "--json"]).stdout)
    assert row == {
        "table": "[run]", "name": "duration", "value": "s, > 0", "default": "required", "meaning": "of a run", "symbol": ""
    }  # fmt: skip
    with pytest.raises(QuestionError, match=r"'race': no such table .* balancers.races,"):
        keys("race")


AUTHOR = """
name = "drum"
axis = "vertical"
unbalances = [{ moment = "600 g*mm", angle = "30 deg" }]
[rotor]
kind = "planar"
mass = 12.0
critical_speed = ["700 rpm", "712 rpm"]
damping_ratio = "3 %"
[[balancers]]
[[balancers.races]]
orbit_radius = "70 mm"
drag = { law = "viscous", damping = 1e-4 }
balls = [{ count = 2, mass = "7 g", motion = "point" }]
[drive]
kind = "speed"
profile = { kind = "constant", speed = 125.0 }
"""


def test_a_changed_machine_is_written_in_the_units_and_words_of_its_author() -> None:
    author = parse_machine(AUTHOR)
    assert isinstance(author, Machine)
    changed = ab.with_parameter(author, "unbalance", 8.123e-4)
    ramp = {"kind": "ramp", "start": 0.0, "end": 40.0 * math.pi, "duration": 20.0}
    for path, value in (("unbalances[1].angle", 1.25), ("rotor.mass", 12.5), ("drive.profile", ramp)):
        changed = ab.with_parameter(changed, path, value)
    written = in_author_units(with_author_springs(changed, author), author)
    data = tomllib.loads(machine_text(written))
    assert data["unbalances"] == [{"moment": "812.3 g*mm", "angle": "71.61972439 deg"}]
    assert data["rotor"]["mass"] == 12.5  # its author wrote a number
    assert data["drive"]["profile"] == {"kind": "ramp", "start": "0 rpm", "end": "1200 rpm", "duration": "20 s"}
    slower = math.sqrt((12.0 + 0.014) / (12.5 + 0.014))  # the springs stayed when the mass grew
    speeds = [float(text.removesuffix(" rpm")) for text in data["rotor"]["critical_speed"]]
    assert speeds == pytest.approx([700.0 * slower, 712.0 * slower], rel=1e-9)
    ratios = data["rotor"]["damping_ratio"]
    assert float(ratios.removesuffix(" %")) == pytest.approx(3.0 * slower, rel=1e-9)
    back = parse_machine(machine_text(written))
    assert back == written
    assert planar_rotor(back).stiffness == pytest.approx(planar_rotor(changed).stiffness, rel=1e-9)
    assert not any("was read in" in note for note in ab.check(back).warnings)


def test_a_machine_that_nobody_changed_keeps_every_letter_of_its_numbers() -> None:
    machine = parse_machine(AUTHOR)
    assert machine_text(in_author_units(machine, machine)) == machine_text(machine)


def test_an_error_has_the_path_of_each_key_at_fault_wherever_it_was_found() -> None:
    text = (ROOT / "examples" / "machines" / "discoidal.toml").read_text()
    for before, after, path in (
        ("[rotor]", "[rotor]\nmas = 1", ("rotor", "mas")),
        ("[rotor]", "[rotor]\nday = 2026-01-01", ("rotor", "day")),
        ('name = "silicone oil', 'name = "silicon oil', ("balancers", 0, "races", 0, "fluid", "name")),
        ("[rotor]", f"notes = ['{'x' * 300}']\n[rotor]", ("notes", 0)),
    ):
        assert before in text
        with pytest.raises(MachineError) as raised:
            parse_machine(text.replace(before, after, 1))
        assert raised.value.path == path
        assert pickle.loads(pickle.dumps(raised.value)).problems == raised.value.problems
