"""The measured files of a user, each in a folder of its own with what its columns mean; they survive a restart.

The readers are imported when they are asked for, so that the page opens at once.
"""

from __future__ import annotations

import json
import re
import shutil
import threading
from dataclasses import asdict, dataclass, field, replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w
import xarray as xr

from autobalancer.errors import AutobalancerError, QuestionError, ResultError, UnitError
from autobalancer.files.matrix_files import FORMATS
from autobalancer.files.samples import example_path, sample_names
from autobalancer.files.text_files import TABLE, TABLES, read_text
from autobalancer.measurement import signal_formats as formats
from autobalancer.measurement.signal_formats import RawColumn, RawFile
from autobalancer.measurement.signals import DIRECTIONS, UNITS, factor_to, quantity_of
from autobalancer.results.folder_store import Shelf
from autobalancer.results.signals import UNIVERSAL, Signals
from autobalancer.results.store import NETCDF
from autobalancer.safe_file import write_safely

# What the columns of a file mean: guessed from their heads, changed on the page, kept with the file.


OUT, TIME = "", "time"
QUANTITIES = {OUT: "leave out", TIME: TIME} | {name: name for name in UNITS}
CLOCKS = re.compile(r"(time|zeit|temps|tiempo|stamp|\bt\b|\bsec)", re.IGNORECASE)
DIRECTION_PATTERN = re.compile(r"(?:^|[\s_.\-])([xyzXYZ])$|^[a-z]+([XYZ])$")


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
    way = DIRECTION_PATTERN.search(name)
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


LARGEST = 24_000_000  # bytes of a file; what goes with it in a request has room, too
MOST, ROOM = 200, 2_000_000_000  # files of one user, and their bytes
SUFFIXES = (*formats.SUFFIXES, ".nc")
MACHINE_SUFFIXES = (
    *sorted({*FORMATS, *TABLES, *UNIVERSAL}),
    ".mapping",
)  # matrices, modes, tables that a machine names
LINES, WIDE = 12, 160  # of a preview
MOST_LOADED = 3  # files whose numbers are kept in memory
_loaded: dict[tuple[str, str], xr.Dataset] = {}
_lock = threading.Lock()


@dataclass
class Measured:
    """What a list of measured files shows of one."""

    name: str
    file: str
    made: str
    bytes: int
    kind: str  # signals, orders or film
    reading: Reading = field(default_factory=Reading)
    notes: list[str] = field(default_factory=list)


class Measurements(Shelf[Measured]):
    """All measured files below the folder of a user."""

    def __init__(self, home: Path) -> None:
        super().__init__(home / "measured", Measured, "measurement")

    def path(self, name: str) -> Path:
        """The file itself, as it was given."""
        return self.folder(name) / self.entry(name).file

    def add(self, file: str, content: bytes) -> str:
        """Keep a file that the readers of measurements can read; gives its name.

        Raises
        ------
        QuestionError
            If it is too large, of no known kind, or there are too many.
        ResultError
            If it cannot be read, in the words of its reader.
        """
        called = plain_name(file)
        _refuse_size(called, content, [one.bytes for one in self.entries()])
        folder = self.new()
        try:
            write_safely(folder / called, lambda path: path.write_bytes(content))
            kind, reading = _kind(folder / called)
        except AutobalancerError as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise type(error)(str(error).replace(f"{folder}/", "")) from None
        except BaseException:
            shutil.rmtree(folder, ignore_errors=True)
            raise
        made = f"{datetime.now(UTC):%Y-%m-%d %H:%M:%S}"
        self.note(Measured(folder.name, called, made, len(content), kind, reading))
        return folder.name

    @staticmethod
    def keep_file(folder: Path, file: str, content: bytes) -> str:
        """Keep a file that machines name, in place of an older one of its name, and give that.

        Raises
        ------
        QuestionError
            If it is too large, of no known kind, or there are too many.
        """
        called = plain_name(file, MACHINE_SUFFIXES)
        folder.mkdir(parents=True, exist_ok=True)
        _refuse_size(called, content, [one.stat().st_size for one in folder.iterdir() if one.name != called])
        write_safely(folder / called, lambda path: path.write_bytes(content))
        return called

    def add_sample(self, sample: str) -> str:
        """Keep a copy of a measurement that comes with the package.

        Raises
        ------
        QuestionError
            If there is none of this name.
        """
        if sample not in samples():
            raise QuestionError(f"{sample[:40]!r}: no such sample; there are {', '.join(samples())}")
        path = example_path(sample)
        return self.add(path.name, path.read_bytes())

    def describe(self, name: str, reading: Reading) -> None:
        """Keep what the columns mean."""
        entry = self.entry(name)
        entry.reading = reading
        self.note(entry)

    def data(self, name: str) -> xr.Dataset:
        """Its signals, orders or film, as its columns were described.

        Raises
        ------
        QuestionError
            If a channel is not described well enough, or samples are missing, in the words of the reader.
        """
        from autobalancer.measurement.load_signals import load_signals
        from autobalancer.measurement.run_up_fit import load_measured

        entry = self.entry(name)
        key = (name, json.dumps(asdict(entry.reading)))
        with _lock:
            if key in _loaded:
                return _loaded[key]
        path = self.path(name)
        with NETCDF:
            if entry.kind == "signals" and path.suffix.lower() != ".nc":
                if not entry.reading.channels():
                    raise QuestionError(f"{entry.file}: say of at least one column what it is")
                found = load_signals(path, entry.reading.channels(), **entry.reading.arguments())
            else:
                found = load_measured(path)
        with _lock:
            _loaded[key] = found
            while len(_loaded) > MOST_LOADED:
                del _loaded[next(iter(_loaded))]
        return found

    def preview(self, name: str) -> list[str]:
        """The first lines of a table; of another file what it has."""
        from autobalancer.measurement.run_up_fit import load_measured
        from autobalancer.measurement.signal_formats import read_raw

        path = self.path(name)
        if path.suffix.lower() in TABLES:
            lines = read_text(path, TABLE, ResultError, path.name, "cp1252").splitlines()
            return [line[:WIDE] + " ..." * (len(line) > WIDE) for line in lines[:LINES]]
        with NETCDF:
            if path.suffix.lower() == ".nc":
                return str(load_measured(path)).splitlines()
            raw = read_raw(path)
        count = max((one.values.size for one in raw.columns.values()), default=0)
        rate = "" if raw.rate is None else f", {raw.rate:g} Hz"
        return [f"{count} samples{rate}", *(f"{key} [{one.unit}]" for key, one in raw.columns.items())]


