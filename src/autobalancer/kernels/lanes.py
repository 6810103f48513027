"""Eight neighboring numbers at once, in the vector registers that Numba's own loops over few numbers do not reach.

``lanes()``
    Eight zeros.
``add_product(total, weight, numbers, place)``
    total += weight * numbers[place : place + 8].
``put(total, numbers, place)``
    numbers[place : place + 8] = total.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import config, types
from numba.core import cgutils
from numba.extending import intrinsic

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
