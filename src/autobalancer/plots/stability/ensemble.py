"""Ensembles as pictures: shares of the ends, distributions of measures, one quantity against another."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.axes import plain_log_ticks, quantity_axis
from autobalancer.plots.drawing.style import BALLS, INK, heading, legend, look, picture
from autobalancer.plots.stability.basins import VERDICTS
from autobalancer.results.answers.studied import Ensemble
from autobalancer.results.display_units import AxisUnit, axis_unit, length_axis
from autobalancer.results.run_argument import Given, result
from autobalancer.results.shares import wilson_interval

PARTS = 12  # parts of equal numbers of members into which a column of many values is cut
OTHERS = ("#8A7A1F", "#CC79A7", "#222222")  # outcomes of members that did not finish


def ensemble(result: Given, *, over: str | None = None, speed_unit: str = "rpm") -> Figure:
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
        If ``result`` holds no ensemble, or no such coordinate.
    """
    members = _members(result, "plot.ensemble")
    columns = [
        str(name) for name in members.coords if name not in ("member", "seed") and members[name].dtype.kind in "fi"
    ]
    if over is not None and over not in members.coords:
        raise QuestionError(f"plot.ensemble: over: given {over!r}; there are {', '.join(map(repr, members.coords))}")
    name = over or (columns[0] if len(columns) == 1 and np.unique(members[columns[0]]).size > 1 else "")
    with look():
        figure = picture(6.6, 3.6 if name else 0.9 + 0.4 * _ends(members).size)
        axes = figure.add_subplot()
        heading(figure, members.heading())
        if name:
            _shares_over(axes, members, name, speed_unit)
        else:
            _bars(axes, members)
    return figure


def ensemble_distribution(
    result: Given, measure: str = "vibration", *, by: str | None = None, speed_unit: str = "rpm"
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
        If there is no ensemble, no such measure, or no member has it.
    """
    members = _members(result, "plot.ensemble_distribution")
    members = Ensemble.of(members.isel(member=np.flatnonzero(members.ran())))
    values = _numbers(members, measure, "plot.ensemble_distribution", "measure")
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
        axes.set_xlabel(f"{measure.replace('_', ' ')}{f' ({unit.sign})' if unit.sign else ''}")
        axes.set_ylabel("share of the members (%)")
        axes.set_ylim(0.0, 102.0)
        legend(axes)
    return figure


def ensemble_scatter(result: Given, x: str = "", y: str = "peak_deflection", *, speed_unit: str = "rpm") -> Figure:
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
        If there is no ensemble, or no such quantity.
    """
    members = _members(result, "plot.ensemble_scatter")
    x = x or str(next((name for name in members.coords if name != "member"), "member"))
    across, up = (_numbers(members, name, "plot.ensemble_scatter", key) for key, name in (("x", x), ("y", y)))
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


def _members(found: Given, text: str) -> Ensemble:
    kept: xr.Dataset = result(found, text, "ensemble", lambda it: "member" in it.dims and "outcome" in it)
    return kept if isinstance(kept, Ensemble) else Ensemble.of(kept)


def _numbers(members: Ensemble, name: str, text: str, key: str) -> Any:
    fitting = [str(n) for n in members.variables if members[n].dims == ("member",) and members[n].dtype.kind in "fi"]
    if name not in fitting:
        raise QuestionError(f"{text}: {key}: given {name!r}; there are {', '.join(fitting)}")
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


def _bars(axes: Axes, members: Ensemble) -> None:
    result = members.shares().sel(end=_ends(members))
    for place, color in enumerate(_colors(members)):
        share, low, high = (100.0 * float(result[name][place]) for name in ("share", "share_low", "share_high"))
        axes.barh(place, share, color=color, height=0.6)
        axes.plot([low, high], [place, place], color=INK, linewidth=1.2, marker="|")
        axes.text(high + 1.5, place, f"{share:.3g} %", va="center")
    axes.set_yticks(range(result.sizes["end"]), list(result["end"].values))
    axes.set_xlim(0.0, 118.0)
    axes.set_xticks(range(0, 101, 20))
    axes.set_ylim(result.sizes["end"] - 0.5, -0.5)
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
    axes.set_xlabel(shown.label)
    axes.set_ylabel("share, with 95 % interval (%)")
    axes.set_ylim(-2.0, 102.0)
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
