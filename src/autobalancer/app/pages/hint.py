"""The help that comes when the mouse rests on something."""

from __future__ import annotations

from typing import Any

from nicegui import ui


def hinted(element: Any, text: str) -> Any:
    """Give an element of the page its help; the element comes back.

    The help is put within the element. NiceGUI's own ``tooltip`` looks for the element in what is shown, and does not find what
    is made while another part of the page is in front.
    """
    with element:
        ui.tooltip(text)
    return element
