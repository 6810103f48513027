"""Panels over the rotor speed: amplitudes of each unit by themselves, and which way time runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

BACK = 0.05  # share of the whole way of the speed; what goes the other way less than this is noise


def panels_of_units(figure: Figure, units: Sequence[str], place: Any = None) -> list[Axes]:
    """A panel for the amplitudes of each unit, in the order in which they come first, and one below all for the phases.

    Parameters
    ----------
    figure
        In which they are drawn.
    units
        Of each channel.
    place
        Cell of a grid; by default the whole figure.
    """
    count = len(set(units))
    inner: Any = figure.add_gridspec if place is None else place.subgridspec
    panels = inner(count + 1, 1, height_ratios=[3] * count + [2]).subplots(sharex=True)
    return list(panels)


def speed_trend(speed: NDArray[np.float64]) -> int:
    """1 of a run-up, -1 of a run-down, 0 of a speed that goes both ways."""
    steps = np.diff(speed[np.isfinite(speed)])
    up, down = float(steps[steps > 0.0].sum()), float(-steps[steps < 0.0].sum())
    if min(up, down) > BACK * (up + down):
        return 0
    return 1 if up >= down else -1


def time_runs(speed: NDArray[np.float64]) -> str:
    """What the label of an axis of the speed says of time: nothing of a run-up."""
    return {1: "", -1: ", time runs to the left", 0: ", up and down"}[speed_trend(speed)]
