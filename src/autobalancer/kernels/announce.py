"""One line on the terminal, in a pipe or in a notebook before kernels are compiled for the first time."""

from __future__ import annotations

import sys
from typing import Any

from numba.core import event

TEXT = "autobalancer: compiling its equations; this happens once and takes up to a minute ..."


class Announcement(event.Listener):
    """Writes the line when the first kernel of a process is compiled; kernels from the cache are not."""

    def __init__(self) -> None:
        self.made = False

    def on_start(self, event: Any) -> None:
        """Called by Numba when it begins to compile."""
        kernel = getattr(event.data.get("dispatcher"), "py_func", None)
        if not self.made and getattr(kernel, "__module__", "").startswith("autobalancer."):
            self.made = True
            print(TEXT, file=sys.stderr, flush=True)

    def on_end(self, event: Any) -> None:
        """Called by Numba when a kernel is ready."""


def announce_compiling() -> None:
    """From now on."""
    event.register("numba:compile", Announcement())
