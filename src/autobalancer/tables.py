"""Results that show themselves: as lines of text, and as a table in a notebook."""

from __future__ import annotations

import math
import re
import textwrap
import unicodedata
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from html import escape
from typing import Any, TypeVar

T = TypeVar("T")
NUMBER = r"\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_SPEEDS = re.compile(rf"(?<!rpm \()(?<![\d.])(?P<numbers>(?:{NUMBER}(?:, | to | and ))*{NUMBER}) rad/s(?![\^²/])")
STEERING = ("Cc", "Zl", "Zp", "Cs")  # Unicode categories of what a terminal obeys or cannot show


def printable(text: object) -> str:
    """The text with control characters other than line ends written out, such as ``\\\\x1b``."""
    return "".join(
        sign if sign == "\n" or unicodedata.category(sign) not in STEERING else f"\\x{ord(sign):02x}"
        for sign in str(text)
    )


@dataclass(frozen=True)
class Column:
    """Values of one column; ``wraps`` where they are texts that may be broken between words, ``once`` if not said again below."""

    head: str
    values: Any  # a sequence or an array
    unit: str = ""
    form: str = ".5g"
    wraps: bool = False
    once: bool = False

    def cells(self) -> list[str]:
        """The values as they are shown; what is not known is a dash."""
        cells = [_cell(value, self.form, self.unit) for value in self.values]
        if not self.once:
            return cells
        return ["" if k and cell == cells[k - 1] else cell for k, cell in enumerate(cells)]

    @property
    def numeric(self) -> bool:
        """Whether it stands at the right."""
        return not any(isinstance(value, str) for value in self.values)


def rounded(number: float, form: str, unit: str = "") -> str:
    """A number in a form, without the sign of a zero; 359.98 deg with one digit less is 0.0 deg."""
    text = format(number, form)
    if unit == "deg" and number < 360.0 and float(text) == 360.0:
        number, text = 0.0, format(0.0, form)
    return text.removeprefix("-") if math.isfinite(number) and float(text.rstrip("%")) == 0.0 else text


def whole_degrees(angle: float) -> str:
    """A direction (rad) in whole degrees, 0 to 359."""
    return rounded(math.degrees(angle) % 360.0, ".0f", "deg")


def _cell(value: Any, form: str, unit: str) -> str:
    if value is None:
        return "-"
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        return printable(value)
    number = float(value)
    if math.isnan(number):
        return "-"
    return str(value) if isinstance(value, int) else rounded(number, form, unit)


def text_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Columns of text, two blanks apart."""
    whole = [list(head), *map(list, rows)]
    widths = [max(len(row[k]) for row in whole) for k in range(len(head))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in whole
    )


def html_table(head: Sequence[str], rows: Sequence[Sequence[str]], title: str = "") -> str:
    """The same for a notebook."""
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    above = f"<b>{escape(title)}</b>" if title else ""
    return f"{above}<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


SOME = "some positions"  # of the balls are stable, others never


def border_cell(speed: float, factor: float = 1.0, best: float = math.nan) -> float | str | None:
    """What a column shows of a border speed: *never* is a statement, too.

    *some positions* (of the balls) if that is so of the worst of them alone, while the best has the border ``best``.
    """
    if math.isnan(speed):
        return None
    if math.isinf(speed):
        return SOME if math.isfinite(best) else "never"
    return float(f"{speed * factor:.10g}")


def rpm_and_si(speed: float) -> str:
    """``297.8 rpm (31.18 rad/s)``; *none* for nan and *never* for infinity, as border speeds mean them."""
    if not math.isfinite(speed):
        return "none" if math.isnan(speed) else "never"
    return f"{speed * 30.0 / math.pi:.5g} rpm ({speed:.5g} rad/s)"


def speeds_in(text: str, factor: float, sign: str) -> str:
    """A sentence whose speeds are in rad/s, with these in another unit; those in brackets behind rpm stay as they are."""

    def shown(found: re.Match[str]) -> str:
        numbers = re.sub(NUMBER, lambda number: format(float(number[0]) * factor, ".4g"), found["numbers"])
        return f"{numbers} {sign}"

    return _SPEEDS.sub(shown, text)


def facts_text(rows: Sequence[tuple[str, str]], width: int = 100) -> str:
    """Names and texts; long texts are broken between words."""
    edge = max(len(name) for name, _ in rows) + 2
    lines = []
    for name, text in rows:
        broken = [piece for line in text.splitlines() for piece in textwrap.wrap(line, width - edge) or [""]]
        lines += [
            f"{head:<{edge}}{piece}".rstrip() for head, piece in zip([name, *[""] * len(broken)], broken, strict=False)
        ]
    return "\n".join(lines)


def in_plain_letters(text: str) -> str:
    """A text without the marks of formulas and code: ``$w_c = \\sqrt{k/M}$`` as ``w_c = sqrt(k/M)``."""
    brackets = str.maketrans({"{": "(", "}": ")", "\\": None, "`": None})
    return re.sub(r"\$(.+?)\$", lambda found: found[1].replace("\\,", " ").translate(brackets), text).replace("`", "")


class Described:
    """What is known of one thing: shows itself as its name, its rows and its warnings."""

    name: str
    warnings: tuple[str, ...]

    def rows(self, said: Callable[[float], str]) -> list[tuple[str, str]]:
        """A name and a text each, with speeds as ``said`` writes them."""
        raise NotImplementedError

    def as_dict(self) -> dict[str, Any]:
        """Plain numbers and texts, e.g. for JSON."""
        return asdict(self)  # type: ignore[call-overload, no-any-return]  # each is a dataclass

    def _noted(self) -> list[tuple[str, str]]:
        return self.rows(rpm_and_si) + [("note", text) for text in self.warnings]

    def __repr__(self) -> str:
        return f"{self.name}\n{facts_text(self._noted())}"

    def _repr_html_(self) -> str:
        return html_table(("", ""), self._noted(), self.name)


class Table(tuple[T, ...]):
    """A tuple that shows itself as a table; ``head`` and ``row`` say how."""

    head: tuple[str, ...] = ()
    most = 24  # rows that are shown

    def row(self, entry: T) -> tuple[str, ...]:
        """The cells of an entry."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return "\n".join((text_table(self.head, self._rows()), *self._rest())) if self else "()"

    def _repr_html_(self) -> str:
        return html_table(self.head, self._rows()) + "".join(f"<p>{text}</p>" for text in self._rest())

    def _rows(self) -> list[tuple[str, ...]]:
        return [self.row(entry) for entry in self[: self.most]]

    def _rest(self) -> tuple[str, ...]:
        return (f"... and {len(self) - self.most} more",) if len(self) > self.most else ()
