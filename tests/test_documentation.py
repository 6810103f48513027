"""What the pages tell people to write: machine files, and the single entries of them that the text shows."""

from __future__ import annotations

import copy
import re
import sys
import tomllib
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import tomli_w

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.system import assemble
from autobalancer.assembly.terms import bibliography, methods, named_in, printed, sources
from autobalancer.assembly.terms import plain_letters as _plain
from autobalancer.files.examples import example, example_text
from autobalancer.files.machine_file import load_machine, load_race_machine, machine_text, parse_machine
from autobalancer.machine import Machine
from autobalancer.machine import plugins as leaves
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.plots.answer import made_by
from autobalancer.public_names import NAMES
from autobalancer.simulation import Method
from autobalancer.simulation.chamber.chamber_summary import chamber_summary

ROOT = Path(__file__).resolve().parent.parent
MEANT_WRONG = {"wrong", "misfit"}
WRITTEN = [path for path in sorted((ROOT / "docs" / "machines").glob("*.toml")) if path.stem not in MEANT_WRONG]
FILES = [path for path in WRITTEN if isinstance(load_machine(path), Machine)]
FENCE = re.compile(r"^```toml\n(.*?)^```", re.MULTILINE | re.DOTALL)
OWN = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
HOMES = {
    "drive": ("drive",),
    "profile": ("drive", "profile"),
    "excitations": ("excitations",),
    "balls": ("balancers", 0, "races", 0, "balls"),
} | {
    key: ("balancers", 0, "races", 0, key)
    for key in (
        "drag",
        "fluid",
        "friction",
        "contact",
        "slipstream",
        "collisions",
        "partitions",
        "harmonics",
        "roundness",
        "resolved",
    )
}
WHOLE: dict[str, Any] = {
    "name": "base",
    "axis": "vertical",
    "rotor": {"mass": 10.0, "stiffness": 6e5, "damping": 100.0, "inertia": 0.1},
    "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
    "balancers": [
        {
            "races": [
                {
                    "race_radius": 0.1,
                    "width": 0.02,
                    "height": 0.02,
                    "fluid": {"density": 955.0, "viscosity": 2e-5},
                    "drag": {"law": "cd_times_re", "cd_times_re": 387.0},
                    "balls": [{"diameter": 0.012, "density": 7800.0}],
                }
            ]
        }
    ],
}


