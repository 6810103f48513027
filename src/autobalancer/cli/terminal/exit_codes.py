"""Exit codes of the command line.

0 finished, or ended by an event; 1 a fault of the program; 2 something the user can mend; 3 to 5 a run that did not come to its
end; 128 and the number of the signal: stopped from outside (130 for Ctrl-C, 143 for SIGTERM).
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer

FAULT, MEND = 1, 2
OUTCOMES = {"not finite": 3, "too dense": 3, "step too small": 4, "budget spent": 5}
_stopped_by: list[int] = []


@contextmanager
def stopped_like_ctrl_c() -> Iterator[None]:
    """While it lasts, SIGTERM (of batch systems and containers) and SIGHUP stop as Ctrl-C does, which keeps what was computed."""
    taken = []
    if threading.current_thread() is threading.main_thread():
        numbers = [getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name)]  # Windows has one
        taken = [number for number in numbers if signal.getsignal(number) is signal.SIG_DFL]
    for number in taken:
        signal.signal(number, _stop)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_DFL)


def _stop(number: int, _frame: Any) -> None:
    _stopped_by.append(number)
    raise KeyboardInterrupt


def stop_code() -> int:
    """The exit code of a command that was stopped."""
    return 128 + (_stopped_by[-1] if _stopped_by else int(signal.SIGINT))


def leave_with(outcome: str) -> None:
    """End the command with the code of the outcome of a run, if that is not 0."""
    code = stop_code() if outcome == "interrupted" else OUTCOMES.get(outcome, 0)
    if code:
        raise typer.Exit(code)
