"""Several numbers at once as one value, in the vector registers of the processor: arithmetic without a branch.

A value of type ``Vector`` holds 2, 4 or 8 numbers (lanes). ``+ - * /`` and comparisons take two of them, or one and a number.
What is wider than the registers of a processor takes several of them, so eight lanes run anywhere. Interpreted, it is an
array of NumPy.

``reading(lanes)``
    The functions ``load(numbers, place)`` and ``all_lanes(number)`` that give so many lanes.
``store(value, numbers, place)``
    numbers[place : place + lanes] = value; ``numbers`` is a pointer from kernels/compiler/numba_struct.py.
``select(condition, one, other)``
    ``one`` where the condition holds, else ``other``; also of plain numbers.
``rounded(value)``, ``root(value)``, ``amount(value)``
    Nearest integer, square root and absolute value of each lane, or of a plain number.
``power_of_two(value)``
    2 to the power of each lane, which must be an integer between -1022 and 1023.
``greater(one, other)``
    The greater of two, lane by lane; ``other`` where one of them is not a number.
``full_like(value, number)``
    The number in as many lanes as the value has; itself where that is a plain number.
``total(value)``, ``greatest(value)``, ``lane(value, i)``
    The sum of all lanes, the greatest one (not a number if any is), and lane i.
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from llvmlite import binding, ir
from numba import config, types
from numba.core import cgutils
from numba.core.datamodel import models
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, register_model

NODES = 8  # lanes that carry the nodes of one step
INTERPRETED = bool(getattr(config, "DISABLE_JIT", False))


def lanes_of_processor() -> int:
    """How many numbers one register of this processor holds: 8, 4 or 2; 1 if that is not known."""
    try:
        features = binding.get_host_cpu_features()
    except RuntimeError:
        return 1
    if features.get("avx512f"):
        return 8
    if features.get("avx"):
        return 4
    return 2 if features.get("sse2") or features.get("neon") else 1


class Vector(types.Type):
    """So many float64 in one value."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        super().__init__(name=f"Vector({lanes})")


