"""A named tuple as kernels see it: its bytes in memory, of which each part is loaded on its own.

They are a copy in the memory of the function that looks at it, or those that Python gives (:func:`passed_by_address`). As one
value a machine has some six hundred words, and all of them would be written down wherever it is given or one of its parts is
used, which takes longer than to compile all else. The optimizer leaves of a copy those parts that are used.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from functools import cache
from typing import Any, TypeVar
from zlib import crc32

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import NativeValue, intrinsic, lower_getattr_generic, register_model, typeof_impl, unbox

from autobalancer.kernels.compiler.cache import stock

WORD = 8  # bytes
T = TypeVar("T")


class Struct(types.Type):
    """A named tuple in memory."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind
        super().__init__(f"Struct({kind.instance_class.__name__}, {crc32(str(kind).encode())})")

    @property
    def key(self) -> Any:
        """What tells it from others."""
        return self.kind


@register_model(Struct)
class _Pointer(models.OpaqueModel):
    """A pointer to bytes."""


def struct_of(kind: Any) -> Any:
    """What kernels see of a part: pairs and the like are taken apart, named tuples stay where they are."""
    if isinstance(kind, types.BaseNamedTuple):
        return Struct(kind)
    return types.Tuple(tuple(map(struct_of, _kinds(kind)))) if isinstance(kind, types.BaseTuple) else kind


def _kinds(pair: Any) -> Any:
    """Types of the parts of a tuple."""
    return pair.types


def load_part(context: Any, builder: Any, kind: Any, pointer: Any) -> Any:
    """The value of such a part, whose bytes begin here."""
    if isinstance(kind, types.BaseNamedTuple):
        return pointer
    if isinstance(kind, types.BaseTuple):
        kinds = enumerate(_kinds(kind))
        parts = [load_part(context, builder, part, _at(context, builder, kind, i, pointer)) for i, part in kinds]
        return context.make_tuple(builder, struct_of(kind), parts)
    return words(builder, builder.bitcast(pointer, context.get_value_type(kind).as_pointer()))


def words(builder: Any, pointer: Any) -> Any:
    """What a pointer points to, each number of it loaded on its own, so that the compiler drops those nobody wants."""
    kind = pointer.type.pointee
    if not isinstance(kind, (ir.LiteralStructType, ir.ArrayType)):
        return builder.load(pointer)
    count = kind.count if isinstance(kind, ir.ArrayType) else len(kind.elements)
    whole = ir.Constant(kind, ir.Undefined)
    for i in range(count):
        whole = builder.insert_value(whole, words(builder, cgutils.gep_inbounds(builder, pointer, 0, i)), i)
    return whole


def stored_kind(kind: Any) -> Any:
    """The tuple in memory, of one that has parts there or is there."""
    if isinstance(kind, Struct):
        return kind.kind
    parts = [stored_kind(part) for part in _kinds(kind)] if type(kind) is types.Tuple else []
    return types.Tuple(parts) if parts and parts != [*_kinds(kind)] else kind


