"""Folders on disk that keep what was computed: a note that says what it is, parts, a lock, and a search.

Runs of an archive, studies, designs, stepped responses and all that the page keeps are such folders. Each file in them is
written beside its place and moved there when complete, so that a crash, or a disk that is full, leaves what was there before.
"""

from __future__ import annotations

import datetime
import hashlib
import json
import os
import re
import secrets
import shutil
import socket
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar
from zipfile import BadZipFile

import numpy as np
from pydantic import TypeAdapter, ValidationError

from autobalancer.errors import QuestionError, ResultError
from autobalancer.safe_file import as_path, write_safely, write_text_safely

if sys.platform == "win32":
    import msvcrt

    def _system_lock(file: int) -> None:
        os.lseek(file, 1 << 30, os.SEEK_SET)  # a byte that no reader of the note comes to
        msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _system_lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


N = TypeVar("N")

# The note: a dataclass, as JSON.

NOTE, LOCK = "note.json", "lock"


def has_note(folder: Path) -> bool:
    """Whether a folder is one of these."""
    return (folder / NOTE).is_file()


def write_note(folder: Path, note: Any) -> None:
    """Write the note of a folder, a dataclass."""
    write_text_safely(folder / NOTE, json.dumps(asdict(note), indent=1) + "\n")


def read_note(folder: Path, kind: type[N], cure: str = "delete its folder") -> N:
    """The note of a folder.

    Raises
    ------
    ResultError
        If there is none, or it is damaged; the message ends with the ``cure``.
    """
    path = folder / NOTE
    try:
        note: Any = json.loads(path.read_text(encoding="utf-8"))
        json.dumps(note, ensure_ascii=False).encode("utf-8")  # half a character, which JSON may hold, is refused here
        adapter: TypeAdapter[N] = _adapter(kind)  # type: ignore[arg-type]  # a class can be hashed
        return adapter.validate_python(note)
    except FileNotFoundError:
        raise ResultError(f"{folder}: there is no {NOTE} in it") from None
    except ValidationError as reason:
        first = reason.errors()[0]
        said = f"{'.'.join(map(str, first['loc']))}: {first['msg']}".removeprefix(": ")
        raise ResultError(f"{path}: cannot be read: {said}; {cure}") from None
    except (OSError, ValueError, RecursionError) as reason:
        raise ResultError(f"{path}: cannot be read: {reason}; {cure}") from None


@cache
def _adapter(kind: Any) -> Any:
    return TypeAdapter(kind)


def plain(value: Any) -> Any:
    """A value as JSON says it; nan and infinity become None."""
    if hasattr(value, "__array__"):  # of NumPy and xarray
        return plain(np.asarray(value).tolist())
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value if isinstance(value, (bool, int, float, str)) or value is None else str(value)


def refuse_other_question(path: Path, kind: str, there: Mapping[str, Any], now: Mapping[str, Any]) -> None:
    """Refuse a folder that holds the answer to another question.

    Raises
    ------
    QuestionError
        With the settings that differ, short ones with their values.
    """
    differ = [key for key in {**there, **now} if there.get(key) != now.get(key)]
    if differ:
        named = ", ".join(f"{key}{_both(there.get(key), now.get(key))}" for key in differ)
        raise QuestionError(
            f"{path}: holds another {kind}; different: {named}. Give another place, or delete this {kind}"
        )


def _both(there: Any, now: Any) -> str:
    short = all(
        value is None or (isinstance(value, (int, float, str)) and len(str(value)) < 30) for value in (there, now)
    )
    return f" ({there!r} there, {now!r} now)" if short else ""


# One process at a time writes a folder.


@contextmanager
def locked(folder: Path, kind: str) -> Iterator[None]:
    """While it lasts, no other process or thread writes in a folder.

    The file ``lock`` names the writer. The system takes the lock back when the process ends, however it ends, so a file that
    was left behind is no lock. Where a disk knows no locks, the file alone counts.

    Raises
    ------
    ResultError
        If another process writes there, or may do so; the message names it. Also if the folder cannot be written.
    """
    path = folder / LOCK
    try:
        file = path.open("a+", encoding="utf-8")
    except OSError as reason:
        raise ResultError(f"{path}: cannot be written: {reason.strerror}") from None
    with file:
        taken = _is_locked(file.fileno())
        file.seek(0)
        owner = file.read(200).strip()
        if taken:
            raise ResultError(
                f"{folder}: {owner or 'another process'} is writing this {kind}; wait for it, or give another place"
            )
        if taken is None and owner:
            raise ResultError(
                f"{folder}: {owner} may still be writing this {kind}; this cannot be checked here. If it is gone, "
                f"delete {path} and start again"
            )
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        try:
            file.truncate(0)
            file.write(f"process {os.getpid()} on {socket.gethostname()}, since {now},")
            file.flush()
        except OSError as reason:  # a full disk
            raise ResultError(f"{path}: cannot be written: {reason.strerror}") from None
        try:
            yield
        finally:
            with suppress(OSError):
                file.truncate(0)


