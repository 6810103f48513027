"""Picture of a fit: measured and fitted curves, deviations of single values, correlation of the parameters."""

from __future__ import annotations

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.plots.drawing.labels import label_point
from autobalancer.plots.drawing.quantity_axis import plain_log_ticks
from autobalancer.plots.drawing.style import ALL_BALLS, BALLS, CRITICAL, FILL, INK, heading, legend, look, picture
from autobalancer.results.display_units import AxisUnit, length_axis, speed_axis
from autobalancer.results.given import Given, result

OUTLIER = 5.0  # standard deviations


def identification(fit: Given, *, speed_unit: str = "rpm", log: bool = True) -> Figure:
    """Response curves and orders before and after the fit (if there are any), deviations in standard deviations, correlation.

    Parameters
    ----------
    fit
        ``data`` of an :class:`~autobalancer.rotordynamics.identification.identify.Identification`.
    speed_unit
        rpm, rad/s or Hz.
    log
        Logarithmic amplitudes.

    Raises
    ------
    QuestionError
        If ``fit`` is no such result.
    """
    wanted = "rotor.identify, its .data"
    fit = result(fit, "plot.identification", wanted, lambda it: "deviation" in it and "correlation" in it)
    unit = speed_axis(speed_unit)
    curves, orders = (np.unique(fit["row_label"].values[fit["row_kind"].values == k]) for k in ("response", "orders"))
    with look():
        figure = picture(7.6, 3.4 + 2.9 * (len(curves) + len(orders)))
        heading(figure, str(fit.attrs.get("title", "")))
        grid = figure.add_gridspec(len(curves) + len(orders) + 1, 2, width_ratios=[1.7, 1.0])
        for i, label in enumerate(orders, len(curves)):
            rows = np.flatnonzero((fit["row_label"].values == label) & (fit["row_kind"].values == "orders"))
            one = [figure.add_subplot(grid[i, k]) for k in range(2)]
            _orders(one[0], one[1], fit.isel(row=rows), unit, str(label))
        for i, label in enumerate(curves):
            wanted = (fit["row_label"].values == label) & (fit["row_kind"].values == "response")
            drawn = np.flatnonzero(fit["curve_label"].values == label)
            part = fit.isel(row=np.flatnonzero(wanted), point=drawn)
            _curve(figure.add_subplot(grid[i, :]), part, unit, str(label), log)
        _deviations(figure.add_subplot(grid[-1, 0]), fit, unit)
        _correlation(figure, figure.add_subplot(grid[-1, 1]), fit)
    return figure


def _curve(axes: Axes, part: xr.Dataset, unit: AxisUnit, label: str, log: bool) -> None:
    order = np.argsort(part["row_speed"].values)
    part = part.isel(row=order)
    speed, sign, factor = part["row_speed"].values * unit.factor, str(part["row_unit"].values[0]), 1.0
    if sign == "m":
        length = length_axis(None, float(part["measured"].max()))
        sign, factor = length.sign, length.factor
    along = part["curve_speed"].values * unit.factor
    axes.plot(along, factor * part["curve_before"].values, color=FILL, lw=3.0, label="before")
    axes.plot(speed, factor * part["measured"].values, ".", ms=4, color=ALL_BALLS, zorder=3, label="measured")
    axes.plot(along, factor * part["curve_after"].values, color=BALLS[0], label="after the fit")
    for i in np.flatnonzero(np.abs(part["deviation"].values) > OUTLIER):
        x, y = float(speed[i]), factor * float(part["measured"].values[i])
        axes.plot(x, y, "o", ms=8, mfc="none", mec=INK, label="_")
        label_point(axes, f"{part['deviation'].values[i]:+.0f} standard deviations", x, y, size=8.0)
    axes.set(xlabel=f"speed ({unit.sign})", ylabel=f"amplitude ({sign})", title=label)
    if log:
        axes.set_yscale("log")
        plain_log_ticks(axes, "y")
    legend(axes)


