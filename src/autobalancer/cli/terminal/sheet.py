"""A table of an answer: printed within the width of the screen without breaking a number, or as CSV with units."""

from __future__ import annotations

import csv
import io
import math
import re
import textwrap
from collections.abc import Sequence
from contextvars import ContextVar
from dataclasses import replace
from typing import Any

from autobalancer.tables import NUMBER, Column, printable, speeds_in

LEAST = 18  # letters of a text that may be broken between words
BESIDE = ("95 % ", "+-")  # how heads begin of what belongs to the number before: an interval, a quantile, a deviation
EDGE, GAP = 1, 2  # blanks at the ends of a line and between columns


def _told_apart(columns: Sequence[Column]) -> list[Column]:
    """Columns whose heads differ: what belongs to the number before says so, ``balanced, 95 % from``, and has its unit."""
    found: list[Column] = []
    number = Column("", ())
    for column in columns:
        if column.head.startswith(BESIDE) or column.head in {one.head for one in found}:
            found.append(replace(column, head=f"{number.head}, {column.head}", unit=column.unit or number.unit))
        else:
            found.append(number := column)
    return found


def sheet_si(columns: Sequence[Column]) -> dict[str, list[Any]]:
    """Values of each column by its head, in SI, for JSON."""
    from autobalancer.results.answers.answer import FACTORS
    from autobalancer.results.display_units import SHOWN, SPEED_UNITS, AxisUnit

    units = {sign: AxisUnit(sign, factor) for sign, factor in FACTORS.items()}
    units |= {unit.sign: unit for unit in (*SHOWN.values(), *SPEED_UNITS.values())}
    found = {}
    for column in _told_apart(columns):
        unit = units.get(column.unit, AxisUnit(column.unit, 1.0))
        found[column.head] = [value if isinstance(value, (str, int)) else unit.in_si(value) for value in column.values]
    return found


def sheet_csv(columns: Sequence[Column]) -> str:
    """Comma-separated values whose first line names the columns with their units: ``speed [rpm],angle [deg]``."""
    columns = _told_apart(columns)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([f"{column.head} [{column.unit}]" if column.unit else column.head for column in columns])
    table.writerows(zip(*([_plain(value) for value in column.values] for column in columns), strict=True))
    return text.getvalue()


def print_sheet(columns: Sequence[Column], title: str = "") -> None:
    """Print it; columns that do not fit beside the first ones follow below, with the first column again."""
    from rich.text import Text

    from autobalancer.cli.terminal.progress_bar import Console

    console = Console(highlight=False)
    if title:
        console.print(Text(printable(title), style="bold"))
    for block in _blocks(columns, console.width):
        console.print(_table(block))


def print_facts(rows: Sequence[tuple[str, str]], title: str = "") -> None:
    """Print what there is to say of one thing, a name and a text in each row; texts are broken between words."""
    from rich import box
    from rich.table import Table
    from rich.text import Text

    from autobalancer.cli.terminal.progress_bar import Console

    table = Table(show_header=False, box=box.SIMPLE_HEAD, padding=(0, 2, 0, 0))
    table.add_column(style="bold", no_wrap=True)
    table.add_column()
    for name, text in rows:
        table.add_row(Text(printable(name)), Text(printable(in_speed_unit(text))))
    console = Console(highlight=False)
    if title:
        console.print(Text(printable(title), style="bold"))
    console.print(table)


def _blocks(columns: Sequence[Column], width: int) -> list[list[tuple[Column, int]]]:
    """Columns with their widths, as many beside one another as there is room for."""
    first = (columns[0], min(_width(columns[0]), width - 2 * EDGE))
    blocks = [[first]]
    for column in columns[1:]:
        wanted = _width(column)
        least = max(_word(column), min(wanted, LEAST)) if column.wraps else wanted
        room = width - _width_used(blocks[-1])
        if room < least:
            blocks.append([first])
            room = width - _width_used(blocks[-1])
        blocks[-1].append((column, min(wanted, room)))
    return blocks


