"""Functions that are called by their address, so that a kernel needs no new compilation for a new force.

``call_force(address, place, numbers, first)`` and ``call_pair(address, place, next, numbers, first)`` return forces,
``call_energy`` and ``call_pair_energy`` an energy. ``numbers[first:]`` are the own numbers of the part, which the function sees
as a record. The call is that of Numba itself; where the function raises an error, what comes back is not a number.

:func:`compiled` makes such an address. Interpreted, addresses are keys of a dictionary.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import config, from_dtype, njit, types
from numba.core import cgutils
from numba.extending import intrinsic

from autobalancer.kernels.flags import APART, KEPT
from autobalancer.kernels.records.forces import PLACE

RESULTS: dict[str, Any] = {  # what each method of a leaf returns: of a force on one ball, of one between two
    "force": (types.UniTuple(types.float64, 2), types.UniTuple(types.float64, 4)),
    "energy": (types.float64, types.float64),
}
INTERPRETED = bool(getattr(config, "DISABLE_JIT", False))


class Called(NamedTuple):
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


_known: dict[tuple[Any, tuple[str, ...]], Called] = {}
_interpreted: dict[int, tuple[Callable[..., Any], np.dtype[Any]]] = {}


def compiled(function: Callable[..., Any], names: tuple[str, ...], method: str, pair: bool) -> Called:
    """A function of one place (two of a ``pair``) and a record of own numbers with these names, ready to be called.

    Raises
    ------
    Exception
        Whatever Numba says if it does not compile.
    """
    known = (function, names)
    if known not in _known:
        own = numbers_kind(names)
        if INTERPRETED:
            _known[known] = Called(len(_interpreted) + 1, function)
            _interpreted[len(_interpreted) + 1] = (function, own)
        else:
            _known[known] = _compiled(function, own, RESULTS[method][pair], pair)
    return _known[known]


def _compiled(function: Callable[..., Any], own: np.dtype[Any], result: Any, pair: bool) -> Called:
    signature = result(*([PLACE.row_type] * (2 if pair else 1)), from_dtype(own))
    try:
        made = njit(signature, cache=KEPT, **APART)(function)
    except RuntimeError as reason:  # written on the spot, so there is no file beside which it could be kept
        if "cannot cache" not in str(reason):
            raise
        made = njit(signature, **APART)(function)
    found = made.overloads[signature.args]
    return Called(found.library.get_pointer_to_function(found.fndesc.llvm_func_name), made)


def _caller(result: Any, places: int) -> Any:
    """An intrinsic that calls a function of so many places and a record of numbers."""

    def typed(typing_context: Any, address: Any, *arguments: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            kinds = [*[PLACE.row_type] * places, PLACE.row_type]  # own numbers too go as a pointer to a record
            numbers = context.make_array(signature.args[-2])(context, builder, values[-2]).data
            own = builder.bitcast(builder.gep(numbers, [values[-1]]), context.get_value_type(PLACE.row_type))
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
if INTERPRETED:
    call_force = call_pair = call_energy = call_pair_energy = _called
else:
    call_force = intrinsic(_caller(RESULTS["force"][0], 1))
    call_pair = intrinsic(_caller(RESULTS["force"][1], 2))
    call_energy = intrinsic(_caller(RESULTS["energy"][0], 1))
    call_pair_energy = intrinsic(_caller(RESULTS["energy"][1], 2))
