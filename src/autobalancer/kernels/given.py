"""Compiled functions as arguments of compiled ones, ready to be given.

Numba looks up type and address of a compiled function each time it is given, which takes 25 us; :func:`given` looks once, and the
function is called as from C.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from autobalancer.kernels.called import INTERPRETED


class Given:
    """A compiled function with its type and address, under the names by which Numba asks for them."""

    def __init__(self, function: Any, kind: Any) -> None:
        found = function.get_compile_result(kind.signature)
        self._numba_type_ = kind
        self.address = int(found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name))

    def __wrapper_address__(self) -> int:
        return self.address


@cache
def given(function: Any, kind: Any) -> Any:
    """A function of this kind, such as ``rhs_type``, as an argument."""
    return function if INTERPRETED else Given(function, kind)
