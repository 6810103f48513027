"""Whether what is asked fits into the memory of this computer, before anything is computed."""

from __future__ import annotations

import os

from autobalancer.errors import QuestionError

SHARE = 0.5  # of the free memory that one question may take


def refuse_beyond_memory(question: str, count: float, what: str, each: float, cure: str) -> None:
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
    """Memory that is free, in bytes, and within the limit of this process where it has one; infinite where nobody says."""
    return min(_free_of_the_computer(), _free_of_the_process())


def _free_of_the_process() -> float:
    try:
        import resource

        limit, _ = resource.getrlimit(resource.RLIMIT_DATA)
        if limit == resource.RLIM_INFINITY:
            return float("inf")
        with open("/proc/self/status", encoding="ascii", errors="replace") as lines:
            used = next(1024.0 * float(line.split()[1]) for line in lines if line.startswith("VmData"))
        return max(0.0, limit - used)
    except (ImportError, OSError, StopIteration, ValueError):
        return float("inf")


def _free_of_the_computer() -> float:
    try:
        with open("/proc/meminfo", encoding="ascii") as lines:
            return next(1024.0 * float(line.split()[1]) for line in lines if line.startswith("MemAvailable"))
    except (OSError, StopIteration, ValueError):
        pass
    try:
        return float(os.sysconf("SC_AVPHYS_PAGES")) * float(os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, OSError, ValueError):
        return float("inf")