def _is_locked(file: int) -> bool | None:
    """Whether another process has the lock; None if the system knows none for this place."""
    try:
        _system_lock(file)
    except (BlockingIOError, PermissionError):
        return True
    except OSError:
        return None
    return False


# A computation in parts, of which none that is finished is ever lost.


FORM = 4  # of the files
PARTS, CHECKSUM = "parts", "checksum"
Arrays = dict[str, np.ndarray]
Span = tuple[int, int]  # by which a part is known


@dataclass
class Note:
    """The note of such a folder: what was asked."""

    kind: str
    form: int
    question: dict[str, Any]


class Store:
    """The folder of one computation, which it keeps for itself until it is closed.

    Parameters
    ----------
    folder
        Made if there is none.
    question
        All on which the answer depends, as plain data.
    kind
        What messages call it.

    Raises
    ------
    QuestionError
        If the folder belongs to another question, or holds other files.
    ResultError
        If it cannot be read or written, or another process works in it.
    """

    def __init__(self, folder: str | Path, question: dict[str, Any], kind: str) -> None:
        self.folder, self.kind = as_path(folder), kind
        try:
            other = not has_note(self.folder) and self.folder.exists() and any(self.folder.iterdir())
        except OSError as reason:
            raise ResultError(f"{self.folder}: is no folder that can be read: {reason.strerror}") from None
        if other:
            raise QuestionError(f"{self.folder}: has other files in it and no {kind}; give a new or empty folder")
        now = Note(kind, FORM, json.loads(json.dumps(question)))
        self._begun, self._new = not has_note(self.folder), not self.folder.exists()
        if self._begun:
            write_note(self.folder, now)
        there = read_note(self.folder, Note, "give another folder")
        if (there.kind, there.form) != (kind, FORM):
            raise QuestionError(
                f"{self.folder}: holds no {kind}, or one of another version of autobalancer; give another folder, or delete it"
            )
        refuse_other_question(self.folder, kind, there.question, now.question)
        self._lock = locked(self.folder, kind)
        self._lock.__enter__()

    def parts(self) -> dict[Span, Arrays]:
        """All finished parts."""
        return {span: read_part(path) for span, path in part_files(self.folder).items()}

    def keep(self, span: Span, arrays: Mapping[str, Any]) -> None:
        """Write a finished part."""
        name, known = f"{span[0]:09d}-{span[1]:09d}", {key: np.asarray(value) for key, value in arrays.items()}

        known = {key.replace("/", "|"): array for key, array in known.items()} | {CHECKSUM: checksum(name, known)}
        write_arrays(self.folder / PARTS / f"{name}.npz", known)

    def close(self) -> None:
        """Give the folder back to others."""
        self._lock.__exit__(None, None, None)

    def remove(self) -> None:
        """Delete the folder, when its answer is kept elsewhere."""
        self.close()
        shutil.rmtree(self.folder)

    def __enter__(self) -> Store:
        return self

    def __exit__(self, why: type[BaseException] | None, *_: object) -> None:
        self.close()
        if why is not None and issubclass(why, QuestionError) and self._begun:
            with suppress(
                OSError
            ):  # what was asked was refused: the folder is given back as it was, if nothing was kept
                if {path.name for path in self.folder.iterdir()} <= {NOTE, LOCK}:
                    for path in (self.folder / NOTE, self.folder / LOCK):
                        path.unlink(missing_ok=True)
                    if self._new:
                        self.folder.rmdir()


def write_arrays(path: Path, arrays: Mapping[str, Any]) -> None:
    """Write arrays to a file, which is replaced only when the new one is complete."""

    def write(place: Path) -> None:
        with place.open("wb") as file:  # a name would get the suffix that it lacks
            np.savez(file, **arrays)

    write_safely(path, write)


