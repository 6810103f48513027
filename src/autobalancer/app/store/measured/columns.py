"""What the columns of a file mean: guessed from their heads, changed on the page, kept with the file."""

from __future__ import annotations

import re
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
import tomli_w

from autobalancer.errors import UnitError
from autobalancer.measurement.signals.form import DIRECTIONS, UNITS
from autobalancer.measurement.signals.formats import RawColumn, RawFile
from autobalancer.measurement.signals.unit_words import factor_to, quantity_of

OUT, TIME = "", "time"
QUANTITIES = {OUT: "leave out", TIME: TIME} | {name: name for name in UNITS}
CLOCKS = re.compile(r"(time|zeit|temps|tiempo|stamp|\bt\b|\bsec)", re.IGNORECASE)
WAY = re.compile(r"(?:^|[\s_.\-])([xyzXYZ])$|^[a-z]+([XYZ])$")


@dataclass
class Column:
    """One column of a file, and the channel that it becomes."""

    column: str
    name: str = ""
    quantity: str = OUT
    unit: str = ""
    place: str = ""
    direction: str = ""
    sensitivity: str = ""
    uncertainty: str = ""

    def described(self) -> dict[str, Any]:
        """As the reader of signals wants it."""
        given = {key: value.strip() for key, value in asdict(self).items() if key != "name" and value.strip()}
        if self.quantity == TIME:
            given = {key: given[key] for key in ("column", "quantity", "unit") if key in given}
        way = given.get("direction", "")
        return given | ({"direction": float(way)} if way and way not in DIRECTIONS and _is_number(way) else {})


@dataclass
class Reading:
    """How a file is read: its columns, and which part of it."""

    columns: list[Column] = field(default_factory=list)
    clock: str = ""  # what the file itself says of its time
    rate: str = ""
    resample: str = ""
    start: str = ""
    end: str = ""
    implausible: bool = False

    @staticmethod
    def of(data: dict[str, Any]) -> Reading:
        """From what was kept."""
        return Reading(**{**data, "columns": [Column(**one) for one in data.get("columns", [])]})

    def channels(self) -> dict[str, dict[str, Any]]:
        """The channels by name; columns that are left out are not among them."""
        used = [one for one in self.columns if one.quantity != OUT]
        return {one.name.strip() or one.column: one.described() for one in used}

    def arguments(self) -> dict[str, Any]:
        """Of the reader of signals."""
        texts = {key: getattr(self, key).strip() for key in ("rate", "resample", "start", "end")}
        return {key: text for key, text in texts.items() if text} | {"implausible": self.implausible}

    def toml(self) -> str:
        """The file that the command line takes with ``--channels``."""
        return tomli_w.dumps({"channels": self.channels()})


def guessed(raw: RawFile) -> Reading:
    """What the heads of the columns say; a column of which nothing is known is left out."""
    found = [_guess(name, column) for name, column in raw.columns.items()]
    if raw.time is None and raw.rate is None:
        clock = next((k for k, one in enumerate(found) if _is_clock(one, raw.columns[one.column])), None)
        if clock is not None:
            found[clock] = replace(found[clock], quantity=TIME, direction="", unit=found[clock].unit or "s")
    return Reading(found, _clock(raw))


def _clock(raw: RawFile) -> str:
    """What the file says of its time; empty if nothing."""
    if raw.time is not None and raw.time.size:
        return f"in the file, {raw.time[0]:.6g} s to {raw.time[-1]:.6g} s, {raw.time.size} samples"
    return "" if raw.rate is None else f"{raw.rate:.6g} samples a second, as the file says"


def _guess(name: str, column: RawColumn) -> Column:
    quantity = column.quantity or quantity_of(name, column.unit)
    way = WAY.search(name)
    direction = str(column.direction) or ((way[1] or way[2]).lower() if way else "")
    sure = quantity if quantity in UNITS else OUT
    return Column(name, name.replace(" ", "_"), sure, column.unit, column.place, direction if sure else "")


def _is_clock(one: Column, column: RawColumn) -> bool:
    """Whether a column is called like a time, or has its unit, and ascends."""
    try:
        seconds = bool(one.unit) and factor_to(one.unit, "s") > 0.0
    except UnitError:
        return False
    called = CLOCKS.search(one.column) is not None
    return (seconds or called) and column.values.size > 1 and bool((np.diff(column.values) > 0.0).all())


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
