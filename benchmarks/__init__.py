"""Ratios against other software, measured in the same run.

A module ``benchmarks/<name>.py`` has a function ``bench() -> list[dict]`` with rows best made by
:func:`compared`, or :func:`measured` where there is no peer. A ratio is the peer's time over ours at equal
accuracy: larger is better.
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter, process_time
from typing import Any


def seconds(call: Callable[[], Any], repeats: int = 5) -> float:
    """Least time of ``repeats`` calls; one call before them, which may compile, is not counted."""
    call()
    times = []
    for _ in range(repeats):
        start = perf_counter()
        call()
        times.append(perf_counter() - start)
    return min(times)


def processor_seconds(call: Callable[[], Any], repeats: int = 2) -> float:
    """Least time of all processors together; one call before, which may compile, is not counted."""
    call()
    times = []
    for _ in range(repeats):
        start = process_time()
        call()
        times.append(process_time() - start)
    return min(times)


def compared(name: str, ours: float, peer: str, theirs: float, *, note: str = "") -> dict[str, Any]:
    """One row from two times in seconds, taken at equal accuracy."""
    return {"name": name, "value": ours, "unit": "s", "peer": peer, "ratio": theirs / ours, "note": note}


def measured(name: str, value: float, unit: str, *, note: str = "") -> dict[str, Any]:
    """One row without a peer."""
    return {"name": name, "value": value, "unit": unit, "peer": None, "ratio": None, "note": note}
