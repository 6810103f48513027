"""What a user waits for before anything moves: import, a short run by the command line, the first compilation."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter
from typing import Any

from benchmarks import measured
from benchmarks._run_up import MACHINE

IMPORT = [sys.executable, "-c", "import autobalancer"]
RUN = [sys.executable, "-m", "autobalancer", "simulate", str(MACHINE)]
LIMITS = {"import_s": 1.0, "warm_run_s": 3.0, "first_compile_s": 60.0}


def wait(command: list[str], repeats: int, **environment: str) -> float:
    """Least wall time of a process, s."""
    times = []
    for _ in range(repeats):
        start = perf_counter()
        subprocess.run(command, env=os.environ | environment, check=True, stdout=subprocess.DEVNULL)
        times.append(perf_counter() - start)
    return min(times)


def bench() -> list[dict[str, Any]]:
    """The ratio is the limit we set ourselves over the time."""
    with tempfile.TemporaryDirectory() as folder:
        run = [*RUN, "--out", str(Path(folder) / "run.nc")]
        times = {"import_s": wait(IMPORT, 5)}
        wait(run, 1)
        times["warm_run_s"] = wait(run, 3)
        times["first_compile_s"] = wait(run, 1, NUMBA_CACHE_DIR=str(Path(folder) / "cache"))
    notes = {
        "import_s": "import autobalancer in a fresh process",
        "warm_run_s": "autobalancer simulate of 20 s of stall and release, result file written, kernels in the cache",
        "first_compile_s": "the same with an empty cache",
    }
    rows = []
    for name, time in times.items():
        limit = LIMITS[name]
        row = measured(name, time, "s", note=notes[name])
        rows.append(row | {"peer": f"limit {limit:g} s", "ratio": limit / time})
    return rows
