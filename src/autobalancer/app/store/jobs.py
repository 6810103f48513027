"""Work in the background: a queue that never blocks the page, with progress, cancel and a time limit."""

from __future__ import annotations

import gc
import itertools
import threading
import time
import traceback
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, Literal

from nicegui import core

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.memory import free_memory

State = Literal["waiting", "running", "done", "failed", "cancelled"]
QUEUED = 20  # jobs of one user that wait or run
TOO_MUCH = "this needs more memory than the server may take; ask for less: fewer balls, samples or points"
LEFT = 200e6  # bytes of free memory below which a job that goes on working is ended, before the system ends the server
LOOKS = 0.5  # s between two looks at it
KEPT = 200  # finished jobs that are remembered
CLEARED = 20  # jobs after which memory that they hold in circles is freed: Python itself may wait for hundreds
here = threading.local()  # the job of this thread


@dataclass
class Job:
    """One piece of work of one user."""

    number: int
    user: str
    title: str
    limit: float  # s
    state: State = "waiting"
    share: float = 0.0  # of the work that is done
    message: str = ""
    result: Any = None
    notes: list[str] = field(default_factory=list)
    begun: float = 0.0
    seconds: float = 0.0
    looked: float = 0.0  # when the free memory was last seen
    stop: threading.Event = field(default_factory=threading.Event)

    @property
    def over(self) -> bool:
        """Whether it will not change any more."""
        return self.state in ("done", "failed", "cancelled")

    def progress(self, done: float, total: float) -> None:
        """Note how far the work is; ends it as Ctrl-C would if it is cancelled or takes too long.

        Raises
        ------
        MemoryError
            If hardly any memory is left: all jobs share that of the server, and one must not take it from the others.
        """
        self.share = done / total if total > 0.0 else 0.0
        if self.stop.is_set():
            raise KeyboardInterrupt
        now = time.monotonic()
        if now - self.looked > LOOKS:
            self.looked = now
            if free_memory() < LEFT:
                raise MemoryError
        if now - self.begun > self.limit:
            self.message = f"ended after the limit of {self.limit:g} s"
            raise KeyboardInterrupt


class Jobs:
    """The queue of a server: whoever has fewest jobs under way is next, and of these who has waited longest.

    ``each`` is how many jobs of one user may run at the same time; by default as many as there are workers.
    """

    def __init__(self, workers: int = 2, limit: float = 600.0, each: int | None = None) -> None:
        self.limit, self.each = limit, each or workers
        self._waiting: dict[int, Callable[[Job], Any]] = {}
        self._served: dict[str, int] = {}  # the last job of each user that was begun, counted
        self._pool = ThreadPoolExecutor(workers, thread_name_prefix="job")
        self._numbers, self._turns = itertools.count(1), itertools.count(1)
        self._jobs: dict[int, Job] = {}
        self._lock = threading.Lock()

    def start(self, user: str, title: str, work: Callable[[Job], Any]) -> Job:
        """Put work at the end of the queue.

        Raises
        ------
        QuestionError
            If too many jobs of this user wait.
        """
        with self._lock:
            mine = [job for job in self._jobs.values() if job.user == user and not job.over]
            if len(mine) >= QUEUED:
                raise QuestionError(f"{QUEUED} jobs wait or run already; wait for one of them, or cancel it")
            job = Job(next(self._numbers), user, title, self.limit)
            self._jobs[job.number] = job
            self._waiting[job.number] = work
            finished = [number for number, one in self._jobs.items() if one.over]
            for number in finished[: max(len(finished) - KEPT, 0)]:
                del self._jobs[number]
        self._pool.submit(self._work)
        return job

    def of(self, user: str) -> list[Job]:
        """The jobs of a user, the latest first."""
        with self._lock:
            return [job for job in reversed(self._jobs.values()) if job.user == user]

    def cancel(self, job: Job) -> None:
        """End a job: at once if it waits, else at its next look at the clock."""
        job.stop.set()
        with self._lock:
            if self._waiting.pop(job.number, None) is not None:
                job.state = "cancelled"

    def close(self) -> None:
        """End all jobs, for the end of the server."""
        for job in list(self._jobs.values()):
            self.cancel(job)
        self._pool.shutdown(wait=False, cancel_futures=True)

    def wait(self, seconds: float) -> None:
        """Wait until what runs has ended and kept what it has, so long at most."""
        end = time.monotonic() + seconds
        while time.monotonic() < end and any(one.state == "running" for one in list(self._jobs.values())):
            time.sleep(0.05)

    def _work(self) -> None:
        """Do what may be done now, until nothing of that waits."""
        while (picked := self._next()) is not None:
            self._run(*picked)

    def _next(self) -> tuple[Job, Callable[[Job], Any]] | None:
        with self._lock:
            running = Counter(one.user for one in self._jobs.values() if one.state == "running")
            first: dict[str, Job] = {}
            for number in self._waiting:
                first.setdefault(self._jobs[number].user, self._jobs[number])
            able = [job for job in first.values() if running[job.user] < self.each]
            if not able:
                return None
            job = min(able, key=lambda one: (running[one.user], self._served.get(one.user, 0)))
            self._served[job.user] = next(self._turns)
            job.state, job.begun = "running", time.monotonic()
            return job, self._waiting.pop(job.number)

    def _run(self, job: Job, work: Callable[[Job], Any]) -> None:
        here.job = job
        try:
            job.result = work(job)
            job.state, job.share = ("cancelled" if job.stop.is_set() else "done"), 1.0
        except KeyboardInterrupt:
            job.state = "cancelled"
        except AutobalancerError as error:
            job.state, job.message = "failed", str(error)
        except MemoryError:
            job.state, job.message = "failed", TOO_MUCH
        except Exception as error:
            traceback.print_exc()  # for whoever looks at the server; nothing of this is the user's fault
            job.state, job.message = "failed", f"unexpected: {type(error).__name__}: {error}"
        finally:
            job.seconds, here.job = time.monotonic() - job.begun, None
            if job.number % CLEARED == 0:
                gc.collect()


class Latest:
    """Work of which only the latest counts: what waits is dropped when something newer comes."""

    def __init__(self, pool: ThreadPoolExecutor) -> None:
        self._pool = pool
        self.number = 0

    def start(self, work: Callable[[], Any], then: Callable[[Any], None]) -> None:
        """Do it in the background; ``then`` is called in the loop of the pages, unless something newer was asked for."""
        self.number += 1
        mine = self.number

        def hand_over(answer: Any) -> None:
            if mine == self.number:  # asked in the loop: until then something newer may have come
                then(answer)

        def run() -> None:
            if mine != self.number:
                return
            answer = work()
            if core.loop is not None:
                core.loop.call_soon_threadsafe(hand_over, answer)

        self._pool.submit(run)
