"""Compiled functions as arguments of compiled ones, ready to be given.

Numba looks up the address of a compiled function each time it is given, which takes 20 us; :func:`given` looks once, and the
function is called as from C.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from numba.core.types import WrapperAddressProtocol

from autobalancer.kernels.called import INTERPRETED


class Given(WrapperAddressProtocol):
    """A compiled function with its address."""

    def __init__(self, function: Any, kind: Any) -> None:
        self.function, self.kind = function, kind.signature
        found = function.get_compile_result(self.kind)
        self.address = int(found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name))

    def __wrapper_address__(self) -> int:
        return self.address

    def signature(self) -> Any:
        """What it takes and returns."""
        return self.kind


@cache
def given(function: Any, kind: Any) -> Any:
    """A function of this kind, such as ``rhs_type``, as an argument."""
    return function if INTERPRETED else Given(function, kind)
