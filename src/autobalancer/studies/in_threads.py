"""Many runs at once, their answers in the order of the questions."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from threading import Lock
from typing import TypeVar

Job = TypeVar("Job")
Answer = TypeVar("Answer")


def in_threads(
    work: Callable[[Job], Answer],
    jobs: Sequence[Job],
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> list[Answer]:
    """Answers of ``work`` to ``jobs``, on ``workers`` threads (by default one for each core).

    ``progress`` is called with (jobs done, jobs in all), by one thread at a time.
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
    if workers == 1:
        return [one(job) for job in jobs]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(one, jobs))
