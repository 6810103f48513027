"""Sphinx configuration; what can be generated from the code or from measured rows is generated here."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path[:0] = [str(ROOT), str(HERE / "_ext")]

import analysis_matrix  # noqa: E402
import border_tables  # noqa: E402
import command_tables  # noqa: E402
import console  # noqa: E402
import key_tables  # noqa: E402
import picture_tables  # noqa: E402
import result_tables  # noqa: E402
from reproductions import KINDS  # noqa: E402
from tools.ledger import BENCHMARKS, REPRODUCTIONS, Ledger, Row, markdown, totals  # noqa: E402

import autobalancer  # noqa: E402
from autobalancer.public_names import ABOUT, NAMES  # noqa: E402

project = "autobalancer"
author = "the autobalancer authors"
copyright = "2026, the autobalancer authors"
version = release = autobalancer.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx-mathjax-offline",  # formulas can be read without the internet
    "sphinx_gallery.gen_gallery",
    "sphinxcontrib.bibtex",
]
templates_path = ["_templates"]
exclude_patterns = ["_build", "reference/generated/tables", "**/GALLERY_HEADER.rst", "gallery/**/*.ipynb"]
# a page of the list of contents that does not exist yet is left out
suppress_warnings = ["toc.not_readable"]

html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["wide.css"]
html_title = f"autobalancer {version}"

myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 3

autosummary_generate = True
autosummary_ignore_module_all = False
autosummary_context = {"commands": command_tables.examples(), "snippets": command_tables.snippets()}  # for _templates
autodoc_typehints = "signature"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_numpy_docstring = True

bibtex_bibfiles = ["../src/autobalancer/catalog/data/references.bib"]
bibtex_default_style = "plain"

TOPICS = ("tutorials", "run_ups", "stability", "races", "rotors", "chambers", "exchange", "test_bench")
sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"plot_",
    "subsection_order": [f"../examples/{topic}" for topic in TOPICS],
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "backreferences_dir": "reference/generated/backreferences",  # which examples, with their pictures, use a function
    "doc_module": ("autobalancer",),
    "remove_config_comments": True,
    "show_memory": False,
    "write_computation_times": False,
    "image_scrapers": ("matplotlib", "gallery_pictures.scrape"),
    "ignore_repr_types": r"matplotlib|autobalancer\.plots",
}


def source_first(app: Any, what: str, name: str, about: Any, options: Any, lines: list[str]) -> None:
    """The paragraph that names sources stands behind the summary, as the last section of a docstring would take it."""
    begin = next((k for k, line in enumerate(lines) if line.startswith("Source: ")), None)
    section = next((k for k, line in enumerate(lines[1:]) if set(line) == {"-"}), None)
    if begin is not None and section is not None and begin > section:
        end = next((k for k in range(begin, len(lines)) if not lines[k].strip()), len(lines))
        moved = lines[begin:end]
        del lines[begin:end]
        lines[section:section] = [*moved, ""]


def keys_only(app: Any, what: str, name: str, about: Any, options: Any, signature: str, returns: str) -> Any:
    """A part is written with its keys alone, whose values and meanings stand below."""
    if what != "class" or not hasattr(about, "model_fields"):
        return None
    keys = (key if one.is_required() else f"{key}=..." for key, one in about.model_fields.items())
    return f"({', '.join(keys)})", returns


def setup(app: Any) -> None:
    """Sphinx calls this."""
    app.connect("autodoc-process-signature", keys_only)
    app.connect("autodoc-process-docstring", source_first, priority=400)  # before napoleon


# what follows writes the generated pages

GENERATED = HERE / "reference" / "generated"
TABLES = GENERATED / "tables"


def public_names() -> str:
    """The public interface: the names at the top, then those of each namespace."""
    text = "Public names\n============\n"
    for space, names in NAMES.items():
        title = f"ab.{space}" if space else "At the top"
        module = f"autobalancer.{space}" if space else "autobalancer"
        listed = "".join(f"   {name}\n" for name in names)
        text += f"\n{title}\n{'-' * len(title)}\n\n{ABOUT.get(space, '')}\n\n.. currentmodule:: {module}\n\n"
        text += f".. autosummary::\n   :toctree: .\n\n{listed}"
    return text


def table(ledger: Ledger, command: str) -> str:
    """The rows of the last run and its pictures, with their totals first, or how to make them."""
    rows = ledger.rows()
    if not rows:
        return (
            f"`build/{ledger.name}.json` is missing, so there is no table in this copy of the pages. "
            f"Run `{command}` in a checkout and build the pages again.\n"
        )
    text = tables(ledger, rows)
    for name in dict.fromkeys(row[ledger.section] for row in rows) if ledger.section else ():
        text += f"\n## {name}\n\n{tables(ledger, [row for row in rows if row[ledger.section] == name], rows_too=True)}"
    pictures = sorted((ledger.file.parent / ledger.name).glob("*/*.png"))
    text += "\n## Pictures\n" if pictures else ""
    for picture in pictures:
        copy = TABLES / f"{picture.parent.name}_{picture.name}"
        shutil.copyfile(picture, copy)
        text += f"\n![{picture.stem.replace('_', ' ')}](/{copy.relative_to(HERE).as_posix()})\n"
    return text


def tables(ledger: Ledger, rows: list[Row], *, rows_too: bool = False) -> str:
    """Totals of the rows, and the rows; of a ledger with sections only where ``rows_too`` says so."""
    counted = totals(ledger, rows)
    text = f"{markdown(list(counted[0]), counted)}\n" if counted else ""
    if rows_too or not ledger.section:
        shown = [key for key in ledger.shown if key != ledger.section and any(key in row for row in rows)]
        text += markdown(shown, rows)
    return text


def kinds() -> str:
    """The kinds of reproduction and what each means."""
    return "| kind | the target is |\n|---|---|\n" + "".join(f"| {kind} | {text} |\n" for kind, text in KINDS.items())


def write(path: Path, text: str) -> None:
    """Touch a page only when it changed, so that an incremental build stays one."""
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


TABLES.mkdir(parents=True, exist_ok=True)
write(GENERATED / "public.rst", public_names())
write(TABLES / "reproductions.md", table(REPRODUCTIONS, "make reproduce"))
write(TABLES / "reproduction_kinds.md", kinds())
write(TABLES / "benchmarks.md", table(BENCHMARKS, "make bench"))
for module in (analysis_matrix, key_tables, result_tables, border_tables, picture_tables, command_tables, console):
    for name, text in module.pages().items():
        write(TABLES / name, text)
