"""Files that are complete or not there: how every result, machine, picture and note comes onto the disk.

A file is written beside its place under another name, brought to the disk, and moved to its place. So a disk that is full, a
crash or Ctrl-C leaves what was there before, and an unfinished file is removed again.
"""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
import shutil
import stat
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from autobalancer.errors import QuestionError, ResultError

NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_failed: list[Path] = []  # places of files that could not be written
HDF5, HEAP = b"\x89HDF\r\n\x1a\n", b"GCOL\1\0\0\0"  # what such a file and a heap of texts in it begin with
HEAD, LOOKED = 4096, 1 << 26  # bytes from the begin in which the one is sought, and the other
LITTLE = 65536  # bytes; with less room left a failure without a reason of its own is laid to the full disk


def as_path(path: str | Path) -> Path:
    """The path of a file as an argument names it.

    Raises
    ------
    QuestionError
        If it is neither a text nor a path, or no file can have this name.
    """
    if not isinstance(path, (str, os.PathLike)):
        raise QuestionError(
            f"path: given {str(path)[:40]} ({type(path).__name__}); give the path of a file as text or Path"
        )
    if "\0" in str(path):
        raise QuestionError(f"path: given {str(path)!r}; the name of a file has no zero character")
    return Path(path)


def write_safely(path: str | Path, write: Callable[[Path], Any]) -> Path:
    """Let ``write`` fill a new file, then move it to its place.

    Parameters
    ----------
    path
        The file; its folder is made if there is none. A link is followed.
    write
        Writes to the path it is given.

    Raises
    ------
    ResultError
        If the place is a folder or a device, or cannot be written, or the disk is full. What was there before is kept.
    """
    path = as_path(path)
    with _system_errors(path):
        place = _place(path)
        place.parent.mkdir(parents=True, exist_ok=True)
        unfinished = _beside(place)
        try:
            write(unfinished)
            # all of it is on the disk before it takes its name
            with unfinished.open("rb+") as file:
                os.fsync(file.fileno())
            if place.exists():  # as many people may read it as before
                os.chmod(unfinished, stat.S_IMODE(place.stat().st_mode))
            os.replace(unfinished, place)
        except (OSError, RuntimeError) as reason:
            raise ResultError(f"{path}: {_reason_text(reason, place)}") from None
        finally:
            if unfinished.exists():
                _failed.append(place)
                _drop(unfinished)
    return path


def write_text_safely(path: str | Path, text: str) -> Path:
    """Write a text file in UTF-8; raises as :func:`write_safely`."""
    return write_safely(path, lambda file: file.write_text(text, encoding="utf-8"))


def ready_to_write(*paths: str | Path | None) -> None:
    """Try the places of files before a long computation whose results they are to hold.

    Raises
    ------
    ResultError
        As :func:`write_safely` would later.
    """
    for path in (as_path(path) for path in paths if path is not None):
        with _system_errors(path):
            place = _place(path)
            folder = next(folder for folder in place.parents if folder.exists())
            trial = _beside(folder / place.name)
            try:
                trial.write_bytes(b"\n")
            finally:
                _drop(trial)


def not_to_read(path: Path) -> str:
    """Why there is no file to read at a place: it is missing, a folder, a device or a pipe; empty if there is one."""
    if path.is_file():
        return ""
    if path.is_dir():
        return "is a folder; give the path of a file"
    return "is a device or a pipe; give the path of a file" if path.exists() else "no such file"


def endless_heap(path: Path) -> str:
    """Why the HDF5 library would never come back from opening a file; empty if it will.

    Its global heaps are the part of a file without a checksum, and the library walks along them by the sizes that stand there:
    from one of size zero it does not get on (HDF5 File Format Specification 3.0, III.E).
    """
    with path.open("rb") as file:
        if HDF5 not in file.read(HEAD):
            return ""
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            at = data.find(HEAP, 0, LOOKED)
            while at >= 0:
                end = at + min(int.from_bytes(data[at + 8 : at + 16], "little"), len(data) - at)
                here = at + 16
                while here + 16 <= end:
                    size = int.from_bytes(data[here + 8 : here + 16], "little")
                    step = (
                        16 + size + -size % 8 if any(data[here : here + 2]) else size
                    )  # the free rest counts its head
                    if step == 0:
                        return f"a heap in it has no end, {here} bytes from its begin"
                    here += step
                at = data.find(HEAP, at + 4, LOOKED)
    return ""


def _beside(place: Path) -> Path:
    """A name for the unfinished file. The netCDF library never lets a file go that it could not write: not that name again."""
    again = f"{_failed.count(place)}-" if place in _failed else ""
    readable = place.name.encode("utf-8", "surrogateescape").decode("utf-8", "replace")  # libraries write no other name
    return place.with_name(f"unfinished-{again}{readable}")


def _drop(unfinished: Path) -> None:
    """Remove an unfinished file; emptied before, so that it takes no room even where a library keeps it open."""
    with contextlib.suppress(OSError):
        os.truncate(unfinished, 0)
    with contextlib.suppress(OSError):
        unfinished.unlink()


def _place(path: Path) -> Path:
    """Where a file really goes."""
    place = path.resolve()
    if place.is_dir():
        raise ResultError(f"{path}: is a folder; give the name of a file in it")
    if place.exists() and not place.is_file():
        raise ResultError(f"{path}: is a device or a pipe; give the name of a file")
    return place


@contextlib.contextmanager
def _system_errors(path: Path) -> Iterator[None]:
    """Whatever the system or the netCDF library (RuntimeError) says becomes one sentence."""
    try:
        yield
    except (OSError, RuntimeError) as reason:
        raise ResultError(f"{path}: {_reason_text(reason, path)}") from None


def _reason_text(reason: OSError | RuntimeError, path: Path) -> str:
    given = reason.errno if isinstance(reason, OSError) else None
    if given in NO_ROOM or (given is None and _full(path.parent)):
        return "the disk is full"
    return f"cannot be written: {(reason.strerror if isinstance(reason, OSError) else None) or reason}"


def _full(folder: Path) -> bool:
    try:
        return shutil.disk_usage(folder).free < LITTLE
    except OSError:
        return False
