"""The door for quantities: ``"4.4 g"``, ``"1200 rpm"``, ``"20 mm^2/s"`` to SI and back, and ranges of them.

Inside the package every number is SI: a plain float. At the door a quantity may be a number (already SI) or a
string with a unit. :class:`WrittenFloat` is the float that remembers how it was written, so that a machine that is read
and saved again keeps its author's units.
"""

from autobalancer.units.quantity import (
    WrittenFloat,
    argument,
    column_factor,
    ends_argument,
    field_arguments,
    from_si,
    list_argument,
    option_to_si,
    optional_argument,
    sample,
    samples_of,
    shortened,
    texts_argument,
    to_si,
    unbalance_argument,
)

__all__ = [
    "WrittenFloat",
    "argument",
    "column_factor",
    "ends_argument",
    "field_arguments",
    "from_si",
    "list_argument",
    "option_to_si",
    "optional_argument",
    "sample",
    "samples_of",
    "shortened",
    "texts_argument",
    "to_si",
    "unbalance_argument",
]
