"""Pages and examples show what a user can write: the public names, and nothing from within the package."""

from __future__ import annotations

import ast
import pickle
import pydoc
import re
import subprocess
import sys
import textwrap
from collections.abc import Callable
from inspect import isfunction, unwrap
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer

import autobalancer as ab
from autobalancer.api import SimulateOptions
from autobalancer.cli import app
from autobalancer.errors import AutobalancerError, QuestionError, UnitError
from autobalancer.machine_kinds import arguments_of
from autobalancer.measurement.loop import balls_of
from autobalancer.plots.animation import race_scene
from autobalancer.plots.chamber_view import chamber_scene
from autobalancer.plots.film_frames import FilmOptions, film_question
from autobalancer.public_names import ABOUT, FIGURES, NAMES, function_of
from autobalancer.simulation.chamber.chamber_run import simulate_chamber
from autobalancer.simulation.run import simulate_races

ROOT = Path(__file__).resolve().parent.parent
FENCE = re.compile(r"^( *)```(?:python|ipython|py)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
PUBLIC_MODULES = {"machine", "errors", "units", "plot.style", *ABOUT}
PAGES = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "CONVENTIONS.md"]
INSIDE = {"plot_sheared_drag.py"}  # solves equations of its own on the meshes of the package
SCRIPTS = sorted(path for path in (ROOT / "examples").glob("**/*.py") if path.name not in INSIDE)


def snippets(path: Path) -> list[str]:
    text = path.read_text(encoding="utf-8")
    return [text] if path.suffix == ".py" else [textwrap.dedent(code) for _, code in FENCE.findall(text)]


def not_public(code: str) -> list[str]:
    """What a piece of code takes from the package that is not public."""
    found = []
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "autobalancer":
            inner = ".".join((node.module or "").split(".")[1:])
            home = ab if not inner else getattr(ab, inner) if inner in PUBLIC_MODULES else None
            found += [f"{node.module}.{a.name}" for a in node.names if a.name not in dir(home)]
        elif isinstance(node, ast.Import):
            found += [a.name for a in node.names if a.name.startswith("autobalancer.")]
        elif isinstance(node, ast.Attribute) and re.fullmatch(r"ab(\.\w+)+", path := ast.unparse(node)):
            _, first, *rest = path.split(".")
            listed = first in dir(ab) and (first not in ABOUT or not rest or rest[0] in dir(getattr(ab, first)))
            found += [] if listed else [path]
    return found


@pytest.mark.parametrize("path", [*PAGES, *SCRIPTS], ids=lambda path: path.relative_to(ROOT).as_posix())
def test_pages_and_examples_use_public_names_only(path: Path) -> None:
    assert [name for code in snippets(path) for name in not_public(code)] == []


def test_a_deep_import_in_a_page_is_found() -> None:
    deep = "import autobalancer.stability\nfrom autobalancer.laws.stall import stall_balance\nab.plot.modus(1)\n"
    assert not_public(deep) == ["autobalancer.stability", "autobalancer.laws.stall.stall_balance", "ab.plot.modus"]
    assert (
        not_public("from autobalancer.machine import Race\nfrom autobalancer import simulate\nab.stability.map(1)")
        == []
    )
    assert sum(len(snippets(page)) for page in PAGES) > 40


def commands(group: typer.core.TyperGroup) -> list[str]:
    """Names of the commands that do something, those of a group with its name before them."""
    inner = ((name, getattr(command, "commands", None), command) for name, command in group.commands.items())
    return [full for name, more, one in inner for full in ([f"{name} {x}" for x in commands(one)] if more else [name])]


def test_a_command_and_its_function_have_one_name() -> None:
    for command in commands(typer.main.get_command(app)):  # type: ignore[arg-type]
        path = function_of(command)
        if command in ("app", "recipe", "cite"):  # a page, and texts to read: not what one function does
            continue
        space, _, name = path.rpartition(".")
        assert path == "plot" or name in NAMES[space], command
        assert command in FIGURES or name.lower().endswith(command.split()[-1].replace("-", "_")), command


