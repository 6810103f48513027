"""Texts of others on the terminal: names are data, no markup and no orders to the terminal."""

from __future__ import annotations

import unicodedata

STEERING = ("Cc", "Zl", "Zp", "Cs")  # Unicode categories of what a terminal obeys or cannot show


def printable(text: object) -> str:
    """The text with control characters other than line ends written out, such as ``\\\\x1b``."""
    return "".join(
        sign if sign == "\n" or unicodedata.category(sign) not in STEERING else f"\\x{ord(sign):02x}"
        for sign in str(text)
    )


def plain(text: object) -> str:
    """The text for ``rich``, which takes square brackets for markup."""
    from rich.markup import escape

    return escape(printable(text))
