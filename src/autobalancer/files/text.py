"""Text files of others, read as far as they may go."""

from __future__ import annotations

from pathlib import Path

from autobalancer.errors import AutobalancerError
from autobalancer.files.samples import sample_hint

MACHINE = 10_000_000  # bytes of a machine file
TABLE = 100_000_000  # bytes of a table


def read_text(path: Path, largest: int, error: type[AutobalancerError], place: str = "", otherwise: str = "") -> str:
    """The text of a file in UTF-8, with or without a mark at its beginning.

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
        Of the given kind, if there is no such file, it cannot be read, is too large or no text.
    """
    place = place or str(path)
    if path.is_dir():
        raise error(f"{place}: is a folder; give the path of a file")
    try:
        with path.open("rb") as file:
            content = file.read(largest + 1)
        text = _decoded(content, otherwise).replace("\r\n", "\n") if len(content) <= largest else ""
    except FileNotFoundError:
        raise error(f"{place}: no such file{sample_hint(path)}") from None
    except (OSError, ValueError) as reason:  # ValueError: no text, or no name of a file
        raise error(f"{place}: cannot be read: {reason}") from None
    if len(content) > largest:
        raise error(f"{place}: is larger than {largest // 1_000_000} MB; files of this kind are smaller")
    return text


def _decoded(content: bytes, otherwise: str) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        if not otherwise:
            raise
        return content.decode(otherwise)
