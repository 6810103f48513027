"""A named tuple as kernels see it: a copy in the memory of the function that looks at it; each part is loaded on its own.

As one value a machine has some six hundred words, and all of them would be written down wherever one of its parts is used:
a third of the time that the equations of motion took to compile. The optimizer leaves of a copy those parts that are used.
"""

from __future__ import annotations

from functools import cache
from typing import Any
from zlib import crc32

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import lower_getattr_generic, register_model

WORD = 8  # bytes


class Copied(types.Type):
    """A named tuple in memory."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind
        super().__init__(f"Copied({kind.instance_class.__name__}, {crc32(str(kind).encode())})")

    @property
    def key(self) -> Any:
        """What tells it from others."""
        return self.kind


@register_model(Copied)
class _Pointer(models.OpaqueModel):
    """A pointer to bytes."""


def seen(kind: Any) -> Any:
    """What kernels see of a part: pairs and the like are taken apart, named tuples stay where they are."""
    if isinstance(kind, types.BaseNamedTuple):
        return Copied(kind)
    return types.Tuple(tuple(map(seen, _kinds(kind)))) if isinstance(kind, types.BaseTuple) else kind


def _kinds(pair: Any) -> Any:
    """Types of the parts of a tuple."""
    return pair.types


def look(context: Any, builder: Any, kind: Any, pointer: Any) -> Any:
    """The value of such a part, whose bytes begin here."""
    if isinstance(kind, types.BaseNamedTuple):
        return pointer
    if isinstance(kind, types.BaseTuple):
        kinds = enumerate(_kinds(kind))
        parts = [look(context, builder, part, _at(context, builder, kind, i, pointer)) for i, part in kinds]
        return context.make_tuple(builder, seen(kind), parts)
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


def copy(context: Any, builder: Any, kind: Any, pointer: Any) -> Any:
    """A copy of a tuple, valid until the calling function returns."""
    size = context.get_abi_sizeof(context.get_value_type(kind))
    place = cgutils.alloca_once(builder, ir.ArrayType(ir.IntType(8 * WORD), -(-size // WORD)))
    here, there = (builder.bitcast(each, cgutils.voidptr_t) for each in (place, pointer))
    move = builder.module.declare_intrinsic("llvm.memcpy", [cgutils.voidptr_t, cgutils.voidptr_t, ir.IntType(64)])
    call = builder.call(move, [here, there, ir.Constant(ir.IntType(64), size), cgutils.false_bit])
    for i in range(2):
        call.arg_attributes[i] = ir.ArgumentAttributes()
        call.arg_attributes[i].align = WORD
    return here


def _at(context: Any, builder: Any, kind: Any, index: int, pointer: Any) -> Any:
    return builder.gep(pointer, [ir.Constant(ir.IntType(64), _offset(context, kind, index))], inbounds=True)


@cache
def _offset(context: Any, kind: Any, index: int) -> int:
    """Bytes before a part."""
    whole = context.get_value_type(kind)
    if isinstance(whole, ir.ArrayType):
        return index * int(context.get_abi_sizeof(whole.element))
    return int(whole.get_element_offset(context.target_data, index))


@infer_getattr
class _Parts(AttributeTemplate):
    key = Copied

    def generic_resolve(self, value: Any, attr: str) -> Any:  # type: ignore[override]
        """Type of a part."""
        if attr in value.kind.fields:
            return seen(value.kind.types[value.kind.fields.index(attr)])
        return None


@lower_getattr_generic(Copied)
def _part(context: Any, builder: Any, whole: Any, pointer: Any, name: str) -> Any:
    index = whole.kind.fields.index(name)
    return look(context, builder, whole.kind.types[index], _at(context, builder, whole.kind, index, pointer))
