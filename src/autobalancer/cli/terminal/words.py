"""Numbers as people read them, in the speed unit that the command was asked for, and lines that fit the screen."""

from __future__ import annotations

import math
import re
from contextvars import ContextVar
from typing import Any

from autobalancer.shown import NUMBER, speeds_in

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


def say(text: str, indent: str = "", first: str = "") -> None:
    """Print sentences, broken between words where the screen ends, the further lines of each with an ``indent``."""
    import textwrap

    import typer

    from autobalancer.cli.terminal.console import Console
    from autobalancer.shown import printable

    for line in printable(in_speed_unit(text)).splitlines() or [""]:
        width = max(Console().width, 40)
        whole = textwrap.wrap(line, width, initial_indent=first, subsequent_indent=indent, **_UNBROKEN)
        typer.echo("\n".join(whole))


def note(text: str) -> None:
    """Print a note that the reader must not miss."""
    say(f"note: {text}", indent="  ")
