"""Every error the package raises on purpose.

    AutobalancerError                 catch this one to catch them all
    ├── MachineError                  the description of a machine is wrong (also a ValueError)
    │   └── MachineFileError          ... and it came from a file: names file and key
    ├── UnitError                     a quantity has no unit, the wrong one, or is not a number
    ├── CatalogError                  a name that no catalog knows
    ├── QuestionError                 the machine is fine, the question asked of it is not
    └── ResultError                   a result file is damaged or not one of ours

A message says what was given, what is allowed, where, and what to do. Where it is about keys of a file or a part, an
error has their paths, too: ``path`` of the first, ``problems`` of all.
A ``RangeWarning`` says that a law was used outside of the range for which it was made, a ``DurationWarning`` that a
computation will take long, a ``CacheWarning`` that compiled equations cannot be kept where they belong.
How a run ended is not an error but a value: see ``run.attrs["outcome"]``.
"""

from __future__ import annotations

import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any, Self

KeyPath = tuple[str | int, ...]
Problem = tuple[KeyPath, str]
LISTED = 20  # problems named in one message

# Ways on that messages name: in the words of the command line and of Python, and in those of the page in a browser.

SIMULATE = "autobalancer simulate tells"
SIMULATE_OR_BASIN = "simulate it instead, or ask basin with random starts"
ENSEMBLE = "autobalancer ensemble FILE --seeds 100"
BORDERS = "'autobalancer borders FILE' (ab.stability.borders)"
LEAST_DRAG = " (autobalancer borders FILE --minimum-drag-at SPEED)"
FRICTIONS = "; typical coefficients: autobalancer catalog friction"
KEEP_TURNS = "; in Python, save must hold LastRevolutions()"
MORE_MODES, LIQUID = "; see autobalancer modes", "; see autobalancer liquid-response"
ON_THE_PAGE = {
    SIMULATE: "a run tells", SIMULATE_OR_BASIN: "run it, or take the basin of the page Stability",
    ENSEMBLE: "a study of many starts", BORDERS: "the page Stability",
    **dict.fromkeys((LEAST_DRAG, FRICTIONS, KEEP_TURNS, MORE_MODES, LIQUID), ""),
}  # fmt: skip


def spell(path: KeyPath, message: str = "") -> str:
    """``("balls", 1, "mass"), "..."`` as ``balls[2].mass: ...``; entries are counted from 1 as people do."""
    text = ""
    for step in path:
        named = step if isinstance(step, int) or step.replace("-", "_").isidentifier() else f'"{step}"'
        text += f"[{named + 1}]" if isinstance(named, int) else f".{named}" if text else named
    return ": ".join(filter(None, (text, message)))


class AutobalancerError(Exception):
    """Base of all errors raised on purpose.

    Parameters
    ----------
    message
        What is wrong.
    path
        The key at fault, such as ``("balancers", 0, "balls", 1, "mass")``; what the error says begins with it.

    Attributes
    ----------
    problems
        Every key at fault: its path, empty where there is none, and what is wrong there.
    """

    problems: tuple[Problem, ...]

    def __init__(self, message: str = "", path: KeyPath = ()) -> None:
        super().__init__(spell(path, message))
        self.problems = ((path, message),)

    @property
    def path(self) -> KeyPath:
        """The first key at fault; empty where the error is about none."""
        return self.problems[0][0]

    @classmethod
    def of(cls, source: str, problems: Sequence[Problem], heading: str = "") -> Self:
        """One error for all problems of a part or a file.

        Parameters
        ----------
        source
            What they are problems of, such as the path of a file.
        problems
            The path and the message of each.
        heading
            Of a list with a line for each problem; without one they stand in one line.
        """
        lines = [spell(path, message) for path, message in problems]
        if heading and len(lines) > LISTED:
            lines = [*lines[:LISTED], f"and {len(lines) - LISTED} more"]
        text = f"{heading}:" + "".join(f"\n  {line}" for line in lines) if heading else "; ".join(lines)
        error = cls(": ".join(filter(None, (source, text))))
        error.problems = tuple(problems)
        return error

    def within(self, *path: str | int) -> Self:
        """The same error, of an entry at a path of something larger."""
        return self.of("", [((*path, *inner), message) for inner, message in self.problems])


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


def one_of(name: str, given: object, *allowed: object) -> None:
    """Refuse what is ``given`` for an argument, unless it is one of the words that are ``allowed``.

    Raises
    ------
    QuestionError
        With these words.
    """
    if given not in allowed:
        *most, last = map(repr, allowed)
        words = " or ".join(filter(None, (", ".join(most), last)))
        raise QuestionError(f"{name}: given {given!r}; must be {words}")


def all_of(*steps: Callable[[], Any]) -> list[Any]:
    """What steps give that do not need each other.

    Raises
    ------
    QuestionError
        With the problems of all steps that refuse.
    """
    results, problems = [], list[Problem]()
    for step in steps:
        try:
            results.append(step())
        except (QuestionError, UnitError) as error:
            problems += error.problems
    if problems:
        raise QuestionError.of("", problems, "not possible as asked" if len(problems) > 1 else "")
    return results


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