def pack(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Copies of the parts of a tuple, one after the other, valid until the calling function returns."""
    whole = stored_kind(kind)
    place = cgutils.alloca_once(builder, context.get_value_type(whole))
    first = builder.bitcast(place, cgutils.voidptr_t)
    for index, part in enumerate(_kinds(kind)):
        here, given = _at(context, builder, whole, index, first), builder.extract_value(value, index)
        if isinstance(part, Struct):
            _move(builder, here, given, context.get_abi_sizeof(context.get_value_type(part.kind)))
        else:
            builder.store(given, builder.bitcast(here, given.type.as_pointer()))
    return place


def copy(context: Any, builder: Any, kind: Any, pointer: Any) -> Any:
    """A copy of a tuple, valid until the calling function returns."""
    size = context.get_abi_sizeof(context.get_value_type(kind))
    place = cgutils.alloca_once(builder, ir.ArrayType(ir.IntType(8 * WORD), -(-size // WORD)))
    here, there = (builder.bitcast(each, cgutils.voidptr_t) for each in (place, pointer))
    _move(builder, here, there, size)
    return here


def _move(builder: Any, here: Any, there: Any, size: int) -> None:
    move = builder.module.declare_intrinsic("llvm.memcpy", [cgutils.voidptr_t, cgutils.voidptr_t, ir.IntType(64)])
    call = builder.call(move, [here, there, ir.Constant(ir.IntType(64), size), cgutils.false_bit])
    for i in range(2):
        call.arg_attributes[i] = ir.ArgumentAttributes()
        call.arg_attributes[i].align = WORD


def _at(context: Any, builder: Any, kind: Any, index: int, pointer: Any) -> Any:
    return builder.gep(pointer, [ir.Constant(ir.IntType(64), _offset(context, kind, index))], inbounds=True)


@cache
def _offset(context: Any, kind: Any, index: int) -> int:
    """Bytes before a part."""
    whole = context.get_value_type(kind)
    if isinstance(whole, ir.ArrayType):
        return index * int(context.get_abi_sizeof(whole.element))
    return int(whole.get_element_offset(context.target_data, index))


def places_of_numbers(context: Any, kind: Any) -> Iterator[int]:
    """Bytes before each plain number of a tuple, in the order in which they stand."""
    for index, part in enumerate(_kinds(kind)):
        before = _offset(context, kind, index)
        if isinstance(part, types.BaseTuple):
            yield from (before + further for further in places_of_numbers(context, part))
        elif isinstance(part, types.Number):
            yield before


@infer_getattr
class _Parts(AttributeTemplate):
    key = Struct

    def generic_resolve(self, value: Any, attr: str) -> Any:  # type: ignore[override]
        """Type of a part."""
        if attr in value.kind.fields:
            return struct_of(value.kind.types[value.kind.fields.index(attr)])
        return None


@lower_getattr_generic(Struct)
def _part(context: Any, builder: Any, whole: Any, pointer: Any, name: str) -> Any:
    index = whole.kind.fields.index(name)
    return load_part(context, builder, whole.kind.types[index], _at(context, builder, whole.kind, index, pointer))


class PassedByAddress:
    """What :func:`passed_by_address` adds to a named tuple."""

    @property
    def address(self) -> int:
        """Where its words are, as long as it lives: numbers by their bits, arrays as Numba's structures without an owner."""
        kept = vars(self)
        if "words" not in kept:
            words = np.fromiter(_words(self), np.int64)
            kept.setdefault("words", (words.ctypes.data, words))  # of two threads at once one wins
        return int(kept["words"][0])

    def __getstate__(self) -> None:
        """Copies, also those in other processes, have words of their own."""


def passed_by_address(kind: type[T]) -> type[T]:
    """A class of named tuples that kernels get by address; the words of one are written down when it is first given."""
    if stock("struct"):
        return kind
    own = {"__doc__": kind.__doc__, "__module__": kind.__module__, "__qualname__": kind.__qualname__}
    return type(kind.__name__, (PassedByAddress, kind), own)


def struct_type(kind: Any) -> Any:
    """What a signature calls a tuple of such a class, of which Numba knows the ``kind``."""
    return kind if stock("struct") else Struct(kind)


def value_type(kind: Any) -> Any:
    """The tuple that stands at such an address."""
    return kind.kind if isinstance(kind, Struct) else kind


def _words(value: Any) -> Iterator[int]:
    if isinstance(value, tuple):
        for part in value:
            yield from _words(part)
    elif isinstance(value, np.ndarray):
        at = value.__array_interface__["data"][0]
        yield from (0, 0, value.size, value.itemsize, at, *value.shape, *value.strides)
    else:
        yield struct.unpack("q", struct.pack("d", value))[0] if isinstance(value, float) else int(value)


@typeof_impl.register(PassedByAddress)
def _type_of(value: Any, context: Any) -> Struct:
    return Struct(typeof_impl.dispatch(tuple)(value, context))


@unbox(Struct)
def _unbox(kind: Any, value: Any, c: Any) -> Any:
    number = c.pyapi.object_getattr_string(value, "address")
    address = c.pyapi.long_as_voidptr(number)
    c.pyapi.decref(number)
    return NativeValue(address, is_error=c.pyapi.c_api_error())


# Plain pointers, for the calls that happen millions of times.
#
# A NamedTuple of arrays goes by value as some sixty words, which costs as much as the equations themselves; and an
# index into a pointer is not tested for being negative.
#
# ``data(array)``
#     Pointer to the first element of a contiguous array, which the caller must keep.
# ``row(array, i)``
#     Record ``i`` of an array of records. The compiler does not learn how far apart they are: if it did, it would gather a field
#     of eight records at once, which takes more than twice as long as one after the other.
# ``address(value)``
#     Pointer to a copy of a tuple, or to the tuple itself where Python gave it, valid until the calling function returns.
# ``deref(value)``
#     The tuple behind a pointer, or the tuple itself: compiled code passes the one, Python the other. It is as it was here.
# ``as_void(pointer)``
#     The same pointer without its type. Function types take these: a type that lists all numbers of a machine makes every
#     call from Python slow.
# ``pointer_to(kind)``
#     A function that gives such a pointer its type back; a tuple stays what it is.


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
    if isinstance(value, Struct):
        return types.CPointer(value.kind)(value), _cast
    if stored_kind(value) != value:
        return types.CPointer(stored_kind(value))(value), _together

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return cgutils.alloca_once_value(builder, arguments[0])

    return types.CPointer(value)(value), generate


def _dereference(typing_context: Any, value: Any) -> Any:
    def load(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return load_part(context, builder, whole, copy(context, builder, whole, arguments[0]))

    def same(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return arguments[0]

    whole = value.kind if isinstance(value, Struct) else getattr(value, "dtype", None)
    return (struct_of(whole)(value), load) if isinstance(value, (Struct, types.CPointer)) else (value(value), same)


def _plain(typing_context: Any, pointer: Any) -> Any:
    return types.voidptr(pointer), _cast


def _together(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return pack(context, builder, signature.args[0], arguments[0])


def _cast(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.bitcast(arguments[0], context.get_value_type(signature.return_type))


def pointer_to(kind: Any) -> Any:
    """See above."""

    def typed(typing_context: Any, value: Any) -> Any:
        def same(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            return arguments[0]

        return (types.CPointer(kind)(value), _cast) if value == types.voidptr else (value(value), same)

    return _itself if getattr(config, "DISABLE_JIT", False) else intrinsic(typed)


def _element(array: Any, index: int) -> Any:
    return array[index]


def _itself(value: Any) -> Any:
    return value


data: Any
row: Any
address: Any
deref: Any
as_void: Any
if getattr(config, "DISABLE_JIT", False):  # interpreted, to look for faults: arrays and tuples are references there
    data, row, address, deref, as_void = np.ravel, _element, _itself, _itself, _itself
else:
    data, row, address = intrinsic(_data), intrinsic(_row), intrinsic(_address)
    deref, as_void = intrinsic(_dereference), intrinsic(_plain)


# The plain numbers of a tuple from an array: all arrays in it stay.
#
# ``with_numbers(value, words, first)`` is ``value`` with its numbers, in the order in which they stand, from ``words``
# (int64), from ``first`` on; floats are there by their bits. ``count_numbers(value)`` says how many there are.


def count_numbers(value: Any) -> int:
    """How many plain numbers a tuple has."""
    if isinstance(value, tuple):
        return sum(map(count_numbers, value))
    return 0 if isinstance(value, np.ndarray) else 1


def _with_numbers(typing_context: Any, value: Any, words: Any, first: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        given, array, start = arguments
        source = context.make_array(signature.args[1])(context, builder, array).data
        whole = isinstance(value, Struct)
        first_byte = copy(context, builder, value.kind, given) if whole else cgutils.alloca_once_value(builder, given)
        for number, offset in enumerate(places_of_numbers(context, value.kind if whole else value)):
            bits = builder.load(builder.gep(source, [builder.add(start, ir.Constant(start.type, number))]))
            there = builder.gep(builder.bitcast(first_byte, cgutils.voidptr_t), [ir.Constant(start.type, offset)])
            builder.store(bits, builder.bitcast(there, bits.type.as_pointer()))
        return first_byte if whole else builder.load(first_byte)

    return value(value, words, types.intp), generate


def _interpreted(value: Any, words: Any, first: int) -> Any:
    rest = iter(words[first : first + count_numbers(value)])

    def rebuilt(now: Any) -> Any:
        if isinstance(now, tuple):
            inner = [rebuilt(entry) for entry in now]
            return type(now)(*inner) if hasattr(now, "_fields") else tuple(inner)
        if isinstance(now, np.ndarray):
            return now
        word = next(rest)
        return float(word.view(np.float64)) if isinstance(now, float) else int(word)

    return rebuilt(value)


with_numbers: Any = _interpreted if getattr(config, "DISABLE_JIT", False) else intrinsic(_with_numbers)
