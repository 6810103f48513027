"""One process at a time writes a run of an archive.

The file ``lock`` in the folder of a run names its writer. Where the system locks files (Linux and macOS, and NFS from Linux
2.6.12 on) the lock ends with its process, however that ends, so a lock that was left behind is no lock. Where it does not,
the note alone counts, and a writer on this host that no longer lives is found by its number.
"""

from __future__ import annotations

import contextlib
import datetime
import json
import os
import socket
import sys
from pathlib import Path
from types import ModuleType, TracebackType
from typing import Any

from autobalancer.errors import ResultError

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
