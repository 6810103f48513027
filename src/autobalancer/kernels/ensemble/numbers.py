"""The plain numbers of a tuple from an array: all arrays in it stay.

``with_numbers(value, words, first)`` is ``value`` with its numbers, in the order in which they stand, from ``words`` (int64),
from ``first`` on; floats are there by their bits. ``count_numbers(value)`` says how many there are.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import config, types
from numba.extending import intrinsic


def count_numbers(value: Any) -> int:
    """How many plain numbers a tuple has."""
    if isinstance(value, tuple):
        return sum(map(count_numbers, value))
    return 0 if isinstance(value, np.ndarray) else 1


def _with_numbers(typing_context: Any, value: Any, words: Any, first: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        given, array, start = arguments
        source = context.make_array(signature.args[1])(context, builder, array).data
        place = 0

        def rebuilt(kind: Any, now: Any) -> Any:
            nonlocal place
            if isinstance(kind, types.BaseTuple):
                for number, inner in enumerate(kind.types):  # type: ignore[attr-defined]
                    old = builder.extract_value(now, number)
                    now = builder.insert_value(now, rebuilt(inner, old), number)
                return now
            if not isinstance(kind, (types.Float, types.Integer)):
                return now
            at = builder.gep(source, [builder.add(start, ir.Constant(start.type, place))])
            place += 1
            bits = builder.load(at)
            return builder.bitcast(bits, now.type) if isinstance(kind, types.Float) else bits

        return rebuilt(value, given)

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
