"""Whether an ensemble fits into memory."""

from __future__ import annotations

import os

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.results.measure_table import SWEPT
from autobalancer.studies.ensemble.columns import ball_count

TEXTS = 400.0  # bytes of a member: outcome, verdict, seed and what its row is made of
SHARE = 0.5  # of the free memory that an ensemble may take


def refuse_what_does_not_fit(machine: Machine, count: int, states: bool) -> None:
    """Refuse more members than the memory holds, before anything runs.

    Raises
    ------
    QuestionError
        With the number that fits.
    """
    free, each = free_memory(), bytes_of_a_member(machine, states)
    if count * each > SHARE * free:
        fits = int(SHARE * free / each)
        raise QuestionError(
            f"ensemble: {count} members need {count * each / 1e9:.3g} GB, and {free / 1e9:.3g} GB of memory are free; "
            f"at most {fits} members fit{', more without keep_states' if states else ''}; split the ensemble"
        )


def bytes_of_a_member(machine: Machine, states: bool) -> float:
    """What a member takes while an ensemble runs and in its result."""
    balls = ball_count(machine)
    kept = len(SWEPT) + 4 * balls + 8
    return TEXTS + 16.0 * (kept + (16 + 4 * balls if states else 0))


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
