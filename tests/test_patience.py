"""Progress of long functions in Python."""

from __future__ import annotations

import signal
import sys
import threading
from types import SimpleNamespace
from typing import Any

import pytest

import autobalancer as ab
from autobalancer import progress as patience
from autobalancer.cli.terminal import progress_bar as progress
from autobalancer.errors import MachineError


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


@pytest.mark.usefixtures("ctrl_c")
def test_a_call_that_does_not_come_back_is_named_and_given_up_and_ctrl_c_ends_the_wait(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    free = threading.Event()
    assert patience.returned(lambda: 3, "the force 'swift'") == 3
    with pytest.raises(ZeroDivisionError):
        patience.returned(lambda: 1 // 0, "the force 'wrong'")
    assert capsys.readouterr().err == ""
    with pytest.raises(MachineError, match=r"has not come back in 0.02 s; let its loops end"):
        patience.returned(free.wait, "the force 'slow'", word=0.0, limit=0.02)
    assert "the force 'slow' has not come back for 0 s; Ctrl-C ends the wait" in capsys.readouterr().err
    monkeypatch.setattr(patience, "LAST", 0.0)
    threading.Timer(0.05, signal.raise_signal, (signal.SIGINT,)).start()
    with pytest.raises(KeyboardInterrupt):
        patience.returned(free.wait, "the force 'slow'", limit=60.0)
    free.set()
