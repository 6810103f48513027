"""Pictures of studies and of what is decided by them."""

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

from autobalancer.errors import QuestionError, one_of
from autobalancer.plots.answer import asked
from autobalancer.plots.ensembles import ensemble
from autobalancer.plots.style import (
    ALL_BALLS,
    BALLS,
    CRITICAL,
    INK,
    UNBALANCE,
    ball_color,
    ball_label,
    heading,
    legend,
    look,
    picture,
    plain_log_ticks,
    quantity_axis,
)
from autobalancer.random_numbers import generator, wilson_interval
from autobalancer.results.answers.studied import Studied
from autobalancer.results.display_units import AxisUnit, axis_unit, length_axis, speed_axis
from autobalancer.results.run_argument import RunArgument

# A study over its grid: a share with its interval, a quantity with its scatter, or both over two parameters as a map.


WRITTEN = 100  # cells of a map into which their value is written
INTERVALS = 36  # cells into which the interval of a share is written too
SHARES = ("balanced", "stalled", "balanced_before")
MOST_TICKS = 12


def study(found: xr.Dataset, quantity: str = "balanced", *, speed_unit: str = "rpm") -> Figure:
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
        If there is no such quantity, or more than two parameters in the grid.
    """
    given = found
    given = given if isinstance(given, Studied) else Studied.of(given)
    known = given.numbers()
    quantity = known[0] if quantity == "balanced" and quantity not in known else quantity
    one_of("plot.answer: quantity", quantity, *known)
    grid = given.grid_names()
    if not grid and quantity == "balanced":
        return ensemble(given, speed_unit=speed_unit)
    if not np.isfinite(given[quantity].values.astype(float)).any():
        raise QuestionError(f"plot.answer: quantity: no member has {quantity!r}")
    if len(grid) > 2:
        raise QuestionError(
            f"plot.answer: the grid has {len(grid)} parameters, and two can be drawn; select values of the "
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


def _over(axes: Axes, studied: Studied, name: str, quantity: str, speed_unit: str) -> None:
    points, ran = studied.at_points(), studied.counted()
    first = [int(np.flatnonzero(where)[0]) for where in points]
    shown = quantity_axis(studied[name].isel(member=first), speed_unit)
    values = np.asarray(shown.values)
    if _is_share(studied, quantity):
        counts = np.array([(studied[quantity].values & where & ran).sum() for where in points])
        totals = np.array([max(int((where & ran).sum()), 1) for where in points])
        low, high = wilson_interval(counts, totals)
        share = counts / totals
        bars = 100.0 * np.array([np.maximum(share - low, 0.0), np.maximum(high - share, 0.0)])
        axes.errorbar(
            values, 100.0 * share, bars, fmt="o-", color=BALLS[0], markersize=4.0, capsize=2.5, elinewidth=1.0
        )
        axes.set(ylabel=f"{quantity} runs, with 95 % interval (%)", ylim=(-3.0, 103.0))
    else:
        unit = _unit(studied, quantity, speed_unit)
        levels = np.array([_levels(studied[quantity].values[where & ran]) for where in points]).T
        low, quarter, middle, upper, high = unit.shown(levels)
        axes.fill_between(values, low, high, color=BALLS[0], alpha=0.15, linewidth=0.0, label="90 % of the members")
        axes.fill_between(values, quarter, upper, color=BALLS[0], alpha=0.3, linewidth=0.0, label="50 %")
        axes.plot(values, middle, "o-", color=BALLS[0], markersize=3.5, label="median")
        axes.set(ylabel=_label(quantity, unit), ylim=(min(0.0, float(np.nanmin(low))), None))
        legend(axes)
    if values.min() > 0.0 and values.max() >= 10.0 * values.min():
        axes.set_xscale("log")
        plain_log_ticks(axes, "x")
    axes.set_xlabel(shown.label)


def _map(figure: Figure, axes: Axes, studied: Studied, grid: list[str], quantity: str, speed_unit: str) -> None:
    points, ran = studied.at_points(), studied.counted()
    first = [int(np.flatnonzero(where)[0]) for where in points]
    shown = [quantity_axis(studied[name].isel(member=first), speed_unit) for name in grid]
    across, up = (np.unique(one.values) for one in shown)
    field, texts = np.full((up.size, across.size), np.nan), dict[int, str]()
    written = np.full(field.shape, "", dtype=object)
    share = _is_share(studied, quantity)
    unit = AxisUnit("%", 100.0) if share else _unit(studied, quantity, speed_unit)
    for number, where in enumerate(points):
        values = studied[quantity].values[where & ran].astype(float)
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
    axes.set(xlabel=shown[0].label, ylabel=shown[1].label)
    axes.grid(visible=False)
    bar = figure.colorbar(image, ax=axes)
    bar.set_label(f"{quantity} runs, with 95 % interval (%)" if share else f"median of {_label(quantity, unit)}")


def _ticks(values: Any) -> tuple[range, list[str]]:
    step = -(-values.size // MOST_TICKS)
    return range(0, values.size, step), [f"{value:.4g}" for value in values[::step]]


def _histogram(axes: Axes, studied: Studied, quantity: str, speed_unit: str) -> None:
    unit = _unit(studied, quantity, speed_unit)
    values = studied[quantity].values[studied.counted()].astype(float)
    known = unit.shown(values[np.isfinite(values)])
    axes.hist(
        known, bins="auto" if known.size < 2000 else 60, color=BALLS[0], alpha=0.75, edgecolor="white", linewidth=0.4
    )
    for level, style in ((0.05, ":"), (0.5, "-"), (0.95, ":")):
        axes.axvline(float(np.quantile(known, level)), color=INK, linestyle=style, linewidth=1.1)
    axes.set(xlabel=f"{_label(quantity, unit)}; lines: 5 %, median, 95 %", ylabel="members")


def _levels(values: Any) -> Any:
    known = values[np.isfinite(values)]
    return np.quantile(known, (0.05, 0.25, 0.5, 0.75, 0.95)) if known.size else np.full(5, np.nan)


def _is_share(studied: Studied, quantity: str) -> bool:
    """Whether a quantity is true or false of each member; a file keeps it as a whole number."""
    return studied[quantity].dtype.kind in "bi" and quantity in SHARES


def _unit(studied: Studied, quantity: str, speed_unit: str) -> AxisUnit:
    if studied[quantity].attrs.get("units") == "m":
        values = studied[quantity].values
        return length_axis(None, float(np.abs(values[np.isfinite(values)]).max(initial=0.0)) or 1.0)
    return axis_unit(studied[quantity], speed_unit)


def _label(quantity: str, unit: AxisUnit) -> str:
    return f"{quantity.replace('_', ' ')}{f' ({unit.sign})' if unit.sign else ''}"


# Picture of a design: how many candidates each question left, and the two objectives of those that ran.


STAGES = ("space", "fluid", "capability", "pressure", "same race", "border", "pick-up", "limits", "not run", "runs")
UNITS = {"m": ("mm", 1e3), "kg m": ("g mm", 1e6), "s": ("s", 1.0), "kg": ("g", 1e3)}
COLORS = {1: BALLS[0], 0: BALLS[1], -1: ALL_BALLS}
SAYS = {1: "keeps all limits in its runs", 0: "too few runs to say", -1: "misses a limit"}
MARK = 11.0  # points, of a mark with a number
NAMED = 3  # designs whose name stands below


def design(designs: RunArgument, *, title: str | None = None) -> Figure:
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
    found = asked(designs, "design")
    ran = found.isel(design=np.argsort(found["place"].values)[: int(np.isfinite(found["place"].values).sum())])
    with look():
        if set(map(str, found["stage"].values)) == {"runs"}:  # nothing was ruled out
            figure = picture(7.4, 4.4)
            panel = figure.add_subplot()
        else:
            figure = picture(10.0, 4.4)
            left, panel = figure.subplots(1, 2, width_ratios=(1.0, 2.4))
            _counts(left, found)
        shown, known = _front(panel, found, ran)
        _legend(figure, ran)
        heading(figure, title if title is not None else str(found.attrs.get("title", "")))
        engine = figure.get_layout_engine()
        assert engine is not None
        engine.execute(figure)  # where marks hide each other depends on the room that all else leaves
        _numbers(panel, ran, shown, known)
    return figure


def _counts(panel: Axes, dataset: xr.Dataset) -> None:
    """How many candidates each question ruled out, and how many ran."""
    counts = Counter(map(str, dataset["stage"].values))
    shown = [stage for stage in STAGES if counts[stage]]
    values = [counts[stage] for stage in shown]
    panel.barh(shown, values, color=ALL_BALLS, height=0.6)
    judged = dataset["meets"].values[dataset["stage"].values == "runs"]
    begin = 0
    for level in [level for level in COLORS if level in judged]:  # those that keep their limits first
        color, count = COLORS[level], int((judged == level).sum())
        panel.barh("runs", count, left=begin, color=color, height=0.6)
        begin += count
    for row, value in enumerate(values):
        panel.text(value, row, f" {value}", va="center", color=INK)
    panel.invert_yaxis()
    panel.set_xlim(0.0, 1.18 * max(values))
    panel.xaxis.set_major_locator(MaxNLocator(5, integer=True))
    panel.set_xlabel("candidates ruled out, and that ran")
    panel.grid(visible=False)


def _front(panel: Axes, dataset: xr.Dataset, ran: xr.Dataset) -> tuple[Any, Any]:
    """Bars, limits and front; returns the places of the designs and which of them have both objectives."""
    limits = json.loads(dataset.attrs["limits"])
    names = [str(name) for name in dataset.attrs["objectives"]]
    for axis, name in zip("xy", names, strict=True):
        sign, factor = UNITS[dataset[name].attrs["units"]]
        share = float(dataset.attrs["share"])
        all_below = f", {100.0 * share:g} % of the runs below" if share < 1.0 else ", worst run"
        below = all_below if f"{name}_median" in dataset else ""
        getattr(panel, f"set_{axis}label")(f"{name.replace('_', ' ')}{below} ({sign})")
        if name in limits:
            draw = panel.axvline if axis == "x" else panel.axhline
            draw(factor * limits[name], color=CRITICAL, lw=0.9, ls="--")
    high = [_display_values(ran, name) for name in names]
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
    labels = [f"{place + 1}: {ran['label'].values[place]}" for place in range(min(NAMED, ran.sizes["design"]))]
    if not known.all():
        lacking = ", ".join(f"{place:.0f}" for place in ran["place"].values[~known])
        labels.append(f"not drawn, as they do not reach both: {lacking}")
    panel.set_title("\n".join(labels), fontsize=8, loc="left")
    panel.margins(0.07)
    return shown, known


def _numbers(panel: Axes, ran: xr.Dataset, places: Any, known: Any) -> None:
    """A mark for each design; in order of their places those get their number that no mark with a number would hide."""
    points = panel.transData.transform(places) * 72.0 / panel.figure.dpi
    numbered: list[int] = []
    for i in np.flatnonzero(known).tolist():  # by place
        if all(np.hypot(*(points[i] - points[j])) > 1.2 * MARK for j in numbered):
            numbered.append(i)
    for i in np.flatnonzero(known).tolist():
        size, above = (MARK, 4.0) if i in numbered else (0.4 * MARK, 3.0)
        panel.plot(*places[i], "o", ms=size, color=COLORS[int(ran["meets"].values[i])], zorder=above, clip_on=False)
    for i in numbered:
        number = f"{ran['place'].values[i]:.0f}"
        panel.annotate(number, places[i], color="white", fontsize=8, zorder=5.0, ha="center", va="center_baseline")


def _middle(ran: xr.Dataset, name: str, row: Any, else_: float) -> float:
    """The median of a design, where the objective is a number of its runs."""
    return float(_display_values(ran, f"{name}_median")[row]) if f"{name}_median" in ran else else_


def _display_values(ran: xr.Dataset, name: str) -> Any:
    return ran[name].values * UNITS[ran[name].attrs["units"]][1]


def _legend(figure: Figure, ran: xr.Dataset) -> None:
    there = [level for level in SAYS if level in ran["meets"].values]
    marks = [Line2D([], [], ls="", marker="o", color=COLORS[level], ms=8, label=SAYS[level]) for level in there]
    if int(((ran["front"].values == 0) & (ran["meets"].values == ran["meets"].values.max(initial=-1.0))).sum()) > 1:
        marks.append(Line2D([], [], color=INK, lw=0.9, label="none is better in both"))
    limited = set(json.loads(ran.attrs["limits"])) & {str(name) for name in ran.attrs["objectives"]}
    marks += [Line2D([], [], color=CRITICAL, lw=0.9, ls="--", label="limit")] * bool(limited)
    bar = COLORS[there[0]] if there else INK
    marks.append(
        Line2D(
            [0.0, 1.0], [0.0, 0.0], color=bar, lw=1.0, marker="o", markevery=[1], ms=5, label="bars: from the median"
        )
    )
    figure.legend(handles=marks, ncols=len(marks), loc="outside lower left", frameon=False)


# Which scatter drives a result, as bars with their intervals.


BARS = {
    "first": ("alone", BALLS[0]),
    "total": ("with all in which it takes part", BALLS[1]),
    "rank_correlation": ("rank correlation", ALL_BALLS),
}


def sensitivity(found: xr.Dataset, *, point: int = 1) -> Figure:
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
        If there is no such point.
    """
    given = found
    if "point" in given.dims:
        if point not in given["point"].values:
            raise QuestionError(f"plot.answer: point: given {point}; there are 1 to {given.sizes['point']}")
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


