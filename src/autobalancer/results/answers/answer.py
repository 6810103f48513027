"""Answers to questions: labeled arrays that show their main numbers, in Python, in notebooks and on the command line."""

from __future__ import annotations

import datetime
import math
import textwrap
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from html import escape
from importlib import import_module
from importlib.metadata import version
from itertools import zip_longest
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
import xarray as xr

from autobalancer.errors import ResultError
from autobalancer.notebook import picture_html
from autobalancer.results.display_units import AxisUnit, axis_unit, length_axis, length_text, moment_text, speed_axis
from autobalancer.tables import Column, facts_text, html_table, rpm_and_si, text_table

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]

A = TypeVar("A", bound="Answer")
MAKER = "autobalancer"

WIDTH = 100  # letters of a line
HEAD = 12  # letters of a column, at least, where heads are broken
DRAWN = 100_000_000  # bytes; what is larger is not drawn unasked
NAMED = 12  # variables that the last line lists
DEGREES = 180.0 / np.pi
THOUSANDTHS, MILLIONTHS = dict.fromkeys(("g", "mm", "mm/s"), 1e3), dict.fromkeys(("g mm", "µm"), 1e6)
FACTORS = {
    "%": 100.0,
    "kN": 1e-3,
    "deg": DEGREES,
    "°": DEGREES,
    **THOUSANDTHS,
    **MILLIONTHS,
}  # of units of columns, else one


def provenance() -> dict[str, str]:
    """Attributes that every result carries: the package with its version, and the moment."""
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
    return {"source": f"{MAKER} {version(MAKER)}", "created": now}


@dataclass(frozen=True)
class Shown:
    """A variable as a column: its head, the unit in which it is shown, its form.

    Without a unit rad/s is shown in the unit of speeds. ``bare`` says no unit, as beside another column; angles are counted
    within one ``turn``.
    """

    name: str
    head: str = ""
    unit: str = ""
    form: str = ".5g"
    bare: bool = False
    turn: float = 0.0


def sure(name: str, unit: str = "", bare: bool = False) -> Shown:
    """The standard deviation of the column before."""
    return Shown(f"{name}_deviation", "+-", unit, ".2g", bare)


@dataclass(frozen=True)
class Form:
    """How a kind of answer shows itself: by functions of the answer, and its table by variables or by a function, too."""

    columns: tuple[Shown, ...] | Callable[[Any, str], list[Column]] = ()  # none where facts say it all
    row_of: str = ""  # dimension of the rows
    needed: tuple[str, ...] = ()  # variables of the table, beside those of its columns
    known: frozenset[str] = frozenset()  # attributes that it needs, too
    there: Callable[[Any], bool] = lambda _: True  # what else there must be
    heading: Callable[[Any], str] = lambda answer: str(answer.attrs.get("title", ""))
    facts: Callable[[Any], Sequence[tuple[str, str]]] = lambda _: ()
    remarks: Callable[[Any], Sequence[str]] = lambda _: ()  # before what the theory ignores
    empty: str = ""  # said where there are no rows
    in_si: Callable[[Any], xr.Dataset] = lambda answer: answer  # what a file of comma-separated values holds
    shown_in: str = "rpm"  # unit of speeds or frequencies
    most: int = 24  # rows in Python; of more the first and the last ones


FORMS: dict[str, Form] = {}  # of answers without methods of their own, by the name of their kind
FILLED_BY = ("forms", "kinds", "run", "studied")  # modules of this folder
UNKNOWN = Form(there=lambda _: False)
KIND = "answer"  # attribute with the name of the kind


