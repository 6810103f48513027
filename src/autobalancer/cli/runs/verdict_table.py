"""A verdict on the terminal and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

from autobalancer.cli.terminal.words import speed_number, speed_sign

if TYPE_CHECKING:
    from autobalancer.cli.terminal.console import Console
    from autobalancer.results.verdict.judged import Verdict

COLORS = {"balanced": "green", "partly balanced": "yellow", "no verdict": "yellow", "not settled yet": "yellow"}


def print_verdict(found: Verdict, console: Console) -> None:
    """The headline, a table that fits the terminal, and notes."""
    from rich.table import Table

    from autobalancer.results.verdict.text import verdict_lines

    head, rows, notes = verdict_lines(found, _speed)
    console.print(head, style=f"bold {COLORS.get(found.word, 'red')}", highlight=False)
    table = Table.grid(padding=(0, 2))
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    for label, text in rows:
        table.add_row(label, text)
    console.print(table, highlight=False)
    for note in notes:
        console.note(note)


def _speed(speed: float) -> str:
    from autobalancer.results.number_text import significant

    return f"{significant(float(speed_number(speed, '.10g')))} {speed_sign()}"
