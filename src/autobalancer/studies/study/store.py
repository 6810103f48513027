"""The folder of a study: what was asked, and every finished chunk, so that nothing finished is ever lost.

A chunk is a file that is there as a whole or not at all. What was asked is written before the first of them; a folder of another
study is refused. A lock, which the system takes back when its process dies, keeps two processes from one folder.
"""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import IO, Any
from zipfile import BadZipFile

import numpy as np

from autobalancer.errors import QuestionError, ResultError
from autobalancer.safe_file import write_safely, write_text_safely

LOCK, CHUNKS, CHECKSUM = "lock", "chunks", "checksum"
FORM = 3  # of the files

Arrays = dict[str, np.ndarray]


class Store:
    """The folder of one study.

    Parameters
    ----------
    folder
        Made if there is none.
    identity
        What makes the study this one, as plain data.
    kind
        What messages call it.

    Raises
    ------
    QuestionError
        If the folder belongs to another study, holds other files, or another process works in it.
    ResultError
        If it cannot be written.
    """

    def __init__(self, folder: str | Path, identity: dict[str, Any], kind: str = "study") -> None:
        self.folder, self._kind = Path(folder), kind
        self._asked = self.folder / f"{kind}.json"
        self._identity = json.loads(json.dumps(identity))
        try:
            asked, other = self._asked.exists(), self.folder.exists() and any(self.folder.iterdir())
        except OSError as reason:
            raise ResultError(f"{self.folder}: is no folder that can be read: {reason.strerror}") from None
        if asked:
            self._compare()
        elif other:
            raise QuestionError(f"{self.folder}: has other files in it and no {self._kind}; give a new or empty folder")
        else:
            self._write()
        self._lock = self._locked()

    def chunks(self) -> dict[tuple[int, int], Arrays]:
        """All finished chunks, by (first, after the last) member."""
        return {span: read_chunk(path) for span, path in finished(self.folder).items()}

    def keep(self, first: int, last: int, arrays: Arrays) -> None:
        """Write a finished chunk."""

        def write(path: Path) -> None:
            with path.open("wb") as file:  # a name would get the suffix that it lacks
                np.savez(file, **_with_plain_names(arrays), **{CHECKSUM: checksum(name, arrays)})  # type: ignore[arg-type]

        name = f"{first:09d}-{last:09d}"
        write_safely(self.folder / CHUNKS / f"{name}.npz", write)

    def close(self) -> None:
        """Give the folder back to others."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def _write(self) -> None:
        content = {"form": FORM, self._kind: self._identity}
        write_text_safely(self._asked, json.dumps(content, indent=1))

    def _compare(self) -> None:
        try:
            stored = json.loads(self._asked.read_text(encoding="utf-8"))
            before, form = dict(stored[self._kind]), stored["form"]
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as reason:
            raise ResultError(f"{self._asked}: cannot be read: {reason}; give another folder") from None
        if form != FORM:
            raise QuestionError(
                f"{self.folder}: was written by another version of autobalancer; give another folder, or delete this one"
            )
        differ = [key for key in {**before, **self._identity} if before.get(key) != self._identity.get(key)]
        if differ:
            told = ", ".join(f"{key}{_both(before.get(key), self._identity.get(key))}" for key in differ)
            raise QuestionError(
                f"{self.folder}: holds another {self._kind}; different: {told}. Give another folder, or delete this one"
            )

    def _locked(self) -> IO[str] | None:
        try:
            import fcntl
        except ImportError:  # Windows
            return None
        try:
            file = (self.folder / LOCK).open("w")
        except OSError as reason:
            raise ResultError(f"{self.folder}: cannot be written: {reason.strerror}") from None
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            file.close()
            raise QuestionError(
                f"{self.folder}: another process is running this {self._kind}; wait for it, or stop it"
            ) from None
        return file


def finished(folder: Path) -> dict[tuple[int, int], Path]:
    """The files of finished chunks in the folder of a study, also while it runs, by (first, after the last) member."""
    found = {}
    for path in sorted((folder / CHUNKS).glob("*.npz")):
        if re.fullmatch(r"[0-9]{9,}-[0-9]{9,}", path.stem):
            first, _, last = path.stem.partition("-")
            found[int(first), int(last)] = path
    return found


def read_chunk(path: Path) -> Arrays:
    """The arrays of a finished chunk.

    Raises
    ------
    ResultError
        If the file is damaged.
    """
    try:
        with np.load(path, allow_pickle=False) as stored:
            arrays = {name.replace("|", "/"): stored[name] for name in stored.files}
            if arrays.pop(CHECKSUM, np.zeros(0)).tolist() != checksum(path.stem, arrays).tolist():
                raise ValueError("what is in it was not written by this study")
            return arrays
    except (OSError, ValueError, EOFError, KeyError, BadZipFile) as reason:
        raise ResultError(f"{path}: is damaged: {reason}; delete it, and the study runs its members again") from None


def checksum(name: str, arrays: Arrays) -> np.ndarray:
    """SHA-256 of a chunk: its members, and the names and contents of its arrays; 32 bytes."""
    content = hashlib.sha256(name.encode())
    for key in sorted(arrays):
        array = np.ascontiguousarray(arrays[key])
        content.update(f"{key} {array.dtype.str} {array.shape}".encode())
        content.update(array.tobytes())
    return np.frombuffer(content.digest(), np.uint8)


def _with_plain_names(arrays: Arrays) -> Arrays:
    return {name.replace("/", "|"): values for name, values in arrays.items()}


def _both(before: Any, now: Any) -> str:
    short = all(isinstance(one, (int, float, str)) and len(str(one)) < 30 for one in (before, now))
    return f" ({before!r} there, {now!r} now)" if short else ""