def _bars(axes: Axes, argument: Any, name: str, number: int, count: int) -> None:
    text, color = BARS[name]
    place = np.arange(argument.sizes["input"]) + 0.34 * (0.5 * (count - 1) - number)
    value, low, high = (argument[f"{name}{end}"].values for end in ("", "_low", "_high"))
    axes.barh(place, value, height=0.3 if count > 1 else 0.5, color=color, label=text)
    axes.hlines(place, low, high, color=INK, linewidth=1.2)


# Percentiles of the deflection of many runs over the time, with the speed above them.


SHALLOW = 1e-5  # of the greatest deflection, below which nobody looks


def envelopes(
    found: xr.Dataset, *, speed_unit: str = "rpm", deflection_unit: str | None = None, log: bool = True
) -> Figure:
    """The deflection of many runs as a fan: bands of 50 % and 90 % of them, the median, the greatest; the rotor speed above.

    Parameters
    ----------
    found
        From :func:`autobalancer.envelopes`.
    speed_unit
        rpm, rad/s or Hz.
    deflection_unit
        m, mm, um or nm; by default one that suits.
    log
        Whether the deflection has a logarithmic axis.
    """
    given = found
    unit, speeds = length_axis(deflection_unit, float(given.attrs["greatest"])), speed_axis(speed_unit)
    level = {percent: unit.shown(given[f"below_{percent}"].values) for percent in (5, 25, 50, 75, 95, 100)}
    time = given["time"].values
    with look():
        figure = picture(7.0, 4.4)
        above, below = figure.subplots(2, sharex=True, height_ratios=[1.0, 2.6])
        heading(figure, str(given.attrs["title"]))
        above.plot(time, speeds.shown(given["speed"].values), color=ALL_BALLS)
        above.set_ylabel(f"speed ({speeds.sign})")
        below.fill_between(
            time, level[5], level[95], color=BALLS[0], alpha=0.18, linewidth=0.0, label="90 % of the runs"
        )
        below.fill_between(time, level[25], level[75], color=BALLS[0], alpha=0.35, linewidth=0.0, label="50 %")
        below.plot(time, level[50], color=BALLS[0], label="median")
        below.plot(time, level[100], color=INK, linewidth=0.8, linestyle=":", label="greatest")
        if log:
            below.set(yscale="log", ylim=(max(SHALLOW * float(level[100].max()), 0.7 * float(level[5].min())), None))
        else:
            below.set_ylim(bottom=0.0)
        below.set(ylabel=f"deflection ({unit.sign})", xlabel="time (s)", xlim=(0.0, float(time[-1])))
        legend(below)
    return figure


