"""One run of an archive on disk: parts as they are computed, a checkpoint, and a note that says what it is.

In the folder of a run are ``machine.toml``, ``run.json`` (parameters, state, measures), ``part-00000.nc`` and so on, and
``checkpoint.npz``; while it is written also ``lock``, which names the writer. Each file is written beside its place and
moved there when complete, so that a crash, or a disk that is full, leaves what was there before. A part counts when the
checkpoint after it is there: a run that goes on drops later ones.
"""

from __future__ import annotations

import contextlib
import datetime
import json
import os
import re
import socket
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from autobalancer.errors import ResultError
from autobalancer.results.answers.kinds import as_kind
from autobalancer.safe_file import endless_heap, write_safely

Write = Callable[[xr.Dataset, Path], Any]
Checkpoint = Mapping[str, NDArray[Any]]
PARTS = "archive_parts"  # entry of a checkpoint: how many parts go before it
PART = re.compile(r"part-(\d{5,})\.nc")
BEGIN_ANEW = "to start the run again, delete its folder"
ANEW = "delete it, and the run starts again from the beginning"


def write_part(chunk: xr.Dataset, path: Path) -> None:
    """Write the samples of a chunk as netCDF."""
    with NETCDF:
        chunk.to_netcdf(path, engine="netcdf4")


class RunFolder:
    """A run of an archive.

    Parameters
    ----------
    path
        Its folder; see :class:`autobalancer.results.archive.folder.Archive`, which makes it.
    write
        What puts a chunk into a file.
    """

    def __init__(self, path: Path, write: Write = write_part) -> None:
        self.path, self.write = path, write
        self.note = read_note(path)
        self._kept: int | None = None  # parts before the checkpoint from which the run goes on

    @property
    def name(self) -> str:
        """Name of the run, that of its folder."""
        return self.path.name

    @property
    def state(self) -> str:
        """``"running"`` (or killed while it was), ``"finished"``, ``"interrupted"`` or ``"failed"``."""
        return str(self.note.get("state", "running"))

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
        with RunLock(self.path):
            self.note = read_note(self.path)
            yield

    def parts(self) -> list[Path]:
        """Files of the samples in the order of time."""
        found = [(int(match[1]), file) for file in self.path.iterdir() if (match := PART.fullmatch(file.name))]
        return [file for _, file in sorted(found)]

    def samples(self, read: Sequence[str] = ()) -> xr.Dataset:
        """All samples written so far, read when used; the attributes tell what the run is and how it ended.

        Variables in ``read`` are read at once, which takes less time if all of them are needed.

        Raises
        ------
        ResultError
            If there are none, or a part is damaged, missing or in the wrong place.
        """
        files = self.parts()
        self._complete(files, self.note.get(PARTS, len(files)))
        found = open_parts(files, read)
        if "body_position" not in found or found.attrs.get("machine", self.machine) != self.machine:
            raise ResultError(f"{files[0]}: is not of this run; was it replaced by another file?")
        told = {key: value for key, value in self.note.get("outcome", {}).items() if value is not None}
        found.attrs.update(machine=self.machine, archive_state=self.state, **told)
        return as_kind(found, "ChamberRun")

    def append(self, chunk: xr.Dataset, checkpoint: Checkpoint | None = None) -> None:
        """Keep a chunk of samples, and the state from which the run goes on after it.

        Raises
        ------
        ResultError
            If the disk is full or cannot be written. What was written before is kept and can be read.
        """
        self._drop_rest()
        number = len(self.parts())
        if chunk.sizes.get("time", 0):
            self._put(self.path / f"part-{number:05d}.nc", lambda file: self.write(chunk, file))
            number += 1
        if checkpoint is not None:
            held = {PARTS: np.array(number), **checkpoint}
            self._put(self.path / "checkpoint.npz", lambda file: _savez(file, held))

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
            kept = int(held.pop(PARTS).item())
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
        self.note.update(state=state)
        if state == "finished":
            self._drop_rest()
            self.note[PARTS] = len(self.parts())
        if outcome is not None:
            self.note["outcome"] = {str(key): plain(value) for key, value in outcome.items()}
        if measures is not None:
            self.note["measures"] = {str(key): plain(value) for key, value in measures.items()}
        self.save_note()
        if state == "finished":
            (self.path / "checkpoint.npz").unlink(missing_ok=True)

    def save_note(self) -> None:
        """Write ``run.json``."""
        text = json.dumps(self.note, indent=1) + "\n"
        self._put(self.path / "run.json", lambda file: file.write_text(text, encoding="utf-8"))

    def _put(self, path: Path, write: Callable[[Path], Any]) -> None:
        try:
            write_safely(path, write)
        except ResultError as reason:
            raise ResultError(
                f"{reason}; the {len(self.parts())} parts written before are kept and can be read. "
                "Make room, then start the run again: it continues from its last checkpoint"
            ) from None


