"""Describe: where a machine comes from, its form, its text, its drawing, and what is known of it."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache, partial
from html import escape
from typing import Any

import tomli_w
from nicegui import events, ui

from autobalancer.api import check
from autobalancer.app.form_fields import USUAL, Field, fields_of, in_unit, number_and_unit, tag_of, word_of, written
from autobalancer.app.pages.elements import (
    Bench,
    Changed,
    button,
    delete_button,
    hinted,
    marked,
    picker,
    refusals,
    toml_editor,
    uploader,
)
from autobalancer.app.problems import (
    EMPTY,
    ROTOR_FILES,
    EntryPath,
    data_of,
    drawable,
    for_page,
    value_at,
    with_entry,
    with_value,
    without,
)
from autobalancer.app.store.jobs import Latest
from autobalancer.app.store.measured_files import LARGEST as LARGEST_FILE
from autobalancer.app.store.measured_files import MACHINE_SUFFIXES, Measurements
from autobalancer.app.store.pictures import svg_of
from autobalancer.catalog import fluids, materials
from autobalancer.errors import AutobalancerError, spell, unwarned
from autobalancer.files.examples import example_text, examples
from autobalancer.machine.part import Part
from autobalancer.machine_kinds import machine_kind
from autobalancer.sketch import machine as machine_picture
from autobalancer.tables import rpm_and_si

LARGEST = 1_000_000  # bytes of a machine file
AGAIN = 32  # machines whose drawing and facts are kept: for undo, redo and a sample that is taken once more


def describe(bench: Bench, dark: Any) -> None:
    """Put this part of the page."""
    _sources(bench)
    with ui.element("div").classes("describe"):
        with ui.element("section").classes("card tall").props('aria-label="form"'):
            ui.html("<h2>Form</h2>", sanitize=False)
            Form(bench)
        with ui.element("section").classes("card text").props('aria-label="text"'):
            ui.html("<h2>Machine file (TOML)</h2>", sanitize=False)
            toml_editor(bench, dark).props('data-at="toml"')
        with ui.column().classes("gap-3 w-full"):
            Check(bench)


def _sources(bench: Bench) -> None:
    """A new machine, a sample, a published rig, a file."""

    async def upload(event: events.UploadEventArguments) -> None:
        content = await event.file.read()
        box.reset()
        try:
            bench.set_text(content[: LARGEST + 1].decode("utf-8-sig").replace("\r\n", "\n"))
            bench.insist()
        except ValueError:
            ui.notify("this file is no text; a machine file is TOML", type="negative")

    with ui.row().classes("items-center gap-2 w-full sources"):
        look = "outline dense no-caps"
        button("Empty machine", lambda: bench.set_text(EMPTY), "note_add", look)
        picker(list(examples()), "sample machine", lambda name: bench.set_text(example_text(name)), at="sample")
        picker(list(examples("rigs")), "published rig", lambda name: bench.set_text(example_text(name)), at="rig")
        box = uploader(upload, "a machine file", (".toml",), LARGEST, at="upload")
        button("Open a file", lambda: box.run_method("pickFiles"), "folder_open", look)
        button("Data files", partial(_data_files, bench), "folder", look, hint="that machines name", at="data files")


def _data_files(bench: Bench) -> None:
    """What was given beside machines, such as matrices of a rotor; each can be deleted."""

    def gone() -> None:
        dialog.close()
        bench.reread()

    with ui.dialog(value=True) as dialog, ui.card():
        for file in sorted(bench.files.glob("*")):
            with ui.row().classes("items-center gap-2 no-wrap"):
                ui.label(f"{file.name}, {file.stat().st_size / 1e3:.0f} kB")
                question = f"Delete {file.name}? Machines that name it need it; runs that are kept do not."
                delete_button(file.name, question, file.unlink, gone)
        ui.label("A file is given beside its field of the form; here are those that were.").classes("quiet")


# The form of a machine, made from the classes that check its file.


ROOM = 100  # entries of lists that have fields: each takes the server a while, with every edit


ALTERNATIVES: dict[
    str, tuple[tuple[tuple[str, ...], tuple[str, ...]], ...]
] = {  # keys to fill in, unless one of the others is given
    "PlanarRotor": (
        (("critical_speed", "stiffness"), ("rubber",)),
        (("damping_ratio",), ("damping", "half_power_bandwidth", "rubber")),
    ),
    "Unbalance": tuple(((key,), ("moment", "couple", "misalignment")) for key in ("mass", "radius")),
    "MatricesRotor": ((("files",), ("coordinates",)),),
    "ModalRotor": ((("files",), ("resonances",)),),
    "MatrixFiles": ((("file",), ("mass", "stiffness")),),
    "Race": ((("orbit_radius", "bearing"), ("race_radius",)),),
    "Fluid": ((("name",), ("density", "viscosity")),),
    "Balls": ((("diameter", "mass"), ()), (("material",), ("density",))),
}


TABLE_FILE = Field("file", "text", True, "a table with a line for each, units in its head", "")
IN_TABLES = [("rotor", name) for name in ("segments", "disks", "supports")]
SHORT = 6  # letters of a name that are seen beside a unit
LOOK = "dense outlined debounce=350"
# as the documentation says of keys whose values commas may part
LISTED = re.compile("list of (?!text)|pair of|three of")


class Form:
    """Fields for every key that is given or required; others are added from a list."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.shut: set[EntryPath] = set()
        self.shown: dict[EntryPath, Any] = {}  # what shows the message of a path
        # of keys that were added and are not filled in yet; the text does not have them
        self.empty: set[EntryPath] = set()
        self.fresh: set[EntryPath] = set()  # what was added, in which nothing is wrong until it was left
        self.left: set[EntryPath] = set()
        self.room = ROOM  # for entries of lists
        self.editing = False
        with ui.column().classes("form") as self.place:
            self.build()
        bench.on_change(self._changed)

    def _changed(self, origin: object) -> None:
        """Follow at once, also behind another part of the page: nobody may write into fields that are soon replaced."""
        if not self.editing or self.bench.text == EMPTY:
            self._forget()
        if origin is not self:
            self.build()
        self.mark()

    def _forget(self) -> None:
        for paths in (self.empty, self.fresh, self.left):
            paths.clear()

    def build(self) -> None:
        """Make the whole form again."""
        self.place.clear()
        self.shown, self.room = {}, ROOM
        data = data_of(self.bench.text)
        with self.place:
            if data is None:
                ui.label("The text is not valid TOML; the form comes back when it is.").classes("quiet")
                ui.label(self.bench.reading.message).classes("wrong")
                return
            root = _root_of(data)
            self._fields(root, (), data)
        self.mark()

    def mark(self) -> None:
        """Put every message beside its field, or beside the nearest table."""
        words: dict[EntryPath, list[str]] = {path: [] for path in self.shown}
        for path, message in self.bench.reading.problems.items():
            near = path
            while near not in self.shown and near:
                near = near[:-1]
            tail = ".".join(str(step) for step in path[len(near) :] if isinstance(step, str))
            if near in words and self._met(near):
                words[near].append(f"{tail}: {message}" if tail else message)
        for path, target in self.shown.items():
            text = "; ".join(words[path])
            if isinstance(target, ui.label):
                target.set_text(text)
                target.set_visibility(bool(text))
            else:
                target.error = text or None

    def _met(self, near: EntryPath) -> bool:
        """Whether somebody has been where a message belongs: what is not filled in yet is no mistake."""
        if not (self.bench.begun or any(near[: len(path)] == path for path in self.fresh)):
            return True
        if not isinstance(self.shown[near], ui.label):
            return near in self.left
        inside = [path for path, one in self.shown.items() if path[:-1] == near and not isinstance(one, ui.label)]
        return bool(inside) and all(path in self.left for path in inside)

    def _fields(self, part: type[Part], path: EntryPath, data: dict[str, Any]) -> None:
        """The keys of one table, and below them its tables."""
        fields = fields_of(part)
        # optional keys of a part that a form asks for: one of several ways to say what has to be said, and none is taken yet
        groups = ALTERNATIVES.get(part.__name__, ())
        asked = {key for keys, others in groups if not {*keys, *others} & set(data) for key in keys}
        given = [
            field
            for field in fields
            if field.name in data or field.required or field.name in asked or (*path, field.name) in self.empty
        ]
        with ui.element("div").classes("fields"):
            for field in (field for field in given if field.kind not in ("table", "tables")):
                bare = field.required or (field.name in asked and (*path, field.name) not in self.empty)
                self._entry(field, (*path, field.name), data.get(field.name), removable=not bare)
        for field in (field for field in given if field.kind == "table"):
            self._table(field, (*path, field.name), data.get(field.name))
        for field in (field for field in given if field.kind == "tables"):
            self._tables(field, (*path, field.name), data.get(field.name))
        missing = [field for field in fields if field not in given]
        if missing:
            self._adder(missing, path)

    def _entry(self, field: Field, path: EntryPath, value: Any, *, removable: bool) -> None:
        def changed(new: Any) -> None:
            if new in (None, ""):
                self.empty.add(path)  # its field stays
            else:
                self.left.add(path)
            self.edit(lambda text: _without(text, path) if new in (None, "") else with_value(text, path, new))

        def dropped() -> None:
            waiting = path in self.empty
            self.empty.discard(path)
            self.edit(lambda text: _without(text, path), again=True)
            if waiting:  # the text does not have it, so nobody was told
                self.build()

        def left() -> None:
            if path not in self.left:
                self.left.add(path)
                self.mark()

        self.shown[path] = shown = _entry_of(field, path, value, changed, dropped if removable else None)
        if path[-1] == "file" or (path[-2:-1] == ("files",) and path[-1] in ROTOR_FILES):
            with shown.parent_slot.parent:
                self._upload(path)
        if value is None:
            shown.on("blur", left)

    def _upload(self, path: EntryPath, text: str = "") -> None:
        """A button that takes the file for a key; it is kept for this user, and replaces one of its name."""

        async def upload(event: events.UploadEventArguments) -> None:
            content = await event.file.read()
            box.reset()
            with refusals():
                name = Measurements.keep_file(self.bench.files, event.file.name, content)
                if value_at(data_of(self.bench.text), path) == name:
                    self.bench.reread(self)
                else:
                    self.edit(lambda text: with_value(text, path, name), again=True)

        box = uploader(upload, "a file of a machine", MACHINE_SUFFIXES, LARGEST_FILE, at=f"upload {spell(path)}")
        take, look = partial(box.run_method, "pickFiles"), "flat dense no-caps size=sm"
        button(text, take, "upload_file", look, label=f"file for {path[-1]}", hint="take the file from this computer")

    def _table(self, field: Field, path: EntryPath, data: Any) -> None:
        with self._box(path, field.name, field.meaning, None if field.required else path):
            self._kind_and_fields(field, path, data if isinstance(data, dict) else {})

    def _tables(self, field: Field, path: EntryPath, data: Any) -> None:
        if isinstance(data, dict) and "file" in data:
            with self._box(path, f"{field.name} in a table", field.meaning, path):
                self._entry(TABLE_FILE, (*path, "file"), data["file"], removable=False)
            return
        entries = data if isinstance(data, list) else [data] if isinstance(data, dict) else []
        for number, entry in enumerate(entries):
            inner = (*path, number)
            if self.room <= 0:
                ui.label(f"{len(entries) - number} more: they stand in the text").classes("quiet")
                break
            self.room -= 1
            with self._box(inner, f"{_singular(field.name)} {number + 1}", field.meaning, inner):
                self._kind_and_fields(field, inner, entry if isinstance(entry, dict) else {})

        def more() -> None:
            part = field.parts[0]
            first = {tag_of(part): word_of(part)} if tag_of(part) else {}
            self.fresh.add((*path, len(entries)))
            self.edit(lambda text: with_entry(text, path, first), again=True)

        if path not in self.shown and not entries:
            self.shown[path] = ui.label("").classes("wrong")
        with ui.row().classes("items-center gap-2"):
            ui.button(f"add {_singular(field.name)}", icon="add", on_click=more).props("flat dense no-caps size=sm")
            if not entries and path in IN_TABLES:
                self._upload((*path, "file"), "or a table (CSV)")

    def _kind_and_fields(self, field: Field, path: EntryPath, data: dict[str, Any]) -> None:
        part = _chosen(field.parts, data)
        tag = tag_of(field.parts[0])
        if len(field.parts) > 1:

            def other(event: Any) -> None:
                if event.value and event.value != data.get(tag):
                    kept = {key: value for key, value in data.items() if key in _names(field.parts, event.value)}
                    self.edit(lambda text: with_value(text, path, {tag: event.value, **kept}), again=True)

            words = [word_of(one) for one in field.parts]
            value = data.get(tag) if data.get(tag) in words else None
            choice = ui.select(words, value=value, label=tag, on_change=other).props("dense outlined options-dense")
            self.shown[(*path, tag)] = marked(choice.classes("field"), at=spell((*path, tag)))
        if part is not None:
            self._fields(part, path, data)

    def _box(self, path: EntryPath, title: str, meaning: str, removable: EntryPath | None) -> Any:
        """A part that opens and shuts, with a bin where it may be removed."""
        with ui.element("div").classes("relative-position w-full"):
            box = ui.expansion(value=path not in self.shut).classes("box").props("dense dense-toggle expand-separator")
            marked(box, at=spell(path))
            if removable is not None:  # beside the header, which is a button itself

                def drop(_: Any = None, path: EntryPath = removable) -> None:
                    self._forget()  # entries behind it move up
                    self.edit(lambda text: without(text, path), again=True)

                button = marked(ui.button(icon="delete_outline"), label=f"remove {title}")
                button.props("flat dense round size=sm").on("click", drop).classes("box-bin")

        def moved(event: Any) -> None:
            (self.shut.discard if event.value else self.shut.add)(path)

        box.on_value_change(moved)
        with box.add_slot("header"), ui.row().classes("items-center w-full no-wrap gap-2"):
            hinted(ui.label(title.replace("_", " ")).classes("box-title"), meaning)
        with box:
            self.shown[path] = ui.label("").classes("wrong")
        return box

    def _adder(self, missing: list[Field], path: EntryPath) -> None:
        """A list of the keys that are not given yet, with their help."""

        def add(field: Field) -> None:
            menu.close()  # before the form is made anew: what shuts it must be there still
            new = (*path, field.name)
            self.fresh.add(new)
            first = _first(field)
            if first is None:
                self.empty.add(new)
                self.build()
            elif field.kind == "tables":
                self.fresh.add((*new, 0))
                self.edit(lambda text: with_entry(text, new, first), again=True)
            else:
                self.edit(lambda text: with_value(text, new, first), again=True)

        label = "add a key" if path else "add a part"
        button = ui.button(label, icon="add").props("flat dense no-caps size=sm")
        with marked(button, at=f"add to {spell(path)}"), ui.menu().props("max-height=60vh") as menu:
            for field in missing:
                with (
                    ui.menu_item(on_click=lambda field=field: add(field), auto_close=False),
                    ui.column().classes("gap-0 adder"),
                ):
                    ui.label(field.name).classes("key")
                    ui.label(field.help).classes("quiet")

    def edit(self, change: Callable[[str], str], *, again: bool = False) -> None:
        """Change the text; ``again`` where other fields belong to it."""
        self.editing = True
        try:
            self.bench.edit(change, None if again else self)
        except (ValueError, LookupError, TypeError):  # what was typed into the text a moment ago
            with self.place:
                ui.notify("not taken: the text of the machine has just changed", type="warning")
        finally:
            self.editing = False