def _refuse_size(called: str, content: bytes, there: list[int]) -> None:
    if len(content) > LARGEST:
        raise QuestionError(f"{called}: has {len(content) / 1e6:.1f} MB; at most {LARGEST // 1_000_000} MB are taken")
    if len(there) >= MOST or sum(there) + len(content) > ROOM:
        raise QuestionError(f"{len(there)} files are kept already; delete some of them first")


def plain_name(file: str, suffixes: tuple[str, ...] = SUFFIXES) -> str:
    """The name of a file without anything that could lead elsewhere.

    Raises
    ------
    QuestionError
        If its ending is none of these, by default of a measurement.
    """
    last = re.split(r"[/\\]", file)[-1]
    stem, dot, ending = last.rpartition(".")
    if f"{dot}{ending}".lower() not in suffixes:
        raise QuestionError(f"{last[:60]!r}: is none of these files; they end in {', '.join(suffixes)}")
    plain = re.sub(r"[^\w -]", "_", stem)[:60].strip() or "measurement"
    return f"{plain}.{ending.lower()}"


@cache
def samples() -> tuple[str, ...]:
    """Measurements of the package that are signals or orders."""
    from autobalancer.measurement.run_up_fit import load_measured

    found = []
    for name in sample_names("measurements"):
        path = example_path(name)
        try:
            with NETCDF:
                known = path.suffix in TABLES and load_measured(path)
        except AutobalancerError:  # it is read by a function of its own
            continue
        if known:
            found.append(name)
    return tuple(found)


def _kind(path: Path) -> tuple[str, Reading]:
    """What a file holds, and how its columns may be meant.

    Raises
    ------
    ResultError
        If it holds nothing that was measured.
    """
    from autobalancer.measurement.pairs import is_orders
    from autobalancer.measurement.run_up_fit import load_measured
    from autobalancer.measurement.signal_formats import read_raw

    with NETCDF:
        if path.suffix.lower() == ".nc":
            return _kind_of(load_measured(path), path.name), Reading()
        try:
            orders: Any = load_measured(path) if path.suffix.lower() in TABLES else None
        except AutobalancerError:
            orders = None
        if orders is not None and is_orders(orders) and not isinstance(orders, Signals):
            return "orders", Reading()
        raw = read_raw(path)
    reading = guessed(raw)
    if not raw.columns:
        raise ResultError(f"{path.name}: has no columns of numbers")
    return "signals", reading


def _kind_of(found: xr.Dataset, file: str) -> str:
    from autobalancer.measurement.pairs import is_orders

    if isinstance(found, Signals):
        return "signals"
    if "ball_angle" in found:
        return "film"
    if is_orders(found):
        return "orders"
    raise ResultError(f"{file}: is a result, but no measurement; signals, orders and ball angles of a film are")
