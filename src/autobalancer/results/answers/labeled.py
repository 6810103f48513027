"""Any labeled result as its single numbers, a table along its main dimension, and the ranges of all other values."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import numpy as np
import xarray as xr

from autobalancer.results.answers.answer import WIDTH, Answer
from autobalancer.results.display_units import AxisUnit, axis_unit, length_axis
from autobalancer.results.number_text import length_text, moment_text
from autobalancer.shown import Column, rpm_and_si

TEXTS: dict[str, Callable[[float], str]] = {"m": length_text, "kg m": moment_text, "rad/s": rpm_and_si}  # by unit
ABOUT = {  # attributes that are numbers of the answer, with their units
    "speed": "rad/s",
    "exact_border": "rad/s",
    "exact_border_deviation": "rad/s",
    "gain_margin": "1",
    "phase_margin": "rad",
    "fit_error": "1",
    "spin_up_time": "s",
    "greatest_lag": "rad/s",
    "gap": "m",
    "scatter": "",
}
SOURCE = ("machine_name", "outcome", "outcome_text", "source")  # of a run
MOST = 8  # facts of the values
READ = 10_000_000  # values; of more only the sizes are said, because they may have to be read from a disk
L = TypeVar("L", bound="Labeled")


class Labeled(Answer):
    """A result without a table of its own."""

    __slots__ = ()
    most = 8

    @classmethod
    def of_run(cls: type[L], run: xr.Dataset, title: str, found: xr.Dataset) -> L:
        """What was found of a run; it says of which one."""
        name = run.attrs.get("machine_name", "")
        own = {key: run.attrs[key] for key in SOURCE if key in run.attrs}
        return cls(found.data_vars, found.coords, {"title": f"{title} of {name}" if name else title, **own})

    def has_table(self) -> bool:
        """There must be something to show."""
        return bool(self.data_vars)

    def facts(self) -> list[tuple[str, str]]:
        """Numbers, and the least and greatest values of what is not in the table."""
        told = [
            (_words(name), _text(float(self.attrs[name]), unit)) for name, unit in ABOUT.items() if name in self.attrs
        ]
        along, ranges = self._along(), []
        for name, entry in self.data_vars.items():
            if entry.dims != (along,):
                ranges += [(_words(str(name)), text) for text in _range(entry)]
        return [*told, *ranges[:MOST]]

    def columns(self, unit: str = "") -> list[Column]:
        """Values along the main dimension, as many as stand side by side."""
        along = self._along()
        names = [str(name) for name in (*self.coords, *self.data_vars) if self[name].dims == (along,)]
        length = _length([self[name] for name in names])
        columns: list[Column] = []
        for name in sorted(names, key=lambda name: name != along):
            columns.append(_column(name, self[name], unit or self.shown_in, length))
            if sum(2 + _width(column) for column in columns) > WIDTH and len(columns) > 1:
                return columns[:-1]
        return columns

    def remarks(self) -> Sequence[str]:
        """What was left out, and what to be careful about."""
        return [*super().remarks(), *(line for line in str(self.attrs.get("warnings", "")).split("\n") if line)]

    def _along(self) -> str:
        """The dimension that most variables have alone; of several the longest."""
        counts = {str(dim): 0 for dim in self.dims}
        for entry in self.data_vars.values():
            if len(entry.dims) == 1:
                counts[str(entry.dims[0])] += 1
        return max(counts, key=lambda dim: (counts[dim], self.sizes[dim]), default="") if any(counts.values()) else ""


def _words(name: str) -> str:
    return name.replace("_", " ")


def _text(value: float, unit: str) -> str:
    written = TEXTS.get(unit)
    if np.isnan(value):
        return "-"
    if written is not None:
        return written(value)
    shown = axis_unit(xr.DataArray(value, attrs={"units": unit}), "rpm")
    return f"{shown.shown(value):.5g} {shown.sign}".rstrip()


def _range(entry: xr.DataArray) -> Iterator[str]:
    """The one value, or the least and greatest one; of texts nothing but one that stands alone."""
    over = f" over {', '.join(f'{dim} ({size})' for dim, size in entry.sizes.items())}" if entry.dims else ""
    if entry.dtype.kind not in "biuf":
        if not over:
            yield str(entry.values)
    elif entry.size <= READ:
        values = np.asarray(entry.values, np.float64)
        known = values[np.isfinite(values)]
        ends = sorted({float(known.min()), float(known.max())}) if known.size else [np.nan]
        unit = _unit(entry, "rpm")
        texts = [_text(ends[0], str(entry.attrs.get("units", "")))] if len(ends) == 1 else _shown(ends, unit)
        yield " to ".join(texts) + over


def _shown(ends: Sequence[float], unit: AxisUnit) -> list[str]:
    first, last = (f"{unit.shown(end):.4g}" for end in ends)
    return [first, f"{last} {unit.sign}".rstrip()]


def _length(entries: Sequence[xr.DataArray]) -> AxisUnit:
    """One unit for all lengths that stand beside each other."""
    sizes = [np.abs(e.values[np.isfinite(e.values)]) for e in entries if e.attrs.get("units") == "m" and e.size <= READ]
    return length_axis(None, max((float(size.max(initial=0.0)) for size in sizes), default=0.0) or 1.0)


def _unit(entry: xr.DataArray, speed: str, length: AxisUnit | None = None) -> AxisUnit:
    if entry.attrs.get("units") == "m":
        return length or _length([entry])
    return axis_unit(entry, "Hz" if "frequency" in str(entry.name) else speed)


def _column(name: str, entry: xr.DataArray, speed: str, length: AxisUnit) -> Column:
    if entry.dtype.kind not in "iuf":
        return Column(_words(name), [str(value) for value in entry.values], wraps=True)
    unit = _unit(entry, speed, length)
    whole = entry.dtype.kind in "iu" and unit.factor == 1.0
    return Column(_words(name), entry.values.tolist() if whole else unit.shown(entry.values), unit.sign)


def _width(column: Column) -> int:
    head = f"{column.head} ({column.unit})" if column.unit else column.head
    ends = (*column.values[:4], *column.values[-4:])
    return max(len(head), *(len(text) for text in Column("", ends, form=column.form).cells()), 0)
