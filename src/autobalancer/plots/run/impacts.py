"""The noise of balls: their impacts over a run."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import BALLS, INK, heading, legend, look, picture
from autobalancer.plots.run.ball_looks import ball_looks
from autobalancer.plots.run.history import critical_speeds_of, history_of, span_of
from autobalancer.plots.run.panels import speed_panel
from autobalancer.results.display_units import speed_axis
from autobalancer.results.given import Given, given_race_run
from autobalancer.results.impacts import Impacts, impacts_of
from autobalancer.units import optional_argument

PARTS = 80  # of the time, in each of which the power is a mean
KINDS = ((1, np.inf, "of two balls", BALLS[0]), (0, 0, "on a partition", BALLS[2]), (-1, -1, "on a wall", BALLS[1]))
POWERS = ((1e-6, "µW", 1e6), (1e-3, "mW", 1e3), (np.inf, "W", 1.0))  # up to a thousand of each


def impacts(
    run: Given, *, speed_unit: str = "rpm", start: float | str | None = None, end: float | str | None = None
) -> Figure:
    """Draw the impacts of a run over time: how fast balls hit each other and walls, and the power they dissipate.

    The upper panel has the speeds of rotor and balls, as that of a run-up; the lowest one the mean power in eighty parts of
    the time.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, of balls that touch.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    start, end
        Part of the run to be drawn, s; by default all of it.

    Raises
    ------
    QuestionError
        If nothing touched in the run, a unit is unknown, or the interval is outside the run.
    """
    run = given_race_run(run, "plot.impacts")
    first, last = span_of(run, optional_argument("start", start, "s"), optional_argument("end", end, "s"))
    found, speeds, history = impacts_of(run), speed_axis(speed_unit), history_of(run, first, last)
    if found is None or not found.time.size:
        raise QuestionError("plot.impacts: no ball hit another one, a partition or a wall in this run")
    with look():
        figure = picture(8.0, 6.6 if history is not None else 4.6)
        panels = list(figure.subplots(2 + (history is not None), 1, sharex=True))
        if history is not None:
            speed_panel(panels[0], history, critical_speeds_of(run), speeds, ball_looks(run))
        _speeds(panels[-2], found)
        _power(panels[-1], found, np.linspace(first, last, PARTS + 1))
        panels[-1].set_xlabel("time (s)")
        panels[-1].set_xlim(first, last)
        figure.align_ylabels(panels)
        heading(figure, str(run.attrs.get("title", "Run")))
    return figure


def _speeds(axes: Axes, found: Impacts) -> None:
    for low, high, label, color in KINDS:
        its = (found.partner >= low) & (found.partner <= high)
        if its.any():
            axes.plot(found.time[its], found.speed[its], ".", ms=4.0, color=color, alpha=0.7, label=label)
    axes.set_yscale("log")
    axes.set_ylabel("impact speed (m/s)")
    legend(axes)


def _power(axes: Axes, found: Impacts, edges: np.ndarray[tuple[int], np.dtype[np.float64]]) -> None:
    power = np.histogram(found.time, edges, weights=found.lost)[0] / np.diff(edges)
    _, sign, factor = next(entry for entry in POWERS if power.max(initial=0.0) < 1e3 * entry[0])
    axes.stairs(factor * power, edges, color=INK, fill=True, alpha=0.75)
    axes.set_ylabel(f"power of impacts ({sign})")
    axes.set_ylim(bottom=0.0)