def _entry_of(field: Field, path: EntryPath, value: Any, changed: Changed, dropped: Callable[[], None] | None) -> Any:
    """Put the entry on the page; gives what shows its error."""
    with_unit = field.kind == "quantity" and (value is None or number_and_unit(value, field.unit) is not None)
    named = field.kind == "text" and isinstance(value, str | None)
    long = field.name == "description" or value is None or (with_unit and len(field.name) > SHORT)
    with ui.row().classes("entry no-wrap" + (" wide" if long else "")):
        if with_unit:
            shown = _quantity(field, path, value, changed)
        elif field.kind in ("choice", "switch") or (named and _known(path)):
            known = [] if field.kind != "text" else _known(path)
            options: Any = list(dict.fromkeys([*known, *([value] if known and value else []), *field.choices]))
            options = {True: "yes", False: "no"} if field.kind == "switch" else options
            chosen = bool(value) if field.kind == "switch" else value if value in options else None
            shown = ui.select(
                options, value=chosen, label=field.name, with_input=bool(known), new_value_mode="add" if known else None
            )
            shown.props("dense outlined options-dense")
            shown.on_value_change(lambda event: changed("" if event.value is None else event.value))
        else:
            shown = ui.input(field.name, value=_as_toml(value))
            shown.props(LOOK + (" autogrow" if field.name == "description" else ""))
            as_value = str if named else partial(_from_toml, many=bool(LISTED.match(field.allowed)))
            shown.on_value_change(lambda event: changed(as_value(event.value or "")))
        marked(shown.classes("field").without_auto_validation(), at=spell(path), about=field.help)
        hinted(shown, field.help)
        if value is None:
            shown.props["hint"] = field.meaning
        if dropped is not None:
            button = ui.button(icon="close", on_click=dropped).props("flat dense round size=xs color=grey tabindex=-1")
            marked(button.classes("drop"), label=f"remove {field.name}")
    return shown


