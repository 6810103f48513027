"""The stability map with the point that one moves: another speed, another oil, and what the machine would do there."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from html import escape
from typing import Any

from nicegui import core, ui

from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.stability.map_point import MapPoint
from autobalancer.app.pages.stability.panel import Panel
from autobalancer.app.store.analyses import said
from autobalancer.app.store.jobs import Latest
from autobalancer.app.store.latest import About
from autobalancer.app.store.map_point import DrawnMap, Seen, drawn_map, seen_exactly, seen_on
from autobalancer.app.text.quantities import alike, machine_with, text_with
from autobalancer.assembly.quantities import value_of
from autobalancer.errors import AutobalancerError
from autobalancer.machine import Machine

HOW = "Drag the point, click, or use the arrow keys: with shift in larger steps, with alt in smaller."
POINT = ThreadPoolExecutor(1, thread_name_prefix="point")
VERDICTS = {"stable": "verdict good", "unstable": "verdict bad"}  # classes


class MapPanel(Panel):
    """The map; its point says at once what the map has there, and soon after what the full equations say."""

    def place(self) -> None:
        """Make room for the map, and beside it for the words of its point."""
        self.map: DrawnMap | None = None
        self.found: Any = None
        self.values: dict[str, float] = {}
        self.moved = False  # by the user
        self.exact = Latest(POINT)
        with ui.element("div").classes("map-and-point"):
            with ui.element("div").classes("map-place"):
                super().place()
                self.point = MapPoint(self._moved)
            with ui.column().classes("gap-2 point-words"):
                ui.html("<h2 class='head'>The point</h2>", sanitize=False)
                with ui.row().classes("gap-2 w-full no-wrap"):
                    self.boxes = [
                        marked(ui.input("").props("dense outlined hide-bottom-space"), at=f"point {k}") for k in "xy"
                    ]
                for number, box in enumerate(self.boxes):
                    box.on("change", lambda _event, number=number: self._typed(number)).without_auto_validation()
                self.verdict = ui.label().props('role="status" aria-live="polite" data-at="point verdict"')
                self.borders = ui.html("", sanitize=False).classes("w-full").props('data-at="point borders"')
                with ui.row().classes("gap-2"):
                    self.take = ui.button("Take into the machine", icon="input", on_click=self._take)
                    hinted(self.take.props('outline no-caps data-at="take point"'), "undo brings the machine back")
                    self.back = ui.button("Back to the machine", icon="undo", on_click=self._own)
                    self.back.props('flat no-caps data-at="own point"')
                ui.label(
                    "Drag the point, click, or use the arrow keys: with shift in larger steps, with alt in smaller."
                ).classes("quiet")

    def drawn(self, found: Any, about: About) -> Any:
        """The picture with its scales."""
        words = " ".join(f"{text}." for text in said(found))
        return drawn_map(found, f"{self.analysis.title} of {about.name}. {words}")

    def put(self, found: Any, drawn: DrawnMap) -> None:
        """Put the map on the page, its point where the machine is."""
        self.found, self.map = found, drawn
        self.picture.set_content(drawn.svg)
        self.point.show(drawn)
        for box, scale in zip(self.boxes, (drawn.x, drawn.y), strict=True):
            box.props["label"] = scale.short
        if self.moved and self.map.knows(self.values):
            self._see(self.values, last=True)
        else:
            self._own()

    def fill(self, known: Any, why: str) -> None:
        """Also where the machine itself is."""
        super().fill(known, why)
        if self.map is not None and self.values:
            self._mark()

    def is_of_the_machine(self) -> bool:
        """A map stays that of a machine that has another speed or another oil."""
        if super().is_of_the_machine():
            return True
        machine = self.bench.reading.machine
        if self.about is None or not isinstance(machine, Machine):
            return False
        try:
            return alike(machine_with(self.about.machine, self._of_machine()), machine)
        except AutobalancerError:
            return False

    def _of_machine(self) -> dict[str, float]:
        """The values of the machine of the page along both axes, as far as it has them."""
        machine = self.bench.reading.machine
        if self.map is None or not isinstance(machine, Machine):
            return {}
        try:
            found = {name: value_of(machine, name) for name in (self.map.x.name, self.map.y.name)}
        except AutobalancerError:
            return {}
        return {name: value for name, value in found.items() if value > 0.0}

    def _own(self) -> None:
        """The point back to the machine, else to the middle."""
        if self.map is None:
            return
        own, self.moved = {**self.map.values(0.5, 0.5), **self._of_machine()}, False
        self._see(own if self.map.shares(own) else self.map.values(0.5, 0.5), last=True)

    def _moved(self, x: float, y: float, last: bool) -> None:
        if self.map is not None:
            self.moved = True
            self._see(self.map.values(x, y), last=last)

    def _typed(self, number: int) -> None:
        """Another value of one axis, as it is written in the box."""
        if self.map is None:
            return
        box, scale = self.boxes[number], (self.map.x, self.map.y)[number]
        try:
            shown = float(str(box.value).strip())
        except ValueError:
            box.error = f"a number in {scale.sign}" if scale.sign else "a number"
            return
        wanted = {**self.values, scale.name: shown / scale.factor}
        if self.map.shares(wanted) is None:
            box.error = f"from {scale.low:.4g} to {scale.high:.4g} on this map"
            return
        self.moved = True
        self._see(wanted, last=True)

    def _see(self, values: dict[str, float], *, last: bool) -> None:
        """Say what the map has at a point, and ask what the equations say; older questions are dropped."""
        assert self.map is not None
        assert self.about is not None
        self.values = values
        for box, scale in zip(self.boxes, (self.map.x, self.map.y), strict=True):
            box.value, box.error = f"{values[scale.name] * scale.factor:.4g}", None
        self._mark()
        self._say(seen_on(self.found, values))
        machine = self.about.machine

        def work() -> Seen | str:
            try:
                return seen_exactly(machine, values, borders=last)
            except AutobalancerError as error:
                return str(error)

        def then(seen: Seen | str) -> None:
            if core.loop is not None:
                core.loop.call_soon_threadsafe(self._say, seen)

        self.exact.start(work, then)

    def _mark(self) -> None:
        assert self.map is not None
        own = self._of_machine()
        self.point.put(self.map.shares(self.values), self.map.shares(own) if len(own) == 2 else None)
        away = any(abs(value / self.values[name] - 1.0) > 1e-3 for name, value in own.items())
        self.take.set_enabled(away and self.is_of_the_machine())

    def _say(self, seen: Seen | str) -> None:
        if self.card.is_deleted:
            return
        if isinstance(seen, str):
            self.verdict.set_text(seen)
            self.verdict.classes(replace="wrong")
            return
        if seen.exact and not seen.borders:  # while the point moves, borders are those of the map
            seen.borders = seen_on(self.found, self.values).borders
        assert self.map is not None
        self.verdict.set_text(seen.words())
        self.verdict.classes(replace=VERDICTS.get(seen.verdict, "verdict"))
        cells = ((name, at, side, near) for name, at, side, near in seen.rows(self.values["speed"]))
        rows = "".join(
            f"<tr{' class=nearest' if near else ''}><td>{escape(name)}</td><td>{escape(at)}</td><td>{escape(side)}</td></tr>"
            for name, at, side, near in cells
        )
        head = "<tr><th>border here</th><th>speed</th><th>point is</th></tr>"
        self.borders.set_content(f'<table class="facts">{head}{rows}</table>' if rows else "")
        where = ", ".join(f"{one.label} {one.text(self.values[one.name])}" for one in (self.map.x, self.map.y))
        self.point.say(f"{where}: {seen.words()}", seen.verdict)

    def _take(self) -> None:
        """Write the values of the point into the text of the machine, as far as it has them."""
        machine, left = self.bench.reading.machine, []
        if not isinstance(machine, Machine):
            return
        text = self.bench.text
        for name, value in self.values.items():
            try:
                text = text_with(text, machine, {name: value})
                machine = machine_with(machine, {name: value})
            except AutobalancerError as error:
                left.append(str(error))
        self.bench.set_text(text)
        if left:
            ui.notify("not taken: " + "; ".join(left), type="warning", multi_line=True, timeout=10000)
        else:
            ui.notify("taken into the machine; undo brings it back", type="positive")
