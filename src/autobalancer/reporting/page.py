"""What a report is made of: sections of paragraphs, tables, pictures and texts, whatever file they become."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from autobalancer.shown import Column

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS = 170  # per inch of a picture


@dataclass(frozen=True)
class Paragraph:
    """A text; ``strong`` where it is what a reader looks for first."""

    text: str
    strong: bool = False


@dataclass(frozen=True)
class Rows:
    """A table: heads, which may be empty, and rows of texts. ``numeric`` columns stand right, ``wide`` ones get the room."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: tuple[bool, ...] = ()
    wide: tuple[bool, ...] = ()


@dataclass(frozen=True)
class Drawing:
    """A picture (PNG) with what it shows in words."""

    png: bytes
    caption: str


@dataclass(frozen=True)
class Listing:
    """A text that keeps its lines, such as a machine file or a command."""

    text: str


Block = Paragraph | Rows | Drawing | Listing


@dataclass(frozen=True)
class Decisive:
    """What decides, for the first page: what is asked and found, whether that is enough, ``"-"`` where nobody asked, of what."""

    question: str
    found: str
    enough: str = "-"
    condition: str = ""  # of which unbalance, temperature, share of which runs


YES, NO = "yes", "NO"
WIDE = (True, True, True, False, False)  # columns of the first page


def yes_or_no(holds: bool) -> str:
    """Whether it is enough, as the first page says it."""
    return YES if holds else NO


@dataclass
class Section:
    """A heading and what stands below it; ``replay`` are the commands that make its numbers again, ``decisive`` what decides."""

    title: str
    blocks: list[Block] = field(default_factory=list)
    replay: str = ""
    decisive: list[Decisive] = field(default_factory=list)


@dataclass(frozen=True)
class Report:
    """A whole report."""

    title: str
    about: tuple[tuple[str, str], ...]  # identity: names and texts
    sections: tuple[Section, ...]
    sign: bool = True  # with lines for name, date and signature


def first_page(pages: Sequence[Section]) -> Section:
    """What decides, gathered from all pages, each with the number of its page behind this one; what is not enough comes first."""
    page = Section("In short")
    known = [
        (one, f"{number} {section.title}") for number, section in enumerate(pages, start=2) for one in section.decisive
    ]
    ranks = {NO: 0, YES: 2, "-": 3}
    known.sort(key=lambda pair: ranks.get(pair[0].enough, 1))
    rows = [(one.question, one.found, one.condition, one.enough, where) for one, where in known]
    missed = [f"{one.question}: {one.found}" for one, _ in known if one.enough == NO]
    said = f"Not enough: {'; '.join(missed)}." if missed else "Nothing that was asked for is missed."
    left = [f"{one.question} ({one.enough})" for one, _ in known if one.enough not in ranks]
    said += f" Look at: {'; '.join(left)}." if left else ""
    heads = ("question", "found", "of what", "enough", "page")
    page.blocks += [Paragraph(said, strong=True), Rows(heads, tuple(rows), wide=WIDE)]
    return page


def facts(rows: Sequence[tuple[str, str]]) -> Rows:
    """Names and texts as a table without heads."""
    return Rows((), tuple((name, text) for name, text in rows))


def columns_table(columns: Sequence[Column]) -> Rows:
    """Columns of a result as a table, units in the heads."""
    heads = tuple(f"{one.head} ({one.unit})" if one.unit else one.head for one in columns)
    cells = zip(*(one.cells() for one in columns), strict=True)
    numeric, wide = tuple(one.numeric for one in columns), tuple(one.wraps for one in columns)
    return Rows(heads, tuple(tuple(row) for row in cells), numeric, wide)


def drawing(figure: Figure, caption: str) -> Drawing:
    """A Matplotlib figure as a picture of a report."""
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=DOTS)
    return Drawing(stream.getvalue(), caption)
