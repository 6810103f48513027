"""One entry of the form: a quantity with its unit, a choice, a switch, a text."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from typing import Any

import tomli_w
from nicegui import ui

from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.text.document import Path, spelled
from autobalancer.app.text.fields import Field, in_unit, number_and_unit, written
from autobalancer.app.text.numbers import USUAL
from autobalancer.catalog import fluids, materials

Changed = Callable[[Any], None]
SHORT = 6  # letters of a name that are seen beside a unit
LOOK = "dense outlined debounce=350"


def entry_of(field: Field, path: Path, value: Any, changed: Changed, dropped: Callable[[], None] | None) -> Any:
    """Put the entry on the page; gives what shows its error."""
    with_unit = field.kind == "quantity" and (value is None or number_and_unit(value, field.unit) is not None)
    long = field.name == "description" or value is None or (with_unit and len(field.name) > SHORT)
    with ui.row().classes("entry no-wrap" + (" wide" if long else "")):
        if with_unit:
            shown = _quantity(field, path, value, changed)
        elif field.kind == "choice":
            options = list(field.choices)
            shown = ui.select(options, value=value if value in options else None, label=field.name)
            shown.props("dense outlined options-dense").on_value_change(lambda event: changed(event.value))
        elif field.kind == "switch":
            shown = ui.select({True: "yes", False: "no"}, value=bool(value), label=field.name)
            shown.props("dense outlined options-dense").on_value_change(lambda event: changed(event.value))
        elif field.kind == "text" and isinstance(value, str | None) and _known(path):
            options = list(dict.fromkeys([*_known(path), *([value] if value else [])]))
            shown = ui.select(options, value=value or None, label=field.name, with_input=True, new_value_mode="add")
            shown.props("dense outlined options-dense").on_value_change(lambda event: changed(event.value or ""))
        elif field.kind == "text" and isinstance(value, str | None):
            shown = ui.input(field.name, value=value or "").props(
                LOOK + (" autogrow" if field.name == "description" else "")
            )
            shown.on_value_change(lambda event: changed(event.value or ""))
        else:
            shown = ui.input(field.name, value=_as_toml(value)).props(LOOK)
            shown.on_value_change(lambda event: changed(_from_toml(event.value or "")))
        marked(shown.classes("field").without_auto_validation(), at=spelled(path), about=field.help)
        hinted(shown, field.help)
        if value is None:
            shown.props["hint"] = field.meaning
        if dropped is not None:
            button = ui.button(icon="close", on_click=dropped).props("flat dense round size=xs color=grey tabindex=-1")
            marked(button.classes("drop"), label=f"remove {field.name}")
    return shown


def _quantity(field: Field, path: Path, value: Any, changed: Changed) -> Any:
    """A number and its unit; another unit keeps the quantity and changes the number."""
    number, unit = number_and_unit(value, field.unit) or ("", _usual(field, path))
    units = list(field.units) if unit in field.units else [*field.units, unit]
    entry = ui.input(field.name, value=number).props(f"{LOOK} inputmode=decimal")
    if units == [""]:
        entry.on_value_change(lambda event: changed(written(event.value or "", "", "") or ""))
        return entry
    choice = ui.select({one: one or "–" for one in units}, value=unit).props("dense outlined options-dense")
    marked(choice.classes("unit"), at=f"unit of {spelled(path)}", label=f"unit of {field.name}")
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


def say_refused(event: Any, what: str, ends: str, largest: int) -> None:
    """Say why the browser did not take a file: its kind or its size."""
    kind = "accept" in json.dumps(event.args, default=str)
    ui.notify(f"{what} ends in {ends}" if kind else f"{what} has at most {largest // 1_000_000} MB", type="negative")


def picker(options: Any, label: str, take: Callable[[str], Any], *, at: str) -> ui.select:
    """A list that one can search, whose choice is taken at once; its box shows none, so any can be taken once more."""

    def chosen(event: Any) -> None:
        if event.value:
            ui.timer(0.05, lambda: box.set_value(None), once=True)  # after what the browser does with the choice
            take(event.value)

    box = ui.select(options, label=label, with_input=True, on_change=chosen)
    box.props("dense outlined options-dense", remove="fill-input").style("width: 220px")
    marked(box, at=at)
    return box


def _usual(field: Field, path: Path) -> str:
    """The unit that most people take; balls and unbalances are weighed in grams."""
    small = field.unit == "kg" and path[0] in ("unbalances", "balancers")
    return "g" if small else (USUAL | {"K": "degC"}).get(field.unit, field.unit)


def _known(path: Path) -> list[str]:
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


def _from_toml(text: str) -> Any:
    """A list or number as TOML writes it, else a text."""
    try:
        return tomllib.loads(f"v = {text}")["v"]
    except (ValueError, RecursionError):
        return text
