"""Plain pointers, for the calls that happen millions of times.

A NamedTuple of arrays goes by value as some sixty words, which costs as much as the equations themselves; and
an index into a pointer is not tested for being negative.

``data(array)``
    Pointer to the first element of a contiguous array, which the caller must keep.
``row(array, i)``
    Record ``i`` of an array of records. The compiler does not learn how far apart they are: if it did, it would gather a field
    of eight records at once, which takes more than twice as long as one after the other.
``address(value)``
    Pointer to a copy of a tuple, valid until the calling function returns.
``behind(value)``
    The tuple behind a pointer, or the tuple itself: compiled code passes the one, Python the other. It is as it was at this place
    (``copied.py``).
``plain(pointer)``
    The same pointer without its type. Function types take these: a type that lists all numbers of a machine makes every
    call from Python slow.
``pointer_to(kind)``
    A function that gives such a pointer its type back; a tuple stays what it is.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic

from autobalancer.kernels.copied import copy, look, seen


def _data(typing_context: Any, array: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.make_array(array)(context, builder, arguments[0]).data

    return types.CPointer(array.dtype)(array), generate


def _row(typing_context: Any, array: Any, index: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        rows = context.make_array(array)(context, builder, arguments[0])
        away = builder.mul(builder.extract_value(rows.strides, 0), arguments[1], flags=["nsw"])
        first = builder.bitcast(rows.data, ir.IntType(8).as_pointer())
        return builder.bitcast(builder.gep(first, [away], inbounds=True), context.get_value_type(array.dtype))

    return array.dtype(array, types.intp), generate


def _address(typing_context: Any, value: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return cgutils.alloca_once_value(builder, arguments[0])

    return types.CPointer(value)(value), generate


def _behind(typing_context: Any, value: Any) -> Any:
    def load(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return look(context, builder, value.dtype, copy(context, builder, value.dtype, arguments[0]))

    def same(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return arguments[0]

    return (seen(value.dtype)(value), load) if isinstance(value, types.CPointer) else (value(value), same)


def _plain(typing_context: Any, pointer: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], cgutils.voidptr_t)

    return types.voidptr(pointer), generate


def pointer_to(kind: Any) -> Any:
    """See above."""

    def typed(typing_context: Any, value: Any) -> Any:
        def cast(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return builder.bitcast(arguments[0], context.get_value_type(kind).as_pointer())

        def same(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return arguments[0]

        return (types.CPointer(kind)(value), cast) if value == types.voidptr else (value(value), same)

    return _itself if getattr(config, "DISABLE_JIT", False) else intrinsic(typed)


def _element(array: Any, index: int) -> Any:
    return array[index]


def _itself(value: Any) -> Any:
    return value


data: Any
row: Any
address: Any
behind: Any
plain: Any
if getattr(config, "DISABLE_JIT", False):  # interpreted, to look for faults: arrays and tuples are references there
    data, row, address, behind, plain = np.ravel, _element, _itself, _itself, _itself
else:
    data, row, address = intrinsic(_data), intrinsic(_row), intrinsic(_address)
    behind, plain = intrinsic(_behind), intrinsic(_plain)
