"""Studies: what varies, how it scatters, and when enough is known, from a file or a dict."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.patience import shows_progress
from autobalancer.results.answers.studied import Studied
from autobalancer.studies.study.chunk import WALL, Arrays, refuse_impossible
from autobalancer.studies.study.dataset import study_dataset
from autobalancer.studies.study.drag_note import drag_note
from autobalancer.studies.study.execute import FIRST, here, in_cluster, next_size
from autobalancer.studies.study.outputs import RUN
from autobalancer.studies.study.reading import read_study
from autobalancer.studies.study.spec import Study
from autobalancer.studies.study.stopping import looks
from autobalancer.studies.study.store import Store

Span = tuple[int, int]


@shows_progress
def study(
    given: str | Path | Mapping[str, Any],
    *,
    folder: str | Path | None = None,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Callable[[int, int], None] | None = None,
    keep_on_interrupt: bool = False,
) -> Studied:
    """Run a study: a machine many times with values from a grid and from distributions.

    Parameters
    ----------
    given
        The path of a study file (TOML), or a dict of the same form; see the page on studies for its keys.
    folder
        Where finished chunks are kept, and taken up again by the same call later. By default nothing is kept on the way.
    scheduler
        Address of a Dask scheduler whose workers run the members, such as ``"tcp://host:8786"``; by default this process does.
    workers
        Threads of this process; by default one for each core. The result does not depend on it.
    progress
        Called with (members done, members in all).
    keep_on_interrupt
        If true, Ctrl-C returns what is done.

    Returns
    -------
    xarray.Dataset
        Over ``member``: as coordinates everything that varied, ``draw``, ``point`` of the grid and ``seed``; the measures of
        :func:`autobalancer.sweep`, ``outcome``, ``verdict`` and ``balanced`` of each run, border speeds and whatever else the
        study asked for. ``attrs["stopped_by"]`` is ``"confidence"``, ``"members"`` or ``"interrupted"``.

    Raises
    ------
    QuestionError
        For a fault in the study, named with its key; for a folder of another study; for distributions of impossible machines.
    MachineError
        If the machine is impossible.
    ResultError
        If a chunk cannot be written; those before it are kept.
    """
    asked = read_study(given)
    if RUN in asked.results and not asked.duration > 0.0:
        raise QuestionError("duration: the machine has no 'run.duration'; give one in the study")
    refuse_impossible(asked)
    store = Store(folder, asked.identity()) if folder is not None else None
    try:
        work = _Work(asked, store, workers, progress)
        interrupted = work.run(scheduler)
    finally:
        if store is not None:
            store.close()
    if interrupted and not keep_on_interrupt:
        raise KeyboardInterrupt
    found = study_dataset(asked, work.chunks, work.end)
    stopped = "interrupted" if interrupted else "confidence" if work.enough else "members"
    named = {"study_file": Path(given).name} if isinstance(given, (str, Path)) else {}
    left = ""
    with suppress(KeyboardInterrupt):  # the members are not lost for that
        left = "" if interrupted else drag_note(asked)
    return Studied.of(found.assign_attrs(stopped_by=stopped, drag_warning=left, **named))


class _Work:
    """What is done, what is to do, and when it is enough."""

    def __init__(self, asked: Study, store: Store | None, workers: int | None, progress: Any) -> None:
        self.asked, self.store, self.progress = asked, store, progress
        self.workers = workers if workers is not None else os.cpu_count() or 1
        self.chunks: dict[Span, Arrays] = store.chunks() if store is not None else {}
        self.end, self.enough = asked.count, False
        self._size = FIRST  # members of the next chunk
        self._looked = 0  # draws

    def run(self, scheduler: str | None) -> bool:
        """Run what is missing; whether somebody interrupted it."""
        try:
            if self._look():
                return False
            if scheduler is None:
                here(self.asked, self._missing(), self._take, self.workers, self._within)
            else:
                in_cluster(self.asked, self._missing(), self._take, scheduler)
        except KeyboardInterrupt:
            return True
        return False

    def _missing(self) -> Iterator[Span]:
        """Chunks that are not there, in order; each is as large as the time of those before it says."""
        first = 0
        while first < self.asked.count:
            there = next((span for span in self.chunks if span[0] == first), None)
            if there is None:
                later = [span[0] for span in self.chunks if span[0] > first]
                there = first, min([first + self._size, self.asked.count, *later])
                yield there
            first = there[1]

    def _take(self, span: Span, arrays: Arrays) -> bool:
        self.chunks[span] = arrays
        if self.store is not None:
            self.store.keep(*span, arrays)
        self._size = next_size(self._size, span[1] - span[0], float(arrays[WALL][0]))
        if self.progress is not None:
            self.progress(self._done(), self.asked.count)
        return self._look()

    def _within(self, done: int, _total: int) -> None:
        """Some members of the chunk under way are done."""
        if self.progress is not None:
            self.progress(min(self._done() + done, self.asked.count), self.asked.count)

    def _done(self) -> int:
        return sum(last - first for first, last in self.chunks)

    def _look(self) -> bool:
        """Whether enough is known. Looks come after fixed numbers of draws, so that chunks make no difference."""
        stop = self.asked.stop
        if stop is None:
            return False
        points, known = len(self.asked.points), self._known()
        for draws in looks(self.asked.draws):
            if draws * points > known:
                return False
            if draws <= self._looked:
                continue
            self._looked = draws
            values = self._values(stop.of, draws * points).reshape(draws, points)
            if all(stop.reached(values[:, point]) for point in range(points)):
                self.end, self.enough = draws * points, True
                return True
        return False

    def _known(self) -> int:
        """Members from the first one on without a gap."""
        end = 0
        for first, last in sorted(self.chunks):
            if first > end:
                break
            end = max(end, last)
        return end

    def _values(self, name: str, count: int) -> Any:
        parts = [self.chunks[span][name] for span in sorted(self.chunks) if span[0] < count]
        return np.concatenate(parts).astype(float)[:count]
