"""Pictures for the page: Matplotlib's figures as SVG or PNG, one at a time, as Matplotlib is not made for several threads."""

from __future__ import annotations

import io
import re
from collections.abc import Callable
from html import escape
from typing import Any

from autobalancer.plots.drawing.style import DRAWING


def svg_of(draw: Callable[[], Any], about: str) -> str:
    """A figure as SVG for a page, with ``about`` for those who do not see it."""
    with DRAWING:
        buffer = io.StringIO()
        draw().savefig(buffer, format="svg")
    text = buffer.getvalue()
    words = escape(about, quote=True)
    fluid = f'<svg role="img" aria-label="{words}" class="drawn" '
    body = text[text.index("<svg ") + 5 :]
    head, rest = body.split(">", 1)
    return fluid + re.sub(r'\b(width|height)="[^"]*"', "", head) + ">" + rest


def file_of(draw: Callable[[], Any], kind: str) -> bytes:
    """A figure as the bytes of a PNG, SVG or PDF file."""
    with DRAWING:
        buffer = io.BytesIO()
        draw().savefig(buffer, format=kind, dpi=150)
    return buffer.getvalue()
