"""Where Numba keeps compiled kernels, and which of them are out of date."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).resolve().parent


def _indexes() -> Iterator[Path]:
    """The index files of compiled kernels of this package."""
    sources = list(HERE.rglob("*.py"))
    stems = {path.stem for path in sources}
    named = os.environ.get("NUMBA_CACHE_DIR")
    folders = [Path(named)] if named else [place / "__pycache__" for place in {path.parent for path in sources}]
    for folder in folders:
        if folder.is_dir():
            yield from (path for path in folder.rglob("*.nbi") if path.name.split(".")[0] in stems)


def compiled_before() -> bool:
    """True if the stepper lies compiled where Numba keeps it. A guess made in a millisecond, for a message only."""
    return any(path.name.startswith("runge_kutta.advance-") for path in _indexes())


def forget_outdated() -> None:
    """Remove what was compiled before the newest change in any kernel.

    Numba itself looks only at the file of a compiled function, not at those of the functions compiled into it.
    """
    newest = max(path.stat().st_mtime for path in HERE.rglob("*.py"))
    for path in _indexes():
        try:
            if path.stat().st_mtime < newest:
                path.unlink()
        except OSError:  # another process was faster, or the folder cannot be written to
            continue
