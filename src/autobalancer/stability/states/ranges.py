"""Ranges of speed with one verdict, their ends found by bisection."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.stability.states.answers import Ranges, ranges_from, verdict_rows
from autobalancer.stability.states.questions import eigenvalues
from autobalancer.units import unbalance_argument

CLOSE = 1e-7  # of a speed: how closely a change of the verdict is located


def ranges(machine: Machine | str | Path, found: xr.Dataset, unbalance: complex | float | str | None = None) -> Ranges:
    """Ranges of speed in which a state keeps its verdict.

    Parameters
    ----------
    machine
        The machine of ``found``.
    found
        From :func:`~autobalancer.stability.states.questions.eigenvalues`. Where the verdict changes between two of its speeds,
        the speed of the change is sought by bisection; a range that lies between two speeds of ``found`` is not seen.
    unbalance
        As it was given there.

    Returns
    -------
    xarray.Dataset
        Along ``range``: ``from_speed``, ``to_speed`` (rad/s), ``verdict``, the greatest ``growth_rate`` at the speeds of
        ``found`` (1/s), and the ``leading_motion`` there.
    """
    machine, unbalance = balls_in_races(machine), unbalance_argument(unbalance)
    rows = verdict_rows(found)
    for left, right in pairwise(rows):
        change = None if right[5] else _change(machine, found.attrs["state"], unbalance, left, right)
        if change is not None:
            left[1] = right[0] = change
    return ranges_from(rows)


def _change(
    machine: Machine, state: Any, unbalance: complex | float | None, left: list[Any], right: list[Any]
) -> float | None:
    """The speed at which the verdict of the left range ends; ``None`` where there is no state in between."""
    low, high = float(left[1]), float(right[0])
    while high - low > CLOSE * high:
        middle = 0.5 * (low + high)
        try:
            at = eigenvalues(machine, [middle], state=state, unbalance=unbalance)
        except QuestionError:
            return None
        low, high = (middle, high) if at["verdict"].values[0] == left[2] else (low, middle)
    return 0.5 * (low + high)
