"""Texts of others on the terminal, where square brackets are markup."""

from __future__ import annotations

from autobalancer.shown import printable


def plain(text: object) -> str:
    """The text for ``rich``, which takes square brackets for markup."""
    from rich.markup import escape

    return escape(printable(text))
