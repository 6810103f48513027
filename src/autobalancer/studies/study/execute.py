"""Chunks of a study run here or by a cluster; each is handed on as soon as it is finished."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

from autobalancer.errors import QuestionError
from autobalancer.studies.study.chunk import Arrays, run_chunk
from autobalancer.studies.study.spec import Study

Span = tuple[int, int]
Take = Callable[[Span, Arrays], bool]  # keeps a chunk; true if no more are wanted
FIRST = 16  # members of the first chunks
MOST = 100_000  # members of a chunk
WORTH = 2.0  # s, that a worker has with a chunk
WAIT = 30.0  # s, for a scheduler to answer
RETRIES = 3  # of a chunk whose worker died


def here(study: Study, spans: Iterator[Span], take: Take, workers: int | None) -> None:
    """Run chunks one after the other, the members of each on all cores."""
    for first, last in spans:
        if take((first, last), run_chunk(study, first, last, workers)):
            return


def in_cluster(study: Study, spans: Iterator[Span], take: Take, address: str) -> None:
    """Run chunks by the workers of a Dask scheduler, some more of them waiting than there are workers.

    Raises
    ------
    QuestionError
        If Dask is not installed, or no scheduler answers there.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise QuestionError(
            "scheduler: Dask is not installed; install it with: pip install 'autobalancer[cluster]'"
        ) from None
    try:
        client = distributed.Client(address, timeout=WAIT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as reason:
        raise QuestionError(f"scheduler: no Dask scheduler answers at {address!r}: {reason}") from None
    with client:
        threads = sum(client.nthreads().values())
        if not threads:
            raise QuestionError(f"scheduler: the scheduler at {address!r} has no workers; start some")
        asked = client.scatter(study, broadcast=True)
        waiting = distributed.as_completed(with_results=True, raise_errors=False, loop=client.loop)
        spans_of = {}

        def submit() -> bool:
            span = next(spans, None)
            if span is not None:
                future = client.submit(run_chunk, asked, *span, pure=False, retries=RETRIES)
                spans_of[future.key] = span
                waiting.add(future)
            return span is not None

        for _ in range(2 * threads):
            if not submit():
                break
        for future, result in waiting:
            span = spans_of.pop(future.key)
            if future.status != "finished":
                raise result[1] if isinstance(result, tuple) else QuestionError(f"scheduler: {span}: {result}")
            if take(span, result):
                return
            submit()


def next_size(size: int, members: int, wall: float) -> int:
    """Members for a chunk worth the trouble, from the time (s) that so many took; the first times are no good measure."""
    wanted = WORTH * members / max(wall, 1e-6)
    return int(min(max(wanted, FIRST), 4 * max(size, FIRST), MOST))
