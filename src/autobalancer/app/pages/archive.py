"""Archive: find runs, tag them, load them again, compare up to three, delete."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from typing import Any

from nicegui import ui

from autobalancer.app.pages.bench import Bench
from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.run import shown
from autobalancer.app.store.archive import UNREADABLE, Archive, Entry, differences
from autobalancer.app.text.problems import for_page
from autobalancer.errors import AutobalancerError, QuestionError

SHOWN = 60  # runs of a list
COLORS = ("#0072B2", "#D55E00", "#009E73")
MOST = 3  # runs side by side


class ArchivePage:
    """The runs of the user; ``show`` is called with the name of one that is to be seen again."""

    def __init__(self, bench: Bench, show: Callable[[str], None]) -> None:
        self.bench, self.archive, self.open = bench, Archive(bench.home), show
        self.chosen: list[str] = []
        with ui.element("section").classes("card"):
            with ui.row().classes("items-center gap-3 w-full"):
                self.search = ui.input("search").props('dense outlined clearable debounce=300 data-at="search"')
                self.search.style("width: 280px").on_value_change(lambda _event: self.refresh())
                self.count = ui.label().classes("quiet")
            self.list = ui.column().classes("w-full gap-0 q-mt-sm")
            self.none = ui.label("No runs yet; start one on the page Run.").classes("quiet")
        self.archive.tidy()
        self.lines: dict[str, tuple[Entry, Any]] = {}
        self.boxes: dict[str, Any] = {}
        self.side = ui.element("section").classes("card").props('data-at="compared"')
        self.refresh()

    def refresh(self) -> None:
        """Read the folder again."""
        found = self.archive.entries(self.search.value or "")
        there = {entry.name for entry in found}
        self.chosen = [name for name in self.chosen if name in there]
        self.count.set_text(f"{len(found)} run{'s' * (len(found) != 1)}")
        self.none.set_visibility(not found)
        self._follow(found[:SHOWN])
        self._compare()

    def _follow(self, found: list[Entry]) -> None:
        """Change the lines that are not right; the others stay under the hand of whoever uses them."""
        wanted = {entry.name: entry for entry in found}
        for name, (entry, line) in [*self.lines.items()]:
            if wanted.get(name) != entry:
                line.delete()
                del self.lines[name]
                self.boxes.pop(name, None)
        for place, entry in enumerate(found):
            if entry.name not in self.lines:
                with self.list:
                    line = marked(ui.row().classes("items-center gap-2 w-full no-wrap archive-line"), at=entry.name)
                with line:
                    self._line(entry, line)
                line.move(target_index=place)
                self.lines[entry.name] = (entry, line)

    def _line(self, entry: Entry, line: Any) -> None:
        """One run; whatever is wrong with it, the others are shown, and it can be deleted."""
        try:
            if entry.machine == UNREADABLE:
                raise QuestionError(UNREADABLE)
            self._run(entry)
        except Exception:
            line.clear()
            ui.label(f"the run {entry.name} {UNREADABLE}").classes("wrong").style("flex: 1 1 auto")
        bin_ = ui.button(icon="delete_outline", on_click=lambda: self._delete(entry)).props("flat dense round")
        marked(bin_, label=f"delete the run of {entry.machine}")

    def _run(self, entry: Entry) -> None:
        box = ui.checkbox(value=entry.name in self.chosen).props("dense")
        self.boxes[entry.name] = marked(box, label=f"compare {entry.machine}")
        box.on_value_change(lambda event: self._choose(entry.name, bool(event.value)))
        with ui.column().classes("gap-0").style("flex: 1 1 auto; min-width: 0"):
            ui.label(entry.machine).classes("key ellipsis")
            ui.label(f"{entry.made} UTC · {entry.seconds:.6g} s · {for_page(entry.verdict or entry.outcome)}").classes(
                "quiet"
            )
        tags = ui.input_chips(value=entry.tags, new_value_mode="add-unique").props('dense borderless label="tags"')
        tags.style("width: 210px; flex: 0 0 auto").on_value_change(
            lambda event: self._tag(entry.name, list(event.value or []))
        )
        ui.button("see", on_click=lambda: self._try(self.open, entry.name)).props("flat dense no-caps")
        load = ui.button("edit", on_click=lambda: self._try(self._edit, entry.name))
        hinted(load.props("flat dense no-caps"), "take its machine onto the page Describe")

    def _edit(self, name: str) -> None:
        self.bench.set_text(self.archive.text(name))

    def _try(self, act: Callable[[str], None], name: str) -> None:
        try:
            act(name)
        except (AutobalancerError, OSError, ValueError) as error:
            ui.notify(str(error), type="warning")

    def _tag(self, name: str, tags: list[str]) -> None:
        self.archive.tag(name, tags)
        self.lines[name] = (self.archive.entry(name), self.lines[name][1])

    def _delete(self, entry: Entry) -> None:
        with ui.dialog(value=True) as dialog, ui.card():
            ui.label(f"Delete the run of {entry.machine} of {entry.made}? It cannot be brought back.")

            def gone() -> None:
                dialog.close()
                self.archive.delete(entry.name)
                self.refresh()

            with ui.row():
                ui.button("Delete", on_click=gone).props("no-caps color=negative")
                ui.button("Keep", on_click=dialog.close).props("no-caps flat")

    def _choose(self, name: str, wanted: bool) -> None:
        self.chosen = [one for one in self.chosen if one != name]
        if wanted:
            self.chosen = [*self.chosen, name]
            if len(self.chosen) > MOST:
                self.boxes[self.chosen[0]].set_value(False)
        self._compare()

    def _compare(self) -> None:
        self.side.clear()
        self.side.set_visibility(bool(self.chosen))
        if not self.chosen:
            return
        try:
            entries = [self.archive.entry(name) for name in self.chosen]
            texts = [self.archive.text(name) for name in self.chosen]
            curves = [_curves(self.archive, name) for name in self.chosen]
        except (AutobalancerError, OSError, ValueError) as error:
            with self.side:
                ui.label(str(error)).classes("wrong")
            return
        with self.side:
            ui.html("<h2>Side by side</h2>", sanitize=False)
            ui.echart(_overlay(entries, curves)).style("height: 300px; width: 100%").props(
                'role="img" aria-label="greatest deflection of the chosen runs over time"'
            )
            ui.html(_table(entries, texts), sanitize=False).classes("w-full")


def _curves(archive: Archive, name: str) -> list[list[float]]:
    """Greatest deflection (µm) over time."""
    run = archive.run(name)
    if "envelope_high" in run:
        time, size = run["envelope_time"].values, run["envelope_high"].values
    elif "deflection" in run:
        time, size = run["time"].values, run["deflection"].values
    else:
        time = run["time"].values
        size = abs(run["body_position"].transpose("time", "axis").values[:, 1:]).max(axis=1)
    thin = max(1, len(time) // 1000)
    return [[float(t), float(f"{1e6 * s:.5g}")] for t, s in zip(time[::thin], size[::thin], strict=True)]


def _overlay(entries: list[Entry], curves: list[list[list[float]]]) -> dict[str, Any]:
    gray = "#808a93"
    axis = {"type": "value", "nameLocation": "middle", "axisLabel": {"color": gray}, "nameTextStyle": {"color": gray}}
    lines = {"splitLine": {"lineStyle": {"color": gray, "opacity": 0.25}}}
    return {
        "animation": False,
        "grid": {"left": 70, "right": 20, "top": 34, "bottom": 62},
        "legend": {"top": 0, "textStyle": {"color": gray}},
        "tooltip": {"trigger": "axis"},
        "xAxis": {
            **axis,
            **lines,
            "axisLabel": {"color": gray, "showMaxLabel": False},  # the end is no round number
            "name": "time (s)",
            "nameGap": 24,
            "max": "dataMax",
        },
        "yAxis": {**axis, **lines, "name": "greatest deflection (µm)", "nameGap": 52},
        "dataZoom": [{"type": "inside"}, {"type": "slider", "height": 16, "bottom": 6}],
        "series": [
            {
                "type": "line",
                "name": f"{number}: {entry.machine}",
                "showSymbol": False,
                "data": curve,
                "lineStyle": {"width": 1.4},
                "color": COLORS[number - 1],
            }
            for number, (entry, curve) in enumerate(zip(entries, curves, strict=True), 1)
        ],
    }


def _table(entries: list[Entry], texts: list[str]) -> str:
    """Measures side by side, and the entries in which the machines differ from the first."""
    heads = "".join(f"<th>{number}: {escape(entry.machine)}</th>" for number, entry in enumerate(entries, 1))
    meanings = {name: values[2] for entry in entries for name, values in entry.measures.items()}
    rows = [
        f"<tr><td>verdict</td>{''.join(f'<td>{escape(entry.verdict or entry.outcome)}</td>' for entry in entries)}</tr>"
    ]
    lengths = "".join(f"<td class='number'>{entry.seconds:.6g} s</td>" for entry in entries)
    rows.append(f"<tr><td>length of the run</td>{lengths}</tr>")
    for name, meaning in meanings.items():
        texts_of = [shown(*entry.measures[name][:2]) if name in entry.measures else "–" for entry in entries]
        cells = "".join(f"<td class='number'>{escape(text)}</td>" for text in texts_of)
        rows.append(f"<tr><td>{escape(meaning)}</td>{cells}</tr>")
    changed: dict[str, list[str]] = {}
    for number, text in enumerate(texts[1:], 1):
        for path, first, other in differences(texts[0], text):
            changed.setdefault(path, [first] * len(texts))[number] = other
    for path, values in changed.items():
        rows.append(f"<tr><td>{escape(path)}</td>{''.join(f'<td>{escape(value[:80])}</td>' for value in values)}</tr>")
    return f"<table class='facts'><tr><td></td>{heads}</tr>{''.join(rows)}</table>"
