"""Answers to questions: labeled arrays that show their main numbers, in Python, in notebooks and on the command line."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from itertools import zip_longest
from typing import ClassVar, TypeVar

import xarray as xr

from autobalancer.pictured import picture_html
from autobalancer.results.display_units import speed_axis
from autobalancer.shown import Column, facts_text, html_table, rpm_and_si, text_table

A = TypeVar("A", bound="Answer")

WIDTH = 100  # letters of a line
HEAD = 12  # letters of a column, at least, where heads are broken
DRAWN = 100_000_000  # bytes; what is larger is not drawn unasked
NAMED = 12  # variables that the last line lists


class Answer(xr.Dataset):
    """A dataset in SI that shows itself as facts and a table of its main numbers; all that a dataset can do, it can.

    What was cut out of it and lacks them is shown as xarray does.
    """

    __slots__ = ()
    drawn_by: ClassVar[str] = ""  # which function of ab.plot shows it in a notebook
    row_of: ClassVar[str] = ""  # dimension of the rows
    needed: ClassVar[tuple[str, ...]] = ()  # variables of the table
    shown_in: ClassVar[str] = "rpm"  # unit of speeds or frequencies
    most: ClassVar[int] = 24  # rows in Python; of more the first and the last ones

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()  # type: ignore[no-untyped-call]

    @classmethod
    def of(cls: type[A], found: xr.Dataset) -> A:
        """The same dataset as an answer."""
        return cls(found.data_vars, found.coords, found.attrs)

    def heading(self) -> str:
        """The first line."""
        return str(self.attrs.get("title", ""))

    def facts(self) -> Sequence[tuple[str, str]]:
        """Names and texts below it."""
        return ()

    def columns(self, unit: str = "") -> list[Column]:
        """The main table, speeds or frequencies in ``unit``; none where facts say it all."""
        return []

    def remarks(self) -> Sequence[str]:
        """Sentences at the end; first what the theory of the answer does not know of its machine, where it says so."""
        return [
            f"{who}ignores {self.attrs[name]}"
            for name, who in (("ignores", ""), ("stalled_ignores", "release and capture speed: "))
            if self.attrs.get(name)
        ]

    def in_si(self) -> xr.Dataset:
        """What a file of comma-separated values holds, in SI."""
        return self

    def scaled(self, name: str, head: str, unit: str, form: str = ".5g") -> Column:
        """A column of a variable in rad/s, shown in the unit of speeds."""
        shown = speed_axis(unit or self.shown_in)
        return Column(head, self[name].values * shown.factor, shown.sign, form)

    def texts(self, name: str, head: str) -> Column:
        """A column of texts."""
        return Column(head, [str(text) for text in self[name].values], wraps=True)

    def has_table(self) -> bool:
        """Whether all that the table needs is there."""
        return all(name in self and self[name].dims[:1] == (self.row_of,) for name in self.needed)

    def _table(self) -> tuple[list[str], list[tuple[str, ...]]]:
        columns = self.columns()
        head = [f"{column.head} ({column.unit})" if column.unit else column.head for column in columns]
        count, half = max((len(column.values) for column in columns), default=0), self.most // 2
        if count <= self.most:
            return head, list(zip(*(column.cells() for column in columns), strict=True))
        first, last = (
            list(zip(*(replace(column, values=column.values[part]).cells() for column in columns), strict=True))
            for part in (slice(half), slice(count - half, None))
        )
        return head, [*first, ("...", *[""] * (len(head) - 1)), *last]

    def _contents(self) -> str:
        sizes = ", ".join(f"{name} ({size})" for name, size in self.sizes.items())
        names = list(map(str, self.data_vars))
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED + 1 else ""
        return f"dataset in SI{f' over {sizes}' if sizes else ''}: {', '.join(names[:NAMED] if more else names)}{more}"

    def told(self) -> str:
        """Heading, facts, table and remarks, for a reader who has no use for the dataset."""
        return self._told(self.remarks())

    def __repr__(self) -> str:
        if not self.has_table():
            return str(xr.Dataset.__repr__(self))
        return self._told((*self.remarks(), self._contents()))

    def _told(self, sentences: Sequence[str]) -> str:
        (head, rows), facts = self._table() if self.has_table() else ([], []), self.facts()
        lines = [line for text in sentences for line in textwrap.wrap(text, WIDTH)]
        table = text_table(*_narrow(head, rows)) if rows else ""
        return "\n".join(line for line in (self.heading(), facts_text(facts) if facts else "", table, *lines) if line)

    def _repr_html_(self) -> str:
        whole = str(xr.Dataset._repr_html_(self))
        if not self.has_table():
            return whole
        (head, rows), facts, title = self._table(), self.facts(), self.heading()
        shown = html_table(("", ""), facts, title) if facts else ""
        shown += html_table(head, rows, "" if facts else title) if rows or not facts else ""
        shown += "".join(f"<p>{escape(text)}</p>" for text in self.remarks())
        shown += picture_html(self, self.drawn_by, title) if self.nbytes < DRAWN else ""
        return f"{shown}<details><summary>{escape(self._contents())}</summary>{whole}</details>"


def _narrow(head: list[str], rows: list[tuple[str, ...]]) -> tuple[list[str], list[tuple[str, ...]]]:
    """Heads of a table that is too wide broken between words."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    if sum(2 + max(len(name), width) for name, width in zip(head, widths, strict=True)) <= WIDTH + 2:
        return head, rows
    broken = [textwrap.wrap(name, max(width, HEAD)) for name, width in zip(head, widths, strict=True)]
    lines = list(zip_longest(*broken, fillvalue=""))
    return list(lines[0]), [*lines[1:], *rows]


def at_speed(found: xr.Dataset) -> str:
    """The speed for which it was asked: ``at 1200 rpm (125.66 rad/s)``; empty if it is not kept."""
    return f"at {rpm_and_si(float(found.attrs['speed']))}" if "speed" in found.attrs else ""