# Where balls come to rest, as dots around the race, a panel for each point of the grid of a study.


MOST_PANELS, COLUMNS = 12, 4
RING, SPREAD = 1.0, 0.12  # radius of the dots, and how far they are moved aside so that all are seen


def rest_positions(found: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
    """Ball angles at the end of the members of a study, counted from the unbalance, which is at the right.

    Dots are moved inwards and outwards at random, so that those at one angle are seen side by side; radius means nothing else.

    Parameters
    ----------
    found
        From :func:`autobalancer.study`, with runs.
    speed_unit
        rpm, rad/s or Hz, for titles of panels.

    Raises
    ------
    QuestionError
        If its grid has more than 12 points.
    """
    given = found
    given = given if isinstance(given, Studied) else Studied.of(given)
    points, texts = given.at_points(), given.point_texts(speed_unit)
    if len(points) > MOST_PANELS:
        raise QuestionError(
            f"plot.answer: the grid has {len(points)} points, at most {MOST_PANELS} are drawn; vary less, "
            "or select some in Python with .where"
        )
    rows = -(-len(points) // COLUMNS)
    columns = -(-len(points) // rows)
    with look():
        figure = picture(max(1.9 * columns, 4.2), 2.15 * rows + 0.9)
        heading(figure, f"{given.heading()}\nballs at the end, from the unbalance (line)")
        for number, (where, text) in enumerate(zip(points, texts, strict=True)):
            axes: Any = figure.add_subplot(rows, columns, number + 1, projection="polar")
            _panel(axes, given["ball_angle_to_unbalance"].values[where & given.counted()])
            axes.set_title(text, fontsize=8.5, loc="center", weight="normal")
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8.5)
    return figure


def _panel(axes: Any, angles: Any) -> None:
    aside = SPREAD * (2.0 * generator(0).random(angles.shape) - 1.0)
    size = float(np.clip(900.0 / max(angles.shape[0], 1), 2.0, 14.0))
    for ball in range(angles.shape[1]):
        axes.scatter(
            angles[:, ball],
            RING + aside[:, ball],
            s=size,
            color=ball_color(ball),
            alpha=0.6,
            linewidths=0.0,
            label=ball_label(ball, angles.shape[1]),
        )
    axes.plot([0.0, 0.0], [0.0, RING - 2.0 * SPREAD], color=UNBALANCE, linewidth=2.0)
    axes.set(ylim=(0.0, RING + 1.5 * SPREAD), yticks=[], xticks=np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False))
    axes.tick_params(axis="x", labelsize=7.0, pad=-1.0)