class Answer(xr.Dataset):
    """A dataset in SI that shows itself as facts and a table of its main numbers; all that a dataset can do, it can.

    What was cut out of it and lacks them is shown as xarray does. Its kind stands in an attribute; a class of its own has what
    can be asked for more.
    """

    __slots__ = ()
    shown_as: ClassVar[Form] = UNKNOWN

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()  # type: ignore[no-untyped-call]

    @classmethod
    def of(cls: type[A], dataset: xr.Dataset, kind: str = "") -> A:
        """The same dataset as an answer of this kind."""
        return cls(dataset.data_vars, dataset.coords, {**dataset.attrs, **({KIND: kind} if kind else {})})

    def form(self) -> Form:
        """How it shows itself."""
        kind = self.attrs.get(KIND) if type(self) is Answer else None
        if kind and kind not in FORMS:
            for name in FILLED_BY:
                import_module(f"{__package__}.{name}")
        return FORMS.get(str(kind), self.shown_as)

    def heading(self) -> str:
        """The first line."""
        return self.form().heading(self)

    def facts(self) -> Sequence[tuple[str, str]]:
        """Names and texts below it."""
        return self.form().facts(self)

    def columns(self, unit: str = "") -> list[Column]:
        """The main table, speeds or frequencies in ``unit``."""
        columns = self.form().columns
        return self.shown(unit, *columns) if isinstance(columns, tuple) else columns(self, unit)

    def remarks(self) -> Sequence[str]:
        """Sentences at the end: what the theory of the answer does not know of its machine, and what to be careful about."""
        form = self.form()
        ignored = [
            f"{who}ignores {self.attrs[name]}"
            for name, who in (("ignores", ""), ("stalled_ignores", "release and capture speed: "))
            if self.attrs.get(name)
        ]
        nothing = [form.empty] if form.empty and not self.sizes[form.row_of] else []
        warnings = str(self.attrs.get("warnings", "")).split("\n")
        return [*nothing, *form.remarks(self), *ignored, *filter(None, warnings)]

    def in_si(self) -> xr.Dataset:
        """What a file of comma-separated values holds, in SI."""
        return self.form().in_si(self)

    def to_pandas_table(self) -> pd.DataFrame:
        """The main table for pandas, in SI with units in the heads of its columns, as a .csv file has it."""
        from pandas import DataFrame

        return DataFrame(main_table(self))

    def shown(self, unit: str, *entries: Shown) -> list[Column]:
        """Variables as columns, speeds or frequencies in ``unit``."""
        columns = []
        for entry in entries:
            variable, head = self[entry.name], entry.head or _words(entry.name)
            if variable.dtype.kind not in "biuf":
                columns.append(Column(head, [str(text) for text in variable.values], wraps=True))
                continue
            speed = not entry.unit and variable.attrs.get("units") == "rad/s"
            axis = (
                speed_axis(unit or self.form().shown_in)
                if speed
                else AxisUnit(entry.unit, FACTORS.get(entry.unit, 1.0))
            )
            whole = variable.dtype.kind in "biu" and axis.factor == 1.0
            values = variable.values.tolist() if whole else axis.shown(variable.values)
            values = np.mod(values, entry.turn) if entry.turn else values
            columns.append(Column(head, values, "" if entry.bare else axis.sign, entry.form))
        return columns

    def has_table(self) -> bool:
        """Whether all that the table needs is there."""
        form = self.form()
        of_columns = [entry.name for entry in form.columns] if isinstance(form.columns, tuple) else []
        names = [*form.needed, *of_columns]
        there = all(name in self and self[name].dims[:1] == (form.row_of,) for name in names)
        return there and form.known <= set(self.attrs) and form.there(self)

    def _table(self) -> tuple[list[str], list[tuple[str, ...]]]:
        columns, most = self.columns(), self.form().most
        head = [f"{column.head} ({column.unit})" if column.unit else column.head for column in columns]
        count, half = max((len(column.values) for column in columns), default=0), most // 2
        if count <= most:
            return head, list(zip(*(column.cells() for column in columns), strict=True))
        first, last = (
            list(zip(*(replace(column, values=column.values[part]).cells() for column in columns), strict=True))
            for part in (slice(half), slice(count - half, None))
        )
        return head, [*first, ("...", *[""] * (len(head) - 1)), *last]

    def _contents(self) -> str:
        sizes = ", ".join(f"{name} ({size})" for name, size in self.sizes.items())
        names = list(map(str, self.data_vars))
        more = f" and {len(names) - NAMED} more" if len(names) > NAMED + 1 else ""
        return f"dataset in SI{f' over {sizes}' if sizes else ''}: {', '.join(names[:NAMED] if more else names)}{more}"

    def told(self) -> str:
        """Heading, facts, table and remarks, for a reader who has no use for the dataset."""
        return self._told(self.remarks())

    def __repr__(self) -> str:
        if not self.has_table():
            return str(xr.Dataset.__repr__(self))
        return self._told((*self.remarks(), self._contents()))

    def _told(self, sentences: Sequence[str]) -> str:
        (head, rows), facts = self._table() if self.has_table() else ([], []), self.facts()
        lines = [line for text in sentences for line in textwrap.wrap(text, WIDTH)]
        table = text_table(*_narrow(head, rows)) if rows else ""
        return "\n".join(line for line in (self.heading(), facts_text(facts) if facts else "", table, *lines) if line)

    def _repr_html_(self) -> str:
        whole = str(xr.Dataset._repr_html_(self))
        if not self.has_table():
            return whole
        (head, rows), facts, title = self._table(), self.facts(), self.heading()
        shown = html_table(("", ""), facts, title) if facts else ""
        shown += html_table(head, rows, "" if facts else title) if rows or not facts else ""
        shown += "".join(f"<p>{escape(text)}</p>" for text in self.remarks())
        shown += picture_html(self, title) if self.nbytes < DRAWN else ""
        return f"{shown}<details><summary>{escape(self._contents())}</summary>{whole}</details>"


