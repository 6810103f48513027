"""How all kernels are compiled.

Without reference counts: kernels own no memory, and counting would cost more than their arithmetic. So a kernel
that allocates an array does not compile.
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.cache import forget_outdated

forget_outdated()

INLINE: dict[str, Any] = {"inline": "always", "error_model": "numpy", "_nrt": False}
COMPILED: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "_nrt": False,
    "fastmath": {"contract"},
}
EQUATIONS: dict[str, Any] = COMPILED | {"fastmath": {"contract", "nsz", "arcp"}}