def _orders(above: Axes, beside: Axes, part: xr.Dataset, unit: AxisUnit, label: str) -> None:
    """Amplitude and phase of every channel over the speed."""
    sign, factor = str(part["row_unit"].values[0]).split(", ")[0], 1.0
    names = list(dict.fromkeys(str(name) for name in part["row_part"].values))
    if sign == "m":
        sizes = [name.endswith(", amplitude") for name in map(str, part["row_part"].values)]
        length = length_axis(None, float(part["measured"].values[sizes].max()))
        sign, factor = length.sign, length.factor
    for k, name in enumerate(names):
        one = part.isel(row=np.flatnonzero(part["row_part"].values == name))
        one = one.isel(row=np.argsort(one["row_speed"].values))
        channel, _, what = name.rpartition(", ")
        axes, scale = (beside, 180.0 / np.pi) if what == "phase" else (above, factor)
        color, speed = BALLS[k % (len(names) // 2) % len(BALLS)], one["row_speed"].values * unit.factor
        for what, look_of in (("measured", {"ls": "", "marker": ".", "ms": 4}), ("before", {"lw": 3.0, "alpha": 0.3})):
            axes.plot(speed, scale * one[what].values, color=color, label="_", **look_of)
        axes.plot(speed, scale * one["after"].values, color=color, lw=1.0, label=channel)
    above.set(xlabel=f"speed ({unit.sign})", ylabel=f"amplitude ({sign})", title=label, ylim=(0.0, None))
    beside.set(xlabel=f"speed ({unit.sign})", ylabel="lead over the mark (°)", title="pale: before the fit")
    legend(above)


def _deviations(axes: Axes, fit: xr.Dataset, unit: AxisUnit) -> None:
    labels = fit["row_label"].values
    many = np.array([bool((labels == label).sum() > 1) for label in labels])
    whole = [
        label for label in dict.fromkeys(labels[many]) if "response" not in fit["row_kind"].values[labels == label]
    ]
    single = fit.isel(row=np.flatnonzero(~many & (fit["row_kind"].values != "response")))
    if single.sizes["row"] == 0 and not whole:
        axes.axhspan(-1.0, 1.0, color="#EFF2F4", lw=0)
        axes.plot(fit["row_speed"].values * unit.factor, fit["deviation"].values, ".", ms=4, color=INK)
        axes.set(xlabel=f"speed ({unit.sign})", ylabel="deviation (standard deviations)", title="after the fit")
        return
    place = np.arange(len(whole), single.sizes["row"] + len(whole))[::-1]
    before = (single["before"] - single["measured"]).values / single["error"].values
    after = single["deviation"].values
    axes.axvspan(-1.0, 1.0, color="#EFF2F4", lw=0)
    if place.size:
        axes.plot(before, place, "o", mfc="white", color=CRITICAL, label="before")
        axes.plot(after, place, "o", color=BALLS[0], label="after the fit")
    means = [float(np.sqrt((fit["deviation"].values[labels == label] ** 2).mean())) for label in whole]
    if means:
        axes.plot(means, range(len(whole)), "D", ms=5, color=BALLS[0], label="after the fit, root mean square")
    for at, a, b in zip(place, before, after, strict=True):
        axes.plot([a, b], [at, at], color=CRITICAL, lw=0.7, zorder=1)
    counts = [f"{label}\n{(labels == label).sum()} values" for label in whole]
    axes.set_yticks([*place, *range(len(whole))], [*map(str, single["row_label"].values), *counts])
    axes.set_ylim(-0.6, place.size + len(whole) - 0.4)
    axes.set_xlabel("deviation (standard deviations)")
    legend(axes)


def _correlation(figure: Figure, axes: Axes, fit: xr.Dataset) -> None:
    values = fit["correlation"].values
    names = [str(name) for name in fit["parameter"].values]
    names = [fill(name, 18) for name in names]
    axes.imshow(values, vmin=-1.0, vmax=1.0, cmap="PuOr")
    axes.grid(False)
    ticks = np.arange(len(names))
    axes.set_xticks(ticks, names, rotation=40, ha="right", fontsize=7.5)
    axes.set_yticks(ticks, names, fontsize=7.5)
    for i in ticks:
        for j in ticks:
            text = "" if np.isnan(values[i, j]) else f"{values[i, j]:.2f}"
            axes.annotate(
                text, (j, i), ha="center", va="center", fontsize=7.5, color="white" if abs(values[i, j]) > 0.6 else INK
            )
    axes.set_title("correlation")