class Mask(types.Type):
    """So many conditions in one value."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        super().__init__(name=f"Mask({lanes})")


@register_model(Vector)
class _WideModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Vector) -> None:
        super().__init__(manager, kind, _vector(kind.lanes))


@register_model(Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: Mask) -> None:
        super().__init__(manager, kind, ir.VectorType(ir.IntType(1), kind.lanes))


def _vector(lanes: int) -> Any:
    return ir.VectorType(ir.DoubleType(), lanes)


def _spread(builder: Any, number: Any, lanes: int) -> Any:
    one = builder.insert_element(ir.Constant(_vector(lanes), ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
    return builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), lanes), [0] * lanes))


def _both(arguments: Any) -> tuple[int, Any] | None:
    """Lanes of an operation on two values and their types, if it is one on wide values."""
    wide = [kind for kind in arguments if isinstance(kind, Vector)]
    plain = [kind for kind in arguments if isinstance(kind, (types.Float, types.Integer))]
    if len(arguments) != 2 or not wide or len(wide) + len(plain) != 2 or len({kind.lanes for kind in wide}) > 1:
        return None
    return wide[0].lanes, [kind if isinstance(kind, Vector) else types.float64 for kind in arguments]


def _widened(builder: Any, its: Any, arguments: Any) -> list[Any]:
    lanes = next(kind.lanes for kind in its.args if isinstance(kind, Vector))
    return [
        value if isinstance(kind, Vector) else _spread(builder, value, lanes)
        for value, kind in zip(arguments, its.args, strict=True)
    ]


def _operator(function: Any, result: Any, emit: Any) -> None:
    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            found = _both(args)
            return None if found is None else signature(result(found[0]), *found[1])

    infer_global(function)(Template)
    for kinds in ((Vector, Vector), (Vector, types.Float), (types.Float, Vector)):

        @lower_builtin(function, *kinds)
        def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
            return emit(builder, *_widened(builder, its, arguments))


for _functions, _name in (
    ((operator.add, operator.iadd), "fadd"),
    ((operator.sub, operator.isub), "fsub"),
    ((operator.mul, operator.imul), "fmul"),
    ((operator.truediv, operator.itruediv), "fdiv"),
):
    for _function in _functions:
        _operator(_function, Vector, lambda builder, a, b, name=_name: getattr(builder, name)(a, b))
for _function, _sign in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _operator(_function, Mask, lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b))


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        return signature(args[0], args[0]) if len(args) == 1 and isinstance(args[0], Vector) else None


@lower_builtin(operator.neg, Vector)
def _negate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
    return builder.fneg(arguments[0])


def _place(builder: Any, lanes: int, numbers: Any, place: Any) -> Any:
    return builder.bitcast(builder.gep(numbers, [place]), _vector(lanes).as_pointer())


def reading(lanes: int) -> tuple[Any, Any]:
    """See above."""
    kind = Vector(lanes)

    def load(typing_context: Any, numbers: Any, place: Any) -> Any:
        def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
            return builder.load(_place(builder, lanes, *arguments), align=8)

        return kind(numbers, types.intp), generate

    def all_lanes(typing_context: Any, number: Any) -> Any:
        def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
            return _spread(builder, arguments[0], lanes)

        return kind(types.float64), generate

    if INTERPRETED:
        return (lambda numbers, place: numbers[place : place + lanes].copy()), (lambda number: np.full(lanes, number))
    return intrinsic(load), intrinsic(all_lanes)


def _store(typing_context: Any, value: Any, numbers: Any, place: Any) -> Any:
    def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
        builder.store(arguments[0], _place(builder, value.lanes, *arguments[1:]), align=8)
        return context.get_dummy_value()

    return types.void(value, numbers, types.intp), generate


def _select(typing_context: Any, condition: Any, one: Any, other: Any) -> Any:
    kind: Any = one if isinstance(one, Vector) else other if isinstance(other, Vector) else types.float64
    kinds = [k if isinstance(k, Vector) else types.float64 for k in (one, other)]

    def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
        values = [
            value if k == kind else _spread(builder, value, kind.lanes)
            for value, k in zip(arguments[1:], kinds, strict=True)
        ]
        return builder.select(arguments[0], *values)

    return kind(condition, *kinds), generate


def _called(name: str, count: int) -> Any:
    """The operation of LLVM with this name on so many values."""

    def typed(value: Any, generate_arguments: int) -> Any:
        def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
            wide = isinstance(value, Vector)
            vector, size = (_vector(value.lanes), f"v{value.lanes}f64") if wide else (ir.DoubleType(), "f64")
            kind = ir.FunctionType(vector, [vector] * generate_arguments)
            function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.{size}")
            return builder.call(function, arguments)

        return value(*[value] * generate_arguments), generate

    def of_one(typing_context: Any, value: Any) -> Any:
        return typed(value, 1)

    def of_two(typing_context: Any, one: Any, other: Any) -> Any:
        return typed(one, 2)

    return of_one if count == 1 else of_two


def _power_of_two(typing_context: Any, value: Any) -> Any:
    def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
        bits = ir.VectorType(ir.IntType(64), value.lanes)
        shifted = builder.fadd(
            arguments[0], _spread(builder, ir.Constant(ir.DoubleType(), 1.5 * 2.0**52 + 1023.0), value.lanes)
        )
        by = ir.Constant(bits, [52] * value.lanes)  # the integer ends where the exponent of a number ends
        return builder.bitcast(builder.shl(builder.bitcast(shifted, bits), by), _vector(value.lanes))

    return value(value), generate


def _larger(builder: Any, one: Any, other: Any) -> Any:
    """What is not a number counts as the larger one, so that it is not lost."""
    above = builder.or_(builder.fcmp_ordered(">", one, other), builder.fcmp_unordered("uno", one, one))
    return builder.select(above, one, other)


def _greater(typing_context: Any, one: Any, other: Any) -> Any:
    def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", *arguments), *arguments)

    return one(one, one), generate


def _full_like(typing_context: Any, value: Any, number: Any) -> Any:
    def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
        return _spread(builder, arguments[1], value.lanes) if isinstance(value, Vector) else arguments[1]

    return value(value, types.float64), generate


def _reduced(combine: Any) -> Any:
    def typed(typing_context: Any, value: Any) -> Any:
        def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
            rest, lanes = arguments[0], value.lanes
            while lanes > 1:  # halves, so that all processors sum in the same order
                lanes //= 2
                low, high = (
                    builder.shuffle_vector(
                        rest, rest, ir.Constant(ir.VectorType(ir.IntType(32), lanes), list(range(first, first + lanes)))
                    )
                    for first in (0, lanes)
                )
                rest = combine(builder, low, high)
            return builder.extract_element(rest, ir.Constant(ir.IntType(32), 0))

        return types.float64(value), generate

    return typed


def _lane(typing_context: Any, value: Any, number: Any) -> Any:
    def generate(context: Any, builder: Any, its: Any, arguments: Any) -> Any:
        return builder.extract_element(arguments[0], builder.trunc(arguments[1], ir.IntType(32)))

    return types.float64(value, types.intp), generate


def _stored(value: Any, numbers: Any, place: int) -> None:
    numbers[place : place + len(value)] = value


store: Any
select: Any
rounded: Any
root: Any
amount: Any
power_of_two: Any
greater: Any
full_like: Any
total: Any
greatest: Any
lane: Any
if INTERPRETED:
    store, select, rounded, root, amount, greater = _stored, np.where, np.rint, np.sqrt, np.abs, np.maximum
    power_of_two, full_like = np.exp2, np.full_like
    total, greatest, lane = np.sum, np.max, lambda value, number: value[number]
else:
    store, select, greater, lane = intrinsic(_store), intrinsic(_select), intrinsic(_greater), intrinsic(_lane)
    rounded, root, amount = (intrinsic(_called(name, 1)) for name in ("rint", "sqrt", "fabs"))
    total = intrinsic(_reduced(lambda builder, a, b: builder.fadd(a, b)))
    greatest, power_of_two = intrinsic(_reduced(_larger)), intrinsic(_power_of_two)
    full_like = intrinsic(_full_like)
load, all_lanes = reading(NODES)


# Eight neighboring numbers at once, in the vector registers that Numba's own loops over few numbers do not reach.
#
# ``lanes()``
#     Eight zeros.
# ``add_product(total, weight, numbers, place)``
#     total += weight * numbers[place : place + 8].
# ``put(total, numbers, place)``
#     numbers[place : place + 8] = total.


LANES = 8
_VECTOR = ir.VectorType(ir.DoubleType(), LANES)
_POINTER = types.CPointer(types.float64)


def _at(builder: Any, pointer: Any, place: Any) -> Any:
    return builder.bitcast(builder.gep(pointer, [place]), _VECTOR.as_pointer())


def _lanes(typing_context: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place = cgutils.alloca_once(builder, _VECTOR)
        builder.store(ir.Constant(_VECTOR, [0.0] * LANES), place)
        return builder.bitcast(place, ir.DoubleType().as_pointer())

    return _POINTER(), generate


def _add_product(typing_context: Any, total: Any, weight: Any, numbers: Any, place: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        total, weight, numbers, place = arguments
        sum_at = builder.bitcast(total, _VECTOR.as_pointer())
        one = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), weight, ir.Constant(ir.IntType(32), 0))
        same = builder.shuffle_vector(one, one, ir.Constant(ir.VectorType(ir.IntType(32), LANES), [0] * LANES))
        product = builder.fmul(same, builder.load(_at(builder, numbers, place), align=8), flags=("contract",))
        builder.store(builder.fadd(builder.load(sum_at), product, flags=("contract",)), sum_at)
        return context.get_dummy_value()

    return types.void(_POINTER, types.float64, _POINTER, types.int64), generate


def _put(typing_context: Any, total: Any, numbers: Any, place: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        total, numbers, place = arguments
        value = builder.load(builder.bitcast(total, _VECTOR.as_pointer()))
        builder.store(value, _at(builder, numbers, place), align=8)
        return context.get_dummy_value()

    return types.void(_POINTER, _POINTER, types.int64), generate


def _add_interpreted(total: Any, weight: float, numbers: Any, place: int) -> None:
    total += weight * numbers[place : place + LANES]


def _put_interpreted(total: Any, numbers: Any, place: int) -> None:
    numbers[place : place + LANES] = total


lanes: Any
add_product: Any
put: Any
if getattr(config, "DISABLE_JIT", False):
    lanes, add_product, put = (lambda: np.zeros(LANES)), _add_interpreted, _put_interpreted
else:
    lanes, add_product, put = intrinsic(_lanes), intrinsic(_add_product), intrinsic(_put)


# A choice between two numbers that both are known: the form of a branch that also serves several lanes at once.


where = select  # (condition, one, other): ``one`` if the condition holds, else ``other``
