"""Text files of others, read as far as they may go."""

from __future__ import annotations

from pathlib import Path

from autobalancer.errors import AutobalancerError
from autobalancer.files.samples import sample_hint
from autobalancer.safe_file import not_to_read

MACHINE = 10_000_000  # bytes of a machine file
TABLE = 100_000_000  # bytes of a table
WINDOWS = "cp1252"  # of tables that old programs wrote
_WIDE = (b"\xff\xfe", b"\xfe\xff")  # marks of UTF-16, as Notepad and Excel ("Unicode text") write them


def read_text(path: Path, largest: int, error: type[AutobalancerError], place: str = "", otherwise: str = "") -> str:
    """The text of a file in UTF-8, with or without a mark at its beginning, or in UTF-16 with one.

    Parameters
    ----------
    path
        The file.
    largest
        Bytes that it may have; no more are read.
    error
        The kind of error to raise.
    place
        What messages begin with; by default the path.
    otherwise
        Encoding of a file that is not UTF-8; by default such a file is refused.

    Raises
    ------
    AutobalancerError
        Of the given kind, if there is no such file, it is a folder, a device or a pipe, cannot be read, is too large or no text.
    """
    place = place or str(path)
    if reason := not_to_read(path):
        raise error(f"{place}: {reason}{sample_hint(path)}")
    try:
        with path.open("rb") as file:
            content = file.read(largest + 1)
    except (OSError, ValueError) as fault:  # ValueError: no name of a file
        raise error(f"{place}: cannot be read: {fault}") from None
    if len(content) > largest:
        raise error(f"{place}: is larger than {largest // 1_000_000} MB; files of this kind are smaller")
    try:
        return decoded(content, otherwise).replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError:
        raise error(f"{place}: is no text in UTF-8; save it with this encoding") from None
    except ValueError as fault:
        raise error(f"{place}: {fault}") from None


def decoded(content: bytes, otherwise: str = "") -> str:
    """The text of bytes in UTF-8, in UTF-16 with its mark, or in another encoding.

    Raises
    ------
    ValueError
        If it is no text.
    """
    if content[:2] in _WIDE:
        return content.decode("utf-16")
    if b"\0" in content:
        raise ValueError("is no text")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        if not otherwise:
            raise
        return content.decode(otherwise, errors="replace")
