"""What a study costs besides its runs, and what a second worker of a cluster brings."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from time import perf_counter, process_time
from typing import Any
from unittest.mock import patch

import autobalancer as ab
from autobalancer.studies.ensemble.layout import run_groups
from autobalancer.studies.ensemble.members import Members
from benchmarks import compared, measured
from benchmarks._run_up import MACHINE

MEMBERS, FEW, IN_CLUSTER = 5000, 50, 20_000
REPEATS = 5  # the least counts


def asked(members: int) -> dict[str, Any]:
    """Run-ups of 20 s with scattered drag and unbalance."""
    vary = {
        "drag": {"distribution": "log-normal", "median": "2e-4 N*m*s", "factor": 1.5},
        "unbalances[1].mass": {"distribution": "normal", "standard_deviation": "5 %"},
    }
    return {"machine": str(MACHINE), "members": members, "vary": vary}


class Stopwatch:
    """Adds up the processor time of calls."""

    def __init__(self) -> None:
        self.seconds = 0.0

    def of(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """The same function, its time added."""

        def timed(*args: Any, **more: Any) -> Any:
            begin = process_time()
            try:
                return function(*args, **more)
            finally:
                self.seconds += process_time() - begin

        return timed


def overhead() -> tuple[float, float]:
    """Time of a study less that of the ensemble engine in it, s; the time of the engine, s.

    The engine makes members ready and runs them. Members that are made before the study begins, to see whether they are
    possible, are not its work.
    """
    engine, probe = Stopwatch(), Stopwatch()
    with (
        patch.object(Members, "sorted", engine.of(Members.sorted)),
        patch("autobalancer.studies.study.chunk.run_groups", engine.of(run_groups)),
    ):
        begin = process_time()
        ab.study(asked(MEMBERS), workers=1, progress=None)
        whole = process_time() - begin
        before = engine.seconds
    with patch.object(Members, "sorted", probe.of(Members.sorted)):
        from autobalancer.studies.study.study import refuse_impossible
        from autobalancer.studies.study.study_file import read_study

        refuse_impossible(read_study(asked(MEMBERS)))
    compute = before - probe.seconds
    return whole - compute, compute


def in_cluster(workers: int) -> float:
    """Time of a study by the workers of a local cluster, each a process with one thread, s."""
    distributed: Any = import_module("distributed")
    with distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None
    ) as cluster:
        ab.study(asked(FEW * workers), scheduler=cluster.scheduler_address, progress=None)  # loads the package
        begin = perf_counter()
        ab.study(asked(IN_CLUSTER), scheduler=cluster.scheduler_address, progress=None)
        return perf_counter() - begin


def bench() -> list[dict[str, Any]]:
    """The rows."""
    ab.study(asked(FEW), progress=None)
    more, compute = min((overhead() for _ in range(REPEATS)), key=lambda found: found[0] / found[1])
    note = f"{MEMBERS} run-ups of 20 s in {compute:.3g} s of a core"
    rows = [
        measured("study_overhead_percent", 100.0 * more / compute, "%", note=f"{note}; at most 5 is asked"),
        measured("study_overhead_us", 1e6 * more / MEMBERS, "us", note=f"for each of {note}; at most 20 is asked"),
    ]
    if find_spec("distributed") is not None:
        one, two = in_cluster(1), in_cluster(2)
        about = f"{IN_CLUSTER} run-ups of 20 s; each worker a process with one thread, on one computer; at least 1.8 is asked"
        rows.append(compared("dask_two_workers", two, "one worker", one, note=about))
    return rows