def test_the_commands_that_make_and_the_benchmarks_call_are_there() -> None:
    known = {command.split()[0] for command in commands(typer.main.get_command(app))}  # type: ignore[arg-type]
    made = re.findall(r"/autobalancer ([a-z-]+)", (ROOT / "Makefile").read_text(encoding="utf-8"))
    timed = re.findall(
        r'"-m", "autobalancer", "([a-z-]+)"', (ROOT / "benchmarks" / "start.py").read_text(encoding="utf-8")
    )
    assert {"check", "simulate", "plot", "animate"} <= set(made)
    assert timed
    assert {*made, *timed} <= known


def test_every_public_name_can_be_imported_and_is_documented() -> None:
    for space, names in NAMES.items():
        home = getattr(ab, space) if space else ab
        for name in names:
            value = getattr(home, name)
            assert len(value.__doc__ or "") > 20, f"{space}.{name}"
            assert name in dir(home)


def test_help_of_the_package_names_every_namespace() -> None:
    assert re.findall(r"- ``ab\.(\w+)``: ", ab.__doc__ or "") == sorted(ABOUT, key=(ab.__doc__ or "").index)
    for space in ABOUT:
        found: dict[str, Any] = {}
        exec(f"from autobalancer.{space} import *", found)
        assert {name for name in found if name != "__builtins__"} == set(dir(getattr(ab, space))), space


def test_a_namespace_has_no_module_with_the_name_of_a_function() -> None:
    for space in ABOUT:
        home = Path(getattr(ab, space).__file__).parent
        modules = {path.stem for path in (*home.glob("*.py"), *(init.parent for init in home.glob("*/__init__.py")))}
        package = Path(getattr(ab, space).__file__).name == "__init__.py"
        assert not package or not modules & set(NAMES[space]), space


def test_the_stubs_are_those_of_the_table() -> None:
    subprocess.run([sys.executable, "-m", "tools.write_stubs", "--check"], cwd=ROOT, check=True)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("modes", "there is ab.plot.modes and ab.rotor.modes"),
        ("borders", "there is ab.plot.borders and ab.stability.borders"),
        ("xyzzy", "no attribute 'xyzzy'"),
        ("simulat", r"did you mean ab.simulate\?"),
        ("plot.runup", r"did you mean ab.plot.run_up\?"),
        ("stability.sweep", "there is ab.sweep"),
    ],
)
def test_a_name_that_is_looked_for_elsewhere_or_misspelled_is_found(name: str, said: str) -> None:
    with pytest.raises(AttributeError, match=f"{said}$"):
        attrgetter(name)(ab)


def test_the_options_of_either_kind_are_those_of_the_functions_behind() -> None:
    own = {"machine", "run", "film", "path", "duration", "seed", "progress", "keep_on_interrupt"}
    for listed, *functions in (
        (SimulateOptions, simulate_races, simulate_chamber),
        (FilmOptions, film_question, race_scene, chamber_scene),
    ):
        behind = {name for function in functions for name in arguments_of(function)}
        assert behind - own == set(listed.__annotations__) - own


def test_functions_refuse_what_belongs_to_the_other_kind_of_machine() -> None:
    with pytest.raises(QuestionError, match="simulate: no argument 'tolerance' for deep chambers; there are duration"):
        ab.simulate(ab.example("single_layer"), tolerance=1e-6)
    with pytest.raises(QuestionError, match="simulate: no argument 'settle' for balls in races; there are duration"):
        ab.simulate(ab.example("discoidal"), settle=False)


def test_a_function_is_known_by_its_public_name_in_help_and_in_tracebacks() -> None:
    for space, names in NAMES.items():
        home = getattr(ab, space) if space else ab
        for name in names:
            value = getattr(home, name)
            assert getattr(value, "__name__", name) == name, f"{space}.{name}"
            if isfunction(inner := unwrap(value)):
                assert inner.__code__.co_qualname == name, f"{space}.{name} in a traceback"
            assert pickle.loads(pickle.dumps(value)) is value, f"{space}.{name}"
    with pytest.raises(TypeError, match=r"^stepped_response\(\) missing 2 required keyword-only arguments"):
        ab.stepped_response(ab.example("discoidal"), speeds=[100.0])
    assert pydoc.plaintext.document(ab.stability.map).startswith("map(machine: ")


