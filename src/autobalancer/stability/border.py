"""One border speed, whichever it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from autobalancer.assembly.terms import Theory, ignores, unknown
from autobalancer.files.machine_file import machine_text
from autobalancer.machine import Machine
from autobalancer.notebook import picture_html
from autobalancer.tables import Table, border_cell, rpm_and_si


@dataclass(frozen=True)
class Border:
    """One border speed: ``speed`` in rad/s, infinite for never, nan where there is none; ``note`` says why.

    Not ``known`` is one that is not computed for such a machine; its speed is nan, too. Where balls can balance at many
    positions, ``speed`` is that of the worst of them and ``best`` (rad/s) that of the best; else ``best`` is nan. ``windows``
    (rad/s) are ranges below ``speed`` in which it is stable, too.
    """

    name: str
    speed: float
    note: str
    known: bool = True
    best: float = math.nan
    windows: tuple[tuple[float, float], ...] = ()

    def __repr__(self) -> str:
        return f"{self.name}: {self.text(rpm_and_si)}{f'; {self.note}' if self.note else ''}"

    @property
    def only_some(self) -> bool:
        """Whether some positions of the balls are stable from a speed on, and others never."""
        return math.isinf(self.speed) and math.isfinite(self.best)

    def text(self, speed_text: Callable[[float], str]) -> str:
        """The speed, or that there is none, or of which positions of the balls, in words."""
        if not self.known:
            return "not known"
        if self.only_some:
            return f"from {speed_text(self.best)} at the best positions of the balls, never at all positions"
        if math.isinf(self.speed) and self.windows:
            return f"stable {self.ranges(speed_text)} only"
        return "never" if math.isinf(self.speed) else speed_text(self.speed)

    def ranges(self, speed_text: Callable[[float], str]) -> str:
        """The ranges below it in words."""
        return ", ".join(f"{speed_text(low)} to {speed_text(high)}" for low, high in self.windows)

    def cell(self, factor: float) -> float | str | None:
        """What a column shows of it, in a unit of which ``factor`` are 1 rad/s."""
        if math.isinf(self.speed) and self.windows:
            return ", ".join(f"{low * factor:.5g} to {high * factor:.5g}" for low, high in self.windows)
        return border_cell(self.speed, factor, self.best)

    def noted(self, text: str) -> Border:
        """With something said before its note."""
        return replace(self, note="; ".join(filter(None, (text, self.note))))


def ignoring(machine: Machine, border: Border, theory: Theory) -> Border:
    """A border whose note names what its theory leaves out of this machine; one that is not known leaves out nothing."""
    left_out = "" if math.isnan(border.speed) else ignores(machine, theory)
    return replace(border, note="; ".join(filter(None, (border.note, left_out))))


def attributes(machine: Machine, title: str, theory: Theory) -> dict[str, Any]:
    """What every labeled answer about stability carries."""
    from autobalancer.results.answers.answer import provenance

    return {
        "title": title,
        **provenance(),
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "ignores": ", ".join(unknown(machine, theory)),
    }


class Borders(Table[Border]):
    """Border speeds of a machine, a tuple."""

    head = ("border", "rad/s", "rpm", "note")

    def row(self, entry: Border) -> tuple[str, ...]:
        """Name, speed and note."""
        cells = (entry.cell(factor) for factor in (1.0, 30.0 / math.pi))
        return (
            entry.name,
            *("-" if one is None else format(one, "" if isinstance(one, str) else ".6g") for one in cells),
            entry.note,
        )

    def _repr_html_(self) -> str:
        return super()._repr_html_() + picture_html(self, "border speeds, one below the other", "borders")