def read_note(folder: Path) -> dict[str, Any]:
    """What ``run.json`` in the folder of a run says.

    Raises
    ------
    ResultError
        If there is none, or it is damaged.
    """
    path = folder / "run.json"
    try:
        note: Any = json.loads(path.read_text(encoding="utf-8"))
        json.dumps(note, ensure_ascii=False).encode("utf-8")  # half a character, which JSON may hold, is refused here
    except FileNotFoundError:
        raise ResultError(f"{folder}: no run of an archive; there is no run.json in it") from None
    except (OSError, ValueError, RecursionError) as reason:
        raise ResultError(f"{path}: cannot be read: {reason}; {BEGIN_ANEW}") from None
    shape = {"state": str, "parameters": dict, "question": dict, "measures": dict, "outcome": dict, PARTS: int}
    wrong = [
        key for key, kind in shape.items() if isinstance(note, dict) and not isinstance(note.get(key, kind()), kind)
    ]
    if isinstance(note, dict) and not wrong:
        wrong = [
            f"{table}: {key!r}"
            for table, kinds in (("measures", (int, float)), ("outcome", (str, int, float)))
            for key, value in note.get(table, {}).items()
            if value is not None and not isinstance(value, kinds)
        ]
    if not isinstance(note, dict) or wrong:
        raise ResultError(f"{path}: cannot be read: {wrong[0] if wrong else 'it'} has another form; {BEGIN_ANEW}")
    return note


def plain(value: Any) -> Any:
    """A value as JSON says it; nan and infinity become None."""
    if isinstance(value, (np.ndarray, xr.DataArray)):
        return plain(np.asarray(value).tolist())
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value if isinstance(value, (bool, int, float, str)) or value is None else str(value)


def _savez(path: Path, held: Mapping[str, NDArray[Any]]) -> None:
    with path.open("wb") as file:
        np.savez(file, **held)  # type: ignore[arg-type]


# Samples of a long run in many files, read as one dataset: only what is asked for comes into memory.


NETCDF = threading.RLock()  # the library must not be entered by two threads


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
            lazy = indexing.LazilyIndexedArray(_Parts(files, name, starts, variable.shape[1:], variable.dtype))
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


class _Parts(BackendArray):
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
        found = np.empty((wanted.size, *self.shape[1:]), self.dtype)
        for file, start, end in zip(self.files, self.starts[:-1], self.starts[1:], strict=True):
            here = np.flatnonzero((wanted >= start) & (wanted < end))
            if here.size == 0:
                continue
            local = wanted[here] - start
            low, high = int(local.min()), int(local.max()) + 1
            found[here] = _samples(file, (self.name,), slice(low, high))[self.name][local - low]
        for axis in range(len(key) - 1, 0, -1):
            found = found[(slice(None),) * axis + (key[axis],)]
        return found[0] if isinstance(key[0], (int, np.integer)) else found


# One process at a time writes a run of an archive.
#
# The file ``lock`` in the folder of a run names its writer. Where the system locks files (Linux and macOS, and NFS
# from Linux 2.6.12 on) the lock ends with its process, however that ends, so a lock that was left behind is no lock.
# Where it does not, the note alone counts, and a writer on this host that no longer lives is found by its number.


fcntl: ModuleType | None
try:
    import fcntl
