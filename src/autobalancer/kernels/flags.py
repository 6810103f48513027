"""How all kernels are compiled.

Without reference counts: kernels own no memory, and counting would cost more than their arithmetic. So a kernel
that allocates an array does not compile.
"""

from typing import Any

INLINE: dict[str, Any] = {"inline": "always", "error_model": "numpy", "_nrt": False}
COMPILED: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "_nrt": False,
    "fastmath": {"contract"},
}
EQUATIONS: dict[str, Any] = COMPILED | {"fastmath": {"contract", "nsz", "arcp"}}
