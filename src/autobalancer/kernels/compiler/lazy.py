"""Kernels that are compiled when they are first used; Numba compiles what declares its types as it is defined."""

from __future__ import annotations

from typing import Any

from numba.core import typeinfer
from numba.core.compiler_lock import global_compiler_lock
from numba.core.dispatcher import Dispatcher


class Kernel(Dispatcher):
    """A function that declares its types, and is compiled for them, and no others, when it is first called."""

    declared: tuple[Any, ...] = ()
    _can_compile: bool

    def compile(self, sig: Any) -> Any:
        """Compile it for all that it declares, whatever is asked."""
        with global_compiler_lock:
            if not self.declared or self.is_compiling:
                return super().compile(sig)
            if self._can_compile:
                with typeinfer.register_dispatcher(self):  # as Numba does, for functions that call themselves
                    for each in self.declared:
                        super().compile(each)
                self.disable_compile()
            return None

    def _compile_for_args(self, *arguments: Any, **named: Any) -> Any:
        if not (self.declared and self._can_compile):  # it may be compiled, and these arguments do not fit
            return super()._compile_for_args(*arguments, **named)  # type: ignore[misc]
        self.compile(None)
        return self  # which Numba calls then


def wait_for_use(dispatcher: Any, declared: list[Any]) -> None:
    """Let a function of Numba declare its types, and compile it when it is used."""
    dispatcher.__class__ = Kernel
    dispatcher.declared = tuple(declared)