except ImportError:  # Windows
    fcntl = None


MAY_WAIT, ACCESS_DENIED, NOT_ENDED = 0x00100000, 5, 0x102  # SYNCHRONIZE, ERROR_ACCESS_DENIED, WAIT_TIMEOUT of Windows


class RunLock:
    """Held while a run is written: ``with RunLock(folder): ...``.

    Parameters
    ----------
    folder
        Of the run; it must be there.

    Raises
    ------
    ResultError
        On entry, if another process writes the run, or may do so; the message names it. Also if the folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.path = folder, folder / "lock"
        self.file: int | None = None

    def __enter__(self) -> RunLock:
        while self.file is None:
            try:
                file = os.open(self.path, os.O_RDWR | os.O_CREAT, 0o644)
            except OSError as reason:
                raise ResultError(f"{self.path}: cannot be written: {reason}") from None
            try:
                self._take(file)
            except OSError as reason:  # a full disk
                raise ResultError(f"{self.path}: cannot be written: {reason.strerror or reason}") from None
            finally:
                if self.file is None:
                    os.close(file)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.file is None:
            return
        if fcntl is None:  # Windows deletes no open file
            os.close(self.file)
        with contextlib.suppress(OSError):
            os.unlink(self.path)
        if fcntl is not None:
            os.close(self.file)
        self.file = None

    def _take(self, file: int) -> None:
        locked = _lock(file)
        owner = _read(file)
        if locked is False:
            raise ResultError(f"{self.folder}: {_told(owner)} is writing this run; wait for it, or give another name")
        if not _same(file, self.path):
            return  # the writer before took the file away while it ended: try the new one
        here = socket.gethostname()
        if locked is None and owner and (owner.get("host") != here or _lives(owner)):
            raise ResultError(
                f"{self.folder}: {_told(owner)} may still be writing this run; this cannot be checked from here. "
                f"If it is gone, delete {self.path} and start again"
            )
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        note = json.dumps({"process": os.getpid(), "host": here, "since": now}) + "\n"
        os.ftruncate(file, 0)
        os.lseek(file, 0, os.SEEK_SET)
        os.write(file, note.encode())
        os.fsync(file)
        self.file = file


def _lock(file: int) -> bool | None:
    """Whether the system gave the lock; None if it has none for this folder."""
    if fcntl is None:
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


def _same(file: int, path: Path) -> bool:
    """Whether ``path`` still is the open file."""
    try:
        return os.path.samestat(os.fstat(file), os.stat(path))
    except FileNotFoundError:
        return False


def _read(file: int) -> dict[str, Any]:
    os.lseek(file, 0, os.SEEK_SET)
    try:
        note = json.loads(os.read(file, 4096))
    except ValueError:
        return {}  # new, or its writer was stopped in the middle
    return note if isinstance(note, dict) else {}


def _lives(owner: dict[str, Any]) -> bool:
    if sys.platform == "win32":  # signal 0 would be Ctrl-C there
        return _lives_on_windows(owner)
    try:
        os.kill(int(owner["process"]), 0)
    except (ProcessLookupError, KeyError, ValueError):
        return False
    except OSError:
        return True
    return True


def _lives_on_windows(owner: dict[str, Any]) -> bool:
    """Whether the process is there and has not ended, by a handle of it."""
    import ctypes

    number = owner.get("process")
    if not isinstance(number, int):
        return False
    kernel: Any = getattr(ctypes, "WinDLL")("kernel32", use_last_error=True)  # noqa: B009  # missing elsewhere
    handle = kernel.OpenProcess(MAY_WAIT, False, number)
    if not handle:
        return bool(getattr(ctypes, "get_last_error")() == ACCESS_DENIED)  # noqa: B009
    try:
        return bool(kernel.WaitForSingleObject(handle, 0) == NOT_ENDED)
    finally:
        kernel.CloseHandle(handle)


def _told(owner: dict[str, Any]) -> str:
    if not owner:
        return "another process"
    return f"process {owner.get('process')} on {owner.get('host')}, since {owner.get('since')},"
