"""Functions that are called by their address, so that a kernel needs no new compilation for a new force or law.

``call_force(address, place, numbers, first)`` and ``call_pair(address, place, next, numbers, first)`` return forces,
``call_energy`` and ``call_pair_energy`` an energy, ``call_friction(address, slip, numbers, first)`` a coefficient.
``numbers[first:]`` are the own numbers of the part, which the function sees as a record. The call is that of Numba itself; where
the function raises an error, what comes back is not a number.

:func:`compiled` makes such an address. Interpreted, addresses are keys of a dictionary.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import config, from_dtype, types
from numba.core import cgutils
from numba.extending import intrinsic

from autobalancer.kernels.compiler.cache import stock
from autobalancer.kernels.compiler.flags import KEPT, NUMBERS, njit
from autobalancer.kernels.fields import Record
from autobalancer.kernels.records import PLACE, SLIP

# Python calls them, too, where they are tried; without its lock, so that others may say that they do not come back
OWN: dict[str, Any] = NUMBERS | {"fastmath": {"contract"}, "nogil": True}


class Call(NamedTuple):
    """What a function returns, and the records that it gets before its own numbers."""

    result: Any
    records: tuple[Record, ...]


FORCE = Call(types.UniTuple(types.float64, 2), (PLACE,))
ENERGY = Call(types.float64, (PLACE,))
PAIR_FORCE = Call(types.UniTuple(types.float64, 4), (PLACE, PLACE))
PAIR_ENERGY = Call(types.float64, (PLACE, PLACE))
FRICTION = Call(types.float64, (SLIP,))
INTERPRETED = bool(getattr(config, "DISABLE_JIT", False))


class CompiledFunction(NamedTuple):
    """A compiled function: its address, and the function for Python."""

    address: int
    function: Callable[..., Any]


def numbers_kind(names: tuple[str, ...]) -> np.dtype[Any]:
    """The record of own numbers with these names."""
    return np.dtype([(name, np.float64) for name in names or ("nothing",)], align=True)


def numbers_row(numbers: dict[str, float]) -> Any:
    """Such a record with its values."""
    row = np.zeros(1, numbers_kind(tuple(numbers))).view(np.recarray)
    for name, value in numbers.items():
        row[name] = value
    return row[0]


_known: dict[tuple[Any, tuple[str, ...]], CompiledFunction] = {}
_interpreted: dict[int, tuple[Callable[..., Any], np.dtype[Any]]] = {}


def compile_function(function: Callable[..., Any], names: tuple[str, ...], call: Call) -> CompiledFunction:
    """A function of records and a record of own numbers with these names, ready to be called.

    Raises
    ------
    Exception
        Whatever Numba says if it does not compile.
    """
    known = (function, names)
    if known not in _known:
        own = numbers_kind(names)
        if INTERPRETED:
            _known[known] = CompiledFunction(len(_interpreted) + 1, function)
            _interpreted[len(_interpreted) + 1] = (function, own)
        else:
            _known[known] = _compiled(function, own, call)
    return _known[known]


def in_words(reason: Exception, function: Callable[..., Any], names: tuple[str, ...], call: Call) -> str:
    """Why Numba did not compile a function; it allocates memory if it does compile where that is allowed."""
    said = str(reason)
    with suppress(Exception):
        njit(_signature(numbers_kind(names), call))(function)
        return (
            "memory is allocated, as arrays, lists and texts do; use numbers only, and the functions of the module math"
        )
    if isinstance(reason, KeyError):
        places = ", ".join(field.name for field in call.records[0].fields if not field.name.startswith("wrong"))
        return f"nothing has the name {said}; at has {places}, own has {', '.join(names) or 'no numbers'}"
    if "return_value" in said:
        return "it returns something else than it must"
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    useful = [line for line in lines if not line.startswith(("Failed in nopython", "During:", "Overload", "File"))]
    return (useful or lines or ["for an unknown reason"])[0]


def _signature(own: np.dtype[Any], call: Call) -> Any:
    return call.result(*(record.row_type for record in call.records), from_dtype(own))


def _compiled(function: Callable[..., Any], own: np.dtype[Any], call: Call) -> CompiledFunction:
    signature = _signature(own, call)
    try:
        made = njit(signature, cache=KEPT, **OWN)(function)
    except (RuntimeError, ImportError) as reason:
        # written on the spot, so there is no file beside which it could be kept; or kept when its file had another module's name
        if isinstance(reason, RuntimeError) and "cannot cache" not in str(reason):
            raise
        made = njit(signature, **OWN)(function)
    found = made.overloads[signature.args]
    return CompiledFunction(found.library.get_pointer_to_function(found.fndesc.llvm_func_name), made)


def _caller(call: Call) -> Any:
    """An intrinsic that calls a function of records and a record of numbers."""
    result, places = call.result, len(call.records)

    def typed(typing_context: Any, address: Any, *arguments: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            of_own = call.records[0].row_type  # own numbers too go as a pointer to a record, whichever
            kinds = [*(record.row_type for record in call.records), of_own]
            numbers = context.make_array(signature.args[-2])(context, builder, values[-2]).data
            own = builder.bitcast(builder.gep(numbers, [values[-1]]), context.get_value_type(of_own))
            convention = context.call_conv
            function = builder.inttoptr(values[0], convention.get_function_type(result, kinds).as_pointer())
            status, found = convention.call_function(builder, function, result, kinds, [*values[1:-2], own])
            return _unless_wrong(builder, status, found, result)

        return result(address, *arguments), generate

    if places == 1:
        return lambda context, address, at, numbers, first: typed(context, address, at, numbers, types.intp)
    return lambda context, address, at, next, numbers, first: typed(context, address, at, next, numbers, types.intp)


def _unless_wrong(builder: Any, status: Any, found: Any, result: Any) -> Any:
    nothing = ir.Constant(ir.DoubleType(), math.nan)
    if not isinstance(result, types.UniTuple):
        return builder.select(status.is_ok, found, nothing)
    parts = cgutils.unpack_tuple(builder, found, result.count)
    return cgutils.pack_array(builder, [builder.select(status.is_ok, part, nothing) for part in parts])


def _called(address: int, *arguments: Any) -> Any:
    """The same, interpreted."""
    function, own = _interpreted[address]
    *places, numbers, first = arguments
    with np.errstate(all="ignore"):
        return function(*places, numbers[first : first + own.itemsize // 8].view(own).view(np.recarray)[0])


call_force: Any
call_pair: Any
call_energy: Any
call_pair_energy: Any
call_friction: Any
if INTERPRETED:
    call_force = call_pair = call_energy = call_pair_energy = call_friction = _called
else:
    call_force, call_energy = intrinsic(_caller(FORCE)), intrinsic(_caller(ENERGY))
    call_pair, call_pair_energy = intrinsic(_caller(PAIR_FORCE)), intrinsic(_caller(PAIR_ENERGY))
    call_friction = intrinsic(_caller(FRICTION))


# Compiled functions as arguments of compiled ones, ready to be given.
#
# Numba looks up type and address of a compiled function each time it is given, which takes 25 us; :func:`callback` looks
# once, and the function is called as from C.


class Callback:
    """A compiled function with its type and address, under the names by which Numba asks for them."""

    def __init__(self, function: Any, kind: Any) -> None:
        found = function.get_compile_result(kind.signature)
        self._numba_type_ = kind
        self.address = int(found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name))

    def __wrapper_address__(self) -> int:
        return self.address


@cache
def callback(function: Any, kind: Any) -> Any:
    """A function of this kind, such as ``rhs_type``, as an argument."""
    return function if INTERPRETED or stock("callbacks") else Callback(function, kind)
