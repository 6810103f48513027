"""Processor time of each test, with that of the processes it starts, for ``make test-times``; and what tests of Ctrl-C share."""

from __future__ import annotations

import gc
import json
import os
import resource
import signal
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

WRITTEN = os.environ.get("TIMES_BY_TEST")  # by tools/parts.py
TIMES = Counter[str]()  # s of each test
LAST = [0.0]  # s of this process and those it waited for, when the last step of a test was over


def used() -> float:
    """Processor time of this process and of those it waited for, s."""
    both = (resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in both)


def pytest_configure(config: Any) -> None:
    gc.set_threshold(200_000, 20, 20)  # as the commands do: looking for garbage takes an eighth of a compilation


def pytest_collection_finish(session: Any) -> None:
    LAST[0] = used()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: Any, call: Any) -> Iterator[None]:
    report = yield
    LAST[0], report.processor = (until := used()), until - LAST[0]  # travels with the report
    return report


def pytest_runtest_logreport(report: Any) -> None:
    TIMES[report.nodeid] += getattr(report, "processor", 0.0)  # that of a worker that died has none


def pytest_sessionfinish(session: Any) -> None:
    if WRITTEN and not hasattr(session.config, "workerinput"):
        Path(WRITTEN).write_text(json.dumps({test: round(taken, 3) for test, taken in TIMES.most_common()}))


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt, which a process in the background would ignore."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
