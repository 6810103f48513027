"""Pages and examples show what a user can write: the public names, and nothing from within the package."""

from __future__ import annotations

import ast
import re
import textwrap
from pathlib import Path

import pytest
import typer

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.public_names import COMMANDS

ROOT = Path(__file__).resolve().parent.parent
FENCE = re.compile(r"^( *)```(?:python|ipython|py)\n(.*?)^ *```", re.MULTILINE | re.DOTALL)
PUBLIC_MODULES = {"machine", "errors", "units"}
PAGES = [*sorted((ROOT / "docs").glob("*.md")), ROOT / "README.md", ROOT / "CONVENTIONS.md"]
SCRIPTS = sorted((ROOT / "examples").glob("**/*.py"))


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
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == "ab":
            found += [f"ab.{node.attr}"] if node.attr not in dir(ab) else []
    return found


@pytest.mark.parametrize("path", [*PAGES, *SCRIPTS], ids=lambda path: path.relative_to(ROOT).as_posix())
def test_pages_and_examples_use_public_names_only(path: Path) -> None:
    assert [name for code in snippets(path) for name in not_public(code)] == []


def test_a_deep_import_in_a_page_is_found() -> None:
    deep = "import autobalancer.stability\nfrom autobalancer.laws.stall import stall_balance\nab.modus(1)\n"
    assert not_public(deep) == ["autobalancer.stability", "autobalancer.laws.stall.stall_balance", "ab.modus"]
    assert not_public("from autobalancer.machine import Race\nfrom autobalancer import simulate\nab.summary(1)") == []
    assert sum(len(snippets(page)) for page in PAGES) > 40


def commands(group: typer.core.TyperGroup) -> list[str]:
    """Names of the commands that do something, those of a group with its name before them."""
    inner = ((name, getattr(command, "commands", None), command) for name, command in group.commands.items())
    return [full for name, more, one in inner for full in ([f"{name} {x}" for x in commands(one)] if more else [name])]


def test_every_command_says_which_functions_do_the_same() -> None:
    assert sorted(COMMANDS) == sorted(commands(typer.main.get_command(app)))  # type: ignore[arg-type]
    assert {name for functions in COMMANDS.values() for name in functions} <= set(ab.__all__)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("modes", "the command `modes` is ab.eigenfrequencies, ab.campbell and ab.critical_speeds in Python"),
        ("check", "the command `check` is ab.summary and ab.chamber_summary in Python"),
        ("friction", "the command `catalog friction` is ab.friction_coefficients in Python"),
        ("step_size", "the command `study step-size` is ab.step_size_study in Python"),
    ],
)
def test_a_command_that_is_asked_for_as_a_function_names_the_function(name: str, said: str) -> None:
    with pytest.raises(AttributeError, match=f"no attribute '{name}'; {said}$"):
        getattr(ab, name)
    with pytest.raises(AttributeError, match=r"no attribute 'mode'$"):
        ab.__getattr__("mode")
