"""The tutorials of the gallery are notebooks: text and code in turn, made from scripts, and they run as they stand."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

import autobalancer as ab

TUTORIALS = sorted((Path(__file__).parents[1] / "examples" / "tutorials").glob("plot_*.py"))


def cells(tutorial: Path, folder: Path) -> list[dict[str, Any]]:
    """The cells of the notebook into which the documentation converts a script."""
    notebook = pytest.importorskip("sphinx_gallery.notebook")
    copy = folder / tutorial.name
    shutil.copyfile(tutorial, copy)
    notebook.python_to_jupyter_cli([str(copy)])
    found: list[dict[str, Any]] = json.loads(copy.with_suffix(".ipynb").read_text(encoding="utf-8"))["cells"]
    return found


def test_the_six_tutorials_are_numbered_and_linked_from_the_first_page() -> None:
    index = (Path(__file__).parents[1] / "docs" / "index.md").read_text(encoding="utf-8")
    assert [path.stem.split("_")[1] for path in TUTORIALS] == list("123456")
    assert [path.stem for path in TUTORIALS if f"gallery/tutorials/{path.stem}.rst" not in index] == []


@pytest.mark.parametrize("tutorial", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_becomes_a_notebook_of_text_and_short_cells_of_code(tutorial: Path, tmp_path: Path) -> None:
    found = cells(tutorial, tmp_path)
    code = ["".join(cell["source"]) for cell in found if cell["cell_type"] == "code"]
    text = "\n".join("".join(cell["source"]) for cell in found if cell["cell_type"] == "markdown")
    assert text.lstrip().startswith("# Tutorial "), "the title is the first heading"
    assert "## Exercises" in text
    assert len(code) >= 8
    assert text.count("\n") > 40, "there is more to read than code"
    assert max(len(cell.splitlines()) for cell in code) <= 25
    assert any("import autobalancer as ab" in cell for cell in code)
    assert not any("from autobalancer" in cell for cell in code), "tutorials use the public names"


@pytest.mark.slow
@pytest.mark.parametrize("tutorial", TUTORIALS, ids=lambda path: path.stem)
def test_the_notebook_of_a_tutorial_runs_from_its_first_to_its_last_cell(
    tutorial: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With few runs in each ensemble and study: every call is made, and every picture and table is drawn."""
    few = {"sensitivity": 20}  # draws, the least that it takes
    found = cells(tutorial, tmp_path)
    monkeypatch.chdir(tmp_path)
    study, ensemble, report, amplitudes = ab.study, ab.ensemble, ab.report, ab.chamber.amplitudes
    monkeypatch.setattr(
        ab, "study", lambda asked, **how: study({**asked, "members": few.get(asked.get("plan"), 8)}, **how)
    )
    monkeypatch.setattr(ab, "ensemble", lambda *given, seeds, **how: ensemble(*given, seeds=min(seeds, 6), **how))
    monkeypatch.setattr(ab, "report", lambda *given, starts, **how: report(*given, starts=min(starts, 3), **how))
    short = {"duration": "0.6 s", "last": "0.2 s"}
    monkeypatch.setattr(ab.chamber, "amplitudes", lambda *given, **how: amplitudes(*given, **how | short))
    names: dict[str, Any] = {"__name__": "__main__"}
    for number, cell in enumerate(found):
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), f"{tutorial.stem}, cell {number}", "exec"), names)
