"""Picture of a design: how many candidates each question left, and the two objectives of those that ran."""

from __future__ import annotations

import json
from collections import Counter
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from autobalancer.plots.drawing.quantity_axis import plain_log_ticks
from autobalancer.plots.drawing.style import ALL_BALLS, BALLS, CRITICAL, INK, heading, look, picture
from autobalancer.results.given import Given, result

STAGES = ("space", "fluid", "capability", "pressure", "same race", "border", "not run", "runs")
UNITS = {"m": ("mm", 1e3), "kg m": ("g mm", 1e6), "s": ("s", 1.0), "kg": ("g", 1e3)}
COLORS = {1: BALLS[0], 0: BALLS[1], -1: ALL_BALLS}
SAYS = {1: "keeps all limits", 0: "too few runs to say", -1: "misses a limit"}
MARK = 11.0  # points, of a mark with a number
NAMED = 3  # designs whose name stands below


def design(designs: Given, *, title: str | None = None) -> Figure:
    """What ruled candidates out, and the two objectives of those that ran, with their places and the Pareto front.

    A point is the value that the wanted share of the runs stays below, the bars reach from the median to it. The line joins the
    designs that no other one beats among those that keep the limits as well. Dashed lines are limits. Where nothing was ruled
    out, only the objectives are drawn. Of designs side by side the best one has its number, the others are dots.

    Parameters
    ----------
    designs
        From :func:`autobalancer.design`, or the path of its file.
    title
        By default that of the answer.

    Returns
    -------
    matplotlib.figure.Figure
    """
    found = result(designs, "plot.design", "design", lambda one: {"place", "stage", "front"} <= set(one.data_vars))
    ran = found.isel(design=np.argsort(found["place"].values)[: int(np.isfinite(found["place"].values).sum())])
    with look():
        if set(map(str, found["stage"].values)) == {"runs"}:  # nothing was ruled out
            figure = picture(7.4, 4.4)
            _front(figure.add_subplot(), found, ran)
        else:
            figure = picture(10.0, 4.4)
            left, right = figure.subplots(1, 2, width_ratios=(1.0, 2.4))
            _counts(left, found)
            _front(right, found, ran)
        _legend(figure, ran)
        heading(figure, title if title is not None else str(found.attrs.get("title", "")))
    return figure


def _counts(panel: Axes, found: xr.Dataset) -> None:
    """How many candidates each question ruled out, and how many ran."""
    counts = Counter(map(str, found["stage"].values))
    shown = [stage for stage in STAGES if counts[stage]]
    values = [counts[stage] for stage in shown]
    panel.barh(shown, values, color=[BALLS[0] if stage == "runs" else ALL_BALLS for stage in shown], height=0.6)
    for row, value in enumerate(values):
        panel.text(value, row, f" {value}", va="center", color=INK)
    panel.invert_yaxis()
    panel.set_xlim(0.0, 1.18 * max(values))
    panel.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    panel.set_xlabel("candidates ruled out, and that ran")
    panel.grid(visible=False)


def _front(panel: Axes, found: xr.Dataset, ran: xr.Dataset) -> None:
    limits = json.loads(found.attrs["limits"])
    names = [str(name) for name in found.attrs["objectives"]]
    for axis, name in zip("xy", names, strict=True):
        sign, factor = UNITS[found[name].attrs["units"]]
        below = f", {100.0 * found.attrs['share']:g} % of the runs below" if f"{name}_median" in found else ""
        getattr(panel, f"set_{axis}label")(f"{name.replace('_', ' ')}{below} ({sign})")
        if name in limits:
            draw = panel.axvline if axis == "x" else panel.axhline
            draw(factor * limits[name], color=CRITICAL, lw=0.9, ls="--")
    high = [_shown(ran, name) for name in names]
    known = np.isfinite(high[0]) & np.isfinite(high[1])
    meets, front = ran["meets"].values.astype(int), ran["front"].values
    best = known & (front == 0) & (meets == meets.max(initial=-1))
    shown = np.column_stack(high)
    best[best] = [
        not (shown[best] < one).all(axis=1).any() for one in shown[best]
    ]  # where all miss limits fronts are by misses
    order = np.argsort(high[0][best])
    panel.plot(high[0][best][order], high[1][best][order], "-", lw=0.9, color=INK, zorder=1.5)
    for i in np.flatnonzero(known):
        color = COLORS[int(meets[i])]
        x, y = float(high[0][i]), float(high[1][i])
        panel.plot([_middle(ran, names[0], i, x), x], [y, y], "-", lw=1.0, color=color, zorder=2.0)
        panel.plot([x, x], [_middle(ran, names[1], i, y), y], "-", lw=1.0, color=color, zorder=2.0)
    values = high[1][known]
    if values.size and values.min() > 0.0 and values.max() > 10.0 * values.min():
        panel.set_yscale("log")
        plain_log_ticks(panel, "y")
    _numbers(panel, ran, shown, known)
    labels = [f"{place + 1}: {ran['label'].values[place]}" for place in range(min(NAMED, ran.sizes["design"]))]
    panel.set_title("\n".join(labels), fontsize=8, loc="left")


def _numbers(panel: Axes, ran: xr.Dataset, places: Any, known: Any) -> None:
    """A mark for each design; in order of their places those get their number that no mark with a number would hide."""
    panel.autoscale_view()
    points = panel.transData.transform(places) * 72.0 / panel.figure.dpi
    numbered: list[int] = []
    for i in np.flatnonzero(known).tolist():  # by place
        if all(np.hypot(*(points[i] - points[j])) > 1.2 * MARK for j in numbered):
            numbered.append(i)
    for i in np.flatnonzero(known).tolist():
        size, above = (MARK, 4.0) if i in numbered else (0.4 * MARK, 3.0)
        panel.plot(*places[i], "o", ms=size, color=COLORS[int(ran["meets"].values[i])], zorder=above)
    for i in numbered:
        number = f"{ran['place'].values[i]:.0f}"
        panel.annotate(number, places[i], color="white", fontsize=8, zorder=5.0, ha="center", va="center_baseline")


def _middle(ran: xr.Dataset, name: str, row: Any, else_: float) -> float:
    """The median of a design, where the objective is a number of its runs."""
    return float(_shown(ran, f"{name}_median")[row]) if f"{name}_median" in ran else else_


def _shown(ran: xr.Dataset, name: str) -> Any:
    return ran[name].values * UNITS[ran[name].attrs["units"]][1]


def _legend(figure: Figure, ran: xr.Dataset) -> None:
    there = [level for level in SAYS if level in ran["meets"].values]
    marks = [Line2D([], [], ls="", marker="o", color=COLORS[level], ms=8, label=SAYS[level]) for level in there]
    if int(((ran["front"].values == 0) & (ran["meets"].values == ran["meets"].values.max(initial=-1.0))).sum()) > 1:
        marks.append(Line2D([], [], color=INK, lw=0.9, label="none is better in both"))
    marks += [
        Line2D([], [], color=CRITICAL, lw=0.9, ls="--", label="limit"),
        Line2D([], [], color=INK, lw=1.0, marker="|", ms=0, label="bars: from the median"),
    ]
    figure.legend(handles=marks, ncols=len(marks), loc="outside lower left", frameon=False)
