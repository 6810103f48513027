"""The help that comes when the mouse rests on something, and the names of elements."""

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


def marked(element: Any, *, at: str = "", label: str = "", about: str = "") -> Any:
    """Give an element of the page the mark by which tests find it, its name and its description for those who do not see it.

    They are set as data. NiceGUI's own ``props`` reads a text as code: what a user has named must never come into it.
    """
    for key, text in (("data-at", at), ("aria-label", label), ("aria-description", about)):
        if text:
            element.props[key] = text
    return element
