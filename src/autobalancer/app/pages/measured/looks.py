"""Looks at a measurement: waveforms, orders over the speed, maps, spectra, an orbit, a decay."""

from __future__ import annotations

from functools import partial
from html import escape
from typing import Any

import xarray as xr
from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.measured.wave_view import WaveView
from autobalancer.app.pages.work import Work
from autobalancer.app.store.drawn import svg_of
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.measured.looks import LOOKS, Asked, looked, order_table, turning, vibrations
from autobalancer.app.store.measured.shelf import Shelf
from autobalancer.measurement.comparison.order_curves import is_orders
from autobalancer.results.signals.signals import Signals

FIELD = "dense outlined hide-bottom-space"
WORDS = {
    "orders": ("orders", "of the rotor speed, such as 1, 2"),
    "slow_roll": (
        "slow roll",
        "time in which the rotor turns slowly, such as 0:4 s; the run-out seen there is subtracted",
    ),
    "revolutions": ("revolutions", "of a window; empty for 4 of orders, 16 of maps"),
    "pulses": ("pulses a turn", "of the tacho"),
    "tacho_angle": ("tacho looks at", "direction from the x axis, such as 90 deg"),
    "start": ("from", "of the piece that is looked at; of an orbit its instant"),
    "end": ("to", "of the piece that is looked at"),
}
NEEDS_TURNING = ("orders", "map", "frequencies", "orbit")


class Looks:
    """The waveforms, and one picture at a time."""

    def __init__(self, bench: Bench, shelf: Shelf) -> None:
        self.shelf, self.asked = shelf, Asked()
        self.name = ""
        with ui.row().classes("items-center gap-2 w-full"):
            ui.html("<h2 class='head'>Look</h2>", sanitize=False)
            self.work = Work(bench, "look")
        self.waves = WaveView().props('data-at="waves"')
        self.asking = ui.column().classes("w-full gap-2 q-mt-sm")
        self.picture = ui.html("", sanitize=False).classes("w-full measured-picture").props('data-at="look"')
        self.words = ui.html("", sanitize=False).classes("w-full").props('data-at="look words"')

    def show(self, name: str, data: xr.Dataset, version: str) -> None:
        """Show another measurement."""
        self.name, self.asked = name, Asked()
        self.picture.set_content("")
        self.words.set_content(f'<pre class="said">{escape(data.told())}</pre>' if isinstance(data, Signals) else "")
        self.waves.show(name if isinstance(data, Signals) else "", version)
        self.asking.clear()
        if isinstance(data, Signals):
            with self.asking:
                self._form(data)
        elif is_orders(data):
            self._ask(
                "orders of the table", lambda: (order_table(data), "") if "time" not in data.dims else _tracked(data)
            )

    def _form(self, data: xr.Dataset) -> None:
        names = vibrations(data)
        if not names:
            ui.label("No channel is a vibration, so there is no picture but the waveforms.").classes("quiet")
            return
        turns = turning(data)
        with ui.row().classes("items-center gap-2"):
            choice = ui.select(
                {"": "all channels of one unit", **{name: name for name in names}}, value="", label="channel"
            )
            choice.props(FIELD).props("options-dense").style("width: 190px").bind_value_to(self.asked, "channel")
            for key, (label, help_) in WORDS.items():
                if turns or key in ("start", "end"):
                    box = marked(ui.input(label, value=getattr(self.asked, key)).props(FIELD), at=f"ask {key}")
                    hinted(box.style("width: 130px"), help_)
                    box.bind_value_to(self.asked, key, lambda text: text or "")
        with ui.row().classes("items-center gap-2"):
            for key, (title, _) in LOOKS.items():
                if turns or key not in NEEDS_TURNING:
                    button = marked(ui.button(title).props("outline no-caps"), at=f"look {key}")
                    button.on_click(partial(self._look, key, data))

    def _look(self, key: str, data: xr.Dataset) -> None:
        asked = Asked(**vars(self.asked))
        self._ask(LOOKS[key][0], lambda: looked(data, key, asked))

    def _ask(self, title: str, make: Any) -> None:
        name = self.name

        def work(_job: Job) -> tuple[str, str]:
            draw, words = make()
            return svg_of(draw, f"{title} of the measurement"), words

        def then(job: Job) -> None:
            if name != self.name or job.state == "cancelled":
                return
            if job.state == "failed":
                self.picture.set_content(f'<div class="wrong">{escape(job.message)}</div>')
                return
            drawn, words = job.result
            self.picture.set_content(drawn)
            notes = "".join(f'<div class="note">{escape(note)}</div>' for note in job.notes)
            self.words.set_content((f'<pre class="said">{escape(words)}</pre>' if words else "") + notes)

        self.work.start(f"look {name}", work, then)


def _tracked(data: xr.Dataset) -> Any:
    from autobalancer.plots.signals.orders import orders as picture

    return (lambda: picture(data)), str(data)
