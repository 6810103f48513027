"""Pictures of how many runs end: basins of starts, ensembles and what varied in them."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator
from numpy.typing import NDArray

from autobalancer.errors import QuestionError, one_of
from autobalancer.plots.style import (
    BALLS,
    CRITICAL,
    HALO,
    INK,
    heading,
    legend,
    look,
    picture,
    plain_log_ticks,
    quantity_axis,
    with_ignored,
)
from autobalancer.random_numbers import wilson_interval
from autobalancer.results.answers.studied import Ensemble, which_starts
from autobalancer.results.display_units import (
    LENGTHS,
    AxisUnit,
    axis_unit,
    length_axis,
    length_text,
    moment_text,
    speed_axis,
)
from autobalancer.results.verdict import BALANCED, NO_VERDICT, NOT, NOT_SETTLED, PARTLY, WORSE

WIDE = 72  # letters of four keys side by side that do not fit the picture
HELD = LinearSegmentedColormap.from_list("held", ["#EFECF7", "#7B68B5", "#2E1F66"])


def basin(found: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
    """The end state over the starts: a map for two axes, a strip for one, bars for random starts.

    Parameters
    ----------
    found
        From :func:`autobalancer.basin`.
    speed_unit
        rpm, rad/s or Hz.
    """
    unit = speed_axis(speed_unit)
    names = list(found.attrs["states"])
    share = {name: float(found["share"].sel(end=name)) for name in names}
    title = f"How balls end: {found.attrs['machine_name']} at {found.attrs['speed'] * unit.factor:.4g} {unit.sign}"
    axes_names = [str(dim) for dim in found["state"].dims if dim != "run"]
    with look():
        if not axes_names:
            return shares_of_ends(found, title)
        figure = picture(6.6, 5.6 if len(axes_names) == 2 else 2.4)
        axes = figure.add_subplot()
        heading(figure, with_ignored(title, found.attrs))
        axes.grid(False)
        # one color for each end state
        colors = ListedColormap([(VERDICTS | COLORS)[name] for name in names])
        norm = BoundaryNorm(np.arange(len(names) + 1) - 0.5, len(names))
        x, x_label = _axis(found[axes_names[0]], speed_unit)
        values = found["state"].values
        if len(axes_names) == 2:
            y, y_label = _axis(found[axes_names[1]], speed_unit)
            axes.set_ylabel(y_label)
        else:
            y, values = np.array([0.0, 1.0]), np.column_stack([values, values])
            axes.set_yticks([])
        axes.set_xlabel(x_label)
        shading: Literal["nearest", "auto"] = "nearest" if min(values.shape) > 1 else "auto"
        axes.pcolormesh(x, y, values.T, cmap=colors, norm=norm, shading=shading, rasterized=True)
        held = names.index("held by friction") if "held by friction" in names else -1
        if (found["state"].values == held).any() and "residual_unbalance" in found:
            _shade(figure, axes, found, held, x, y, shading)
        # the key names what is there, with its share
        there = set(np.unique(found["state"].values))
        overlapping = f"overlapping start: {found.attrs.get('overlapping', 0)} of {found['state'].size}, not counted"
        handles = [
            Patch(
                color=(VERDICTS | COLORS)[name],
                label=f"{name} {100 * share[name]:.3g} %" if share[name] else overlapping,
            )
            for number, name in enumerate(names)
            if number in there
        ]
        columns = 4 if sum(len(str(patch.get_label())) for patch in handles[:4]) < WIDE else 2
        figure.legend(
            handles=handles,
            loc="outside lower center",
            ncols=min(len(handles), columns),
            title=_verdicts(found) or None,
        )
        if len(axes_names) == 2 and all("angle" in name for name in axes_names):
            axes.set_aspect("equal")
            axes.xaxis.set_major_locator(MultipleLocator(90))
            axes.yaxis.set_major_locator(MultipleLocator(90))
    return figure


def _verdicts(dataset: xr.Dataset) -> str:
    """The shares of the verdicts in one line; empty without unbalance."""
    if "verdict_share" not in dataset or not float(dataset["unbalance"]) > 0.0:
        return ""
    shares = {str(word): float(dataset["verdict_share"].sel(verdict=word)) for word in dataset["verdict"].values}
    return "Verdict: " + ", ".join(f"{word} {100 * share:.3g} %" for word, share in shares.items() if share > 0.0)


def _shade(
    figure: Figure,
    axes: Axes,
    dataset: xr.Dataset,
    held: int,
    x: np.ndarray,
    y: np.ndarray,
    shading: Literal["nearest", "auto"],
) -> None:
    """Held states by what they leave: the darker, the more of the unbalance."""
    left = 100.0 * dataset["residual_unbalance"].values / max(float(dataset["unbalance"]), 1e-300)
    left = np.where(dataset["state"].values == held, left, np.nan)
    left = left if left.ndim == 2 else np.column_stack([left, left])
    drawn = axes.pcolormesh(x, y, left.T, cmap=HELD, vmin=0.0, vmax=100.0, shading=shading, rasterized=True)
    extend = "max" if np.nanmax(left) > 100.0 else "neither"
    bar = figure.colorbar(drawn, ax=axes, pad=0.02, fraction=0.05, extend=extend)
    bar.set_label("residual unbalance (%)" if dataset["state"].ndim == 2 else "residual\nunbalance (%)")
    bar.outline.set_visible(False)


def _axis(values: xr.DataArray, speed_unit: str) -> tuple[np.ndarray, str]:
    label, unit = str(values.attrs["long_name"]), str(values.attrs["units"])
    if unit == "rad":
        return values.values * 180.0 / math.pi, f"{label} (°)"
    if unit == "rad/s":
        shown = speed_axis(speed_unit)
        return values.values * shown.factor, f"{label} ({shown.sign})"
    return values.values, f"{label} ({unit.replace('^2', '²')})"


# Random starts as a picture: shares of the ends and of the verdicts, and the distributions of what is left.


MOVING = "balls not at rest"
COLORS = {
    "balanced": "#009E73",
    "mixed": "#A6C936",
    "coincident": "#D55E00",
    "in line": "#E69F00",
    "held by friction": "#7B68B5",
    "stalled": "#0072B2",
    "oscillating": "#56B4E9",
    "chaotic": "#CC79A7",
    "failed": "#222222",
    "overlapping start": "#E3E3E3",
}
VERDICTS = {
    BALANCED: "#009E73",
    PARTLY: "#E69F00",
    NOT: "#D55E00",
    WORSE: "#8C2D04",
    NO_VERDICT: "#56B4E9",
    NOT_SETTLED: "#7B68B5",
    MOVING: "#0072B2",
    "failed": "#222222",
}
FAR = 5.0  # times the greatest of the runs: farther away the value without balls is written, not drawn
DUST = 1e-4  # of the value without balls: less is not worth a curve
AT_REST = ("balanced", "mixed", "coincident", "in line", "held by friction")
QUANTITIES = {  # drawn as a distribution: with which value without balls, under which name
    "residual_unbalance": ("unbalance", "residual unbalance"),
    "vibration": ("vibration_without_balls", "vibration"),
    "peak_deflection": ("peak_without_balls", "greatest deflection on the way"),
}


def shares_of_ends(dataset: xr.Dataset, title: str) -> Figure:
    """Bars of the ends, beside them of the verdicts if those are others; below what each start leaves.

    Parameters
    ----------
    dataset
        From :func:`autobalancer.basin` with random starts.
    title
        Machine and speed.
    """
    verdicts = "vibration" in dataset
    drawn = [name for name, (whole, _) in QUANTITIES.items() if whole in dataset and _values(dataset, name).size]
    if not verdicts:  # the deflection of balls at rest is their residual in another unit
        drawn = drawn[:1] if float(dataset["unbalance"]) > 0.0 else []
    shares = {str(name): float(dataset["share"].sel(end=name)) for name in dataset["end"].values}
    words = (
        {} if verdicts else {str(w): float(dataset["verdict_share"].sel(verdict=w)) for w in dataset["verdict"].values}
    )
    words = words if words and sum(words.values()) > words[MOVING] and float(dataset["unbalance"]) > 0.0 else {}
    rows = max(sum(value > 0.0 for value in some.values()) for some in (shares, words))
    heights = [0.9 + 0.34 * rows, *([2.9] if drawn else [])]
    figure = picture(9.2 if len(drawn) > 2 else 6.6 if verdicts or not words else 8.0, sum(heights) + 0.35)
    count = dataset["state"].size
    run_ups = f"{count} run-ups from random starts, {dataset.attrs['acceleration']:.3g} rad/s²"
    title += f", {run_ups if 'peak_without_balls' in dataset else f'{count} random starts'}"
    heading(figure, with_ignored(title, dataset.attrs))
    parts = figure.add_gridspec(len(heights), 1, height_ratios=heights)
    above = parts[0].subgridspec(1, 2 if words else 1)
    axes = figure.add_subplot(above[0])
    low, high = (dataset[f"share_{end}"].to_series().to_dict() for end in ("low", "high"))
    _bars(axes, shares, {name: (low[name], high[name]) for name in shares}, rows)
    axes.set_xlabel("share of the starts, with its 95 % interval (%)")
    if words:
        axes.set_xlabel("how balls end, with 95 % interval (%)")
        beside = figure.add_subplot(above[1])
        _bars(beside, words, {}, rows)
        beside.set_xlabel("how well they then balance: verdict (%)")
    if drawn:
        below = parts[1].subgridspec(1, len(drawn))
        panels = [figure.add_subplot(below[column]) for column in range(len(drawn))]
        for panel, name in zip(panels, drawn, strict=True):
            _distribution(panel, dataset, name)
        next((panel for panel in panels if panel.axison), panels[0]).set_ylabel("share of the starts (%)")
    return figure


def _bars(axes: Axes, share: dict[str, float], interval: dict[str, tuple[float, float]], rows: int) -> None:
    names = [name for name, value in share.items() if value > 0.0]
    for place, name in enumerate(names):
        low, high = interval.get(name, (share[name], share[name]))
        axes.barh(place, 100 * share[name], color=(VERDICTS | COLORS)[name], height=0.6)
        if interval:
            axes.plot([100 * low, 100 * high], [place, place], color=INK, linewidth=1.2, marker="|")
        axes.text(100 * high + 1.5, place, f"{100 * share[name]:.3g} %", va="center")
    axes.set_yticks(range(len(names)), names)
    axes.set(xlim=(0.0, 118.0), xticks=range(0, 101, 20), ylim=(rows - 0.5, -0.5))
    axes.grid(False)


def _values(dataset: xr.Dataset, quantity: str) -> NDArray[np.float64]:
    """Of the starts that count, in ascending order: all whose run finished, or of planar machines those at rest."""
    names = list(dataset.attrs["states"])
    verdicts = "vibration" in dataset
    counted = [name for name in names if name != "failed"] if verdicts else [name for name in names if name in AT_REST]
    chosen = np.isin(dataset["state"].values, [names.index(name) for name in counted])
    left: NDArray[np.float64] = np.sort(dataset[quantity].values[chosen])
    finite: NDArray[np.float64] = left[np.isfinite(left)]
    return finite


def _distribution(axes: Axes, dataset: xr.Dataset, quantity: str) -> None:
    """Share of the starts below a residual unbalance, a vibration or a peak, with median and 95 %."""
    without, name = QUANTITIES[quantity]
    moment, verdicts = quantity == "residual_unbalance", "vibration" in dataset
    whole, left = float(dataset[without]), _values(dataset, quantity)
    text = moment_text if moment else length_text
    of = which_starts(dataset, quantity)
    name += of.replace(" ", "\n", 1) if verdicts else of  # panels of verdicts are narrow
    if left[-1] < DUST * whole:
        axes.set_axis_off()
        axes.set_title(name, fontweight="normal", loc="center", y=0.6)
        axes.text(
            0.5, 0.45, f"all below 0.01 % of\n{text(whole)} without balls", ha="center", va="center", transform=axes.transAxes
        )  # fmt: skip
        return
    farthest = (
        max(left[-1], whole) if whole < FAR * left[-1] else left[-1]
    )  # else the line is too far to show the curve
    factor, unit = (1e6, "g mm") if moment else _natural(farthest)
    color = COLORS["held by friction"]
    axes.step(left * factor, 100.0 * np.arange(1, left.size + 1) / left.size, where="post", color=color)
    if whole <= farthest:
        axes.axvline(whole * factor, color=INK, linewidth=1.0, linestyle=(0, (5, 3)))
        right = whole > 0.5 * farthest
        place = whole * factor
    else:
        right, place = True, 1.05 * farthest * factor
    axes.annotate(
        f"without balls {text(whole)}",
        (place, 107.0),
        (-4.0 if right else 4.0, 0.0),
        textcoords="offset points",
        ha="right" if right else "left",
        color=INK,
    )
    for share in (0.5, 0.95):
        value = float(np.quantile(left, share)) * factor
        axes.plot([0.0, value, value], [100 * share, 100 * share, 0.0], color=CRITICAL, linewidth=0.8, zorder=1)
        right = value > 0.5 * farthest * factor
        axes.annotate(
            f"{100 * share:.0f} %{':' if verdicts else ' below'} {text(value / factor)}",
            (value, 100 * share),
            (-6.0, 4.0) if right else (8.0, -14.0),  # off the curve
            textcoords="offset points",
            ha="right" if right else "left",
            path_effects=HALO,
        )
    axes.set(xlim=(0.0, 1.05 * farthest * factor), ylim=(0.0, 118.0), xlabel=f"{name} ({unit})")


def _natural(length: float) -> tuple[float, str]:
    """Factor and unit in which a length is a number above one."""
    return next(((factor, sign) for sign, factor in LENGTHS[1:] if length * factor >= 1.0), (1e9, "nm"))


# Ensembles as pictures: shares of the ends, distributions of measures, one quantity against another.


PARTS = 12  # parts of equal numbers of members into which a column of many values is cut
OTHERS = ("#8A7A1F", "#CC79A7", "#222222")  # outcomes of members that did not finish


def ensemble(result: xr.Dataset, *, over: str | None = None, speed_unit: str = "rpm") -> Figure:
    """Shares of the ends of an ensemble with their 95 % intervals, as bars, or over a column.

    Parameters
    ----------
    result
        From :func:`autobalancer.ensemble`.
    over
        Name of a coordinate; by default the only column. A column of many values is cut into parts of equal numbers of members.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If there is no such coordinate.
    """
    members = result if isinstance(result, Ensemble) else Ensemble.of(result)
    columns = [
        str(name) for name in members.coords if name not in ("member", "seed") and members[name].dtype.kind in "fi"
    ]
    if over is not None and over not in members.coords:
        raise QuestionError(f"plot.answer: over: given {over!r}; there are {', '.join(map(repr, members.coords))}")
    name = over or (columns[0] if len(columns) == 1 and np.unique(members[columns[0]]).size > 1 else "")
    with look():
        figure = picture(6.6, 3.6 if name else 0.9 + 0.4 * _ends(members).size)
        axes = figure.add_subplot()
        heading(figure, members.heading())
        if name:
            _shares_over(axes, members, name, speed_unit)
        else:
            _end_bars(axes, members)
    return figure


def ensemble_distribution(
    result: xr.Dataset, measure: str = "vibration", *, by: str | None = None, speed_unit: str = "rpm"
) -> Figure:
    """Share of the members of an ensemble below each value of a measure.

    Parameters
    ----------
    result
        From :func:`autobalancer.ensemble`.
    measure
        Name of a variable over the members.
    by
        Name of a coordinate with few values: one curve for each; by default the only column, if it has few values.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If there is no such measure, or no member has it.
    """
    members = result if isinstance(result, Ensemble) else Ensemble.of(result)
    members = Ensemble.of(members.isel(member=np.flatnonzero(members.ran())))
    values = _numbers(members, measure, "plot.answer", "measure")
    by = by if by is not None else members.group()
    unit = _unit(members[measure], speed_unit)
    with look():
        figure = picture(6.6, 3.8)
        axes = figure.add_subplot()
        heading(figure, members.heading())
        groups = sorted(set(members[by].values.tolist())) if by else [None]
        for number, group in enumerate(groups):
            own = values if group is None else values[members[by].values == group]
            known = np.sort(own[np.isfinite(own)])
            heights = 100.0 * np.arange(1, known.size + 1) / max(own.size, 1)
            label = None if group is None else _group_text(members, by, group, speed_unit)
            axes.step(unit.shown(known), heights, where="post", color=BALLS[number % len(BALLS)], label=label)
        positive = values[np.isfinite(values) & (values > 0.0)]
        if positive.size and positive.size == np.isfinite(values).sum() and positive.max() > 30.0 * positive.min():
            axes.set_xscale("log")
            plain_log_ticks(axes, "x")
        axes.set(
            xlabel=f"{measure.replace('_', ' ')}{f' ({unit.sign})' if unit.sign else ''}",
            ylabel="share of the members (%)",
            ylim=(0.0, 102.0),
        )
        legend(axes)
    return figure


def ensemble_scatter(result: xr.Dataset, x: str = "", y: str = "peak_deflection", *, speed_unit: str = "rpm") -> Figure:
    """Every member of an ensemble as a point, in the color of its end.

    Parameters
    ----------
    result
        From :func:`autobalancer.ensemble`.
    x, y
        Names of coordinates or variables over the members; ``x`` is by default the first column.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If there is no such quantity.
    """
    members = result if isinstance(result, Ensemble) else Ensemble.of(result)
    x = x or str(next((name for name in members.coords if name != "member"), "member"))
    across, up = (_numbers(members, name, "plot.answer", key) for key, name in (("x", x), ("y", y)))
    units = [_unit(members[name], speed_unit) for name in (x, y)]
    classes = members.classes()
    with look():
        figure = picture(6.6, 4.2)
        axes = figure.add_subplot()
        heading(figure, members.heading())
        for end, color in zip(_ends(members), _colors(members), strict=True):
            own = (classes == end) & members.ran()
            axes.plot(
                units[0].shown(across[own]), units[1].shown(up[own]), ".", color=color, markersize=4.0, label=end, rasterized=True
            )  # fmt: skip
        for name, unit, place in ((x, units[0], axes.set_xlabel), (y, units[1], axes.set_ylabel)):
            text = str(members[name].attrs.get("long_name", name)) if name in members.coords else name.replace("_", " ")
            place(f"{text}{f' ({unit.sign})' if unit.sign else ''}")
        legend(axes)
    return figure


def _numbers(members: Ensemble, name: str, text: str, key: str) -> Any:
    fitting = [str(n) for n in members.variables if members[n].dims == ("member",) and members[n].dtype.kind in "fi"]
    one_of(f"{text}: {key}", name, *fitting)
    values = np.asarray(members[name].values, np.float64)
    if not np.isfinite(values).any():
        raise QuestionError(f"{text}: {key}: no member has {name!r}")
    return values


def _ends(members: Ensemble) -> Any:
    shares = members.shares()
    return shares["end"].values[shares["count"].values > 0]


def _colors(members: Ensemble) -> list[str]:
    others = iter(OTHERS * 3)
    return [VERDICTS.get(str(end)) or next(others) for end in _ends(members)]


def _end_bars(axes: Axes, members: Ensemble) -> None:
    result = members.shares().sel(end=_ends(members))
    for place, color in enumerate(_colors(members)):
        share, low, high = (100.0 * float(result[name][place]) for name in ("share", "share_low", "share_high"))
        axes.barh(place, share, color=color, height=0.6)
        axes.plot([low, high], [place, place], color=INK, linewidth=1.2, marker="|")
        axes.text(high + 1.5, place, f"{share:.3g} %", va="center")
    axes.set_yticks(range(result.sizes["end"]), list(result["end"].values))
    axes.set(xlim=(0.0, 118.0), xticks=range(0, 101, 20), ylim=(result.sizes["end"] - 0.5, -0.5))
    axes.grid(False)
    axes.set_xlabel("share of the members, with its 95 % interval (%)")


def _shares_over(axes: Axes, members: Ensemble, name: str, speed_unit: str) -> None:
    shown = quantity_axis(members[name], speed_unit)
    ran, classes = members.ran(), members.classes()
    values = np.unique(shown.values[ran])
    if values.size <= PARTS:
        middles, part = values, np.searchsorted(values, shown.values)
    else:
        edges = np.unique(np.quantile(shown.values[ran], np.linspace(0.0, 1.0, PARTS + 1)))
        part = np.clip(np.searchsorted(edges, shown.values, side="right") - 1, 0, edges.size - 2)
        middles = np.array([np.median(shown.values[ran & (part == i)]) for i in range(edges.size - 1)])
    totals = [int((ran & (part == i)).sum()) for i in range(middles.size)]
    ends, log = _ends(members), bool(middles.min() > 0.0 and middles.max() >= 10.0 * middles.min())
    span = float(middles.max() / middles.min() if log else np.ptp(middles)) or 1.0
    for number, (end, color) in enumerate(zip(ends, _colors(members), strict=True)):
        counts = [int((ran & (part == i) & (classes == end)).sum()) for i in range(middles.size)]
        low, high = np.array([wilson_interval(np.array([c]), t) for c, t in zip(counts, totals, strict=True)])[..., 0].T
        share = np.array(counts) / np.array(totals)
        apart = 0.006 * (
            number - 0.5 * (ends.size - 1)
        )  # of the width, so that bars of equal shares stand side by side
        where = middles * span**apart if log else middles + apart * span
        bars = np.array([np.maximum(share - low, 0.0), np.maximum(high - share, 0.0)])
        axes.errorbar(
            where, 100.0 * share, 100.0 * bars, fmt="o-", markersize=3.5, elinewidth=1.0, capsize=2.0, color=color, label=end
        )  # fmt: skip
    if log:
        axes.set_xscale("log")
        plain_log_ticks(axes, "x")
    axes.set(xlabel=shown.label, ylabel="share, with 95 % interval (%)", ylim=(-2.0, 102.0))
    legend(axes)


def _unit(values: xr.DataArray, speed_unit: str) -> AxisUnit:
    if values.attrs.get("units") == "m":
        known = np.abs(values.values[np.isfinite(values.values)])
        return length_axis(None, float(known.max(initial=0.0)) or 1.0)
    return axis_unit(values, speed_unit)


def _group_text(members: Ensemble, by: str, value: Any, speed_unit: str) -> str:
    unit = axis_unit(members[by], speed_unit)
    text = f"{unit.shown(value):.4g} {unit.sign}" if isinstance(value, (int, float)) else str(value)
    return text.strip()
