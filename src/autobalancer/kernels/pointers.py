"""Plain pointers, for the calls that happen millions of times.

A NamedTuple of arrays goes by value as some sixty words, which costs as much as the equations themselves; and
an index into a pointer is not tested for being negative.

``data(array)``
    Pointer to the first element of a contiguous array, which the caller must keep.
``address(value)``
    Pointer to a copy of a tuple, valid until the calling function returns.
``behind(value)``
    The tuple behind a pointer, or the tuple itself: compiled code passes the one, Python the other.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic


def _data(typing_context: Any, array: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.make_array(array)(context, builder, arguments[0]).data

    return types.CPointer(array.dtype)(array), generate


def _address(typing_context: Any, value: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return cgutils.alloca_once_value(builder, arguments[0])

    return types.CPointer(value)(value), generate


def _behind(typing_context: Any, value: Any) -> Any:
    def load(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load(arguments[0])

    def same(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return arguments[0]

    return (value.dtype(value), load) if isinstance(value, types.CPointer) else (value(value), same)


def _itself(value: Any) -> Any:
    return value


data: Any
address: Any
behind: Any
if getattr(config, "DISABLE_JIT", False):  # interpreted, to look for faults: arrays and tuples are references there
    data, address, behind = np.ravel, _itself, _itself
else:
    data, address, behind = intrinsic(_data), intrinsic(_address), intrinsic(_behind)