def _quantity(field: Field, path: EntryPath, value: Any, changed: Changed) -> Any:
    """A number and its unit; another unit keeps the quantity and changes the number."""
    number, unit = number_and_unit(value, field.unit) or ("", _usual(field, path))
    units = list(field.units) if unit in field.units else [*field.units, unit]
    entry = ui.input(field.name, value=number).props(f"{LOOK} inputmode=decimal")
    if units == [""]:
        entry.on_value_change(lambda event: changed(written(event.value or "", "", "") or ""))
        return entry
    choice = ui.select({one: one or "–" for one in units}, value=unit).props("dense outlined options-dense")
    marked(choice.classes("unit"), at=f"unit of {spell(path)}", label=f"unit of {field.name}")
    state = {"unit": unit}

    def say(_: Any = None) -> None:
        changed(written(entry.value or "", state["unit"], field.unit))

    def other(event: Any) -> None:
        try:
            number = in_unit(entry.value or "", state["unit"], event.value, field.unit)
        except ValueError:  # what is written is no number; the reader says so
            number = entry.value or ""
        state["unit"] = event.value
        if number == entry.value:
            say()
        else:
            entry.value = number

    entry.on_value_change(say)
    choice.on_value_change(other)
    return entry


def _usual(field: Field, path: EntryPath) -> str:
    """The unit that most people take; balls and unbalances are weighed in grams."""
    small = field.unit == "kg" and path[0] in ("unbalances", "balancers")
    return "g" if small else (USUAL | {"K": "degC"}).get(field.unit, field.unit)


