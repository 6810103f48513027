"""Every error the package raises on purpose.

    AutobalancerError                 catch this one to catch them all
    ├── MachineError                  the description of a machine is wrong (also a ValueError)
    │   └── MachineFileError          ... and it came from a file: names file and key
    ├── UnitError                     a quantity has no unit, the wrong one, or is not a number
    ├── CatalogError                  a name that no catalog knows
    ├── QuestionError                 the machine is fine, the question asked of it is not
    └── ResultError                   a result file is damaged or not one of ours

A message says what was given, what is allowed, where, and what to do.
A ``RangeWarning`` says that a law was used outside of the range for which it was made, a ``DurationWarning`` that a
computation will take long, a ``CacheWarning`` that compiled equations cannot be kept where they belong.
How a run ended is not an error but a value: see ``run.attrs["outcome"]``.
"""

from __future__ import annotations

import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType


class AutobalancerError(Exception):
    """Base of all errors raised on purpose."""


class MachineError(AutobalancerError, ValueError):
    """The description of a machine is not possible."""


class MachineFileError(MachineError):
    """A machine file was refused; the message names the file and every key at fault."""


class UnitError(AutobalancerError, ValueError):
    """A quantity could not be read."""


class CatalogError(AutobalancerError, LookupError):
    """No catalog has this entry."""


class QuestionError(AutobalancerError, ValueError):
    """What was asked makes no sense for this machine or result."""


class ResultError(AutobalancerError):
    """A result file is damaged or was not written by this package."""


class RangeWarning(UserWarning):
    """A law was used outside of the range for which it was made; what it gives there is an assumption."""


class DurationWarning(UserWarning):
    """A computation will take long; the message says how long, and what is quicker."""


class CacheWarning(UserWarning):
    """Compiled equations cannot be kept where they belong; results are the same."""


_unwarned = threading.local()


@contextmanager
def unwarned(*categories: type[UserWarning]) -> Iterator[None]:
    """Give no warnings of this package, or none of these classes, meanwhile and in this thread.

    What Python has for that changes all threads, and can silence them for good.
    """
    before = getattr(_unwarned, "now", ())
    _unwarned.now = (*before, *(categories or (UserWarning,)))
    try:
        yield
    finally:
        _unwarned.now = before


def warn(text: str, category: type[UserWarning]) -> None:
    """Warn at the line outside of this package that asked."""
    if issubclass(category, getattr(_unwarned, "now", ())):
        return
    frame: FrameType | None = sys._getframe()
    level = 1
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] == "autobalancer":
        frame, level = frame.f_back, level + 1
    warnings.warn(text, category, stacklevel=level)
