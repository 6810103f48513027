"""The parts of the page: a click on a tab shows its part at once, in the browser; the server is only told."""

from __future__ import annotations

from typing import Any

from nicegui import ui

FIT = (  # texts of several lines that were made while another part was shown find their height now, as after an animation
    "document.querySelectorAll('.q-textarea--autogrow textarea').forEach("
    "(one) => one.dispatchEvent(new Event('animationend')))"
)


class Tabs(ui.tabs):
    """Tabs that do not wait for the server; ``panels`` are what they show."""

    LOOPBACK = False

    def __init__(self) -> None:
        super().__init__()
        self.panels: Any = None

    def show_in(self, panels: ui.tab_panels) -> None:
        """Let a click change ``panels``, which were made without tabs."""
        self.panels = panels
        self.set_value(panels.value)
        self.on(
            "update:model-value",
            js_handler=f"(name) => {{ [{self.id}, {panels.id}].forEach("
            "(id) => { mounted_app.elements[id].props['model-value'] = name; }); "
            f"Vue.nextTick(() => {FIT}); }}",
        )

    def go(self, name: str) -> None:
        """Show a part for a reason of the server's."""
        self.panels.props["model-value"] = name
        self.panels.update()  # the server does not know what the browser shows
        self.set_value(name)
