"""What the pages say of the house: its layers and rooms are those of the contracts, and what they name exists."""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest
from tools import parts

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "autobalancer"
PAGES = [ROOT / f"{name}.md" for name in ("README", "ARCHITECTURE", "CONTRIBUTING", "CONVENTIONS")]
BUILT = {"build", "docs/_build"}  # made by commands


def contract(name: str) -> list[set[str]]:
    """The layers of a contract, from the highest down."""
    linter = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]
    (found,) = (one for one in linter["contracts"] if one["name"] == name)
    return [set(layer.split(" | ")) for layer in found["layers"]]


def table(heading: str) -> list[tuple[str, str]]:
    """The two cells of each row of the table under a heading of ARCHITECTURE.md."""
    page = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    part = page.split(f"## {heading}\n")[1].split("\n## ")[0]
    return [(row[0], row[1]) for row in re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", part, re.MULTILINE)[1:]]


def test_the_table_of_layers_is_the_contract() -> None:
    assert [set(re.findall(r"`(\w+)`", names)) for _, names in table("Layers")] == contract("Data flows one way")


def test_the_rooms_of_stability_stand_in_the_order_of_their_contract() -> None:
    rooms = [name.strip("`") for names, _ in table("Rooms of stability") for name in names.split(", ")]
    height = {room: -n for n, layer in enumerate(contract("Rooms of stability")) for room in layer}
    assert set(rooms) == set(height) - {"border"}
    assert [height[room] for room in rooms] == sorted(height[room] for room in rooms)


def named(page: Path) -> set[str]:
    """Files and folders in a page: what has a slash, or the suffix of a file."""
    spans = re.findall(r"`([^`\n]+)`", page.read_text(encoding="utf-8"))
    return {one.rstrip("/") for one in spans if re.fullmatch(r"[\w./-]*/[\w./-]*|[\w.-]+\.(py|bib|md|cff)", one)}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_file_and_folder_that_a_page_names_exists(page: Path) -> None:
    tops = [path for path in ROOT.iterdir() if path.name not in (".venv", ".git", "build")]
    there = "\n".join(f"/{path.relative_to(ROOT).as_posix()}" for top in tops for path in (top, *top.rglob("*"))) + "\n"
    assert {name for name in named(page) - BUILT if f"/{name}\n" not in there} == set()


@pytest.mark.skipif(shutil.which("make") is None, reason="needs make")
def test_make_help_lists_every_target_and_pages_name_no_other() -> None:
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    listed = subprocess.run(["make", "help"], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert re.findall(r"^  make ([a-z-]+) ", listed, re.MULTILINE) == targets
    pages = "\n".join(path.read_text(encoding="utf-8") for path in [*PAGES, *ROOT.glob("docs/*.md")])
    assert set(re.findall(r"(?:^|`)make ([a-z-]+)", pages, re.MULTILINE)) <= set(targets)


def test_a_part_of_the_check_is_judged_by_its_work_and_not_by_the_speed_of_the_computer() -> None:
    quick = parts.SHARES["test"] * 1000.0 * 0.006
    took = {"processor_s": 0.9 * quick, "clock_s": quick, "loop_s": 0.006, "tests": {"tests/test_a.py::test_b": 3.0}}
    slow, more = took | {"processor_s": 9.0 * quick, "loop_s": 0.06}, took | {"processor_s": 1.4 * quick}
    assert parts.over({"test": took}) == parts.over({"test": slow}) == parts.over({"unknown": more}) == []
    assert parts.over({"lint": took | {"processor_s": 0.0}, "test": more}) == ["test"]
    assert parts.over({"test": more}, parts.FAILS) == []
    assert parts.over({"test": slow | {"loop_s": 0.006}}, parts.FAILS) == ["test"]
    assert any("tests/test_a.py" in line for line in parts.table({"test": took}))
    assert "test takes 1.4 times its share" in "\n".join(parts.table({"test": more}))


def test_every_file_that_a_comment_of_the_source_names_exists() -> None:
    there = "\n".join(
        f"/{path.relative_to(ROOT).as_posix()}" for top in (SOURCE, ROOT / "tools") for path in top.rglob("*.py")
    )
    named = {
        f"{path.relative_to(SOURCE)}: {name}"
        for path in SOURCE.rglob("*.py")
        for name in re.findall(r"\b(?:[a-z_]+/)+\w+\.py\b", path.read_text(encoding="utf-8"))
        if f"/{name}\n" not in f"{there}\n"
    }
    assert named == set()
