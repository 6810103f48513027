"""Chunks of a study run here or by a cluster; each is handed on as soon as it is finished."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from importlib import import_module
from socket import create_connection, gaierror
from time import monotonic, sleep
from typing import Any

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.studies.study.chunk import Arrays, run_chunk
from autobalancer.studies.study.spec import Study

Span = tuple[int, int]
Take = Callable[[Span, Arrays], bool]  # keeps a chunk; true if no more are wanted
Look = Callable[[int, int], None]
FIRST = 16  # members of the first chunks
MOST = 100_000  # members of a chunk
WORTH = 2.0  # s, that a worker has with a chunk
WAIT = 5.0  # s, for a scheduler to answer
LOST = 30.0  # s without scheduler or workers, after which nobody waits for them any longer
PAUSE = 0.01  # s, between two looks whether a chunk is finished
RETRIES = 3  # of a chunk whose worker died


def here(study: Study, spans: Iterator[Span], take: Take, workers: int | None, look: Look | None = None) -> None:
    """Run chunks one after the other, the members of each on all cores; ``look`` is told how many of a chunk are done."""
    for first, last in spans:
        if take((first, last), run_chunk(study, first, last, workers, look)):
            return


def in_cluster(study: Study, spans: Iterator[Span], take: Take, address: str) -> None:
    """Run chunks by the workers of a Dask scheduler, some more of them waiting than there are workers.

    Raises
    ------
    QuestionError
        If Dask is not installed, no scheduler answers there, or it or all its workers are lost. What was finished before is kept.
    """
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise QuestionError(
            "scheduler: Dask is not installed; install it with: pip install 'autobalancer[cluster]'"
        ) from None
    try:
        _knock(address)
        client = distributed.Client(address, timeout=WAIT, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as reason:
        raise QuestionError(f"scheduler: no Dask scheduler answers at {address!r}: {reason}") from None
    try:
        with client:
            _share_out(distributed, client, study, spans, take, address)
    except (OSError, TimeoutError, CancelledError) as reason:
        raise _lost(f"the scheduler at {address!r} was lost: {reason}") from None


def _knock(address: str) -> None:
    """Try the door of a scheduler for a while: plainly, since Dask itself says little of what is wrong and takes long.

    Raises
    ------
    OSError, ValueError
        If nobody opens, or this is no address.
    """
    addressing: Any = import_module("distributed.comm.addressing")
    way, place = addressing.parse_address(address)
    if way not in ("tcp", "tls"):
        raise ValueError("write it as tcp://HOST:PORT")
    host, port = addressing.parse_host_port(place)
    begun = monotonic()
    while True:
        try:
            create_connection((host, port), timeout=WAIT).close()
            return
        except OSError as reason:
            if isinstance(reason, (gaierror, TimeoutError)) or monotonic() - begun > WAIT:
                raise
            sleep(0.1 * WAIT)


def _share_out(distributed: Any, client: Any, study: Study, spans: Iterator[Span], take: Take, address: str) -> None:
    threads = sum(client.nthreads().values())
    if not threads:
        raise QuestionError(f"scheduler: the scheduler at {address!r} has no workers; start some")
    waiting = distributed.as_completed(with_results=True, raise_errors=False, loop=client.loop)
    spans_of, again = {}, dict[Span, int]()

    def submit(span: Span | None) -> None:
        if span is not None:  # with the study each time: what is kept by workers is gone with the last of them
            future = client.submit(run_chunk, study, *span, pure=False, retries=RETRIES)
            spans_of[future.key] = span
            waiting.add(future)

    for _ in range(2 * threads):
        submit(next(spans, None))
    while spans_of:
        _wait(waiting, client, address)
        future, result = next(waiting)
        span = spans_of.pop(future.key)
        if future.status == "finished":
            if take(span, result):
                return
            submit(next(spans, None))
        elif isinstance(result, CancelledError) and client.status == "running" and again.get(span, 0) < RETRIES:
            again[span] = again.get(span, 0) + 1  # its worker was lost with what it had
            submit(span)
        else:
            raise _failure(span, result)


def _wait(waiting: Any, client: Any, address: str) -> None:
    """Wait for a chunk, as long as there is somebody to run it."""
    looked = seen = monotonic()
    while not waiting.has_ready():
        sleep(PAUSE)
        now = monotonic()
        if now - looked > 1.0:
            looked = now
            if client.status == "running" and client.nthreads():
                seen = now
            elif now - seen > LOST or client.status == "closed":
                raise _lost(f"the scheduler at {address!r} or all its workers were lost")


def _failure(span: Span, result: Any) -> Exception:
    """Why a chunk could not be run; faults of the study are those of the worker."""
    reason = result[1] if isinstance(result, tuple) else result
    if isinstance(reason, AutobalancerError):
        return reason
    members = f"members {span[0] + 1} to {span[1]}"
    if isinstance(reason, CancelledError):
        return _lost(f"it was lost, or the workers that had {members}")
    return _lost(f"{members} could not be run: {type(reason).__name__}: {reason}")


def _lost(said: str) -> QuestionError:
    return QuestionError(f"scheduler: {said}. What was finished before is in the folder, and the same call goes on")


def next_size(size: int, members: int, wall: float) -> int:
    """Members for a chunk worth the trouble, from the time (s) that so many took; the first times are no good measure."""
    wanted = WORTH * members / max(wall, 1e-6)
    return int(min(max(wanted, FIRST), 4 * max(size, FIRST), MOST))
