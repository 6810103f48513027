"""Which scatter drives a result, as bars with their intervals."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import ALL_BALLS, BALLS, INK, heading, legend, look, picture
from autobalancer.results.given import Given, result

BARS = {
    "first": ("alone", BALLS[0]),
    "total": ("with all in which it takes part", BALLS[1]),
    "rank_correlation": ("rank correlation", ALL_BALLS),
}


def sensitivity(found: Given, *, point: int = 1) -> Figure:
    """How much each input adds to the scatter of a quantity, the strongest on top, with 95 % intervals.

    Parameters
    ----------
    found
        From :func:`autobalancer.sensitivity`.
    point
        Of a study with a grid, the number of its point.

    Raises
    ------
    QuestionError
        If ``found`` is none, or has no such point.
    """
    given = result(found, "plot.sensitivity", "sensitivity", lambda it: "input" in it.dims and "quantity" in it.attrs)
    if "point" in given.dims:
        if point not in given["point"].values:
            raise QuestionError(f"plot.sensitivity: point: given {point}; there are 1 to {given.sizes['point']}")
        given = given.sel(point=point)
    at = f"; {given['at'].item()}" if "at" in given.coords else ""
    names = [name for name in BARS if name in given]
    order = np.argsort(np.abs(given[names[-1]].values), kind="stable")
    given = given.isel(input=order)
    with look():
        figure = picture(6.6, 1.5 + (0.3 + 0.22 * len(names)) * order.size)
        axes = figure.add_subplot()
        heading(
            figure,
            f"{given.attrs['study_name']}: what drives the scatter of {given.attrs['quantity'].replace('_', ' ')}{at}",
        )
        for number, name in enumerate(names):
            _bars(axes, given, name, number, len(names))
        axes.set_yticks(range(order.size), [str(name).replace("_", " ") for name in given["input"].values])
        axes.axvline(0.0, color=INK, linewidth=0.8)
        axes.grid(axis="y", visible=False)
        axes.set_xlabel("rank correlation (Spearman)" if names[0] == "rank_correlation" else "share of the variance")
        if len(names) > 1:
            legend(axes)
    return figure


def _bars(axes: Axes, given: Any, name: str, number: int, count: int) -> None:
    text, color = BARS[name]
    place = np.arange(given.sizes["input"]) + 0.34 * (0.5 * (count - 1) - number)
    value, low, high = (given[f"{name}{end}"].values for end in ("", "_low", "_high"))
    axes.barh(place, value, height=0.3 if count > 1 else 0.5, color=color, label=text)
    axes.hlines(place, low, high, color=INK, linewidth=1.2)
