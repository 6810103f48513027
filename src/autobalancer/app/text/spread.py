"""What varies in the text of a study, as rows of a form: values or a distribution, each entry as a person writes it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from autobalancer.app.text.document import Path, data_of, with_value, without
from autobalancer.app.text.fields import PLAIN, in_unit, number_and_unit
from autobalancer.app.text.numbers import USUAL, Number, numbers_of
from autobalancer.assembly.quantities import value_of
from autobalancer.errors import AutobalancerError
from autobalancer.machine import Machine
from autobalancer.machine.plain_names import QUANTITIES, named_unit, text_of
from autobalancer.studies.study.distributions import KINDS

VALUES = "values"
WORDS = {
    VALUES: "values",
    "normal": "normal",
    "uniform": "uniform",
    "log-normal": "log-normal",
    "triangular": "triangular",
    "tolerance": "tolerance",
    "discrete": "one of several",
}
SHOWN = {  # entries of each kind in the form, and what stands where nothing is given
    VALUES: (VALUES,),
    "normal": ("mean", "standard_deviation", "low", "high"),
    "uniform": ("low", "high"),
    "log-normal": ("median", "factor"),
    "triangular": ("low", "mode", "high"),
    "tolerance": ("nominal", "plus_minus", "plus", "minus", "shape"),
    "discrete": (VALUES, "weights"),
}
MIDDLES = ("mean", "median", "mode", "nominal")


@dataclass(frozen=True)
class Row:
    """One parameter that varies."""

    name: str
    at: Path  # in the tables of the study
    kind: str
    label: str
    entries: dict[str, str]  # as they are written


def rows_of(text: str) -> list[Row]:
    """All that varies, in the order of the text."""
    data = data_of(text) or {}
    vary = data.get("vary")
    return [_row(at, given) for at, given in _spread(vary if isinstance(vary, dict) else {}, ("vary",))]


def offered(text: str, machine: Machine) -> dict[str, Number]:
    """What of a machine may vary, by its name: quantities such as the viscosity, then all its numbers."""
    found = {}
    for name in QUANTITIES:
        try:
            value = value_of(machine, name)
        except AutobalancerError:
            continue
        if math.isfinite(value):
            unit = named_unit(name)
            usual = "degC" if unit == "K" else USUAL.get(unit, unit)
            number = f"{float(in_unit(f'{value:.12g}', unit, usual, unit)):.6g}"
            found[name] = Number(name, text_of(name), value, number, usual, True)
    return found | {one.path: one for one in numbers_of(text, machine)}


def with_row(text: str, number: Number) -> str:
    """The text with one more parameter that varies, by 10 % to begin with."""
    return _spaced(with_value(text, ("vary", number.path), fresh("normal", number)))


def with_kind(text: str, row: Row, kind: str, number: Number | None) -> str:
    """The text with another distribution of a parameter; what both have stays."""
    known = fresh(kind, number)
    if kind != VALUES and isinstance(known, dict):
        for key in SHOWN[kind]:
            if row.entries.get(key) and key != VALUES:
                known[key] = as_entry(row.entries[key])
    return _spaced(with_value(text, row.at, known))


def with_entry(text: str, row: Row, key: str, given: str) -> str:
    """The text with another entry of a parameter; without it where nothing is given."""
    many = key in (VALUES, "weights")
    value = as_list(given) if many else as_entry(given)
    if row.kind == VALUES:
        return with_value(text, row.at, value)
    return with_value(text, (*row.at, key), value) if given.strip() else without(text, (*row.at, key))


def fresh(kind: str, number: Number | None) -> Any:
    """A distribution to begin with, about what the machine has."""
    unit = number.unit if number is not None else ""
    middle = float(number.number) if number is not None else 1.0
    away, width = (0.1 * abs(middle), "10 %") if middle else (1.0, f"1 {unit}".strip())
    if unit in ("degC", "degF", "K"):
        away, width = 10.0, "5 K"
    if unit == "deg":
        away, width = (180.0, "10 deg")
    low, high = (_written(middle + sign * away, unit) for sign in (-1.0, 1.0))
    several = [_written(middle + part * 3.0 * away, unit) for part in (-1.0, 0.0, 1.0)]
    if kind == VALUES:
        return several
    of = {
        "normal": {"standard_deviation": width},
        "uniform": {"low": low, "high": high},
        "log-normal": {"factor": 1.1},
        "triangular": {"low": low, "high": high},
        "tolerance": {"plus_minus": width},
        "discrete": {VALUES: several},
    }
    return {"distribution": kind, **of[kind]}


def as_entry(given: str) -> Any:
    """A number where no unit is written, else the text."""
    given = given.strip()
    return _number(given) if PLAIN.fullmatch(given) else given


def as_list(given: str) -> Any:
    """``5, 10, 20 mm^2/s`` as a list; a unit at the end is that of all; a range stays a text."""
    given = given.strip().removeprefix("[").removesuffix("]")
    if ":" in given:
        return given
    parts = [part.strip().strip('"') for part in given.split(",") if part.strip()]
    last = number_and_unit(parts[-1], "") if parts else None
    unit = last[1] if last else ""
    return [as_entry(f"{part} {unit}" if unit and PLAIN.fullmatch(part) else part) for part in parts]


def shown(value: Any) -> str:
    """An entry as a person writes it: of a list whose entries have one unit it stands at the end."""
    if value is None:
        return ""
    if not isinstance(value, list):
        return f"{value:.12g}" if isinstance(value, float) else str(value)
    found = [number_and_unit(one, "") for one in value]
    units = {one[1] for one in found if one is not None}
    if all(found) and len(units) == 1:
        return f"{', '.join(one[0] for one in found if one)} {units.pop()}".strip()
    return ", ".join(map(str, value))


def _spaced(text: str) -> str:
    """With an empty line above each table."""
    found = re.sub(r"(?m)^([^\n#\[][^\n]*\n)(?=\[)", r"\1\n", text)
    return found if data_of(found) == data_of(text) else text


def _spread(table: dict[str, Any], at: Path) -> Iterator[tuple[Path, Any]]:
    """Entries of 'vary', those of tables of the study as ``sudden_unbalance.angle``, too."""
    for name, given in table.items():
        if isinstance(given, dict) and not {"distribution", VALUES} & set(given) and given and _tables(given):
            yield from _spread(given, (*at, name))
        else:
            yield (*at, name), given


def _tables(given: dict[str, Any]) -> bool:
    return all(isinstance(value, (dict, list)) for value in given.values())


def _row(at: Path, given: Any) -> Row:
    name = ".".join(map(str, at[1:]))
    if not isinstance(given, dict):
        return Row(name, at, VALUES, _label(name), {VALUES: shown(given)})
    if "distribution" not in given:
        return Row(name, at, VALUES, _label(name), {VALUES: shown(given.get(VALUES))})
    kind = str(given["distribution"])
    entries = {key: shown(value) for key, value in given.items() if key != "distribution"}
    return Row(name, at, kind if kind in KINDS else "", _label(name), entries)


def _label(name: str) -> str:
    try:
        return text_of(name)
    except AutobalancerError:
        return name


def _written(value: float, unit: str) -> Any:
    number = f"{value:.6g}"
    return f"{number} {unit}" if unit else _number(number)


def _number(text: str) -> int | float:
    return int(text) if re.fullmatch(r"[-+]?\d+", text) else float(text)