@pytest.fixture
def own_leaves(monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    """Runs what a page shows as a law of one's own, which is forgotten again after the test."""
    monkeypatch.setattr(leaves, "_registered", dict(leaves._registered))

    def run(page: str) -> None:
        for code in OWN.findall((ROOT / "docs" / page).read_text(encoding="utf-8")):
            if "ab.laws.register(" in code:
                exec(compile(code, page, "exec", dont_inherit=True), {"__name__": "__main__"})

    return run


def entries(page: str) -> list[str]:
    """The lines of a page that show one entry of a machine file."""
    blocks = FENCE.findall((ROOT / "docs" / page).read_text(encoding="utf-8"))
    lines = [line for block in blocks for line in block.splitlines()]
    return [line for line in lines if " = " in line and line.split(" = ")[0] in HOMES]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_machine_of_the_pages_can_be_assembled(path: Path) -> None:
    machine = load_race_machine(path)
    assembly = assemble(machine)
    assert len(assembly.balls) == sum(race.ball_count for b in machine.balancers for race in b.races) > 0


def test_the_deep_chamber_of_the_pages_can_be_run() -> None:
    (described,) = [found for path in WRITTEN if isinstance(found := load_machine(path), ChamberMachine)]
    assert chamber_summary(described).warnings == ()
    assert parse_machine(machine_text(described)) == described


def test_every_key_says_what_it_means_and_in_which_unit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    import key_tables

    pages = key_tables.pages()
    assert "| None |" not in "".join(pages.values())
    assert "| `freedom` |" in pages["chamber_keys.md"]
    assert "| `restitution` | number, > 0, ≤ 1 |" in pages["chamber_keys.md"]
    assert "| `stiffness` | three of N/m, ≥ 0 |" in pages["chamber_keys.md"]
    assert "| `name` | text | required |" in pages["machine_keys.md"]
    monkeypatch.delitem(sys.modules, "key_tables")


@pytest.mark.parametrize("page", ["machine_files.md", "drag.md"])
def test_every_entry_that_a_page_shows_is_accepted_in_its_place(page: str, own_leaves: Callable[[str], None]) -> None:
    own_leaves(page)
    shown = entries(page)
    assert len(shown) > 5
    for line in shown:
        ((key, value),) = tomllib.loads(line).items()
        data = copy.deepcopy(WHOLE)
        place: Any = data
        for step in HOMES[key][:-1]:
            place = place[step]
        place[HOMES[key][-1]] = value
        if key == "balls" and not {"mass", "diameter"} & set(value[0] if isinstance(value, list) else value):
            place |= {"bearing": "16021"}  # whose balls they are
        if key == "balls" and "point" in line:
            place |= {"orbit_radius": place.pop("race_radius"), "drag": {"law": "viscous", "damping": 1e-4}}
        assemble(parse_machine(tomli_w.dumps(data), line))


def test_the_friction_laws_that_a_page_shows_brake_a_ball(own_leaves: Callable[[str], None]) -> None:
    own_leaves("resolved_balls.md")
    blocks = FENCE.findall((ROOT / "docs" / "resolved_balls.md").read_text(encoding="utf-8"))
    laws = [tomllib.loads(block)["friction_law"] for block in blocks if "friction_law" in block]
    assert [law["kind"] for law in laws] == ["stribeck", "oiled_wall"]
    for law in laws:
        data = copy.deepcopy(WHOLE)
        resolved = {"stiffness": 1e6, "restitution": 0.5, "sliding_friction": 0.1, "slip_speed": 0.01}
        data["balancers"][0]["races"][0]["resolved"] = resolved | {"friction_law": law}
        assert assemble(parse_machine(tomli_w.dumps(data))).resolved


def test_the_joint_of_ones_own_that_a_page_shows_holds_a_rig(own_leaves: Callable[[str], None]) -> None:
    own_leaves("multibody.md")
    blocks = FENCE.findall((ROOT / "docs" / "multibody.md").read_text(encoding="utf-8"))
    (shown,) = (tomllib.loads(block)["rotor"]["joints"][0] for block in blocks if "rubber_foot" in block)
    data = tomllib.loads(example_text("discoidal_rig"))
    data["rotor"]["joints"][-1] = shown
    model = lateral_model(parse_machine(tomli_w.dumps(data)))
    assert model.top_speed == 200.0
    more = model.stiffness_at(100.0) - model.stiffness_at(0.0)
    assert np.abs(more).max() == pytest.approx(5.0 * 48e3 * (100.0 / 300.0) ** 0.5, rel=1e-6)


def test_the_machine_file_of_the_readme_is_the_first_one_of_the_pages() -> None:
    (shown,) = FENCE.findall((ROOT / "README.md").read_text(encoding="utf-8"))
    assert shown == (ROOT / "docs" / "machines" / "first.toml").read_text(encoding="utf-8")


@pytest.mark.slow
def test_every_variable_that_is_explained_is_held_by_some_run(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    import result_tables

    with caplog.at_level("WARNING"):
        assert "| `rotor_sag` | place | m |" in result_tables.result_variables()
    assert [record.getMessage() for record in caplog.records] == []
    monkeypatch.delitem(sys.modules, "result_tables")


ENTRIES = list(bibliography().values())
NAME = r"[A-ZŠŽČ][\w'-]+"
CITED = re.compile(rf"({NAME})(?: et al\.|(?:, {NAME})* and {NAME})?,? \(((?:18|19|20)\d\d)[,)]")


def test_every_entry_of_the_bibliography_is_closed() -> None:
    assert len(ENTRIES) > 50
    assert [entry.splitlines()[0] for entry in ENTRIES if entry.count("{") != entry.count("}")] == []


def test_every_source_that_a_page_or_a_docstring_cites_is_in_the_bibliography() -> None:
    keys = set(bibliography())
    for page in sorted((ROOT / "docs").glob("*.md")):
        cited = re.findall(r"\{cite(?::\w+)?\}`([^`]+)`", page.read_text(encoding="utf-8"))
        unknown = {key.strip() for text in cited for key in text.split(",")} - keys
        assert not unknown, page.name
    entries = [_plain(entry) for entry in ENTRIES]
    for path in sorted((ROOT / "src" / "autobalancer").rglob("*.py")):
        for cited in CITED.finditer(path.read_text(encoding="utf-8")):
            name, year = _plain(cited[1]), cited[2]
            there = any(re.search(rf"\b{re.escape(name)}\b", entry) and year in entry for entry in entries)
            assert there, f"{path.name}: {cited[0]}"


def test_the_program_is_cited_with_the_version_and_year_of_its_citation_file() -> None:
    about = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    told = dict(re.findall(r'^([\w-]+): "?(.*?)"?$', about, re.MULTILINE))
    entry = bibliography()["autobalancer"]
    assert told["version"] == ab.__version__
    assert f"Version {ab.__version__}" in entry
    assert told["title"] in entry
    assert told["date-released"][:4] in entry


def test_a_machine_rests_on_the_sources_of_its_laws_its_fluid_and_its_method() -> None:
    rig = {"spannan2021", "jan1997", "mark1999", "autobalancer"}
    assert set(sources(example("discoidal"))) == rig
    run = sources(example("discoidal"), {"method": "tsitouras"})
    assert set(run) == rig | {"tsitouras2011", "lam2015", "gustafsson1991", "hairer1996"}
    assert run["tsitouras2011"] == ("Runge–Kutta pair of order 5(4)",)
    free = with_value_at(example("discoidal"), "balancers[1].races[1].drag", {"law": "free_sphere"})
    assert sources(free)["cheng2009"] == ("drag free sphere",)
    assert "cheng2009" not in rig
    assert "pakula2021" in sources(example("deep_chamber"))
    steel = sources(example("washing_machine"))
    assert ("material bearing steel 100Cr6",) in steel.values(), "a source without an entry is said in words"


def test_every_method_and_every_law_that_names_a_source_has_it_in_the_bibliography() -> None:
    results = {name for of, _ in methods().values() for name in of}
    assert results >= {*get_args(Method)} - {"auto", "verlet"}
    assert named_in("Prince and Dormand (1981), Hairer et al. (1993)") == ("prince1981", "hairer1993")
    assert named_in("ISO 2768-2, class H") == ("iso2768-2",)
    assert named_in("Nobody (1999)") == ()


def test_one_table_says_which_result_rests_on_which_source() -> None:
    public = {f"{space}.{name}".lstrip("."): home for space, names in NAMES.items() for name, home in names.items()}
    of_runs = {*get_args(Method), "runge_kutta", "verlet", "Vold-Kalman", "plot.style"}
    assert {name for results, _ in methods().values() for name in results} <= {*public, *of_runs}
    assert {key for _, keys in methods().values() for key in keys} <= set(bibliography())
    # what the docstring of a public function names is in the table, except the machine that an example is about
    lacking = {}
    for name, home in public.items():
        text = str(getattr(import_module(f"autobalancer.{home}"), name.split(".")[-1]).__doc__)
        named = set(named_in(text)) - {key for results, keys in methods().values() if name in results for key in keys}
        lacking |= {name: sorted(named)} if named else {}
    assert lacking == {}
    assert printed("iso492").endswith(
        "(2014), ISO 492: Rolling bearings. Radial bearings. Geometrical product specifications (GPS) "
        "and tolerance values"
    )
    assert printed("prince1981") == "Prince and Dormand (1981), High order embedded Runge–Kutta formulae"


def test_an_answer_is_known_by_the_function_that_made_it() -> None:
    signals = ab.measure.load_signals(ab.catalog.example_path("as_found"))
    machine = example("discoidal")
    answers = {
        "measure.load_signals": signals,
        "measure.orders": ab.measure.orders(signals, progress=False),
        "measure.balance": ab.measure.balance(ab.catalog.example_path("two_plane_job")),
        "measure.race_shape": ab.measure.race_shape(ab.catalog.example_path("race_profile")),
        "rotor.critical_speeds": ab.rotor.critical_speeds(machine),
        "stability.eigenvalues": ab.stability.eigenvalues(machine, [60.0, 70.0]),
        "stability.equilibria": ab.stability.equilibria(machine, 120.0),
    }
    assert {name: made_by(answer) for name, answer in answers.items()} == {name: name for name in answers}
    several = sources(machine, {"method": "exponential_collocation, tsitouras"})
    assert {"hochbruck2010", "tsitouras2011"} <= set(several), "of an ensemble"
    of_orders = {"measure.orders"}
    assert "vold1993" not in sources(None, answers["measure.orders"].attrs, of_orders)
    filtered = ab.measure.orders(signals, method="vold-kalman", progress=False)
    assert "vold1993" in sources(None, filtered.attrs, of_orders)


@pytest.mark.parametrize(
    ("made", "key", "use"),
    [
        ("stability.border_curve", "ryzhik2001", "release and capture speed, torque balance of stalled balls"),
        ("measure.orders", "fyfe1997", "orders in windows of the angle"),
        ("sensitivity", "saltelli2010", "Sobol' indices"),
    ],
)
def test_a_function_rests_on_the_sources_of_its_methods(made: str, key: str, use: str) -> None:
    assert use in sources(None, {}, {made})[key]
    assert key not in sources(None, {}, {"simulate"})


def test_every_public_name_has_an_example_on_its_page(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "docs" / "_ext"))
    import command_tables

    shown = {name for name, lines in command_tables.examples().items() if lines} | set(command_tables.snippets())
    code = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "examples").rglob("*.py"))
    shown |= {f"autobalancer.{name}" for name in re.findall(r"\bab\.([\w.]+)", code)}
    public = {f"autobalancer.{space}.{name}".replace("..", ".") for space, names in NAMES.items() for name in names}
    assert public - shown == set()
    monkeypatch.delitem(sys.modules, "command_tables")


def test_the_short_examples_run(capsys: pytest.CaptureFixture[str]) -> None:
    blocks = OWN.findall((ROOT / "docs" / "short_examples.md").read_text(encoding="utf-8"))
    names: dict[str, Any] = {"__name__": "__main__"}
    for block in blocks:
        if not block.startswith("# files of your own"):
            exec(compile(block, "short_examples.md", "exec", dont_inherit=True), names)
    assert capsys.readouterr().out.startswith("6.3\n")
