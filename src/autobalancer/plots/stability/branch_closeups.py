"""Branches too narrow to be read in a picture of a wide range: letters on it, and panels of their own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator

from autobalancer.plots.drawing.style import CRITICAL
from autobalancer.results.display_units import AxisUnit

NARROW = 0.02  # of the range of the picture: narrower branches are vertical strokes
TOGETHER = 0.03  # of it: letters nearer to each other stand in one place
MOST = 3  # panels in a row


class CloseUp(NamedTuple):
    """Where one branch lies, SI."""

    branch: int  # from 1
    letter: str
    low: float
    high: float
    bottom: float
    top: float


def close_ups(data: xr.Dataset) -> list[CloseUp]:
    """Of the branches that are too narrow, up to three: the widest, by their parameter."""
    parameter, branch = data["parameter"].values, data["branch"].values
    span, found = float(np.ptp(parameter)), []
    for number in np.unique(branch):
        here = branch == number
        low, high = float(parameter[here].min()), float(parameter[here].max())
        if 0.0 < high - low < NARROW * span:
            bottom, top = (
                float(data["deflection_min"].values[here].min()),
                float(data["deflection_max"].values[here].max()),
            )
            found.append(CloseUp(int(number), "", low, high, bottom, top))
    widest = sorted(found, key=lambda one: one.low - one.high)[:MOST]
    return [
        one._replace(letter=letter) for letter, one in zip("abc", sorted(widest, key=lambda w: w.low), strict=False)
    ]


def mark(axes: Axes, narrow: list[CloseUp], across: AxisUnit, span: float) -> None:
    """Letters above the places of the close-ups; those of neighbors stand together."""
    groups: list[list[CloseUp]] = []
    for one in narrow:
        if groups and one.low - groups[-1][-1].high < TOGETHER * span:
            groups[-1].append(one)
        else:
            groups.append([one])
    for group in groups:
        place = across.shown(0.5 * (group[0].low + group[-1].high))
        axes.axvline(place, color=CRITICAL, lw=0.6, ls=":", zorder=1.5)
        axes.annotate(
            ", ".join(one.letter for one in group), (place, 1.0), xycoords=("data", "axes fraction"), xytext=(3.0, -2.0),
            textcoords="offset points", va="top", fontweight="bold",
        )  # fmt: skip


def empty_panels(figure: Figure, row: SubplotSpec, narrow: list[CloseUp], across: AxisUnit) -> list[Axes]:
    """An empty panel for each with its range along the parameter, and its letter."""
    grid, found = row.subgridspec(1, len(narrow)), []
    for column, one in enumerate(narrow):
        axes = figure.add_subplot(grid[column])
        room = 0.12 * (one.high - one.low)
        axes.set_xlim(across.shown(one.low - room), across.shown(one.high + room))
        axes.xaxis.set_major_locator(MaxNLocator(3))
        axes.ticklabel_format(axis="x", useOffset=False)
        axes.set_title(f"{one.letter}: branch {one.branch}, enlarged", fontsize=9.0)
        found.append(axes)
    return found


def fit(axes: Axes, one: CloseUp, unit: AxisUnit) -> None:
    """The range of its deflection; after everything is drawn."""
    room = 0.08 * (one.top - one.bottom) or 0.05 * one.top or 1e-9
    axes.set_ylim((one.bottom - room) * unit.factor, (one.top + room) * unit.factor)