def _width_used(block: list[tuple[Column, int]]) -> int:
    """Letters of a line that are taken, with the gap to the next column."""
    return 2 * EDGE + sum(width + GAP for _, width in block)


def _width(column: Column) -> int:
    """Letters that the longest cell needs, and the longest word of the head."""
    return max(
        map(len, (*column.head.split(), column.unit, *(line for cell in column.cells() for line in cell.split("\n"))))
    )


def _word(column: Column) -> int:
    """The longest word, which is not broken."""
    return max(
        map(len, (*column.head.split(), column.unit, *(word for cell in column.cells() for word in cell.split())))
    )


def _table(block: list[tuple[Column, int]]) -> Any:
    from rich import box
    from rich.table import Table
    from rich.text import Text

    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0))
    for column, width in block:
        lines = textwrap.wrap(column.head, width, break_long_words=False, break_on_hyphens=False)
        head = Text("\n".join([*lines, column.unit] if column.unit else lines))
        side: Any = "right" if column.numeric else "left"
        table.add_column(head, justify=side, no_wrap=not column.wraps, overflow="fold", width=width, vertical="top")
    for row in zip(*(column.cells() for column, _ in block), strict=True):
        table.add_row(*map(Text, row))
    return table


def _plain(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, (str, bool, int)):
        return str(value)
    number = float(value)
    return "" if math.isnan(number) else f"{number:.10g}"


# Numbers as people read them, in the speed unit that the command was asked for, and lines that fit the screen.


_BOTH = re.compile(rf"{NUMBER} rpm \((?P<si>{NUMBER}) rad/s\)")
_UNBROKEN: dict[str, Any] = {"break_long_words": False, "break_on_hyphens": False}
_SPEED_UNIT: ContextVar[str] = ContextVar("speed_unit", default="rpm")


def use_speed_unit(unit: str) -> str:
    """Remember the --speed-unit of the command that runs; every text of a speed follows it."""
    _SPEED_UNIT.set(str(unit))
    return unit


def speed_number(speed: float, form: str = ".5g") -> str:
    """``"1200"``, in the unit of :func:`speed_sign`."""
    from autobalancer.results.display_units import speed_axis

    return format(speed * speed_axis(_SPEED_UNIT.get()).factor, form)


def speed_sign() -> str:
    """``"rpm"``."""
    return _SPEED_UNIT.get()


def speed_text(speed: float, form: str = ".5g") -> str:
    """``"1200 rpm"``; *none* for nan and *never* for infinity, as border speeds mean them."""
    if math.isnan(speed):
        return "none"
    return "never" if math.isinf(speed) else f"{speed_number(speed, form)} {speed_sign()}"


def in_speed_unit(text: str) -> str:
    """A sentence of the package, which has its speeds in rad/s, with these in the unit of :func:`speed_sign`."""
    from autobalancer.results.display_units import speed_axis

    text = _BOTH.sub(lambda found: speed_text(float(found["si"])), text)
    return text if speed_sign() == "rad/s" else speeds_in(text, speed_axis(speed_sign()).factor, speed_sign())


def print_sentences(text: str, indent: str = "", first: str = "") -> None:
    """Print sentences, broken between words where the screen ends, the further lines of each with an ``indent``."""
    import textwrap

    import typer

    from autobalancer.cli.terminal.progress_bar import Console
    from autobalancer.tables import printable

    for line in printable(in_speed_unit(text)).splitlines() or [""]:
        width = max(Console().width, 40)
        whole = textwrap.wrap(line, width, initial_indent=first, subsequent_indent=indent, **_UNBROKEN)
        typer.echo("\n".join(whole))


def note(text: str) -> None:
    """Print a note that the reader must not miss."""
    print_sentences(f"note: {text}", indent="  ")
