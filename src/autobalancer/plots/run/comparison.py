"""Runs of several machines side by side."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.quantity_axis import plain_log_ticks
from autobalancer.plots.drawing.style import CRITICAL, INK, heading, legend, look, picture
from autobalancer.results.display_units import length_tick
from autobalancer.results.given import Given, result

COLUMNS = 2
SHOWN = 1e-5  # of the greatest deflection; what is below it is balanced for every eye


def comparison(found: Given) -> Figure:
    """Draw the deflection of each machine over time, with that of the first one behind it.

    Parameters
    ----------
    found
        From :func:`autobalancer.compare`.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each machine, in the order of the table, on one logarithmic axis of deflection.

    Raises
    ------
    QuestionError
        If there is nothing to draw.
    """
    found = result(found, "plot.comparison", "compare", lambda it: {"deflection", "time_in_run"} <= set(it))
    names, time, high = found["machine"].values, found["time_in_run"].values, found["deflection"].values
    greatest = float(np.nanmax(high, initial=0.0))
    if greatest == 0.0:
        raise QuestionError("plot.comparison: no machine was deflected, so there is nothing to draw")
    rows = math.ceil(len(names) / COLUMNS)
    with look():
        figure = picture(8.0, 0.6 + 1.5 * rows)
        panels = figure.subplots(rows, COLUMNS, sharex=True, sharey=True, squeeze=False).ravel()
        for number, (axes, name) in enumerate(zip(panels, names, strict=False)):
            axes.set_yscale("log")
            if number:
                axes.plot(
                    time[0], high[0], color=CRITICAL, lw=0.8, alpha=0.7, label=str(names[0]) if number == 1 else "_"
                )
            axes.plot(time[number], high[number], color=INK, lw=1.2)
            axes.set_title(str(name), fontsize=9.0)
        panels[0].set_ylim(SHOWN * greatest, 2.0 * greatest)
        plain_log_ticks(panels[0], "y", length_tick)
        for axes in panels[len(names) :]:
            axes.set_visible(False)
        for axes in panels[max(len(names) - COLUMNS, 0) : len(names)]:
            axes.set_xlabel("time (s)")
            axes.tick_params(labelbottom=True)
        for axes in panels[::COLUMNS]:
            axes.set_ylabel("deflection")
        if len(names) > 1:
            legend(panels[1])
        heading(figure, str(found.attrs["title"]))
    return figure
