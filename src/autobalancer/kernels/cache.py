"""Whether the kernels were compiled before, seen without importing them."""

from __future__ import annotations

import os
from pathlib import Path


def compiled_before() -> bool:
    """True if an index of compiled kernels lies where Numba keeps it for this package.

    A guess made in a millisecond, for a message only: Numba itself checks whether the index is up to date.
    """
    here = Path(__file__).resolve().parent
    named = os.environ.get("NUMBA_CACHE_DIR")
    folders = [Path(named)] if named else [here / "integrators" / "__pycache__"]
    return any(folder.is_dir() and any(folder.rglob("runge_kutta.advance-*.nbi")) for folder in folders)
