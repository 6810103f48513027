"""How all kernels are compiled.

Without reference counts: kernels own no memory, and counting would cost more than their arithmetic. So a kernel
that allocates an array does not compile.
"""

from __future__ import annotations

import warnings
from typing import Any

from autobalancer.errors import CacheWarning
from autobalancer.kernels.announce import announce_compiling
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
# a part of such a function that Python never calls: without the code that would take a machine apart for it
INNER: dict[str, Any] = EXACT | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
EQUATIONS: dict[str, Any] = COMPILED | {"fastmath": {"contract", "nsz", "arcp"}}
# parts of a compiled kernel: MERGED into its caller by LLVM, and APART from it, as it is called at several places
APART: dict[str, Any] = NUMBERS | {"fastmath": {"contract"}}
MERGED: dict[str, Any] = APART | {"forceinline": True}
