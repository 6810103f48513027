"""Pages and examples show what a user can write: the public names, and nothing from within the package."""

from __future__ import annotations

import ast
import re
import textwrap
from pathlib import Path

import pytest

import autobalancer as ab

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
