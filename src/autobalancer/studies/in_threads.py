"""Many runs at once, their answers in the order of the questions."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Event, Lock
from typing import TypeVar

Job = TypeVar("Job")
Answer = TypeVar("Answer")


def in_threads(
    work: Callable[[Job], Answer],
    jobs: Sequence[Job],
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    *,
    cost: Callable[[Job], float] | None = None,
    stop: Event | None = None,
) -> list[Answer]:
    """Answers of ``work`` to ``jobs``, on ``workers`` threads (by default one for each core).

    ``progress`` is called with (jobs done, jobs in all), by one thread at a time. The jobs of most ``cost`` begin first, so that
    no thread is left with a long one at the end. After an error or Ctrl-C no further job begins, and ``stop`` is set for those
    that run.
    """
    done, told = 0, Lock()

    def one(job: Job) -> Answer:
        nonlocal done
        answer = work(job)
        with told:
            done += 1
            if progress is not None:
                progress(done, len(jobs))
        return answer

    workers = workers if workers is not None else os.cpu_count() or 1
    order = sorted(range(len(jobs)), key=lambda k: -cost(jobs[k])) if cost else range(len(jobs))
    if workers == 1:
        found = {k: one(jobs[k]) for k in order}
        return [found[k] for k in range(len(jobs))]
    with ThreadPoolExecutor(workers) as pool:
        waiting = {k: pool.submit(one, jobs[k]) for k in order}
        try:
            return [waiting[k].result() for k in range(len(jobs))]
        except BaseException:  # Ctrl-C too
            for future in waiting.values():
                future.cancel()
            if stop is not None:
                stop.set()
            raise
