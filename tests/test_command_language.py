"""The command line as a language: numbers have units, one name for one thing, files are what their names say."""

from __future__ import annotations

import csv
import io
import json
import re
import shlex
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
import rich.console
import typer
import xarray as xr
from tests.references import answer_schemas
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import Commands, app
from autobalancer.cli.stability import usual_speeds as usual
from autobalancer.cli.terminal import command as shell
from autobalancer.cli.terminal import sheet
from autobalancer.cli.terminal import sheet as words
from autobalancer.cli.terminal.command import public
from autobalancer.cli.terminal.group import places
from autobalancer.cli.terminal.options import parameter_values, speed_range
from autobalancer.cli.terminal.progress_bar import Console
from autobalancer.cli.terminal.sheet import print_sheet, sheet_csv, sheet_si
from autobalancer.errors import MachineFileError, QuestionError, ResultError, UnitError
from autobalancer.files.samples import write_example
from autobalancer.machine.schema import answer_schema
from autobalancer.results.store import plain_json
from autobalancer.stability.states.questions import eigenvalues, ranges
from autobalancer.tables import Column
from autobalancer.units.quantity import listed, range_values

ROOT = Path(__file__).parents[1]
DISCOIDAL = str(ROOT / "examples" / "machines" / "discoidal.toml")
RIGID = str(ROOT / "examples" / "machines" / "rigid_rotor.toml")
RPM = np.pi / 30.0


@pytest.fixture(autouse=True)
def no_word_of_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    """How far a command is after 20 s depends on the computer, and is no part of its answer."""
    for wait in ("FIRST", "SOON"):
        monkeypatch.setattr(f"autobalancer.cli.terminal.progress_bar.{wait}", float("inf"))


def say(*words: str, code: int = 0, columns: int = 80) -> str:
    answer = CliRunner().invoke(app, list(words), env={"COLUMNS": str(columns)})
    assert answer.exit_code == code, answer.output
    return answer.output


