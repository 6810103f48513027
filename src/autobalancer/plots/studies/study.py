"""A study over its grid: a share with its interval, a quantity with its scatter, or both over two parameters as a map."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.quantity_axis import plain_log_ticks, quantity_axis
from autobalancer.plots.drawing.style import BALLS, INK, heading, legend, look, picture
from autobalancer.plots.stability.ensemble import ensemble
from autobalancer.results.answers.studied import Studied
from autobalancer.results.display_units import AxisUnit, axis_unit, length_axis
from autobalancer.results.given import Given, result
from autobalancer.results.shares import wilson_interval

WRITTEN = 100  # cells of a map into which their value is written
INTERVALS = 36  # cells into which the interval of a share is written too
SHARES = ("balanced", "stalled", "balanced_before")
MOST_TICKS = 12


def study(found: Given, quantity: str = "balanced", *, speed_unit: str = "rpm") -> Figure:
    """A quantity of a study over the parameters of its grid.

    One parameter: the share of members for which it is true, with its 95 % interval, or the median of a number with bands of
    50 % and 90 % of the members. Two parameters: share, with its interval, or median as a map. No grid: the shares of all ends.

    Parameters
    ----------
    found
        From :func:`autobalancer.study`.
    quantity
        ``"balanced"``, ``"stalled"`` or a number of each member, such as ``"peak_deflection"``.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If ``found`` is no study, has no such quantity, or more than two parameters in its grid.
    """
    given = result(found, "plot.study", "study", lambda it: "draw" in it.coords and "member" in it.dims)
    given = given if isinstance(given, Studied) else Studied.of(given)
    known = [
        str(name) for name in given.data_vars if given[name].dims == ("member",) and given[name].dtype.kind in "fib"
    ]
    if quantity == "balanced" and quantity not in known:
        quantity = known[0]
    if quantity not in known:
        raise QuestionError(f"plot.study: quantity: given {quantity!r}; there are {', '.join(known)}")
    grid = given.grid_names()
    if not grid and quantity == "balanced":
        return ensemble(given, speed_unit=speed_unit)
    if not np.isfinite(given[quantity].values.astype(float)).any():
        raise QuestionError(f"plot.study: quantity: no member has {quantity!r}")
    if len(grid) > 2:
        raise QuestionError(
            f"plot.study: the grid has {len(grid)} parameters, and two can be drawn; select values of the "
            "others, in Python with .where"
        )
    with look():
        figure = picture(6.6, 3.8 if len(grid) < 2 else 4.4)
        axes = figure.add_subplot()
        heading(figure, given.heading())
        if len(grid) == 2:
            _map(figure, axes, given, grid, quantity, speed_unit)
        elif len(grid) == 1:
            _over(axes, given, grid[0], quantity, speed_unit)
        else:
            _histogram(axes, given, quantity, speed_unit)
    return figure


def _over(axes: Axes, given: Studied, name: str, quantity: str, speed_unit: str) -> None:
    points, ran = given.at_points(), given.counted()
    first = [int(np.flatnonzero(where)[0]) for where in points]
    shown = quantity_axis(given[name].isel(member=first), speed_unit)
    values = np.asarray(shown.values)
    if _is_share(given, quantity):
        counts = np.array([(given[quantity].values & where & ran).sum() for where in points])
        totals = np.array([max(int((where & ran).sum()), 1) for where in points])
        low, high = wilson_interval(counts, totals)
        share = counts / totals
        bars = 100.0 * np.array([np.maximum(share - low, 0.0), np.maximum(high - share, 0.0)])
        axes.errorbar(
            values, 100.0 * share, bars, fmt="o-", color=BALLS[0], markersize=4.0, capsize=2.5, elinewidth=1.0
        )
        axes.set_ylabel(f"{quantity} runs, with 95 % interval (%)")
        axes.set_ylim(-3.0, 103.0)
    else:
        unit = _unit(given, quantity, speed_unit)
        levels = np.array([_levels(given[quantity].values[where & ran]) for where in points]).T
        low, quarter, middle, upper, high = unit.shown(levels)
        axes.fill_between(values, low, high, color=BALLS[0], alpha=0.15, linewidth=0.0, label="90 % of the members")
        axes.fill_between(values, quarter, upper, color=BALLS[0], alpha=0.3, linewidth=0.0, label="50 %")
        axes.plot(values, middle, "o-", color=BALLS[0], markersize=3.5, label="median")
        axes.set_ylabel(_label(quantity, unit))
        axes.set_ylim(bottom=min(0.0, float(np.nanmin(low))))
        legend(axes)
    if values.min() > 0.0 and values.max() >= 10.0 * values.min():
        axes.set_xscale("log")
        plain_log_ticks(axes, "x")
    axes.set_xlabel(shown.label)


def _map(figure: Figure, axes: Axes, given: Studied, grid: list[str], quantity: str, speed_unit: str) -> None:
    points, ran = given.at_points(), given.counted()
    first = [int(np.flatnonzero(where)[0]) for where in points]
    shown = [quantity_axis(given[name].isel(member=first), speed_unit) for name in grid]
    across, up = (np.unique(one.values) for one in shown)
    field, texts = np.full((up.size, across.size), np.nan), dict[int, str]()
    written = np.full(field.shape, "", dtype=object)
    share = _is_share(given, quantity)
    unit = AxisUnit("%", 100.0) if share else _unit(given, quantity, speed_unit)
    for number, where in enumerate(points):
        values = given[quantity].values[where & ran].astype(float)
        known = values[np.isfinite(values)]
        value = np.nan if not known.size else known.mean() if share else np.median(known)
        texts[number] = f"{unit.shown(value):.3g}"
        if share and known.size and len(points) <= INTERVALS:
            ends = wilson_interval(np.array([known.sum()]), known.size)
            texts[number] += "\n" + " to ".join(f"{100.0 * float(end[0]):.3g}" for end in ends)
        place = [
            int(np.searchsorted(one, axis.values[number])) for one, axis in zip((up, across), shown[::-1], strict=True)
        ]
        field[place[0], place[1]] = unit.shown(value)
        written[place[0], place[1]] = texts[number]
    low, high = (0.0, 100.0) if share else (float(np.nanmin(field)), float(np.nanmax(field)))
    image = axes.imshow(field, origin="lower", aspect="auto", cmap="cividis", vmin=low, vmax=high)
    for row, column in np.argwhere(np.isfinite(field)) if field.size <= WRITTEN else ():
        value = field[row, column]
        color = INK if value > 0.5 * (low + high) else "white"
        axes.text(column, row, written[row, column], ha="center", va="center", color=color, fontsize=8.0)
    axes.set_xticks(*_ticks(across))
    axes.set_yticks(*_ticks(up))
    axes.set_xlabel(shown[0].label)
    axes.set_ylabel(shown[1].label)
    axes.grid(visible=False)
    bar = figure.colorbar(image, ax=axes)
    bar.set_label(f"{quantity} runs, with 95 % interval (%)" if share else f"median of {_label(quantity, unit)}")


def _ticks(values: Any) -> tuple[range, list[str]]:
    step = -(-values.size // MOST_TICKS)
    return range(0, values.size, step), [f"{value:.4g}" for value in values[::step]]


def _histogram(axes: Axes, given: Studied, quantity: str, speed_unit: str) -> None:
    unit = _unit(given, quantity, speed_unit)
    values = given[quantity].values[given.counted()].astype(float)
    known = unit.shown(values[np.isfinite(values)])
    axes.hist(
        known, bins="auto" if known.size < 2000 else 60, color=BALLS[0], alpha=0.75, edgecolor="white", linewidth=0.4
    )
    for level, style in ((0.05, ":"), (0.5, "-"), (0.95, ":")):
        axes.axvline(float(np.quantile(known, level)), color=INK, linestyle=style, linewidth=1.1)
    axes.set_xlabel(f"{_label(quantity, unit)}; lines: 5 %, median, 95 %")
    axes.set_ylabel("members")


def _levels(values: Any) -> Any:
    known = values[np.isfinite(values)]
    return np.quantile(known, (0.05, 0.25, 0.5, 0.75, 0.95)) if known.size else np.full(5, np.nan)


def _is_share(given: Studied, quantity: str) -> bool:
    """Whether a quantity is true or false of each member; a file keeps it as a whole number."""
    return given[quantity].dtype.kind in "bi" and quantity in SHARES


def _unit(given: Studied, quantity: str, speed_unit: str) -> AxisUnit:
    if given[quantity].attrs.get("units") == "m":
        values = given[quantity].values
        return length_axis(None, float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) or 1.0)
    return axis_unit(given[quantity], speed_unit)


def _label(quantity: str, unit: AxisUnit) -> str:
    return f"{quantity.replace('_', ' ')}{f' ({unit.sign})' if unit.sign else ''}"
