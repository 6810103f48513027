"""Progress of long functions in Python: a bar on a terminal, a line in a notebook, nothing in a pipe or a script's log.

And questions with a limit: their loops ask :func:`check_deadline`.
"""

from __future__ import annotations

import math
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, nullcontext
from contextvars import ContextVar, copy_context
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from autobalancer.errors import MachineError

P = ParamSpec("P")
R = TypeVar("R")
Progress = Callable[[float, float], None]
SOON = 1.0  # s; what takes less shows nothing
WORD, ENOUGH, LAST = 3.0, 20.0, 2.0  # s until a call is named, until it is given up, and after Ctrl-C


def silent(_done: float, _total: float) -> None:
    """Progress of a part that somebody else shows as a whole."""


def shows_progress(function: Callable[P, R]) -> Callable[P, R]:
    """Give a function with the argument ``progress`` a bar of its own.

    ``None`` shows it where a person is looking, after a second; ``False`` never; a callable takes its place.
    """

    @wraps(function)
    def shown(*args: P.args, **kwargs: P.kwargs) -> R:
        given = kwargs.get("progress")
        if callable(given):
            return function(*args, **kwargs)
        bar = None if given is False else _bar(function.__name__.removesuffix("_races").removesuffix("_chamber"))
        kwargs["progress"] = bar
        try:
            return function(*args, **kwargs)
        finally:
            if bar is not None:
                bar.close()

    shown.__dict__["shows_progress"] = True  # also where it is one of many options
    return shown


def _bar(text: str) -> Any:
    if in_notebook():
        return Line(text)
    return RichBar(text) if sys.stderr.isatty() else None


