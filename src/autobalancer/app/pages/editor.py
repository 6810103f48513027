"""The text of a file on the page: what is typed is told when the typing pauses."""

from __future__ import annotations

import contextlib
from typing import Any, Literal

from nicegui import ui

from autobalancer.app.pages.typed import Typed

PAUSE = 0.4  # s
LIGHT: Literal["githubLight"] = "githubLight"
NAMED = """(() => {
  document.querySelectorAll(".cm-content:not([aria-label])").forEach((one) =>
    one.setAttribute("aria-label", one.closest("[aria-label]")?.getAttribute("aria-label") || "text"));
  return document.body.classList.contains("body--dark");
})()"""
DARK: Literal["githubDark"] = "githubDark"


def toml_editor(of: Typed, dark: Any) -> Any:
    """Put an editor of a text on the page."""
    editor: Any = ui.codemirror(of.text, language="TOML", theme=LIGHT, line_wrapping=True, indent="  ")
    timer: dict[str, Any] = {}

    def later(event: Any) -> None:
        """Wait until the typing pauses, or somebody asks for the text."""
        of.typing = None
        if timer.get("now") is not None:
            timer["now"].cancel()
        if event.value == of.text:
            return
        of.typing = lambda: of.set_text(event.value or "", editor)
        timer["now"] = ui.timer(PAUSE, of.take, once=True)

    def follow(origin: object) -> None:
        if origin is not editor:
            editor.value = of.text

    editor.on_value_change(later)
    of.on_change(follow)

    def shade(now: bool | None) -> None:
        editor.theme = DARK if now else LIGHT

    async def as_browser() -> None:
        """Until somebody chooses, the page is as the browser is set."""
        with contextlib.suppress(TimeoutError):  # the page was closed
            shaded = await ui.run_javascript(NAMED)
            if dark.value is None:
                shade(shaded)

    shade(dark.value)
    dark.on_value_change(lambda _event: shade(dark.value))
    ui.timer(0.3, as_browser, once=True)
    return editor