def _narrow(head: list[str], rows: list[tuple[str, ...]]) -> tuple[list[str], list[tuple[str, ...]]]:
    """Heads of a table that is too wide broken between words."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    if sum(2 + max(len(name), width) for name, width in zip(head, widths, strict=True)) <= WIDTH + 2:
        return head, rows
    broken = [textwrap.wrap(name, max(width, HEAD)) for name, width in zip(head, widths, strict=True)]
    lines = list(zip_longest(*broken, fillvalue=""))
    return list(lines[0]), [*lines[1:], *rows]


# Any labeled result as its single numbers, a table along its main dimension, and the ranges of all other values.


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
    shown_as = Form(most=8)

    @classmethod
    def of_run(cls: type[L], run: xr.Dataset, title: str, dataset: xr.Dataset) -> L:
        """What was found of a run; it says of which one."""
        name = run.attrs.get("machine_name", "")
        own = {key: run.attrs[key] for key in SOURCE if key in run.attrs}
        return cls(dataset.data_vars, dataset.coords, {"title": f"{title} of {name}" if name else title, **own})

    def has_table(self) -> bool:
        """There must be something to show."""
        return bool(self.data_vars)

    def facts(self) -> list[tuple[str, str]]:
        """Numbers, and the least and greatest values of what is not in the table."""
        messages = [
            (_words(name), _text(float(self.attrs[name]), unit)) for name, unit in ABOUT.items() if name in self.attrs
        ]
        along, ranges = self._along(), []
        for name, entry in self.data_vars.items():
            if entry.dims != (along,):
                ranges += [(_words(str(name)), text) for text in _range(entry)]
        return [*messages, *ranges[:MOST]]

    def columns(self, unit: str = "", width: float = WIDTH) -> list[Column]:
        """Values along the main dimension with their uncertainties, as many as stand side by side in a ``width``."""
        along = self._along()
        names = [str(name) for name in (*self.coords, *self.data_vars) if self[name].dims == (along,)]
        length = _length([self[name] for name in names])
        columns: list[Column] = []
        for name in sorted(names, key=lambda name: (name != along, names.index(_certain(name, names)))):
            column = _column(name, self[name], unit or self.form().shown_in, length)
            columns.append(column if _certain(name, names) == name else replace(column, head="+-", form=".2g"))
            if sum(2 + _width(column) for column in columns) > width and len(columns) > 1:
                return columns[:-1]
        return columns

    def _along(self) -> str:
        """The dimension that most variables have alone; of several the longest."""
        counts = {str(dim): 0 for dim in self.dims}
        for entry in self.data_vars.values():
            if len(entry.dims) == 1:
                counts[str(entry.dims[0])] += 1
        return max(counts, key=lambda dim: (counts[dim], self.sizes[dim]), default="") if any(counts.values()) else ""


def _certain(name: str, names: Sequence[str]) -> str:
    """The value whose uncertainty it is; else the name itself."""
    value = name.removesuffix("_uncertainty").removesuffix("_deviation")
    return value if value in names else name


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
    over = f", {entry.size} values over {' and '.join(map(str, entry.dims))}" if entry.dims else ""
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


# The main table in SI, as files of comma-separated values and pandas have it.

TABLE = 2  # dimensions that rows may follow


def main_table(result: xr.Dataset) -> dict[str, np.ndarray]:
    """The columns of the main table of a result by their heads, which have the units, in SI.

    Rows follow the numeric dimensions of the largest group of variables; dimensions that only count or name, such as
    balls and stations, become columns.

    Raises
    ------
    ResultError
        If it has no table.
    """
    if isinstance(result, Answer):
        result = result.in_si()
    rows = _row_dims(result)
    if not rows:
        raise ResultError("this result has no table; write it as .nc or .json")
    index = [
        result[name] if name in result.coords else xr.DataArray(np.arange(1, result.sizes[name] + 1), dims=name)
        for name in rows
    ]
    grids = xr.broadcast(*index) if len(index) > 1 else index
    heads = [_head(name, str(entry.attrs.get("units", ""))) for name, entry in zip(rows, index, strict=True)]
    columns = [grid.transpose(*rows).values.ravel() for grid in grids]
    for name, entry in result.variables.items():
        if str(name) in rows or not set(rows) & set(entry.dims) or not set(entry.dims) - set(rows) <= _named(result):
            continue
        if not set(rows) <= set(entry.dims):
            continue
        others = [dim for dim in entry.dims if dim not in rows]
        values = entry.transpose(*rows, *others).values.reshape(columns[0].size, -1)
        for k, (place, unit) in enumerate(zip(_places(result, others), _units(result, entry, others), strict=True)):
            heads.append(_head(f"{name}{place}", unit))
            columns.append(values[:, k])
    return dict(zip(heads, columns, strict=True))


def _named(result: xr.Dataset) -> set[Any]:
    """Dimensions that count or name things: they become columns."""
    return {dim for dim in result.dims if dim not in result.coords or result[dim].dtype.kind not in "f"}


def _row_dims(result: xr.Dataset) -> list[str]:
    """The one or two numeric dimensions that span the most values; without any, the dimension of the most values."""
    named = _named(result)
    groups: dict[tuple[str, ...], int] = {}
    for entry in result.data_vars.values():
        dims = tuple(str(dim) for dim in entry.dims if dim not in named) or tuple(map(str, entry.dims[:1]))
        if dims:
            groups[dims] = groups.get(dims, 0) + entry.size

    ranked = [(len(dims) if len(dims) <= TABLE and not named & set(dims) else 0, groups[dims], dims) for dims in groups]
    return list(max(ranked)[2]) if ranked else []


def _places(result: xr.Dataset, dims: list[Any]) -> list[str]:
    """``[1]``, ``[2]`` or ``[B1]`` for each value of the dimensions that become columns."""
    places = [""]
    for dim in dims:
        labels = result[dim].values if dim in result.coords else np.arange(1, result.sizes[dim] + 1)
        places = [f"{place}[{label}]" for place in places for label in labels]
    return places


def _units(result: xr.Dataset, entry: Any, dims: list[Any]) -> list[str]:
    """The unit of each such column: of the variable, or of its channel, which ``units`` says, in the form ``units_form``."""
    own = str(entry.attrs.get("units", ""))
    if own or "units" not in result.variables or not set(result["units"].dims) <= set(dims):
        return [own] * math.prod(result.sizes[dim] for dim in dims)
    form = str(entry.attrs.get("units_form", "{}"))
    like = xr.DataArray(np.zeros([result.sizes[dim] for dim in dims]), dims=dims)
    units = xr.broadcast(result["units"].reset_coords(drop=True), like)[0].transpose(*dims).values.ravel()
    return [form.format(unit if unit.isalpha() or form == "{}" else f"({unit})") for unit in map(str, units)]


def _head(name: str, unit: str) -> str:
    return f"{name} [{unit}]" if unit and unit != "1" else name