def in_notebook() -> bool:
    """Whether a notebook kernel runs this; asked without importing anything."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return any(kind.__name__ == "ZMQInteractiveShell" for kind in type(shell).__mro__)  # Colab has one of its own


class Line:
    """A line that is written over, as notebooks can."""

    def __init__(self, text: str) -> None:
        self.text, self.begun, self.last = text, time.monotonic(), 0.0

    def __call__(self, done: float, total: float) -> None:
        now = time.monotonic()
        if now - self.begun > SOON and now - self.last > 0.2 and total > 0.0:
            self.last = now
            print(f"\r{self.text}: {100.0 * done / total:3.0f} %", end="", file=sys.stderr, flush=True)

    def close(self) -> None:
        """Leave the line."""
        if self.last:
            print(f"\r{self.text}: {time.monotonic() - self.begun:.3g} s", file=sys.stderr, flush=True)


class RichBar:
    """A bar on a terminal that vanishes at the end."""

    def __init__(self, text: str) -> None:
        self.text, self.begun = text, time.monotonic()
        self.bar: Any = None
        self.task: Any = None

    def __call__(self, done: float, total: float) -> None:
        if self.bar is None and time.monotonic() - self.begun > SOON:
            from rich.console import Console
            from rich.progress import Progress

            self.bar = Progress(console=Console(stderr=True), transient=True)
            self.bar.start()
            self.task = self.bar.add_task(self.text)
        if self.bar is not None:
            self.bar.update(self.task, completed=done, total=total)

    def close(self) -> None:
        """Take it away."""
        if self.bar is not None:
            self.bar.stop()


class OutOfTime(Exception):
    """A question took more computing time than it may."""


_END: ContextVar[float] = ContextVar("end of a question, s of the thread", default=math.inf)


@contextmanager
def question(name: str, seconds: float, say: Callable[[str], None] | None = None) -> Iterator[None]:
    """Within it loops may compute for some ``seconds`` of this thread; after one ``say`` is told the name, once."""
    word = threading.Timer(SOON, say or (lambda _: None), (name,))
    word.daemon = True
    end = _END.set(time.thread_time() + seconds)
    if say is not None:
        word.start()
    try:
        yield
    finally:
        word.cancel()
        _END.reset(end)


def check_deadline() -> None:
    """Asked in loops that may take long.

    Raises
    ------
    OutOfTime
        If the :func:`question` around them has no computing time left.
    """
    end = _END.get()
    if end < math.inf and time.thread_time() > end:
        raise OutOfTime


def not_counted(seconds: float) -> None:
    """Let the question around this last longer, by what compiling took."""
    _END.set(_END.get() + seconds)


def looking_for(name: str) -> None:
    """A line about what a check is busy with."""
    print(f"check: looking for {name}", file=sys.stderr, flush=True)


def returned(call: Callable[[], R], text: str, word: float = WORD, limit: float = ENOUGH) -> R:
    """What a call of somebody's own code returns, which may never do so.

    It runs in a thread of its own, so that Ctrl-C works here. After some seconds a ``word`` is said: the ``text``.

    Raises
    ------
    MachineError
        If it has not come back after the ``limit``, s; its thread is left alone.
    """
    context, answers, reasons = copy_context(), [], []

    def run() -> None:
        try:
            answers.append(context.run(call))
        except BaseException as reason:  # for whoever waits
            reasons.append(reason)

    thread = threading.Thread(target=run, daemon=True)
    begun, said = time.monotonic(), False
    thread.start()
    try:
        while thread.is_alive():
            raise_noted()
            waited = time.monotonic() - begun
            thread.join(0.2 if waited > word else min(word, 0.2))
            if waited > limit:
                raise MachineError(f"has not come back in {limit:g} s; let its loops end")
            if waited > word and not said:
                said = True
                print(f"{text} has not come back for {waited:.0f} s; Ctrl-C ends the wait", file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        thread.join(LAST)
        raise
    if reasons:
        raise reasons[0]
    return answers[0]


# Ctrl-C where something is to be kept.
#
# It is raised at any place of the main thread, also where Numba reads the arguments of compiled code: there it is lost, becomes
# another error or ends the process. So it is noted, and raised between two pieces of work.


_noted: list[list[int]] = []  # signals that came, in the one list that is filled now
_unwritten: list[ExitStack] = []  # of a command that has still to write what is kept


@contextmanager
def interrupts_noted(*, keep: bool = True, written: bool = False) -> Iterator[list[int]]:
    """While it lasts, a first Ctrl-C only fills the list, so that no work is left half done; a second one is raised.

    So does any other signal that is taken for Ctrl-C, such as SIGTERM on the command line. Work in pieces asks
    :func:`raise_noted` between them. One that came after the last piece is raised at the end, unless its work is to be kept.
    Where results are ``written`` nothing is noted at first; what is once noted within it is so up to its end, and raised there.
    """
    if threading.current_thread() is not threading.main_thread():  # no other one is interrupted
        yield []
        return
    if written:
        with ExitStack() as stack:
            _unwritten.append(stack)
            try:
                yield []
            finally:
                _unwritten.clear()
            raise_noted()
        return
    with nullcontext() if _noted else nullcontext(_unwritten[0]) if _unwritten else ExitStack() as open_stack:
        if open_stack is not None:
            open_stack.enter_context(_noting())
        yield _noted[0]
        if not keep:
            raise_noted()


def raise_noted() -> None:
    """Raise the Ctrl-C that was noted, if one was.

    Raises
    ------
    KeyboardInterrupt
        Then.
    """
    if _noted and _noted[0] and threading.current_thread() is threading.main_thread():
        _noted[0].clear()
        raise KeyboardInterrupt


@contextmanager
def _noting() -> Iterator[None]:
    def noting(before: Callable[[int, Any], Any]) -> Callable[[int, Any], None]:
        def note(number: int, frame: Any) -> None:
            try:
                before(number, frame)
            except KeyboardInterrupt:
                noted.append(number)
                if len(noted) > 1:
                    raise

        return note

    noted: list[int] = []
    numbers = [getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name)]
    taken: dict[int, Any] = {n: signal.getsignal(n) for n in numbers if callable(signal.getsignal(n))}
    _noted.append(noted)
    for number, before in taken.items():
        signal.signal(number, noting(before))
    try:
        yield
    finally:
        for number, before in taken.items():
            signal.signal(number, before)
        _noted.clear()
