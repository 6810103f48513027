"""One border speed, whichever it is."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from autobalancer.assembly.terms import Theory, ignores
from autobalancer.machine import Machine
from autobalancer.notebook import picture_html
from autobalancer.tables import Table, rpm_and_si, speed_cells


@dataclass(frozen=True)
class Border:
    """One border speed: ``speed`` in rad/s, infinite for never, nan where there is none; ``note`` says why.

    Not ``known`` is one that is not computed for such a machine; its speed is nan, too.
    """

    name: str
    speed: float
    note: str
    known: bool = True

    def __repr__(self) -> str:
        speed = rpm_and_si(self.speed) if self.known else "not known"
        return f"{self.name}: {speed}{f'; {self.note}' if self.note else ''}"


def ignoring(machine: Machine, border: Border, theory: Theory) -> Border:
    """A border whose note names what its theory leaves out of this machine; one that is not known leaves out nothing."""
    left_out = "" if math.isnan(border.speed) else ignores(machine, theory)
    return replace(border, note="; ".join(filter(None, (border.note, left_out))))


class Borders(Table[Border]):
    """Border speeds of a machine, a tuple."""

    head = ("border", "rad/s", "rpm", "note")

    def row(self, entry: Border) -> tuple[str, ...]:
        """Name, speed and note."""
        return (entry.name, *speed_cells(entry.speed), entry.note)

    def _repr_html_(self) -> str:
        return super()._repr_html_() + picture_html(self, "borders", "border speeds, one below the other")