@pytest.mark.parametrize(
    "asked",
    [
        ab.stability.borders,
        ab.stability.averaged_border,
        ab.rotor.modes,
        lambda machine: ab.sweep(machine, {"rotor.mass": [1.0, 2.0]}),
        lambda machine: ab.stepped_response(machine, [100.0], dwell=1.0, window=0.5),
        balls_of,
    ],
)
def test_a_question_of_races_says_what_it_wants_and_what_deep_chambers_have(asked: Callable[[Any], Any]) -> None:
    with pytest.raises(
        AutobalancerError, match=r"machine: its balls move freely in chambers.*races.*simulate.*amplitudes"
    ):
        asked(ab.example("deep_chamber"))
    with pytest.raises(AutobalancerError, match=r"deep_chamber\.toml: its balls move freely in chambers.*races"):
        asked(ab.catalog.example_path("deep_chamber"))
    with pytest.raises(
        QuestionError, match=r"machine: given a dict; wanted is a machine, as of load_machine or example"
    ):
        asked({"mass": 1.0})


def test_a_parameter_has_its_plain_name_everywhere_and_one_value_needs_no_list() -> None:
    machine = ab.example("discoidal")
    assert ab.with_parameter(machine, "viscosity", "10 mm^2/s").balancers[0].races[0].fluid.viscosity == pytest.approx(
        1e-5
    )
    assert ab.with_parameter(machine, "axis", "vertical").axis == "vertical"
    said = r"did you mean 'viscosity'\?"
    for asked in (lambda name: ab.with_parameter(machine, name, 1e-5), lambda name: ab.sweep(machine, {name: [1e-5]})):
        with pytest.raises(QuestionError, match=said):
            asked("viscosty")
    assert ab.sweep(machine, {"viscosity": "10 mm^2/s"}, duration=0.01, progress=False)["viscosity"].size == 1


def test_a_range_is_one_text_in_python_as_on_the_command_line() -> None:
    machine, rpm = ab.example("discoidal"), np.pi / 30.0
    speeds = ab.stability.eigenvalues(machine, "600:1200 rpm:3")["speed"].values
    assert speeds == pytest.approx(np.array([600.0, 900.0, 1200.0]) * rpm)
    assert ab.rotor.campbell(ab.example("rigid_rotor"), "0:600 rpm:3")["speed"].values[-1] == pytest.approx(600.0 * rpm)
    swept = ab.sweep(machine, {"viscosity": "1:100 mm^2/s:3:log"}, duration=0.01, progress=False)
    assert swept["viscosity"].values == pytest.approx([1e-6, 1e-5, 1e-4])
    found = ab.stability.map(machine, {"speed": "600:1200 rpm:3", "count": "2:4:3"}, borders=0)
    assert list(found["count"].values) == [2, 3, 4]
    curve = ab.stability.border_curve(machine, "rotor.damping", "50:90 N*s/m:2", only=["averaged border"])
    assert list(curve["rotor_damping"].values) == [50.0, 90.0]
    one, two = (
        ab.stability.branches(machine, "speed", *ends, orbits=False) for ends in (["80:84 rad/s"], [80.0, 84.0])
    )
    assert one.drop_attrs().equals(two.drop_attrs())
    for text, reason in (("600 rpm:1200 rpm", "without the number of values"), ("600:1200:3", "without a unit")):
        with pytest.raises((QuestionError, UnitError), match=f"speeds.*{reason}"):
            ab.stability.eigenvalues(machine, text)
    with pytest.raises(QuestionError, match=r"speed: given '80 rad/s' only; give the other end too, or both as"):
        ab.stability.branches(machine, "speed", "80 rad/s")


def test_the_keys_of_a_machine_file_print_themselves() -> None:
    shown = str(ab.keys("rotor"))
    assert "Key(" not in shown
    assert "[rotor]" in shown
    assert "stiffness" in shown
    assert "$" not in shown
    assert max(map(len, shown.splitlines())) <= 100


def test_a_question_of_deep_chambers_says_what_it_wants() -> None:
    with pytest.raises(QuestionError, match=r"its balls run in races, and this question is for deep chambers.*sweep"):
        ab.chamber.amplitudes(ab.example("discoidal"), [2], [0.5], duration=0.1)
    with pytest.raises(QuestionError, match="machine: given 5; wanted is a machine"):
        ab.check(5)