def commands(command: Any = None, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every command that does something, with the words that call it."""
    command = command or typer.main.get_command(app)
    for name, child in getattr(command, "commands", {}).items():
        if getattr(child, "commands", None):
            yield from commands(child, (*path, name))
        else:
            yield (*path, name), child


COMMANDS = dict(commands())


@pytest.mark.parametrize(
    "words",
    [
        ("basin", DISCOIDAL, "--speed", "1200", "--random", "2"),
        ("response", RIGID, "--speeds", "600:1200:10"),
        ("eigenvalues", DISCOIDAL, "--speeds", "60:120:10"),
        ("catalog", "bearings", "--max-outer", "60"),
        ("catalog", "bearings", "--unbalance", "600"),
        ("map", DISCOIDAL, "--x", "speed=50:130:4", "--y", "viscosity=1:9 mm^2/s:4"),
        ("borders", DISCOIDAL, "--over", "rotor.damping=50:90:3"),
        ("branches", DISCOIDAL, "--over", "speed=50:90"),
        ("simulate", DISCOIDAL, "--duration", "20"),
        ("basin", DISCOIDAL, "--speed", "1200 rpm", "--x", "ball_angle[1]=-180:180:5"),
        ("catalog", "fluids", "--temperature", "0"),
    ],
)
def test_a_number_without_its_unit_is_refused_with_an_example(words: tuple[str, ...]) -> None:
    told = say(*words, code=2)
    assert "without a unit; write it with one, such as" in " ".join(told.split())
    assert "--" in told, "it says which option"


def test_a_range_has_one_form_and_a_unit_may_stand_once() -> None:
    expected = np.linspace(600.0 * RPM, 1200.0 * RPM, 7)
    for text in ("600 rpm:1200 rpm:7", "600:1200 rpm:7", "600 rpm:1200:7", "600rpm:1200rpm:7"):
        assert speed_range("--speeds", text) == pytest.approx(expected)
    assert range_values("--x", "1:100 mm^2/s:3:log", "m^2/s") == pytest.approx([1e-6, 1e-5, 1e-4])
    assert listed("--speeds", "4,6,8 m/s", "m/s") == [4.0, 6.0, 8.0]
    assert listed("--friction", "0.3,0.5", "") == [0.3, 0.5]
    machine = ab.load_machine(DISCOIDAL)
    name, numbers = parameter_values("--x", "balancers[1].races[1].orbit_radius=70:80 mm:3", machine)
    assert name == "balancers[1].races[1].orbit_radius"
    assert numbers == pytest.approx([0.07, 0.075, 0.08])
    with pytest.raises(QuestionError, match="entry 2 does not exist"):
        parameter_values("--x", "balancers[2].races[1].orbit_radius=70:80 mm:3", machine)


@pytest.mark.parametrize("text", ["600 rpm to 1200 rpm", "100 rpm:200 rpm:5", "600 rpm 700 rpm"])
def test_a_range_where_one_quantity_is_wanted_is_named_as_such(text: str) -> None:
    told = " ".join(say("modes", RIGID, "--speed", text, code=2).split())
    assert "one quantity is wanted here" in told
    with pytest.raises(UnitError, match="a range is written as from:to:count"):
        speed_range("--speeds", "600 rpm to 1200 rpm")


def test_options_of_one_name_mean_the_same_in_every_command() -> None:
    for path, command in COMMANDS.items():
        names = {option for parameter in command.params for option in parameter.opts if option.startswith("--")}
        assert "--output" not in names, path
        assert "--result" not in names, path
        assert "--axis" not in names, path
        assert "--json" in names, path
        helps = {option: parameter.help for parameter in command.params for option in parameter.opts}
        for option in ("--json", "--csv", "--speed-unit", "--seed"):
            if option in helps and path[0] not in ("plot", "animate"):
                assert helps[option] == HELPS.setdefault(option, helps[option]), path


HELPS: dict[str, str] = {}


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_the_example_of_a_help_can_be_copied(path: tuple[str, ...]) -> None:
    """Joined at its backslashes it is one line of known options, and no line is broken by the width of the terminal."""
    text = say(*path, "--help")
    lines = [line.strip() for line in text[text.index("Example:") :].splitlines()]
    example = lines[0].removeprefix("Example: ")
    for line in lines[1:]:
        if not example.endswith("\\"):
            break
        example = example[:-1] + line
    words = shlex.split(example)
    assert words[: 1 + len(path)] == ["autobalancer", *path]
    known = {option for parameter in COMMANDS[path].params for option in parameter.opts}
    assert {word for word in words if word.startswith("--")} <= known


SAMPLES = (
    "discoidal",
    "stall_and_release",
    "two_plane_rotor",
    "rigid_rotor",
    "coupled_drive",
    "liquid_ring",
    "thinning_fluid",
    "deep_chamber",
    "equilibrium_angle",
    "discoidal_hammer",
    "rubber_loops",
    "rubber_signals",
    "run_up_signals",
    "decay_signals",
    "two_plane_job",
    "later_run",
    "four_runs",
    "run_down_orders",
    "one_ball_run_up",
    "race_profile",
    "rest_positions",
    "ball_lag",
    "rodrigues_rig",
    "rodrigues_critical_speeds",
    "oil_study",
    "tube_breakage",
    "speed_reduction",
    "stall_share",
    "centrifuge_design",
    "deep_chamber_design",
)
WIDE = (
    'ensemble stall_and_release.toml --column "drag=1e-4,2e-4 N*m*s" --duration "0.05 s"',
    "check discoidal.toml",
    "check two_plane_rotor.toml",
    "check deep_chamber.toml",
    'simulate stall_and_release.toml --duration "0.2 s"',
    'simulate deep_chamber.toml --duration "0.05 s"',
    "example",
    "recipe",
    "cite discoidal.toml --out used.bib",
    "keys",
    "keys balancers.races",
    "run-measures stall.nc",
    'run-measures runs/one --last "0.01 s"',
    "plot stall.nc --kind race --out pictures",
    'animate stall.nc --out stall.gif --seconds "0.2 s" --fps 10',
    'borders discoidal.toml --over "unbalance=0:600 g*mm:3" --windows --up-to "1200 rpm"',
    'eigenvalues discoidal.toml --speeds "500:1500 rpm:20"',
    'map discoidal.toml --x "speed=500:1500 rpm:5" --y "viscosity=1:100 mm^2/s:5:log"',
    'compare discoidal.toml stall_and_release.toml --duration "0.2 s" --at "1 rpm"',
    'basin discoidal.toml --speed "1200 rpm" --random 2',
    'basin discoidal.toml --speed "1200 rpm" --x "ball_angle[1]=-180:180 deg:2"',
    'modes rigid_rotor.toml --speed "1200 rpm"',
    'campbell rigid_rotor.toml --speeds "0:6000 rpm:21"',
    'response rigid_rotor.toml --speeds "1200 rpm"',
    "torsional-modes coupled_drive.toml",
    'torsional-response coupled_drive.toml --speeds "100:3000 rpm:9"',
    'liquid-response liquid_ring.toml --speeds "100:1000 rpm:9"',
    'stepped-response discoidal.toml --speeds "400:500 rpm:2" --dwell "0.2 s" --window "0.1 s"',
    "equivalent-planar rigid_rotor.toml",
    'ball-drag discoidal.toml --gap "10 um" --reynolds 0 --mesh-gap 0.1 --fineness 0.5',
    'annulus-flow discoidal.toml --speed "60 rad/s" --initial-speed "0 rpm" --duration "0.04 s" --points 12x14',
    'equilibrium-angle equilibrium_angle.toml --speeds "5:60 rpm:12"',
    'receptance discoidal_hammer.csv --machine discoidal.toml --speed "1200 rpm" --resamples 0',
    "rubber rubber_loops.csv",
    "measure signals run_up_signals.csv",
    'measure balance later_run.toml --influence two_plane_job.toml --runout "bearing 1: 0.5 mm/s @ 30 deg"',
    'measure balance two_plane_job.toml --largest "5 g" --holes 12 --mass "1 g" --most 2',
    "measure four-run four_runs.toml",
    "measure run-down two_plane_rotor.toml run_down_orders.csv --plane lower --plane upper",
    'measure trial-mass --radius "100 mm" --speed "1500 rpm" --rotor-mass "20 kg"',
    'measure split-mass "15 g" "40 deg" --holes 6',
    "measure race-shape race_profile.csv",
    "measure rubber-signals rubber_signals.csv",
    'measure rest-friction one_ball_run_up.toml rest_positions.csv --speed "1200 rpm"',
    "measure drag-from-lag one_ball_run_up.toml ball_lag.csv",
    "compare stall.nc logger.nc",
    'measure record stall.nc --sensor "displacement::x:40 dB" --rate "2 kHz" --end "0.1 s"',
    "measure orders run_up_signals.csv --orders 1,2",
    'measure film stall.nc --out film.mp4 --tilt "30 deg" --end "0.1 s" --size 480x360',
    "measure balls film.mp4 --setup film.toml --out film.nc",
    'measure spectrum run_up_signals.csv --start "13 s"',
    "measure order-map run_up_signals.csv",
    "measure damping decay_signals.csv",
    'measure orbit run_up_signals.csv --at "9 s"',
    "measure envelope run_up_signals.csv",
    "chamber archive runs",
    "chamber bounds deep_chamber.toml",
    'catalog bearings --unbalance "594 g*mm"',
    "catalog bearing 16021",
    "catalog drag-laws",
    "catalog fluids",
    'catalog fluid "silicone oil 20"',
    'catalog blend "silicone oil 1" "silicone oil 50" --viscosity "5 mm^2/s"',
    "catalog materials",
    "catalog friction",
    "catalog rigs",
    "catalog rig cfrp_rig --out rig.toml",
    'catalog capability --orbit-radius "77 mm" --ball-diameter "12 mm"',
)
WIDE_AND_SLOW = (
    "study oil_study.toml --sensitivity peak_deflection",
    "design centrifuge_design.toml",
    "report stall_and_release.toml --starts 0",
    "envelopes discoidal.toml --members 4 --coast-down",
    'branches discoidal.toml --over "speed=60:70 rad/s"',
    "identify rodrigues_rig.toml --measurements rodrigues_critical_speeds.toml",
    'chamber amplitudes deep_chamber.toml --balls 3 --friction 0.3 --duration "0.05 s" --archive studied',
    'chamber reactions deep_chamber.toml --duration "0.05 s" --archive reacted --out pictures',
    "chamber step-size --stiffness-over-mass 1e10",
    "design deep_chamber_design.toml",
    "export two_plane_rotor.toml --out two_planes.fmu",
    "chamber sensitivity small_design.nc unbalance=0.2 --archive small_parts",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The samples, the result of a run, and an archive with a run in it."""
    place = tmp_path_factory.mktemp("copied")
    for name in SAMPLES:
        write_example(name, place)
    for name, many, few in (
        ("centrifuge_design", "count = [1, 2, 3]", "count = [2]"),
        (
            "deep_chamber_design",
            'duration = "16 s"\nshort = "5 s"\nlast = "1 s"\nfillings = 3',
            "duration = 0.05\nfillings = 1",
        ),
        ("deep_chamber_design", "balls = [5, 8, 12, 20, 30, 50]", "balls = [3]"),
        ("oil_study", "members = 400", "members = 20"),
    ):
        text = (place / f"{name}.toml").read_text(encoding="utf-8")
        assert many in text
        (place / f"{name}.toml").write_text(text.replace(many, few), encoding="utf-8")
    small = {
        "machine": ab.example("deep_chamber"),
        "candidates": {"balls": [3]},
        "runs": {"duration": 0.05, "fillings": 1},
    }
    ab.save_run(ab.design(small), place / "small_design.nc")
    ab.save_run(run := ab.simulate(ab.example("stall_and_release"), duration=0.2), place / "stall.nc")
    sensors = [ab.measure.Sensor("displacement", direction=way, noise="40 dB") for way in ("x", "y")]
    ab.save_run(ab.measure.record(run, sensors, "2 kHz"), place / "logger.nc")
    ab.chamber.archived_run(
        ab.chamber.Archive(place / "runs"), "one", ab.example("deep_chamber"), duration=0.02, last=0.01
    )
    return place


def test_every_command_is_among_those_whose_width_is_tried() -> None:
    assert {
        path for line in (*WIDE, *WIDE_AND_SLOW) for path in COMMANDS if tuple(line.split())[: len(path)] == path
    } == {*COMMANDS} - {("app",)}  # it serves until Ctrl-C, see the tests in a browser


class Whole:
    """What a command has to tell, before lines are broken: collected while it answers."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.texts: list[str] = []
        wide = rich.console.Console(width=400, file=io.StringIO(), markup=False, emoji=False)
        for place, name in ((typer, "echo"), (typer, "secho"), (textwrap, "wrap")):
            monkeypatch.setattr(place, name, self.heard(getattr(place, name)))
        table, show = sheet._table, Console.print

        def tabled(block: Any) -> Any:
            for column, _ in block:
                self.told(column.head, column.unit, *column.cells())
            made = table(block)
            made.is_told = True
            return made

        def shown(console: Any, *things: Any, **how: Any) -> None:
            for thing in things:
                if not hasattr(thing, "is_told"):
                    with wide.capture() as captured:
                        wide.print(console.render_str(thing) if isinstance(thing, str) else thing)
                    self.told(captured.get())
            show(console, *things, **how)

        monkeypatch.setattr(sheet, "_table", tabled)
        monkeypatch.setattr(Console, "print", shown)

    def heard(self, function: Callable[..., Any]) -> Callable[..., Any]:
        return lambda text="", *size, **how: self.told(text) or function(text, *size, **how)

    def told(self, *texts: object) -> None:
        self.texts += map(str, texts)

    def numbers(self) -> set[str]:
        return numbers_of("\n".join(self.texts))


def numbers_of(text: str) -> set[str]:
    return set(re.findall(r"[^\s─]*\d[^\s─]*", text))


@pytest.mark.parametrize("line", [*WIDE, *(pytest.param(line, marks=pytest.mark.slow) for line in WIDE_AND_SLOW)])
def test_an_answer_fits_80_columns_and_breaks_no_number(
    line: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    whole = Whole(monkeypatch)
    given = json_as_well(monkeypatch)
    narrow = say(*shlex.split(line), columns=80)
    fits_its_schema(line, *given[0])
    assert max(map(len, narrow.splitlines())) <= 80
    assert "…" not in narrow
    assert numbers_of(narrow) == whole.numbers(), "a number of the answer is broken"


def json_as_well(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Any, Any]]:
    """What a command would print with --json, and the answer that this is of, beside what it prints."""
    found: list[tuple[Any, Any]] = []
    answered = shell.answered

    def heard(reply: Any, files: Any, unit: str, about: Any, **forms: Any) -> None:
        found.append((shell.json_of(reply, about), reply.answer))
        answered(reply, files, unit, about, **forms)

    monkeypatch.setattr(shell, "answered", heard)
    return found


def fits_its_schema(line: str, plain: Any, answer: Any) -> None:
    """The schema of the command knows every key, type and unit of its answer, and a validator agrees."""
    name = " ".join(next(path for path in COMMANDS if tuple(line.split())[: len(path)] == path))
    known, new = answer_schemas.shipped(), answer_schemas.schema_of(plain, answer)
    if answer_schemas.WRITES:
        known.pop("number", None)
        answer_schemas.write(known | {name: answer_schemas.merged(known.get(name, {}), new)})
        return
    assert answer_schemas.merged(known[name], new) == known[name], "see tests/references/answer_schemas.py"
    short = json.loads(json.dumps(first_of(plain_json(plain))), parse_constant=pytest.fail)
    jsonschema.Draft202012Validator(answer_schema(name)).validate(short)


def first_of(plain: Any) -> Any:
    """The same with no more than three entries of each list, which are alike."""
    if isinstance(plain, dict):
        return {name: first_of(value) for name, value in plain.items()}
    return [first_of(one) for one in plain[:3]] if isinstance(plain, list) else plain


def test_a_rounded_angle_is_below_a_turn_and_a_rounded_zero_has_no_sign() -> None:
    assert Column("angle", [359.96, -0.04, 359.94, 720.0], "deg", ".1f").cells() == ["0.0", "0.0", "359.9", "720.0"]
    assert Column("share", [-1e-9, 360.0, -0.2], "%", ".0f").cells() == ["0", "360", "0"]


def test_columns_without_room_follow_below_with_the_first_one_again(capsys: pytest.CaptureFixture[str]) -> None:
    columns = [
        Column("run", ["deep-n3", "deep-n20"]),
        *(Column(f"measure {i}", [1.2345e-6, None], "um") for i in range(9)),
    ]
    print_sheet(columns, "runs")
    text = capsys.readouterr().out
    assert text.count("deep-n20") >= 2
    assert text.count("1.2345e-06") == 9
    rows = list(csv.reader(io.StringIO(sheet_csv(columns))))
    assert rows[0][:2] == ["run", "measure 0 [um]"]
    assert rows[2] == ["deep-n20", *[""] * 9]


def test_values_of_a_table_in_json_are_si_and_a_deviation_says_of_what() -> None:
    sure = Column("+-", [0.2])
    columns = [Column("peak", [1.5], "µm"), sure, Column("speed", [600.0], "rpm"), sure, Column("room", [20.0], "°C")]
    assert sheet_si(columns) == {
        "peak": pytest.approx([1.5e-6]),
        "peak, +-": pytest.approx([2e-7]),
        "speed": pytest.approx([20.0 * np.pi]),
        "speed, +-": pytest.approx([0.2 * np.pi / 30.0]),
        "room": [293.15],
    }


def test_json_is_json_where_numbers_are_not_known(tmp_path: Path) -> None:
    assert plain_json({"a": [float("nan"), np.float64("inf"), np.int64(3)], "b": Path("x")}) == {
        "a": [None, "Infinity", 3],
        "b": "x",
    }
    ran = ("simulate", str(ROOT / "examples/machines/stall_and_release.toml"), "--duration", "0.02 s")
    text = say(*ran, "--out", str(tmp_path / "r.nc"), "--json")
    found = json.loads(text, parse_constant=pytest.fail)
    assert None in np.atleast_1d(found["measures"]["break_away_speed"]), "no ball was released within 0.02 s"


def test_a_file_is_what_its_name_says(tmp_path: Path) -> None:
    over = ("borders", DISCOIDAL, "--only", "release speed", "--over", "viscosity=10:40 mm^2/s:4:log")
    files = [tmp_path / "new" / f"b{suffix}" for suffix in (".nc", ".csv", ".json")]
    told = say(*over, *(word for path in files for word in ("--out", str(path))), columns=300)
    assert f"new folder: {tmp_path / 'new'}" in told
    kept = ab.load_run(files[0])
    rows = list(csv.reader(io.StringIO(files[1].read_text())))
    assert rows[0][:2] == ["viscosity [m^2/s]", "release_speed [rad/s]"]
    table = np.array([[float(row[0]), float(row[1])] for row in rows[1:]])
    assert table[:, 1].tolist() == kept["release_speed"].values.tolist()
    whole = json.loads(files[2].read_text())
    assert whole["variables"]["release_speed"]["values"] == kept["release_speed"].values.tolist()
    assert whole["variables"]["release_speed"]["units"] == "rad/s"
    told = " ".join(say(*over, "--out", str(tmp_path / "b.dat"), code=2).split())
    assert "end it with .nc, .csv or .json" in told
    assert not (tmp_path / "b.dat").exists()
    with pytest.raises(ResultError, match=r"written as \.nc, \.csv or \.json"):
        ab.save_run(kept, tmp_path / "b.dat")


def test_a_table_of_two_parameters_has_a_row_for_each_pair(tmp_path: Path) -> None:
    grid = ("--x", "speed=50:130 rad/s:3", "--y", "viscosity=1:20 mm^2/s:2")
    rows = list(csv.DictReader(io.StringIO(say("map", DISCOIDAL, *grid, "--csv"))))
    assert len(rows) == 6
    answer = json.loads(say("map", DISCOIDAL, *grid, "--json"))
    rates = np.array(answer["growth_rate"])
    found = {(float(row["speed [rad/s]"]), float(row["viscosity [m^2/s]"])): row for row in rows}
    assert len(found) == 6
    assert float(found[(130.0, 2e-5)]["growth_rate [1/s]"]) in rates


def test_csv_prints_the_units_that_were_asked_for() -> None:
    stability = ("eigenvalues", DISCOIDAL, "--speeds", "60:70 rad/s:5", "--csv")
    rows = list(csv.DictReader(io.StringIO(say(*stability, "--speed-unit", "rad/s"))))
    assert float(rows[0]["from [rad/s]"]) == 60.0
    hertz = list(csv.DictReader(io.StringIO(say(*stability, "--speed-unit", "hz"))))
    assert float(hertz[0]["from [Hz]"]) == pytest.approx(60.0 / (2.0 * np.pi))
    assert "choose one of them" in " ".join(say(*stability, "--json", code=2).split())


def test_the_change_of_the_verdict_is_located_between_the_speeds() -> None:
    machine = ab.load_machine(DISCOIDAL)
    coarse = eigenvalues(machine, [50.0, 62.0, 71.0, 100.0])
    found = ranges(machine, coarse)
    assert found["verdict"].values.tolist() == ["unstable", "stable"]
    border = {entry.name: entry.speed for entry in ab.stability.borders(machine)}["exact border"]
    assert float(found["to_speed"][0]) == float(found["from_speed"][1]) == pytest.approx(border, rel=3e-7)


def test_only_undamped_speeds_are_called_critical() -> None:
    shapes, diagram = say("modes", RIGID), say("campbell", RIGID, "--speeds", "0:6000 rpm:31")
    found = [text[text.index("critical speeds, without damping") :].split() for text in (shapes, diagram)]
    assert found[0] == found[1][: len(found[0])]
    assert "4 branches from 0 rpm to 6000 rpm" in diagram


def test_the_planar_stand_in_is_the_one_that_holds() -> None:
    assert ab.rotor.equivalent_planar(RIGID).data.attrs["chosen"] == "modal"
    assert "does not hold anywhere" in say("equivalent-planar", RIGID, "--method", "static")


def test_a_result_given_for_a_machine_is_recognized(tmp_path: Path) -> None:
    xr.Dataset({"a": 1.0}).to_netcdf(tmp_path / "cf.nc")
    told = " ".join(say("check", str(tmp_path / "cf.nc"), code=2).split())
    assert "is a result, not a machine file" in told
    (tmp_path / "meas.csv").write_text("speed [rpm], amplitude [mm]\n1, 2\n")
    told = " ".join(say("identify", DISCOIDAL, "--measurements", str(tmp_path / "meas.csv"), code=2).split())
    assert "[[responses]]" in told


def test_a_run_with_random_starts_says_its_seed(tmp_path: Path) -> None:
    text = (ROOT / "examples/machines/stall_and_release.toml").read_text()
    (tmp_path / "m.toml").write_text(re.sub(r"start_angles = \[[^]]*\],? ?", "", text).replace(", }", " }"))
    told = say(
        "simulate", str(tmp_path / "m.toml"), "--duration", "0.02 s", "--seed", "7", "--out", str(tmp_path / "r.nc")
    )
    assert "seed 7" in told


def test_a_pipe_gets_no_stray_lines_and_the_version_is_known(tmp_path: Path) -> None:
    words = ("eigenvalues", DISCOIDAL, "--speeds", "60:70 rad/s:5")
    ran = subprocess.run([sys.executable, "-m", "autobalancer", *words], capture_output=True, text=True, check=True)
    # but a word of how far it has come, on a machine so slow that it takes more than five seconds
    assert not [line for line in ran.stderr.splitlines() if not re.fullmatch(r".+: .+ after \d+ s", line)]
    assert re.fullmatch(r"autobalancer \d+\.\d+.*\n", say("--version"))
    assert "--install-completion" in say("--help")


def test_a_temperature_is_shown_as_it_is_asked_for() -> None:
    over = ("borders", DISCOIDAL, "--only", "release speed", "--over", "temperature=10 degC:40 degC:3", "--csv")
    rows = list(csv.reader(io.StringIO(say(*over))))
    assert "[°C]" in rows[0][0]
    assert [float(row[0]) for row in rows[1:]] == pytest.approx([10.0, 25.0, 40.0])


def test_speeds_in_sentences_have_the_unit_of_the_command() -> None:
    before = words.speed_sign()
    try:
        words.use_speed_unit("rpm")
        said = "stable also 10 to 20 rad/s; the drive rises by 0.5 rad/s^2; at 62.83 and 3.1416e1 rad/s"
        assert (
            words.in_speed_unit(said)
            == "stable also 95.49 to 191 rpm; the drive rises by 0.5 rad/s^2; at 600 and 300 rpm"
        )
        words.use_speed_unit("rad/s")
        assert words.in_speed_unit(said) == said
    finally:
        words.use_speed_unit(before)


def test_eigenvalues_reach_the_highest_speed_of_the_drive_by_default() -> None:
    found = ab.check(ROOT / "examples" / "machines" / "two_plane_rotor.toml")
    assert found.highest_speed is not None
    assert found.highest_speed > 3.0 * max(w for w in found.critical_speeds if w <= found.highest_speed)
    chosen = usual(ab.load_machine(ROOT / "examples" / "machines" / "two_plane_rotor.toml"))
    assert chosen[-1] == pytest.approx(found.highest_speed, rel=1e-12)
    assert chosen[0] == pytest.approx(0.5 * min(found.critical_speeds), rel=1e-12)


def test_an_option_that_is_taken_has_the_default_and_the_words_of_the_function() -> None:
    """Read off the source; a quantity is shown as one writes it."""
    function = public("stepped_response")
    assert function.defaults["direction"] == "up"
    assert function.meanings["window"] == "Length of the measurement, s."
    options = {option: one for one in COMMANDS[("stepped-response",)].params for option in one.opts}
    assert options["--direction"].default == "up"
    assert options["--window"].help == 'Length of the measurement. Such as "10 s".'
    assert options["--window"].required
    assert not options["--acceleration"].required


def test_the_six_first_commands_stand_first_and_each_belongs_to_a_topic() -> None:
    text = say("--help")
    panels = re.findall(r"\u256d\u2500 (.+?) \u2500", text)
    assert panels[:2] == ["Options", "First"]
    assert len(places()["First"]) == 6
    groups = [name for inner in Commands.topics.values() for name in inner]
    assert set(places()) == {topic for topic in Commands.topics if topic != "Deep chambers"} | set(groups)
    listed = [*groups, *(name for topic, names in places().items() if topic not in groups for name in names)]
    assert len(listed) == len(set(listed))
    assert set(listed) == {path[0] for path in COMMANDS}


@pytest.mark.parametrize("path", COMMANDS, ids=" ".join)
def test_a_help_breaks_its_lines_at_the_edge_of_the_screen_only(path: tuple[str, ...]) -> None:
    """A line ends early only at the end of a paragraph, however wide the screen."""
    text = say(*path, "--help", columns=400)
    told = text[: text.index("Example:")].split("Usage:")[1]
    blocks = re.split(r"\n\s*\n", told)[1:]
    assert all("\n" not in block.strip() for block in blocks)


def test_no_description_of_a_sample_is_cut() -> None:
    assert "..." not in say("example")


def test_a_unit_in_brackets_is_shown_in_the_help() -> None:
    from rich.text import Text

    for words_, command in COMMANDS.items():
        for param in command.params:
            text = getattr(param, "help", None) or ""
            assert Text.from_markup(text).plain == text.replace("\\[", "["), words_


KINDS_OF_SAMPLES = {
    "oil_study.toml": ("study", "study {}"),
    "centrifuge_design.toml": ("design specification", "design {}"),
    "measured_rotor_design.toml": ("design specification", "design {}"),
    "deep_chamber_design.toml": ("design specification of a deep chamber", "design {}"),
    "two_plane_job.toml": ("balancing job", "measure balance {}"),
    "rodrigues_plain_rotor.toml": ("measurement file", "identify MACHINE {}"),
}


@pytest.mark.parametrize("name", KINDS_OF_SAMPLES)
def test_a_file_of_another_kind_is_checked_as_such_and_refused_by_name_where_a_machine_is_wanted(
    tmp_path, name
) -> None:
    for sample in {name, "discoidal.toml", "thin_oil.toml"}:
        write_example(Path(sample).stem, tmp_path)
    path, (noun, question) = tmp_path / name, KINDS_OF_SAMPLES[name]
    result = CliRunner().invoke(app, ["check", str(path)], env={"COLUMNS": "400"})
    assert result.exit_code == 0, result.output
    assert f"a {noun} without faults; 'autobalancer {question.format(path)}' answers it" in result.output
    with pytest.raises(
        MachineFileError, match=f"is a {noun}, not a machine file; 'autobalancer {question.format(path)}'"
    ):
        ab.load_machine(path)
    machine = tmp_path / "discoidal.toml"
    for read in (ab.study, ab.design, ab.measure.balance):
        with pytest.raises(QuestionError, match=r"discoidal\.toml: is a machine file; wanted is a file with"):
            read(machine)


def test_a_check_lists_the_faults_of_a_job_as_those_of_a_job(tmp_path) -> None:
    job = tmp_path / "job.toml"
    job.write_text('deviation = "1 %"\n[[runs]]\nnmae = "original"\n')
    result = CliRunner().invoke(app, ["check", str(job)], env={"COLUMNS": "400"})
    assert result.exit_code == 2
    assert "runs[1].nmae: unknown key; did you mean 'name'" in result.stderr
    assert "rotor" not in result.stderr


def test_files_written_beside_a_schema_name_it_to_editors(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    say("example", "discoidal")
    plain = (tmp_path / "discoidal.toml").read_text(encoding="utf-8")
    assert not plain.startswith("#:schema")
    say("keys", "--out", "races.schema.json")
    say("keys", "--kind", "study", "--out", "study.schema.json")
    say("example", "discoidal", "thin_oil", "oil_study", "deep_chamber")
    heads = {path.stem: path.read_text(encoding="utf-8").splitlines()[0] for path in tmp_path.glob("*.toml")}
    assert heads["thin_oil"] == "#:schema ./races.schema.json"
    assert heads["oil_study"] == "#:schema ./study.schema.json"
    assert not heads["deep_chamber"].startswith("#:schema"), "its schema is not there"
    assert (tmp_path / "discoidal.toml").read_text(encoding="utf-8") == plain, "what is there is left as it is"
    say("example", "thin_oil")
    saved = ab.save_machine(ab.load_machine("thin_oil.toml"), "again.toml").read_text(encoding="utf-8")
    assert saved.startswith("#:schema ./races.schema.json\n")
    assert ab.load_machine("again.toml") == ab.load_machine("thin_oil.toml")


def test_the_schema_of_an_answer_is_given_by_the_name_of_its_command(tmp_path: Path) -> None:
    schema = json.loads(say("keys", "modes", "--kind", "answers"))
    assert schema["properties"]["frequency"]["unit"] == "rad/s"
    say("keys", "--kind", "answers", "--out", str(tmp_path / "answers.json"))
    whole = json.loads((tmp_path / "answers.json").read_text(encoding="utf-8"))
    assert {" ".join(path) for path in COMMANDS} - {"app"} == set(whole["$defs"]) - {"number"}
    assert "has no schema of its answer" in " ".join(say("keys", "soup", "--kind", "answers", code=2).split())
    wrong = json.loads(say("modes", RIGID, "--speed", "0 rpm", "--json")) | {"frequency": "fast"}
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(wrong, answer_schema("modes"))
