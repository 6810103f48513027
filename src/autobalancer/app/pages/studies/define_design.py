"""The specification of a design as a form of its most used entries and as its text."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path as File
from typing import Any

from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.studies.entries import LOOK, NONE, Entries
from autobalancer.app.pages.typed import Typed
from autobalancer.app.text.asked_design import DesignReading, read_design_text
from autobalancer.app.text.document import Path, data_of, value_at
from autobalancer.app.text.spread import as_entry, as_list, shown
from autobalancer.catalog.fluid_table import fluids
from autobalancer.studies.design.spec import OBJECTIVES

NUMBER = "an entry with its unit, such as"
SPACE = (("bore", "free bore", "24 mm"), ("outer", "outer diameter", "160 mm"), ("width", "width", "16 mm"))
OPERATION = (
    ("speed", "operating speed", "by default the highest of the drive; several with commas, such as 1200, 3000 rpm"),
    ("run_up", "run-up", "time to the speed; empty for the drive of the machine"),
    ("hold", "hold", "time at the speed, where there is a run-up"),
    ("coast_down", "coast-down", "time back to rest, where there is a run-up"),
)
LIMITS = (
    ("peak_deflection", "peak deflection", "on the way up and down, such as 1.3 mm"),
    ("residual_vibration", "residual vibration", "at the end, such as 20 um"),
    ("residual_unbalance", "residual unbalance", "at the end, such as 12 g*mm"),
    ("settling_time", "settling time", "of the last ball, such as 10 s"),
    ("stall_probability", "stall probability", "such as 0.02"),
    ("border_margin", "border margin", "least (speed - border) / border, such as 0.2"),
    ("contact_pressure", "contact pressure", "between ball and race, such as 2000 MPa"),
    ("share", "share of the runs", "which must keep each limit; 0.95 unless given"),
)
RACES = (
    ("bearings", "bearings", "names with commas, or all: their outer rings are the races"),
    ("orbit_radius", "orbit radius", "of free races, with commas, such as 70, 80 mm"),
    ("ball_diameter", "ball diameter", "with commas, such as 12, 15 mm"),
    ("count", "balls of a race", "with commas, such as 2, 3; or fewest"),
    ("races", "races of a plane", "with commas, such as 1, 2"),
)


class DefineDesign:
    """Form and text; ``start`` is called with what was read."""

    def __init__(
        self,
        bench: Bench,
        draft: Typed,
        find: Callable[[str], File | None],
        start: Callable[[DesignReading], None],
    ) -> None:
        self.bench, self.draft, self.find, self.start = bench, draft, find, start
        self.entries = Entries(draft)
        self.reading = DesignReading(read_design_text("", bench.text).of)
        self.place = ui.column().classes("w-full gap-2")
        with ui.row().classes("items-center gap-2 w-full q-mt-sm"):
            self.go = ui.button("Start", icon="play_arrow", on_click=lambda: self.start(self.reading))
            self.go.props('unelevated no-caps data-at="start design"')
            self.said = ui.label().classes("quiet").props('data-at="design size"')
        self.wrong = ui.label().classes("wrong").props('role="alert" data-at="design wrong"')
        draft.on_change(lambda origin: self._read(again=origin is not self.entries))
        bench.on_change(lambda _origin: self._read(again=True))
        self._read(again=True)

    def _read(self, *, again: bool) -> None:
        self.reading = read_design_text(self.draft.text, self.bench.text, self.find)
        if again:
            self._build()
        self.entries.mark(self.reading.key, self.reading.message)
        spec = self.reading.spec
        self.said.set_text("" if spec is None else f"{spec.search.members} runs of each candidate that is left")
        self.wrong.set_text(self.reading.message)
        self.go.set_enabled(spec is not None)

    def _build(self) -> None:
        self.place.clear()
        self.entries.shown = {}
        with self.place:
            data = data_of(self.draft.text)
            if data is None:
                ui.label("The text is not valid TOML; the form comes back when it is.").classes("quiet")
                return
            self._machine()
            self._part("Unbalance and temperature")
            with ui.element("div").classes("fields"):
                self._ends("unbalance", "unbalance", "500 g*mm")
                self._ends("temperature", "temperature", "20 degC")
            self._lines("Operation", "operation", OPERATION, many=("speed",))
            self._lines("Space", "space", [(key, word, f"{NUMBER} {hint}") for key, word, hint in SPACE])
            self._lines("Limits", "limits", LIMITS)
            self._lines(
                "Candidates", "candidates", RACES, many=("bearings", "orbit_radius", "ball_diameter", "count", "races")
            )
            self._fluids(data)
            self._search()

    def _machine(self) -> None:
        of = self.reading.of
        where = "of the page Describe" if of.file == "machine.toml" else f"sample {of.file}"
        text = f"{of.machine.name}, {where}" if of.machine is not None else NONE if of.file else "a measured rotor"
        with ui.row().classes("items-center gap-2 w-full"):
            ui.label(f"Machine: {text}").classes("key").props('data-at="design machine"')
            if of.file not in ("", "machine.toml"):
                page = ui.button("take the one of Describe", on_click=lambda: self._page())
                page.props('flat dense no-caps size=sm data-at="design of page"')

    def _page(self) -> None:
        self.entries.put(("machine",), "machine.toml", self)
        with self.place:  # the button is gone
            self.entries.focus("unbalance.from")

    def _part(self, title: str) -> None:
        ui.label(title).classes("box-title q-mt-xs")

    def _lines(self, title: str, table: str, lines: Any, many: tuple[str, ...] = ()) -> None:
        self._part(title)
        with ui.element("div").classes("fields"):
            for key, word, help_ in lines:
                path: Path = (table, key)
                held = value_at(data_of(self.draft.text), path)
                if isinstance(held, dict):
                    box = ui.input(word, value="see the text").props(f"{LOOK} readonly")
                    self.entries.known(box, path, help_)
                else:
                    self.entries.line(word, path, help_, made=_several if key in many else as_entry)

    def _ends(self, name: str, word: str, hint: str) -> None:
        """From and to; a single value stands in both."""
        held = value_at(data_of(self.draft.text), (name,))
        ends = held if isinstance(held, dict) else {"from": held, "to": held}

        def changed(end: str, given: str) -> None:
            now = value_at(data_of(self.draft.text), (name,))
            known = dict(now) if isinstance(now, dict) else {} if now is None else {"from": now, "to": now}
            known |= {end: as_entry(given)}
            kept = {key: value for key, value in known.items() if value != ""}
            self.entries.put((name,), kept or None)

        for end in ("from", "to"):
            box = ui.input(f"{word} {end}", value=shown(ends.get(end))).props(LOOK)
            box.on_value_change(lambda event, end=end: changed(end, event.value or ""))
            self.entries.known(box, (name, end), f"{NUMBER} {hint}")

    def _fluids(self, data: dict[str, Any]) -> None:
        held = value_at(data, ("candidates", "fluids"))
        path: Path = ("candidates", "fluids")
        if held is not None and not (isinstance(held, list) and all(isinstance(one, str) for one in held)):
            box = ui.input("fluids", value="blends, or a fluid for each race: see the text").props(f"{LOOK} readonly")
            self.entries.known(box.classes("w-full"), path, "of the races")
            return
        names = list(dict.fromkeys([*(held or []), *(one.name for one in fluids())]))
        self.entries.several("fluids", path, names, [], "of the races; the machine keeps its own if none is chosen")
        self.entries.shown["candidates.fluids"].classes("w-full")

    def _search(self) -> None:
        self._part("Search")
        with ui.element("div").classes("fields"):
            self.entries.line("runs of each candidate", ("search", "members"), "with scatter; 200 unless given", "200")
            self.entries.line(
                "candidates that may run", ("search", "budget"), "60 unless given; of more a search", "60"
            )
            self.entries.line("seed", ("search", "seed"), "equal seeds, equal numbers", "0")
        names = list(OBJECTIVES)
        said = "two numbers that should be small; they make the Pareto front"
        default = ["peak_deflection", "settling_time"]
        self.entries.several("objectives", ("search", "objectives"), names, default, said)
        self.entries.shown["search.objectives"].classes("w-full")


def _several(given: str) -> Any:
    """A word, one value, or a list."""
    given = given.strip()
    if "," in given:
        return as_list(given)
    value = as_entry(given)
    return [value] if isinstance(value, int) else value
