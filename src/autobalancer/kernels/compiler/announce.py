"""A line on the terminal, in a pipe or in a notebook for each kind of kernels that is compiled for the first time."""

from __future__ import annotations

import sys
import time
from typing import Any

from numba.core import event

from autobalancer.kernels.compiler.cache import complaints
from autobalancer.progress import not_counted

TEXT = "autobalancer: first use of {}: compiling, up to a minute"  # fits 80 columns
SHARED = "this version"
KINDS = {
    "chamber": "deep chambers",
    "annulus_flow": "the flow in a race",
    "planar": "planar rotors",
    "on_stations": "balls on any rotor",
    "resolved_balls": "resolved balls",
    "characteristic": "stability maps",
    "dwell": "stepped responses",
    "many_members": "many runs at once",
}


class Announcement(event.Listener):
    """Writes a line when the first kernel of a kind is compiled in a process; kernels from the cache are not."""

    def __init__(self) -> None:
        self.said: set[str] = set()
        self.begun, self.depth = 0.0, 0  # a kernel compiles those that it calls, of whatever kind

    def on_start(self, event: Any) -> None:
        """Called by Numba when it begins to compile."""
        self.depth += 1
        if self.depth == 1:
            self.begun = time.thread_time()
        for complaint in complaints():
            print(f"autobalancer: {complaint}", file=sys.stderr, flush=True)
        kernel = getattr(event.data.get("dispatcher"), "py_func", None)
        place = (getattr(kernel, "__module__", None) or "").split(".")
        if self.depth > 1 or place[:2] != ["autobalancer", "kernels"]:
            return
        kind = next((KINDS[name] for name in place if name in KINDS), SHARED)
        if kind not in self.said:
            self.said.add(kind)
            print(TEXT.format(kind), file=sys.stderr, flush=True)

    def on_end(self, event: Any) -> None:
        """Called by Numba when a kernel is ready."""
        self.depth -= 1
        if self.depth == 0:
            not_counted(time.thread_time() - self.begun)


def announce_compiling() -> None:
    """From now on."""
    event.register("numba:compile", Announcement())
