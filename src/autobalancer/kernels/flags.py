"""How all kernels are compiled.

Without reference counts: kernels own no memory, and counting would cost more than their arithmetic. So a kernel
that allocates an array does not compile.
"""

from __future__ import annotations

import warnings
from typing import Any

from autobalancer.errors import CacheWarning
from autobalancer.kernels.announce import announce_compiling
from autobalancer.kernels.cache import njit as njit
from autobalancer.kernels.cache import prepare_cache
from autobalancer.kernels.inlining import KernelCompiler

KEPT, NOTE = prepare_cache()
if NOTE:
    warnings.warn(NOTE, CacheWarning, stacklevel=1)
announce_compiling()

INLINE: dict[str, Any] = {"inline": "always", "error_model": "numpy", "_nrt": False}
NUMBERS: dict[str, Any] = {"pipeline_class": KernelCompiler, "error_model": "numpy", "_nrt": False}
# nothing is contracted: the same bits alone and as a part of another function
EXACT: dict[str, Any] = NUMBERS | {"cache": KEPT, "nogil": True}
COMPILED: dict[str, Any] = EXACT | {"fastmath": {"contract"}}
# The code that takes a machine apart for a call from Python is longer than most kernels. Without it such a call ends
# the process, so only kernels call what has these flags: by its address what is given to an integrator, by its name a
# part of a kernel.
ADDRESSED: dict[str, Any] = COMPILED | {"no_cpython_wrapper": True}
EQUATIONS: dict[str, Any] = ADDRESSED | {"fastmath": {"contract", "nsz", "arcp"}}
UNSEEN: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
PART: dict[str, Any] = COMPILED | UNSEEN
EXACT_PART: dict[str, Any] = EXACT | UNSEEN
EQUATIONS_PART: dict[str, Any] = EQUATIONS | UNSEEN
# parts of a compiled kernel: MERGED into its caller by LLVM, and APART from it, as it is called at several places
APART: dict[str, Any] = NUMBERS | {"fastmath": {"contract"}} | UNSEEN
MERGED: dict[str, Any] = APART | {"forceinline": True}
