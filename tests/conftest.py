"""Workers share the compilation of a fresh checkout, so that no kernel is compiled twice at the same time."""

from __future__ import annotations

import gc
import signal
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest

FOLDER = "kernels"  # what workers are told: where they note what is compiled


@pytest.hookimpl(optionalhook=True)  # of xdist
def pytest_configure_node(node: Any) -> None:
    """Called where the tests are handed out, for each worker."""
    from autobalancer.kernels import cache

    if not hasattr(node.config, "kernel_notes"):
        node.config.kernel_notes = None if cache.any_compiled() else TemporaryDirectory()
    node.workerinput[FOLDER] = node.config.kernel_notes.name if node.config.kernel_notes else ""


def pytest_configure(config: Any) -> None:
    gc.set_threshold(200_000, 20, 20)  # as the commands do: looking for garbage takes an eighth of a compilation
    folder = getattr(config, "workerinput", {}).get(FOLDER)
    if folder:
        from tests.references.compiled import compile_in_turns

        compile_in_turns(Path(folder))


@pytest.fixture
def ctrl_c() -> Iterator[None]:
    """Ctrl-C raises KeyboardInterrupt, which a process in the background would ignore."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
