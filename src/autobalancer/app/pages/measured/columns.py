"""What the columns of a measured file mean: the first lines of the file beside a row for each column."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

from nicegui import ui

from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.store.measured.columns import QUANTITIES, Column, Reading
from autobalancer.app.store.measured.shelf import Measured

FIELD = "dense outlined hide-bottom-space"
MORE = (
    ("rate", "samples a second", "where no column has the time, such as 2 kHz"),
    ("start", "from", "of the piece that is read, such as 0.5 s"),
    ("end", "to", "of the piece that is read"),
    ("resample", "resample to", "brings uneven samples to an even rate, such as 1 kHz"),
)


class Columns:
    """The form of one file; ``read`` is called with what it says."""

    def __init__(self, entry: Measured, preview: list[str], places: list[str], read: Callable[[Reading], None]) -> None:
        self.reading = entry.reading
        ui.html(f"<h2>{escape(entry.file)}</h2>", sanitize=False)
        text = escape("\n".join(preview))
        ui.html(
            f'<pre class="preview" data-at="preview" tabindex="0" aria-label="first lines">{text}</pre>', sanitize=False
        )
        if not self.reading.columns:
            return
        if self.reading.clock:
            ui.label(f"time: {self.reading.clock}").classes("quiet").props('data-at="clock"')
        with ui.element("div").classes("columns").props('role="table" aria-label="columns of the file"'):
            for column in self.reading.columns:
                self._row(column, places)
        with ui.row().classes("items-center gap-2 q-mt-sm"):
            for key, label, help_ in MORE:
                box = marked(ui.input(label, value=getattr(self.reading, key)).props(FIELD), at=f"reading {key}")
                hinted(box.style("width: 170px"), help_).bind_value_to(self.reading, key, lambda text: text or "")
            large = ui.checkbox("large values are right", value=self.reading.implausible).props("dense")
            hinted(large, "takes vibrations so large that their unit is probably wrong")
            large.bind_value_to(self.reading, "implausible")
            ui.button("Read", icon="check", on_click=lambda: read(self.reading)).props(
                'unelevated no-caps data-at="read columns"'
            )

    def _row(self, column: Column, places: list[str]) -> None:
        hinted(ui.label(column.column).classes("key ellipsis"), column.column)
        kind = ui.select(QUANTITIES, value=column.quantity, label="is").props(FIELD).props("options-dense")
        kind.bind_value_to(column, "quantity")
        _named(kind, "quantity", column)
        self._text(column, "unit", "of its numbers, such as um; of voltages V, with a sensitivity")
        self._text(column, "direction", "x, y, z, or degrees from x", ["x", "y", "z"])
        self._text(column, "place", "the station where the sensor is; empty for the rotor", places)
        self._text(column, "uncertainty", "one standard deviation of a value, such as 1 um; fits of samples need it")
        self._text(column, "sensitivity", "of the sensor, such as 8 mV/um, where the numbers are voltages")
        self._text(column, "name", "of the channel")

    def _text(self, column: Column, key: str, help_: str, offered: list[str] | None = None) -> None:
        word = {"uncertainty": "noise"}.get(key, key)
        box = hinted(ui.input(word, value=getattr(column, key), autocomplete=offered).props(FIELD), help_)
        box.bind_value_to(column, key, lambda text: text or "")
        _named(box, word, column)


def _named(element: Any, what: str, column: Column) -> None:
    """Its name for those who do not see it, and for tests."""
    marked(element, at=f"{what} of {column.column}", label=f"{what} of {column.column}")
