"""Records: rows of numbers with names. The unit and the meaning of a number stand here once, where its record is defined.

A row of a record goes to compiled code as one pointer, where ``ball.mass`` costs what a column of a matrix costs. A field of
several numbers is an array there: ``ball.velocity[0]``.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import from_dtype, types

Rows = Any  # array of records
Row = Any  # one of them: whoever changes it, changes its array


class Field(NamedTuple):
    """One quantity of a record: a number, or several with a ``shape``."""

    name: str
    unit: str
    meaning: str
    shape: tuple[int, ...] = ()
    kind: type = np.float64


class Record:
    """Fields in the order in which they are in memory."""

    def __init__(self, *fields: Field) -> None:
        self.fields = fields
        self.dtype = np.dtype([(field.name, field.kind, field.shape) for field in fields], align=True)

    @property
    def row_type(self) -> Any:
        """What a signature calls one row."""
        return from_dtype(self.dtype)

    def rows_type(self, dimensions: int = 1) -> Any:
        """What a signature calls an array of rows."""
        return types.Array(self.row_type, dimensions, "C")

    def rows(self, *shape: int) -> Rows:
        """Rows of zeros."""
        return np.zeros(shape, self.dtype).view(np.recarray)

    def row(self, **values: Any) -> Row:
        """One row with these values, zero elsewhere."""
        row = self.rows(1)[0]
        for name, value in values.items():
            if name not in (self.dtype.names or ()):
                raise AttributeError(f"a record has no field {name}")
            row[name] = value
        return row
