"""Groups of members run by threads that need no lock, until all are done or somebody stops them."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from threading import Lock
from typing import Any, NamedTuple, Protocol

import numpy as np

from autobalancer.kernels.many_members import DONE, FLAGS, STOP
from autobalancer.kernels.system import Floats
from autobalancer.studies.ensemble.layout import Found, Group, Groups
from autobalancer.studies.variations import completed, gauges_for

PART, LEAST = 0.2, 0.004  # s, that a thread works between two looks, and that it takes at least
Progress = Callable[[int, int], None]


@contextmanager
def interrupts_noted() -> Iterator[list[int]]:
    """While it lasts, a first Ctrl-C only fills the list, so that no work is left half done; a second one is raised.

    So does any other signal that is taken for Ctrl-C, such as SIGTERM on the command line.
    """
    noted: list[int] = []

    def noting(before: Callable[[int, Any], Any]) -> Callable[[int, Any], None]:
        def note(number: int, frame: Any) -> None:
            try:
                before(number, frame)
            except KeyboardInterrupt:
                noted.append(number)
                if len(noted) > 1:
                    raise

        return note

    taken: dict[int, Any] = {}
    if threading.current_thread() is threading.main_thread():  # no other one is interrupted
        numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
        taken = {number: signal.getsignal(number) for number in numbers if callable(signal.getsignal(number))}
    for number, before in taken.items():
        signal.signal(number, noting(before))
    try:
        yield noted
    finally:
        for number, before in taken.items():
            signal.signal(number, before)


class Ran(NamedTuple):
    """A group that was run."""

    group: Group
    found: Found
    starts: Floats  # (members, balls) ball angles


class Shared(Protocol):
    """Work that threads share, each with its own flags."""

    flags: list[Any]

    def thread(self, flags: Any, look: Callable[[], None] | None = None) -> None:
        """What each thread does; ``look`` is called now and then."""

    def done(self) -> int:
        """How much is done."""

    def stop(self) -> None:
        """Let all threads stop soon."""


class Work:
    """The members of one group in parts, each thread its next one."""

    def __init__(self, group: Group, most: int, keep_states: bool) -> None:
        self.group, self.found, self._most = group, group.room(keep_states), most
        self._places, self._words = group.words()
        self._next, self._lock, self._each = 0, Lock(), 0.0
        self.flags: list[Any] = []
        self.seconds = 0.0

    @property
    def ran(self) -> Ran:
        """What there is of it."""
        return Ran(self.group, self.found, self.group.starts(self._places, self._words))

    def done(self) -> int:
        """How many members are done."""
        return sum(int(flags[DONE]) for flags in self.flags)

    def stop(self) -> None:
        """Let all threads stop at their next look."""
        for flags in self.flags:
            flags[STOP] = 1

    def _parts(self) -> Iterator[range]:
        """The next members, fewer towards the end so that all threads end together."""
        count = len(self.group.numbers)
        while True:
            with self._lock:
                share = self._each * (count - self._next) / (2 * len(self.flags))
                size = max(1, int(min(PART, max(share, LEAST)) / self._each)) if self._each > 0.0 else 1
                part = range(self._next, min(self._next + min(size, -(-count // 8)), count))
                self._next = part.stop
            if not part:
                return
            yield part

    def thread(self, flags: Any, look: Callable[[], None] | None = None) -> None:
        """Work until nothing is left; ``look`` is called between two parts."""
        bench = self.group.bench()
        for part in self._parts():
            begin = time.thread_time()
            bench.run(self.group.fresh, self._places, self._words, part, self._most, flags, self.found)
            spent = time.thread_time() - begin
            with self._lock:
                self.seconds += spent
                self._each = spent / len(part)
            if look is not None:
                look()
            if flags[STOP]:
                return


def run_groups(
    groups: Groups, workers: int | None, progress: Progress | None, keep_states: bool = False
) -> tuple[list[Ran], float, bool]:
    """Run all members that are ready; what they left, seconds of a core in all, and whether somebody interrupted any of it."""
    workers = workers if workers is not None else os.cpu_count() or 1
    total, before, ran, seconds = sum(len(group.numbers) for group in groups.all), 0, list[Ran](), 0.0
    stopped = False
    for group in groups.all:
        work = Work(group, groups.plan.max_steps, keep_states)
        if not stopped:
            try:
                run_threads(work, min(workers, len(group.numbers)), before, total, progress)
            except KeyboardInterrupt:
                stopped = True
        _complete(work.ran, groups.plan.end)
        ran.append(work.ran)
        seconds, before = seconds + work.seconds, before + work.done()
    return ran, seconds, stopped or groups.interrupted


def run_threads(work: Shared, workers: int, before: int, total: int, progress: Progress | None) -> None:
    """Let so many threads do a piece of work; ``before`` of the ``total`` are done already.

    Raises
    ------
    KeyboardInterrupt
        When somebody interrupts them, once all threads have stopped.
    """
    work.flags = [np.zeros(FLAGS, np.int64) for _ in range(workers)]
    told = -1

    def look() -> None:
        nonlocal told
        if progress is not None and (done := before + work.done()) != told:
            told = done
            progress(done, total)

    if workers == 1:
        work.thread(work.flags[0], look)
        return
    with ThreadPoolExecutor(workers) as pool:
        waiting: set[Future[None]] = {pool.submit(work.thread, flags) for flags in work.flags}
        try:
            while waiting:
                finished, waiting = wait(waiting, timeout=PART)
                look()
                for future in finished:
                    future.result()
        except BaseException:
            work.stop()
            raise


def _complete(ran: Ran, end: float) -> None:
    """What of the measures no compiled code finds."""
    for row, number in enumerate(ran.group.numbers):
        if number in ran.group.later and ran.found.counts[row, 0] > 0:
            assembly, places = ran.group.later[number]
            completed(ran.found.rows[row], assembly, places, gauges_for(assembly, places, end))