def part_files(folder: Path) -> dict[Span, Path]:
    """The files of the finished parts in a folder, also while it is written."""
    result = {}
    for path in sorted((folder / PARTS).glob("*.npz")):
        if numbers := re.fullmatch(r"([0-9]{9,})-([0-9]{9,})", path.stem):
            result[int(numbers[1]), int(numbers[2])] = path
    return result


def read_part(path: Path) -> Arrays:
    """The arrays of a finished part.

    Raises
    ------
    ResultError
        If the file is damaged.
    """
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name.replace("|", "/"): stored[name] for name in stored.files}
        if arrays.pop(CHECKSUM, np.zeros(0)).tolist() != checksum(path.stem, arrays).tolist():
            raise ValueError("what is in it was not written here")
    except (OSError, ValueError, EOFError, KeyError, BadZipFile) as reason:
        raise ResultError(f"{path}: is damaged: {reason}; delete it, and it is computed again") from None
    return arrays


def checksum(name: str, arrays: Arrays) -> np.ndarray:
    """SHA-256 of a part: its numbers, and the names and contents of its arrays; 32 bytes."""
    content = hashlib.sha256(name.encode())
    for key in sorted(arrays):
        array = np.ascontiguousarray(arrays[key])
        content.update(f"{key} {array.dtype.str} {array.shape}".encode())
        content.update(array.tobytes())
    return np.frombuffer(content.digest(), np.uint8)


# Folders with notes of one kind, beside each other.


class NamedNote(Protocol):
    """A note that has the name of its folder."""

    __dataclass_fields__: ClassVar[dict[str, Any]]
    name: str


E = TypeVar("E", bound=NamedNote)
NAME = re.compile(r"\d{8}-\d{6}-[0-9a-f]{6}")  # checked, so that no path leaves the folder of its user


def new_name() -> str:
    """A new name: date, time (UTC) and six random digits."""
    return f"{datetime.datetime.now(datetime.UTC):%Y%m%d-%H%M%S}-{secrets.token_hex(3)}"


class Shelf(Generic[E]):
    """Folders that are named when they are made; what is on the disk is all there is, so a restart loses nothing.

    Parameters
    ----------
    home
        The folder in which they are.
    kind
        The class of their notes.
    word
        What messages call one.
    """

    def __init__(self, home: Path, kind: type[E], word: str) -> None:
        self.home, self.kind, self.word = home, kind, word

    def __len__(self) -> int:
        return sum(1 for _ in self.home.glob("*"))

    def folder(self, name: str) -> Path:
        """The folder of one.

        Raises
        ------
        QuestionError
            If there is none of this name.
        """
        place = self.home / name
        if not NAME.fullmatch(name) or place.is_symlink() or not place.is_dir():
            raise QuestionError(f"{self.word} {name[:40]!r}: there is none of this name; it may have been deleted")
        return place

    def new(self) -> Path:
        """A new folder, without a note."""
        place = self.home / new_name()
        place.mkdir(parents=True)
        return place

    def entry(self, name: str) -> E:
        """What is known of one.

        Raises
        ------
        QuestionError
            If there is none of this name, or its note cannot be read.
        """
        try:
            entry = read_note(self.folder(name), self.kind)
        except ResultError as reason:
            raise QuestionError(f"{self.word} {name}: {str(reason).replace(f'{self.home / name}/', '')}") from None
        if entry.name != name:
            raise QuestionError(f"{self.word} {name}: its note is that of {entry.name[:40]!r}")
        return entry

    def names(self) -> list[str]:
        """Of all that have a note, the latest first."""
        result = sorted((path.parent.name for path in self.home.glob(f"*/{NOTE}")), reverse=True)
        return [name for name in result if NAME.fullmatch(name)]

    def entries(self, unreadable: Callable[[str], E] | None = None) -> list[E]:
        """All of them, the latest first; one that cannot be read is left out, or what ``unreadable`` makes of its name."""
        result = []
        for name in self.names():
            try:
                result.append(self.entry(name))
            except QuestionError:
                result += [unreadable(name)] if unreadable else []
        return result

    def note(self, entry: E) -> None:
        """Keep what is known of one."""
        write_note(self.folder(entry.name), entry)

    def delete(self, name: str) -> None:
        """Remove one for good."""
        shutil.rmtree(self.folder(name))

    def tidy(self, before: float) -> None:
        """Remove what was left half: a folder without a note that is older than a time (s since 1970)."""
        for place in self.home.glob("*"):
            with suppress(OSError, QuestionError):
                if place.stat().st_mtime < before and not has_note(place):
                    self.delete(place.name)