def _known(path: EntryPath) -> list[str]:
    """Names of the catalog that may stand at a path."""
    if path[-2:] == ("fluid", "name"):
        return [one.name for one in fluids()]
    return [one.name for one in materials()] if path[-1] == "material" else []


def _as_toml(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    return " ".join(tomli_w.dumps({"v": value}).removeprefix("v = ").split()).replace(", ]", "]").replace("[ ", "[")


def _from_toml(text: str, many: bool = False) -> Any:
    """A list or number as TOML writes it, else a text; ``many`` are also those with commas between them, without brackets."""
    try:
        return tomllib.loads(f"v = {text}")["v"]
    except (ValueError, RecursionError):
        parts = re.split(r"[,;]\s+|;", text.strip()) if many and not text.lstrip().startswith(("[", "{")) else []
        return [_from_toml(part.strip()) for part in parts if part.strip()] if len(parts) > 1 else text


def _chosen(parts: tuple[type[Part], ...], data: Any) -> type[Part] | None:
    """Which of several parts a table of a file is; ``None`` if it does not say."""
    if len(parts) == 1:
        return parts[0]
    given = data if isinstance(data, dict) else {}
    return next((part for part in parts if given.get(tag_of(part)) == word_of(part)), None)


def _root_of(data: dict[str, Any]) -> type[Part]:
    """The class of a machine file, from its keys."""
    part: type[Part] = machine_kind(data).part
    return part


def _first(field: Field) -> Any:
    """What is written for a key that is added; ``None`` where its field waits to be filled in, in the unit that people take."""
    if field.kind in ("table", "tables"):
        part = field.parts[0]
        return {tag_of(part): word_of(part)} if tag_of(part) else {}
    if field.kind == "switch":
        return True
    if field.kind == "choice":
        return field.choices[-1]
    return field.default or None


def _without(text: str, path: EntryPath) -> str:
    """The text without a key, if it has it."""
    return without(text, path) if value_at(data_of(text), path) is not None else text


def _names(parts: tuple[type[Part], ...], word: str) -> set[str]:
    return {name for part in parts if word_of(part) == word for name in part.model_fields} - {"kind", "law"}


def _singular(name: str) -> str:
    """One of several: ``race`` of ``races``, ``balls`` stays, as a group of balls is one entry."""
    if name == "balls":
        return "group of balls"
    return name[:-3] + "y" if name.endswith("ies") else name.removesuffix("s")


# What is known of the machine at once: capability, critical speeds, borders; only the latest text counts.


POOL = ThreadPoolExecutor(1, thread_name_prefix="check")
PENCIL = ThreadPoolExecutor(1, thread_name_prefix="drawing")
INCOMPLETE_TEXT = "The facts come when there is enough to know. Still wanted, or not possible yet:"
NEUTRAL = """<svg role="img" aria-label="a rotor on its springs, with balls in a race, not to scale" class="begun"
 viewBox="0 0 320 130">
<path d="M20 60H180M75 20H125V100H75ZM40 60v30m-8 0h16M160 60v30m-8 0h16" />
<path d="M36 90l8 6-8 6 8 6-8 6M156 90l8 6-8 6 8 6-8 6" />
<circle cx="255" cy="60" r="48" /><circle cx="255" cy="60" r="32" /><circle cx="255" cy="60" r="4" />
<circle cx="222" cy="83" r="8" class="ball" /><circle cx="226" cy="32" r="8" class="ball" />
<path d="M255 60L290 45" class="heavy" />
</svg>"""


class Check:
    """Drawing and facts of the machine; both follow every edit."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.latest, self.pencil = Latest(POOL), Latest(PENCIL)
        with ui.element("section").classes("card"):
            with ui.row().classes("items-center gap-2 w-full"):
                ui.html("<h2 class='head'>Drawing</h2>", sanitize=False)
                marks = {"at": "enlarge", "label": "larger drawing", "hint": "larger"}
                button("", self.enlarge, "open_in_full", "flat dense round size=sm", **marks)
            self.drawing = ui.html("", sanitize=False).classes("w-full").props('data-at="drawing"')
        with ui.element("section").classes("card tall-rest"):
            with ui.row().classes("items-center gap-2 w-full"):
                ui.html("<h2 class='head'>Check</h2>", sanitize=False)
                self.busy = ui.spinner(size="1.1em")
            self.facts = ui.html("", sanitize=False).classes("w-full").props('data-at="check"')
        with ui.dialog().props('aria-label="drawing"') as self.dialog, ui.card().classes("large"):
            button("", self.dialog.close, "close", "flat dense round", label="close").classes("ml-auto")
            self.large = ui.html("", sanitize=False).classes("w-full").props('data-at="large drawing"')
        bench.on_change(lambda _origin: self.follow())
        self.follow()

    def enlarge(self) -> None:
        """Show the drawing as large as the window."""
        self.large.set_content(self.drawing.content)
        self.dialog.open()

    def follow(self) -> None:
        """Show the drawing now, and ask for the facts."""
        machine = self.bench.reading.machine
        if machine is None:
            # what is under way is outdated; a drawing on its way is that of the last possible machine
            self.latest.number += 1
            self.busy.set_visibility(False)
            self.facts.classes(remove="old")
            message = escape(self.bench.reading.message)
            if not self.bench.begun:
                self.drawing.classes(add="old")
                self.facts.set_content(f'<div class="wrong">{message}</div>')
                return
            self.facts.set_content(f'<div class="quiet">{INCOMPLETE_TEXT}</div><div class="quiet told">{message}</div>')
            begun = drawable(self.bench.text)
            if begun is None:
                self.pencil.number += 1
                self.drawing.set_content(NEUTRAL)
                self.drawing.classes(remove="old")
            else:
                self.pencil.start(partial(_answer_or_fault, _drawing, begun), partial(self._put, self.drawing))
            return
        self.busy.set_visibility(True)
        for shown in (self.drawing, self.facts):
            shown.classes(add="old")  # until the new one is there
        self.pencil.start(partial(_answer_or_fault, _drawing, machine), partial(self._put, self.drawing))
        self.latest.start(partial(_answer_or_fault, _facts, machine), partial(self._put, self.facts))

    def _put(self, target: Any, content: str) -> None:
        possible = self.bench.reading.machine is not None or (target is self.drawing and self.bench.begun)
        if target.is_deleted or (target is self.facts and not possible):
            return
        with target:
            target.set_content(content)
            if possible:
                target.classes(remove="old")
            if target is self.facts:
                self.busy.set_visibility(False)


def _answer_or_fault(ask: Callable[[Any], str], machine: Any) -> str:
    """An answer, or what is wrong."""
    try:
        with unwarned():  # the facts have them as notes
            return ask(machine)
    except AutobalancerError as error:
        return f'<div class="wrong">{escape(str(error))}</div>'


@lru_cache(AGAIN)
def _drawing(machine: Any) -> str:
    return svg_of(
        lambda: machine_picture(machine, title=""), f"Drawing of {machine.name}: from the side and from above"
    )


@lru_cache(AGAIN)
def _facts(machine: Any) -> str:
    return facts_html(check(machine))


def facts_html(found: Any) -> str:
    """Rows and notes of what is known."""
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td>{escape(for_page(text))}</td></tr>" for name, text in found.rows(rpm_and_si)
    )
    notes = "".join(f'<div class="note">{escape(for_page(text))}</div>' for text in found.warnings)
    return f'<table class="facts">{rows}</table>{notes}'
