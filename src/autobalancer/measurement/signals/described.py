"""What the user says of the channels of a file: column, quantity, unit, place, direction, sensitivity."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from autobalancer.errors import QuestionError
from autobalancer.files.text import MACHINE, read_text

EXAMPLE = (
    '[channels.x]\ncolumn = "ai0"\nquantity = "displacement"\nunit = "V"\nsensitivity = "8 mV/um"\ndirection = "x"'
)


@dataclass(frozen=True)
class DescribedChannel:
    """One channel in words; what is empty is taken from the file.

    Attributes
    ----------
    column
        Its name in the file; by default that of the channel.
    quantity, unit, place, direction
        Of the channel; the unit is that of the numbers in the file. The quantity ``time`` says that the column has the instants.
    sensitivity
        Of the sensor, voltage over quantity, such as "100 mV/g", "200 mV/mil" or "4 mV/(mm/s)"; the numbers of the file
        are then voltages.
    full_scale
        Value at the greatest number that the file can hold, such as "20 m/s^2"; for sound files.
    uncertainty
        One standard deviation of a value, such as "1 um".
    """

    column: str = ""
    quantity: str = ""
    unit: str = ""
    place: str = ""
    direction: str | float = ""
    sensitivity: str = ""
    full_scale: str = ""
    uncertainty: str = ""


Described = Mapping[str, Mapping[str, Any] | DescribedChannel]


def described_channels(given: Described | str | Path | None, beside: Path | None = None) -> dict[str, DescribedChannel]:
    """The channels that were described, by name; empty if none were.

    Parameters
    ----------
    given
        By name, a TOML file with a table ``channels``, or ``None``.
    beside
        The file of the signals; where nothing was given, ``NAME.channels.toml`` beside it is read if it exists.

    Raises
    ------
    QuestionError
        If a key is unknown.
    """
    if given is None and beside is not None:
        own = beside.with_name(f"{beside.stem}.channels.toml")
        given = own if own.is_file() else None
    if given is None:
        return {}
    place = ""
    if isinstance(given, (str, Path)):
        place, given = f"{given}: ", _from_file(Path(given))
    return {
        str(name): one if isinstance(one, DescribedChannel) else _one(place, str(name), one)
        for name, one in given.items()
    }


def _from_file(path: Path) -> Mapping[str, Any]:
    try:
        found = tomllib.loads(read_text(path, MACHINE, QuestionError)).get("channels")
    except tomllib.TOMLDecodeError as reason:
        raise QuestionError(f"{path}: {reason}") from None
    if not isinstance(found, dict) or not found:
        raise QuestionError(f"{path}: no table of channels; write for each\n{EXAMPLE}")
    return found


def _one(place: str, name: str, given: Any) -> DescribedChannel:
    if not isinstance(given, Mapping):
        raise QuestionError(f"{place}channels.{name}: given {given!r}; must be a table, such as\n{EXAMPLE}")
    known = [field.name for field in fields(DescribedChannel)]
    for key, value in given.items():
        if key not in known:
            near = get_close_matches(str(key), known, 1)
            meant = f"; did you mean {near[0]}?" if near else f"; there are {', '.join(known)}"
            raise QuestionError(f"{place}channels.{name}: no key {key!r}{meant}")
        if not isinstance(value, str) and not (key == "direction" and isinstance(value, (int, float))):
            raise QuestionError(f"{place}channels.{name}.{key}: given {value!r}; must be a text")
    return DescribedChannel(**given)
