"""Progress of long functions in Python."""

from __future__ import annotations

import sys
from types import SimpleNamespace
from typing import Any

import pytest

import autobalancer as ab
from autobalancer import patience
from autobalancer.cli.terminal import progress


class ZMQInteractiveShell:
    """What IPython calls the shell of a notebook."""


def test_a_notebook_sees_a_line_that_a_pipe_and_false_do_not_show(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(patience, "SOON", -1.0)
    ab.simulate(ab.example("stall_and_release"), duration=0.2)  # compiles, and says so, where no other test ran before
    capsys.readouterr()

    def runs(**more: Any) -> str:
        ab.simulate(ab.example("stall_and_release"), duration=0.2, **more)
        return capsys.readouterr().err

    assert runs() == ""  # no terminal, no notebook
    shell = SimpleNamespace(get_ipython=ZMQInteractiveShell)
    monkeypatch.setitem(sys.modules, "IPython", shell)
    shown = runs()
    assert shown.startswith("\rsimulate: ")
    assert shown.endswith(" s\n")
    assert runs(progress=False) == ""
    seen: list[float] = []
    assert runs(progress=lambda now, end: seen.append(now / end)) == ""
    assert seen[-1] == 1.0


def test_quick_functions_show_nothing(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=ZMQInteractiveShell))
    monkeypatch.setattr(patience, "SOON", 60.0)
    ab.simulate(ab.example("stall_and_release"), duration=0.2)
    assert capsys.readouterr().err == ""


def test_a_pipe_gets_a_line_now_and_then(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    now = iter([0.0, 1.0, 21.0, 30.0, 61.0, 90.0])
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: next(now)))
    with progress.progress_bar("runs") as update:
        for done in (10, 400, 500, 900, 1100):
            update(done, 12000)
    assert capsys.readouterr().err == "runs: 400 of 12000 after 21 s\nruns: 900 of 12000 after 61 s\n"
