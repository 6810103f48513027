"""Tables and sentences of results as HTML."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from autobalancer.shown import Column


def table_html(columns: Sequence[Column], at: str = "", most: int = 200) -> str:
    """A table with numbers at the right; of a long one the first rows."""
    heads = [f"{column.head} ({column.unit})" if column.unit else column.head for column in columns]
    sides = [" class='number'" if column.numeric else "" for column in columns]
    rows = list(zip(*(column.cells() for column in columns), strict=True))
    top = "".join(f"<th{side}>{escape(head)}</th>" for head, side in zip(heads, sides, strict=True))
    body = "".join(
        "<tr>" + "".join(f"<td{side}>{escape(cell)}</td>" for cell, side in zip(row, sides, strict=True)) + "</tr>"
        for row in rows[:most]
    )
    more = f"<div class='quiet'>and {len(rows) - most} more rows</div>" if len(rows) > most else ""
    return f'<div class="wide-table"><table class="facts" data-at="{at}"><tr>{top}</tr>{body}</table></div>{more}'


def notes_html(texts: Sequence[str]) -> str:
    """Sentences below a table."""
    return "".join(f'<div class="quiet">{escape(text)}</div>' for text in texts)


def warnings_html(texts: Sequence[str]) -> str:
    """Notes that the package gave."""
    return "".join(f'<div class="note">{escape(text)}</div>' for text in texts)
