"""Nothing pressed on the page is lost in silence: the server confirms it, and the browser says what is not confirmed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nicegui import Client, core, ui

SCRIPT = Path(__file__).with_suffix(".js")


def confirm() -> None:
    """Let the server answer every event; once for all pages."""
    known = core.sio.handlers["/"]["event"]

    def taken(socket: str, told: dict[str, Any]) -> str:
        client = Client.instances.get(told["client_id"])
        if client is not None and told["id"] not in client.elements:
            return "gone"
        known(socket, told)
        return "taken"

    core.sio.on("event", taken)


def watch() -> None:
    """Put what waits for these answers onto a page."""
    ui.add_head_html(f"<script>{SCRIPT.read_text(encoding='utf-8')}</script>")
