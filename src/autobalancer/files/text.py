"""Text files of others, read as far as they may go, and what TOML says in them."""

from __future__ import annotations

import datetime
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from autobalancer.errors import AutobalancerError, Problem, QuestionError, UnitError
from autobalancer.files.samples import sample_hint
from autobalancer.safe_file import not_to_read
from autobalancer.units import shortened

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


def read_toml(path: Path, error: type[AutobalancerError] = QuestionError) -> dict[str, Any]:
    """The content of a TOML file of at most 10 MB; raises as :func:`read_text`, also if it is no TOML."""
    return parsed_toml(read_text(path, MACHINE, error), str(path), error)


def parsed_toml(text: str, place: str, error: type[AutobalancerError] = QuestionError) -> dict[str, Any]:
    """The content of a text in TOML.

    Parameters
    ----------
    text
        What was read.
    place
        What messages begin with.
    error
        The kind of error to raise.

    Raises
    ------
    AutobalancerError
        Of the given kind, if it is no text, no TOML, or holds a date.
    """
    if not isinstance(text, str):
        raise error(f"{place}: given a {type(text).__name__}; wanted is the text of a file")
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as reason:  # also a number of thousands of digits
        path = " (a path of Windows needs single quotes, or / for each \\)" if "\\" in str(reason) else ""
        raise error(f"{place}: not valid TOML: {reason}{path}") from None
    for problem in _odd_values(data, ()):
        raise error.of(place, [problem])
    return data


def _odd_values(value: Any, path: tuple[str | int, ...]) -> Iterator[Problem]:
    """Values that TOML knows and no file of ours does."""
    if isinstance(value, dict):
        for key, entry in value.items():
            yield from _odd_values(entry, (*path, key))
    elif isinstance(value, list):
        for number, entry in enumerate(value):
            yield from _odd_values(entry, (*path, number))
    elif isinstance(value, (datetime.date, datetime.time)):
        yield path, f"given the date or time {value}; no key takes one, put a text in quotes"


def question_data(argument: Any, what: str, name: str) -> tuple[dict[str, Any], str, Path, str]:
    """What a file, or a dict of the same form, asks.

    Parameters
    ----------
    argument
        The path of the file, or the dict.
    what, name
        Of a dict: what messages call it, and its name.

    Returns
    -------
    dict, str, Path, str
        Its tables; what messages begin with; the folder from which files are seen; a name.

    Raises
    ------
    QuestionError
        If it is neither, or the file cannot be read.
    """
    if isinstance(argument, Mapping):
        return {str(key): value for key, value in argument.items()}, what, Path(), name
    if not isinstance(argument, (str, Path)):
        raise QuestionError(f"{what}: given {shortened(argument)}; give the path of a file, or a dict of its form")
    path = Path(argument)
    return read_toml(path), str(path), path.parent, path.stem


@contextmanager
def faults_of(source: str) -> Iterator[None]:
    """Let questions that are refused meanwhile begin with the file they are from."""
    try:
        yield
    except (QuestionError, UnitError) as error:
        several = "not possible as described" if len(error.problems) > 1 else ""
        raise QuestionError.of(source, error.problems, several) from None


def decoded(content: bytes, otherwise: str = "") -> str:
    """The text of bytes in UTF-8, in UTF-16 with its mark, or in another encoding; raises as :func:`encoding_of`."""
    encoding = encoding_of(content, otherwise)
    return content.decode(encoding, "replace" if encoding == otherwise else "strict")


def encoding_of(content: bytes, otherwise: str = "") -> str:
    """The encoding of bytes: UTF-8, UTF-16 with its mark, or the other one.

    Raises
    ------
    ValueError
        If it is no text.
    """
    if content[:2] in _WIDE:
        return "utf-16"
    if b"\0" in content:
        raise ValueError("is no text")
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError:
        if not otherwise:
            raise
        return otherwise
    return "utf-8-sig"
