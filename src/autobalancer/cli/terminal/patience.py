"""A word when a run takes long, also where no progress bar is seen."""

from __future__ import annotations

import time
from typing import Any

FIRST = 20.0  # s of waiting after which it is said, and after three times as long again
LONG = 120.0  # s still to wait that are worth a word


class Patience:
    """Says once in a while how long a run will still take.

    Parameters
    ----------
    console
        Where it is said.
    """

    def __init__(self, console: Any) -> None:
        self.console, self.begin, self.next = console, time.monotonic(), FIRST

    def look(self, now: float, end: float) -> None:
        """The run has come to ``now`` of ``end``, s."""
        waited = time.monotonic() - self.begin
        if waited < self.next or now >= end:
            return
        self.next = 3.0 * waited
        still = waited * (end - now) / now if now > 0.0 else float("inf")
        if still > LONG:
            minutes = f"another {still / 60.0:.2g} minutes" if still < 1e5 else "days or more"
            self.console.print(
                f"note: {now:.3g} s of {end:.3g} s after {waited:.0f} s of computing; at this pace it takes {minutes}. Ctrl-C "
                "ends the run and keeps what was computed",
                style="yellow",
            )
