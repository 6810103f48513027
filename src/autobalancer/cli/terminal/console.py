"""The terminal, on which names are data: no markup, no emoji codes, no orders to the terminal."""

from __future__ import annotations

from typing import Any

import rich.console
from rich.text import Text

from autobalancer.shown import printable


class Console(rich.console.Console):
    """As that of rich, but square brackets and colons in a text are shown as they are."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(markup=False, emoji=False, **settings)

    def render_str(self, text: str, **settings: Any) -> Text:
        """A text of a table or a line."""
        return super().render_str(printable(text), **settings)

    def note(self, text: object) -> None:
        """A remark that stands out."""
        self.print(Text.assemble(("note:", "yellow"), f" {printable(text)}"))
