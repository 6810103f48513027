"""How all kernels are compiled.

What knows the private parts of Numba stands beside this, in ``inlining.py``, ``kept.py`` and ``lazy.py``, which are imported
where no piece of them is left to Numba (:func:`stock`), so a Numba without these parts will do too.

Without reference counts: kernels own no memory, and counting would cost more than their arithmetic. So a kernel
that allocates an array does not compile.
"""

from __future__ import annotations

import inspect
import warnings
from pathlib import Path
from typing import Any

import numba

from autobalancer.errors import CacheWarning
from autobalancer.kernels.compiler.cache import HERE, announce_compiling, prepare_cache, stock


def njit(signature: Any = None, *, cache: bool = False, **options: Any) -> Any:
    """Numba's decorator of the same name, but kernels are kept in :func:`cache_place`, not where Numba looks.

    Parameters
    ----------
    signature
        Types for which the function is compiled when it is first used, or a list of them; else they follow from its calls. A
        function from outside the kernels is compiled at once.
    cache
        Whether the compiled function is kept for other processes.
    options
        Those of Numba.
    """
    if not cache:
        return numba.njit(signature, **options)

    def decorate(function: Any) -> Any:
        kernel = numba.njit(**options)(function)
        if hasattr(kernel, "_cache"):  # else the compiler is switched off
            if not stock("cache"):
                from autobalancer.kernels.compiler.kept import KernelCache

                kernel._cache = KernelCache(function)
            if signature is not None:
                declared = signature if isinstance(signature, list) else [signature]
                if stock("lazy"):
                    for each in declared:
                        kernel.compile(each)
                    kernel.disable_compile()
                    return kernel
                from autobalancer.kernels.compiler.lazy import wait_for_use

                wait_for_use(kernel, declared)
            if signature is not None and not Path(inspect.getfile(function)).is_relative_to(HERE):
                kernel.compile(None)  # the law of a user: whether it compiles is asked here
        return kernel

    return decorate


def _pipeline() -> dict[str, Any]:
    if stock("inlining"):
        return {}
    from autobalancer.kernels.compiler.inlining import KernelCompiler

    return {"pipeline_class": KernelCompiler}


KEPT, NOTE = prepare_cache()
if NOTE:
    warnings.warn(NOTE, CacheWarning, stacklevel=1)
if not stock("announce"):
    announce_compiling()

INLINE: dict[str, Any] = {"inline": "always", "error_model": "numpy", "_nrt": False}
NUMBERS: dict[str, Any] = _pipeline() | {"error_model": "numpy", "_nrt": False}
# nothing is contracted: the same bits alone and as a part of another function, from which Numba would else take its flags
EXACT: dict[str, Any] = NUMBERS | {"cache": KEPT, "nogil": True, "no_cfunc_wrapper": True, "fastmath": False}
COMPILED: dict[str, Any] = EXACT | {"fastmath": {"contract"}}
# Code for calls from Python or C takes longer to compile than short kernels. Without it such a call ends the process, so
# only kernels call what has these flags: by its address what is given to an integrator, by its name a part of a kernel.
ADDRESSED: dict[str, Any] = COMPILED | {"no_cpython_wrapper": True, "no_cfunc_wrapper": False}
EQUATIONS: dict[str, Any] = ADDRESSED | {"fastmath": {"contract", "nsz", "arcp"}}
UNSEEN: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
PART: dict[str, Any] = COMPILED | UNSEEN
EXACT_PART: dict[str, Any] = EXACT | UNSEEN
EQUATIONS_PART: dict[str, Any] = EQUATIONS | UNSEEN
# parts of a compiled kernel: MERGED into its caller by LLVM, and APART from it, as it is called at several places
APART: dict[str, Any] = NUMBERS | {"fastmath": {"contract"}} | UNSEEN
MERGED: dict[str, Any] = APART | {"forceinline": True}
