"""``python -m autobalancer``, and the command ``autobalancer``."""

from __future__ import annotations

import atexit
import gc
import io
import os
import signal
import sys
from typing import Any

TRACEBACK = "AUTOBALANCER_TRACEBACK"
NARROWEST = 40  # columns for which tables and helps are made


def main() -> None:
    """Run the command line; also what goes wrong in the program itself, or while it loads, ends in a sentence."""
    pressed: list[int] = []

    def stop(number: int, frame: Any) -> None:
        pressed.append(number)
        raise KeyboardInterrupt

    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, stop)
    gc.set_threshold(
        200_000, 20, 20
    )  # what a command loads lives to its end: looking for garbage in it takes a tenth of the time
    atexit.register(gc.freeze)  # nor is garbage looked for when the process ends: that takes a third of a warm check
    for stream in (sys.stdout, sys.stderr):  # a pipe may have an encoding without µ: an answer must not be lost for it
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace" if stream is sys.stderr else "replace")
    os.environ["MPLBACKEND"] = (
        "agg"  # a notebook passes its own on, which this installation may not have; no window is opened
    )
    columns = os.environ.get("COLUMNS", "")
    if columns.isdecimal() and int(columns) < NARROWEST:
        os.environ["COLUMNS"] = str(NARROWEST)
    try:
        from autobalancer.cli import app

        app()
    except (Exception, KeyboardInterrupt) as reason:
        if pressed or isinstance(
            reason, KeyboardInterrupt
        ):  # a module that was stopped while it loads may raise anything
            sys.exit(130)
        if os.environ.get(TRACEBACK):
            raise
        print(_fault(reason), file=sys.stderr)
        sys.exit(1)


def _fault(reason: Exception) -> str:
    if isinstance(reason, MemoryError):
        return "autobalancer: there is not enough memory for this; ask for less"
    told = ascii(str(reason))[1:-1]
    said = f"{type(reason).__name__}: {told if len(told) < 300 else told[:297] + '...'}"
    return (
        f"autobalancer: a fault of the program, not yours: {said}\nPlease report it with the command and its files; "
        f"the same command with {TRACEBACK}=1 in the environment shows where it happened"
    )


if __name__ == "__main__":
    main()
