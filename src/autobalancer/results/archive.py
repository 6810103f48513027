"""An archive: a folder of long runs, each written in parts while it is computed, and the catalogue of what they asked and found.

In the folder of a run are ``machine.toml``, its note (parameters, state, measures), ``part-00000.nc`` and so on, and
``checkpoint.npz``. A part counts when the checkpoint after it is there: a run that goes on drops later ones.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import pandas as pd  # type: ignore[import-untyped]
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from autobalancer.errors import QuestionError, ResultError
from autobalancer.machine_kinds import CHAMBERS, machine_kind
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.results.answers.kinds import as_kind
from autobalancer.results.folder_store import (
    has_note,
    locked,
    plain,
    read_note,
    refuse_other_question,
    write_arrays,
    write_note,
)
from autobalancer.results.store import NETCDF, save_run
from autobalancer.safe_file import endless_heap, write_safely, write_text_safely
from autobalancer.units import shortened

Write = Callable[[xr.Dataset, Path], Any]
Checkpoint = Mapping[str, NDArray[Any]]
PARTS_KEY = "archive_parts"  # entry of a checkpoint: how many parts go before it
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]*")
PART = re.compile(r"part-(\d{5,})\.nc")
BEGIN_ANEW = "to start the run again, delete its folder"
ANEW = "delete it, and the run starts again from the beginning"


@dataclass
class RunNote:
    """What a run is: ``"running"`` (or killed while it was), ``"finished"``, ``"interrupted"`` or ``"failed"``."""

    state: str
    parameters: dict[str, Any]
    question: dict[str, Any]
    source: str
    created: str
    measures: dict[str, int | float | None] = field(default_factory=dict)
    outcome: dict[str, str | int | float | None] = field(default_factory=dict)
    parts: int | None = None  # when it is finished
    measured_last: float | None = None  # window of its measures, s


def write_part(chunk: xr.Dataset, path: Path) -> None:
    """Write the samples of a chunk as netCDF."""
    with NETCDF:
        chunk.to_netcdf(path, engine="netcdf4")


NODES = (
    *(ast.BoolOp, ast.UnaryOp, ast.Compare, ast.BinOp, ast.Name, ast.Constant, ast.List, ast.Tuple, ast.expr_context),
    *(ast.And, ast.Or, ast.Not, ast.USub, ast.UAdd, ast.cmpop, ast.Add, ast.Sub, ast.Mult, ast.Div),
)
LONGEST = 500  # characters of a condition
HOW = 'write conditions such as "friction >= 0.5 and balls == 8", with and, or, not, in, numbers and quoted texts'


class Archive:
    """A folder of runs; it is created with the first run.

    The catalogue is read from the notes of the runs, so runs can be copied, moved or deleted by hand.

    Parameters
    ----------
    folder
        Where the archive is.
    write
        Function that writes a part of the samples to a file; by default as netCDF.
    """

    def __init__(self, folder: str | Path, write: Write = write_part) -> None:
        self.folder, self.write = Path(folder), write
        if self.folder.exists() and not self.folder.is_dir():
            raise ResultError(f"{self.folder}: is a file; an archive is a folder")

    def start(self, name: str, machine: str, parameters: Mapping[str, Any], question: Mapping[str, Any]) -> RunFolder:
        """A run to write into: a new one, or the existing one of this name if it has the same settings.

        Parameters
        ----------
        name
            Of the run; letters, digits, ``.``, ``_``, ``+`` and ``-``.
        machine
            Text of the machine file.
        parameters
            Numbers and texts by which the run is found in the catalogue.
        question
            Other settings on which the result depends: duration, step, seed and so on.

        Raises
        ------
        QuestionError
            If the name is not possible, or a run of this name has other settings.
        ResultError
            If the folder cannot be written, or another process is writing the run.
        """
        if not NAME.fullmatch(name):
            raise QuestionError(f"name: given {name!r}; use letters, digits, and . _ + - after the first")
        path, requested = self.folder / name, {str(key): plain(value) for key, value in question.items()}
        try:
            path.mkdir(parents=True, exist_ok=True)
        except OSError as reason:
            raise ResultError(f"{path}: cannot be written: {reason}") from None
        if not has_note(path):
            with locked(path, "run"):
                if not has_note(path):
                    made, told = provenance(), {str(key): plain(value) for key, value in parameters.items()}
                    write_text_safely(path / "machine.toml", machine)
                    write_note(path, RunNote("running", told, requested, made["source"], made["created"]))
        run = RunFolder(path, self.write)
        refuse_other_question(
            path, "run", {"machine": run.machine, **run.note.question}, {"machine": machine, **requested}
        )
        return run

    def names(self) -> list[str]:
        """Names of the runs."""
        return sorted(path.name for path in self.folder.glob("*") if has_note(path))

    def run(self, name: str) -> RunFolder:
        """A run by its name.

        Raises
        ------
        QuestionError
            If there is none of this name.
        """
        if name not in self.names():
            raise QuestionError(f"run: given {name!r}; {self.folder} has {', '.join(self.names()) or 'no runs'}")
        return RunFolder(self.folder / name, self.write)

    def samples(self, name: str) -> xr.Dataset:
        """All samples of a run as one dataset, read from disk when used."""
        return self.run(name).samples()

    def runs(self, where: str | Mapping[str, Any] = "") -> xr.Dataset:
        """The catalogue: parameters and measures of the runs for which ``where`` holds.

        Parameters
        ----------
        where
            A condition such as ``"friction >= 0.5 and state == 'finished'"``, or values that must be met.

        Returns
        -------
        xarray.Dataset
            Along ``run``, its name: ``state``, and every parameter and every measure of one number or text. A number
            that a run does not have is nan, a text empty.

        Raises
        ------
        QuestionError
            If the condition cannot be read, or contains a name that no run has.
        """
        from autobalancer.results.chamber_measures import catalog_unit  # with compiled code

        rows = {name: self._row(name) for name in self.names()}
        items = [rows[name] for name in _matching(rows, where)]
        table = xr.Dataset(coords={"run": ("run", np.array([row["run"] for row in items], dtype=object))})
        for key in sorted(
            {key for row in rows.values() for key in row} - {"run"}, key=lambda key: (key != "state", key)
        ):
            unit = catalog_unit(key)
            table[key] = ("run", _column([row.get(key) for row in items]), {"units": unit} if unit else {})
        table.attrs.update(title=f"Runs of {self.folder}", **provenance())
        return Labeled.of(table)

    def export(self, name: str, path: str | Path) -> Path:
        """Write a run as one result file, one variable at a time."""
        samples = self.samples(name)
        samples.attrs.setdefault("source", provenance()["source"])
        return save_run(samples, path)

    def _row(self, name: str) -> dict[str, Any]:
        """What the note of a run says; of one that cannot be read only that."""
        try:
            note = read_note(self.folder / name, RunNote, BEGIN_ANEW)
        except ResultError as reason:
            return {"run": name, "state": str(reason).partition(": ")[2]}
        values = {**note.parameters, **note.measures}
        single = {key: value for key, value in values.items() if not isinstance(value, (list, dict))}
        return {**single, "run": name, "state": note.state}


# Which of many notes: conditions such as ``friction >= 0.5 and balls in [8, 9]``.


def _matching(rows: Mapping[str, Mapping[str, Any]], where: str | Mapping[str, Any]) -> list[str]:
    """Names of the rows for which a condition holds, or that have the values of a mapping.

    A comparison with a value that a row does not have does not hold, and neither does its contrary. Only comparisons and
    arithmetic are possible; no code is called.

    Raises
    ------
    QuestionError
        If the text is no condition, or names a value that no row has.
    """
    known = {key for row in rows.values() for key in row}
    if isinstance(where, Mapping):
        _refuse_unknown(where, known)
        return [name for name, row in rows.items() if all(row.get(key) == plain(v) for key, v in where.items())]
    if not where.strip():
        return list(rows)
    refused = QuestionError(f"where: given {shortened(where)}; {HOW}")
    try:
        if len(where) > LONGEST:
            raise refused
        nodes = list(ast.walk(ast.parse(where.strip(), mode="eval").body))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise refused from None
    _refuse_unknown([node.id for node in nodes if isinstance(node, ast.Name)], known)
    parts = [part for node in nodes if isinstance(node, ast.BinOp) for part in (node.left, node.right)]
    if not all(isinstance(node, NODES) for node in nodes) or any(
        isinstance(part, ast.Constant) and isinstance(part.value, str) for part in parts
    ):
        raise refused
    table = pd.DataFrame.from_dict(rows, orient="index").fillna(np.nan).convert_dtypes()
    try:
        result = table.eval(where.strip(), engine="python")
        if not pd.api.types.is_bool_dtype(result):
            raise refused
        return [str(name) for name in table.index[result.fillna(False).astype("boolean")]]
    except QuestionError:
        raise
    except Exception as reason:  # pandas raises many kinds
        words = "numbers and texts cannot be compared; " if isinstance(reason, TypeError) else ""
        raise QuestionError(f"where: given {shortened(where)}; {words}{HOW}") from None


def _refuse_unknown(names: Any, known: set[str]) -> None:
    for name in names:
        if name not in known:
            raise QuestionError(f"where: given {name!r}; the runs have {', '.join(sorted(known)) or 'no values'}")


def _column(cells: list[Any]) -> np.ndarray:
    if any(isinstance(cell, str) for cell in cells):
        return np.array(["" if cell is None else str(cell) for cell in cells], dtype=object)
    return np.array([_number(cell) for cell in cells], np.float64)


def _number(cell: Any) -> float:
    try:
        return np.nan if cell is None else float(cell)
    except OverflowError:
        return np.nan


class RunFolder:
    """A run of an archive.

    Parameters
    ----------
    path
        Its folder; see :class:`Archive`, which makes it.
    write
        What puts a chunk into a file.
    """

    def __init__(self, path: Path, write: Write = write_part) -> None:
        self.path, self.write = path, write
        self.note = read_note(path, RunNote, BEGIN_ANEW)
        self._kept: int | None = None  # parts before the checkpoint from which the run goes on

    @property
    def name(self) -> str:
        """Name of the run, that of its folder."""
        return self.path.name

    @property
    def state(self) -> str:
        """``"running"`` (or killed while it was), ``"finished"``, ``"interrupted"`` or ``"failed"``."""
        return self.note.state

    @property
    def machine(self) -> str:
        """Text of the machine file.

        Raises
        ------
        ResultError
            If it cannot be read.
        """
        try:
            return (self.path / "machine.toml").read_text(encoding="utf-8")
        except (OSError, ValueError) as reason:
            raise ResultError(f"{self.path / 'machine.toml'}: cannot be read: {reason}") from None

    @contextmanager
    def writing(self) -> Iterator[None]:
        """While it lasts, no other process writes this run; its note is read again at the beginning.

        Raises
        ------
        ResultError
            If another process writes it.
        """
        with locked(self.path, "run"):
            self.note = read_note(self.path, RunNote, BEGIN_ANEW)
            yield

    def parts(self) -> list[Path]:
        """Files of the samples in the order of time."""
        result = [(int(match[1]), file) for file in self.path.iterdir() if (match := PART.fullmatch(file.name))]
        return [file for _, file in sorted(result)]

    def samples(self, read: Sequence[str] = ()) -> xr.Dataset:
        """All samples written so far, read when used; the attributes tell what the run is and how it ended.

        Variables in ``read`` are read at once, which takes less time if all of them are needed.

        Raises
        ------
        ResultError
            If there are none, or a part is damaged, missing or in the wrong place.
        """
        files = self.parts()
        self._complete(files, self.note.parts or 0)
        parts = open_parts(files, read)
        if machine_kind(parts) is not CHAMBERS or parts.attrs.get("machine", self.machine) != self.machine:
            raise ResultError(f"{files[0]}: is not of this run; was it replaced by another file?")
        told = {key: value for key, value in self.note.outcome.items() if value is not None}
        parts.attrs.update(machine=self.machine, archive_state=self.state, **told)
        return as_kind(parts, CHAMBERS.run)

    def append(self, chunk: xr.Dataset, checkpoint: Checkpoint | None = None) -> None:
        """Keep a chunk of samples, and the state from which the run goes on after it.

        Raises
        ------
        ResultError
            If the disk is full or cannot be written. What was written before is kept and can be read.
        """
        self._drop_rest()
        number = len(self.parts())
        with self._kept_so_far():
            if chunk.sizes.get("time", 0):
                write_safely(self.path / f"part-{number:05d}.nc", lambda file: self.write(chunk, file))
                number += 1
            if checkpoint is not None:
                write_arrays(self.path / "checkpoint.npz", {PARTS_KEY: np.array(number), **checkpoint})

    def checkpoint(self) -> dict[str, NDArray[Any]] | None:
        """The last checkpoint, None if the run made none. Parts that came after it are dropped when the run goes on.

        Raises
        ------
        ResultError
            If it cannot be read, or a part before it is missing; then nothing is dropped.
        """
        path = self.path / "checkpoint.npz"
        try:
            with np.load(path, allow_pickle=False) as stored:
                held = {key: stored[key] for key in stored.files}
            kept = int(held.pop(PARTS_KEY).item())
        except FileNotFoundError:
            self._kept = 0
            return None
        except Exception as reason:  # a damaged archive of arrays may raise anything
            raise ResultError(f"{path}: cannot be read: {type(reason).__name__}: {reason}; {ANEW}") from None
        self._complete(self.parts()[:kept], kept)
        self._kept = kept
        return held

    def _drop_rest(self) -> None:
        """Remove the parts after the checkpoint from which the run goes on."""
        for file in self.parts()[self._kept :] if self._kept is not None else ():
            file.unlink()
        self._kept = None

    def _complete(self, files: list[Path], count: int) -> None:
        """Refuse parts with a hole."""
        for number in range(max(len(files), int(count))):
            if number >= len(files) or files[number].name != f"part-{number:05d}.nc":
                raise ResultError(f"{self.path}: part-{number:05d}.nc is missing; the run is not complete without it")

    def end(
        self, state: str, outcome: Mapping[str, Any] | None = None, measures: Mapping[str, Any] | None = None
    ) -> None:
        """Note how the run ended, and its measures for the catalogue.

        Raises
        ------
        ResultError
            If the disk is full.
        """
        self.note.state = state
        if state == "finished":
            self._drop_rest()
            self.note.parts = len(self.parts())
        if outcome is not None:
            self.note.outcome = {str(key): plain(value) for key, value in outcome.items()}
        if measures is not None:
            self.note.measures = {str(key): plain(value) for key, value in measures.items()}
        with self._kept_so_far():
            write_note(self.path, self.note)
        if state == "finished":
            (self.path / "checkpoint.npz").unlink(missing_ok=True)

    @contextmanager
    def _kept_so_far(self) -> Iterator[None]:
        """An error while something is written says what is kept."""
        try:
            yield
        except ResultError as reason:
            raise ResultError(
                f"{reason}; the {len(self.parts())} parts written before are kept and can be read. "
                "Make room, then start the run again: it continues from its last checkpoint"
            ) from None


# Samples of a long run in many files, read as one dataset: only what is asked for comes into memory.


def open_parts(files: Sequence[Path], read: Sequence[str] = ()) -> xr.Dataset:
    """The parts of a run, one after the other in time, as one dataset whose samples stay on disk until they are used.

    Times, and what does not depend on time, are read at once. A part is read at a time, so memory stays small while one
    goes through a run in slices.

    Parameters
    ----------
    files
        netCDF files with the dimension ``time`` first; their times ascend.
    read
        Variables that are read at once, as far as there are such: each file is opened once for all of them.

    Raises
    ------
    ResultError
        If there is no part, or one cannot be read.
    """
    if not files:
        raise ResultError("the run has no samples yet; nothing was written before it ended")
    try:
        for file in files:
            if endless := endless_heap(file):
                raise ValueError(endless)
        with NETCDF, xr.open_dataset(files[0], engine="netcdf4", decode_times=False) as stored:
            first = stored.isel(time=slice(0, 0)).load()
    except (OSError, RuntimeError, ValueError) as reason:
        raise ResultError(f"{files[0]}: not a readable part of a run: {reason}") from None
    at_once = [name for name in read if name in first and "time" in first[name].dims]
    pieces = [_samples(file, ("time", *at_once), first=first) for file in files]
    times = [piece["time"] for piece in pieces]
    _ascending(files, times)
    starts = np.concatenate([[0], np.cumsum([time.size for time in times])])
    variables: dict[str, Any] = {}
    for key, variable in first.variables.items():
        name = str(key)
        if name == "time":
            variables[name] = xr.Variable("time", np.concatenate(times), variable.attrs)
        elif name in at_once:
            variables[name] = xr.Variable(variable.dims, np.concatenate([p[name] for p in pieces]), variable.attrs)
        elif "time" in variable.dims:
            lazy = indexing.LazilyIndexedArray(_SplitVariable(files, name, starts, variable.shape[1:], variable.dtype))
            variables[name] = xr.Variable(variable.dims, lazy, variable.attrs)
        else:
            variables[name] = variable
    coords = {name: variables.pop(name) for name in map(str, first.coords)}
    return xr.Dataset(variables, coords, first.attrs)


def _ascending(files: Sequence[Path], times: Sequence[NDArray[Any]]) -> None:
    """Refuse parts that were exchanged, or are of other runs."""
    last = -np.inf
    for file, time in zip(files, times, strict=True):
        if time.dtype.kind not in "fiu" or time.ndim != 1 or not np.all(np.diff(time, prepend=last) > 0.0):
            raise ResultError(
                f"{file}: its times do not follow those of the part before; was it replaced by another file?"
            )
        last = time[-1] if time.size else last


def _samples(
    file: Path, names: Sequence[str], which: slice = slice(None), first: xr.Dataset | None = None
) -> dict[str, NDArray[Any]]:
    """Variables of a file; refused if it is not of the same run as the ``first`` part."""
    try:
        with NETCDF, netCDF4.Dataset(file) as stored:
            if first is not None:
                _refuse_other_run(stored, first)
            return {name: np.asarray(stored.variables[name][which]) for name in names}
    except KeyError as reason:
        raise ResultError(f"{file}: not a readable part of this run: it has no {reason}") from None
    except (OSError, RuntimeError, IndexError, ValueError) as reason:
        raise ResultError(f"{file}: not a readable part of a run: {reason}") from None


def _refuse_other_run(stored: netCDF4.Dataset, first: xr.Dataset) -> None:
    for key, variable in first.variables.items():
        if stored.variables[str(key)].shape[1:] != variable.shape[1:]:
            raise ValueError(f"{str(key)!r} is of another size than in the first part; is it of another run?")
    for name in {"machine", "seed"} & set(first.attrs):
        if getattr(stored, name, None) != first.attrs[name]:
            raise ValueError(f"its {name} is not that of the first part; is it of another run?")


class _SplitVariable(BackendArray):
    """One variable, its first axis time, in many files."""

    def __init__(
        self, files: Sequence[Path], name: str, starts: NDArray[np.int64], rest: tuple[int, ...], dtype: np.dtype[Any]
    ) -> None:
        self.files, self.name, self.starts = list(files), name, starts
        self.shape = (int(starts[-1]), *rest)
        self.dtype = dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._read)

    def _read(self, key: tuple[Any, ...]) -> NDArray[Any]:
        wanted = np.atleast_1d(np.arange(self.shape[0])[key[0]])
        result = np.empty((wanted.size, *self.shape[1:]), self.dtype)
        for file, start, end in zip(self.files, self.starts[:-1], self.starts[1:], strict=True):
            here = np.flatnonzero((wanted >= start) & (wanted < end))
            if here.size == 0:
                continue
            local = wanted[here] - start
            low, high = int(local.min()), int(local.max()) + 1
            result[here] = _samples(file, (self.name,), slice(low, high))[self.name][local - low]
        for axis in range(len(key) - 1, 0, -1):
            result = result[(slice(None),) * axis + (key[axis],)]
        return result[0] if isinstance(key[0], (int, np.integer)) else result
