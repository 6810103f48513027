"""Columns of a file before they are channels: numbers with the unit that the file names, if it names one."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RawColumn:
    """Numbers as they stand in the file; nan where it has none. ``quantum`` is their last digit, zero if they are not rounded."""

    values: Floats
    unit: str = ""
    quantity: str = ""
    place: str = ""
    direction: str | float = ""
    quantum: float = 0.0


@dataclass(frozen=True, eq=False)
class RawFile:
    """Columns by name over instants in s.

    Attributes
    ----------
    origin
        Name of the file, for messages.
    time
        Instants, s; ``None`` where the file has none.
    rate
        Samples in a second, where the file says it and has no instants.
    columns
        All but the time.
    quantum
        Last digit of the written instants, s; zero where they are not rounded.
    """

    origin: str
    time: Floats | None
    rate: float | None
    columns: dict[str, RawColumn] = field(default_factory=dict)
    quantum: float = 0.0
