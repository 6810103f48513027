"""Entries of the forms of studies and designs: each shows what stands at a key of the text, and changes it there."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from nicegui import ui

from autobalancer.app.pages.hint import hinted, marked
from autobalancer.app.pages.typed import Typed
from autobalancer.app.text.document import Path, data_of, value_at, with_value, without
from autobalancer.app.text.spread import as_entry, shown

FOCUS = """let left = 60;
const go = () => {{
  const marked = [...document.querySelectorAll("[data-at]")].find((one) => one.dataset.at === {place});
  const wanted = marked?.tabIndex >= 0 ? marked : marked?.querySelector("input");
  if (wanted && document.activeElement === document.body) wanted.focus();
  else if (left--) requestAnimationFrame(go);
}};
requestAnimationFrame(go);"""  # once the entry that had the focus is gone; whoever is elsewhere by then stays there
NONE = "none that is possible here"
LOOK = "dense outlined stack-label debounce=350"


class Entries:
    """Puts entries on the page; ``shown`` are those that can carry an error, by their key."""

    def __init__(self, draft: Typed) -> None:
        self.draft = draft
        self.shown: dict[str, Any] = {}

    def put(self, path: Path, value: Any, origin: object | None = None) -> None:
        """Write a value to the text; without one the key goes."""

        def change(text: str) -> str:
            there = value_at(data_of(text), path) is not None
            if value is None or value == "":
                return without(text, path) if there else text
            return with_value(text, path, value)

        with contextlib.suppress(ValueError, KeyError, TypeError):  # the text is no TOML; its editor says so
            self.draft.edit(change, self if origin is None else origin)

    def line(self, label: str, path: Path, help_: str, hint: str = "", made: Callable[[str], Any] = as_entry) -> Any:
        """A number, a quantity with its unit, or a text."""
        box = ui.input(label, value=shown(value_at(data_of(self.draft.text), path)), placeholder=hint).props(LOOK)
        box.on_value_change(lambda event: self.put(path, made(event.value or "")))
        return self.known(box, path, help_)

    def choice(self, label: str, path: Path, choices: Mapping[str, str], default: str, help_: str) -> Any:
        """One of several words; the default is not written."""
        value = value_at(data_of(self.draft.text), path)
        box = ui.select(dict(choices), value=value if value in choices else default, label=label)
        box.on_value_change(lambda event: self.put(path, None if event.value == default else event.value))
        return self.known(box.props("dense outlined options-dense"), path, help_)

    def several(self, label: str, path: Path, choices: Sequence[str], default: Sequence[str], help_: str) -> Any:
        """Some of several words."""
        value = value_at(data_of(self.draft.text), path)
        given = [value] if isinstance(value, str) else value if isinstance(value, list) else list(default)
        box = ui.select(list(choices), value=[one for one in given if one in choices], label=label, multiple=True)
        box.on_value_change(lambda event: self.put(path, list(event.value) if list(event.value) != default else None))
        return self.known(box.props("dense outlined options-dense use-chips"), path, help_)

    def known(self, box: Any, path: Path, help_: str) -> Any:
        """An entry with its help, its name for tests, and a place for its error."""
        key = ".".join(map(str, path))
        self.shown[key] = box
        marked(box.classes("field").without_auto_validation(), at=key, about=help_)
        hinted(box, help_)
        return box

    def focus(self, place: str) -> None:
        """Give the focus, which a form that is made anew loses, to the entry with this mark."""
        ui.run_javascript(FOCUS.format(place=json.dumps(place)))

    def mark(self, key: str, message: str) -> None:
        """Put a message beside the entry of a key, or of the table in which it is."""
        for box in self.shown.values():
            box.error = None
        near = key
        while near and near not in self.shown:
            near = near.rpartition(".")[0]
        if near:
            self.shown[near].error = message.removeprefix(f"{key}: ")
