"""Answers to questions: labeled arrays that show themselves as a short table, in Python, in notebooks and on the command line."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from html import escape
from typing import ClassVar, TypeVar

import xarray as xr

from autobalancer.results.display_units import speed_axis
from autobalancer.shown import Column, html_table, rpm_and_si, text_table

A = TypeVar("A", bound="Answer")

WIDTH = 100  # letters of a line


class Answer(xr.Dataset):
    """A dataset in SI that shows itself as a table of its main numbers; all that a dataset can do, it can.

    What was cut out of it and has no such table is shown as xarray does.
    """

    __slots__ = ()
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

    def columns(self, unit: str = "") -> list[Column]:
        """The main table, speeds or frequencies in ``unit``."""
        raise NotImplementedError

    def heading(self) -> str:
        """The line above it."""
        return str(self.attrs.get("title", ""))

    def remarks(self) -> Sequence[str]:
        """Sentences below it."""
        return ()

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
        rows = list(zip(*(column.cells() for column in columns), strict=True))
        if len(rows) > self.most:
            half = self.most // 2
            rows = [*rows[:half], ("...", *[""] * (len(head) - 1)), *rows[-half:]]
        return head, rows

    def _contents(self) -> str:
        sizes = ", ".join(f"{name} ({size})" for name, size in self.sizes.items())
        return f"dataset in SI over {sizes}: {', '.join(map(str, self.data_vars))}"

    def __repr__(self) -> str:
        if not self.has_table():
            return str(xr.Dataset.__repr__(self))
        head, rows = self._table()
        lines = [line for text in (*self.remarks(), self._contents()) for line in textwrap.wrap(text, WIDTH)]
        return "\n".join(line for line in (self.heading(), text_table(head, rows) if rows else "", *lines) if line)

    def _repr_html_(self) -> str:
        whole = str(xr.Dataset._repr_html_(self))
        if not self.has_table():
            return whole
        remarks = "".join(f"<p>{escape(text)}</p>" for text in self.remarks())
        more = f"<details><summary>{escape(self._contents())}</summary>{whole}</details>"
        return html_table(*self._table(), self.heading()) + remarks + more


def at_speed(found: xr.Dataset) -> str:
    """The speed for which it was asked: ``at 1200 rpm (125.66 rad/s)``; empty if it is not kept."""
    return f"at {rpm_and_si(float(found.attrs['speed']))}" if "speed" in found.attrs else ""
