"""Whether what is asked fits into the memory of this computer, before anything is computed."""

from __future__ import annotations

import os

from autobalancer.errors import QuestionError

SHARE = 0.5  # of the free memory that one question may take


def refuse_what_does_not_fit(question: str, count: float, what: str, each: float, cure: str) -> None:
    """Refuse more of something than the memory holds.

    Parameters
    ----------
    question
        What the message begins with.
    count
        How many were asked for.
    what
        Their name, in the plural.
    each
        Bytes that one takes.
    cure
        What to do about it.

    Raises
    ------
    QuestionError
        With the number that fits.
    """
    free = free_memory()
    if count * each > SHARE * free:
        raise QuestionError(
            f"{question}: {count:.10g} {what} need {count * each / 1e9:.3g} GB, and {free / 1e9:.3g} GB of memory are free; "
            f"at most {int(SHARE * free / each)} {what} fit{cure}"
        )


def free_memory() -> float:
    """Memory that is free, in bytes; infinite where the system does not say."""
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            return next(1024.0 * float(line.split()[1]) for line in lines if line.startswith("MemAvailable"))
    except (OSError, StopIteration, ValueError):
        pass
    try:
        return float(os.sysconf("SC_AVPHYS_PAGES")) * float(os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return float("inf")
