"""Pictures of studies of a deep chamber, and of the catalogue of an archive."""

from __future__ import annotations

from typing import Any

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.quantity_axis import QuantityAxis, plain_log_ticks, quantity_axis
from autobalancer.plots.drawing.style import BALLS, INK, ball_color, heading, legend, look, picture
from autobalancer.results.display_units import length_axis
from autobalancer.results.given import Given, result

COLORS = "viridis"  # of curves in the order of a number
NAMES = {"deep": "deep chamber", "single": "single layer"}


def chamber_amplitudes(study: Given, *, measure: str = "vertical_amplitude", title: str | None = None) -> Figure:
    """Amplitude over the number of balls, a curve for each friction, a panel for each chamber (Pakuła 2021, figure 10).

    With several seeds the mean is drawn, with bars from the least to the greatest value. ``title`` stands above the panels.

    Raises
    ------
    QuestionError
        If the study has no such measure.
    """
    study = result(study, "plot.chamber_amplitudes", "chamber.amplitudes", _is_study)
    if measure not in study:
        raise QuestionError(f"measure: given {measure!r}; the study has {', '.join(sorted(map(str, study.data_vars)))}")
    layers = [str(layer) for layer in study["layers"].values]
    unit = length_axis(None, float(np.nanmax(study[measure].values, initial=0.0)))
    with look():
        figure = picture(3.9 * len(layers), 3.6)
        axes = figure.subplots(1, len(layers), squeeze=False, sharey=True)[0]
        for panel, layer in zip(axes, layers, strict=True):
            for i, friction in enumerate(study["friction"].values):
                values = study[measure].sel(layers=layer, friction=friction) * unit.factor
                _curve(panel, study["balls"], values, ball_color(i), f"friction {friction:g}")
            panel.set_title(NAMES.get(layer, layer), pad=20.0)
            panel.set_xlabel("number of balls")
            panel.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
            panel.set_yscale("log")
            plain_log_ticks(panel, "y")
        axes[0].set_ylabel(f"{measure.replace('_', ' ')} ({unit.sign})")
        legend(axes[-1])
        heading(figure, title if title is not None else str(study.attrs.get("machine_name", "")))
    return figure


def chamber_carried(study: Given, *, title: str | None = None) -> Figure:
    """Share of the balls of a ``study`` that go around with the rotor over friction, a curve for each number of balls.

    A curve rises at the least friction that carries so many balls up from the bottom; the lowest curve that reaches
    the top belongs to the least number of balls. ``title`` stands above the picture.
    """
    study = result(study, "plot.chamber_carried", "chamber.amplitudes", _is_study)
    layers = [str(layer) for layer in study["layers"].values]
    with look():
        figure = picture(3.9 * len(layers), 3.4)
        axes = figure.subplots(1, len(layers), squeeze=False, sharey=True)[0]
        for panel, layer in zip(axes, layers, strict=True):
            held = study["share_carried"].sel(layers=layer)
            # a number of balls that was asked for at one friction only makes no curve
            asked = held.notnull().any("seed") if "seed" in held.dims else held.notnull()
            several = study["balls"].values[asked.sum("friction").values > 1]
            shown = several if several.size else study["balls"].values
            beside = 0.02 * float(np.ptp(study["friction"].values)) / max(len(shown) - 1, 1)
            for i, balls in enumerate(shown):
                # side by side, for most are at one end or the other
                friction = study["friction"] + (i - 0.5 * (len(shown) - 1)) * beside
                color = matplotlib.colormaps[COLORS](0.9 * i / max(len(shown) - 1, 1))
                _curve(panel, friction.rename("friction"), 100.0 * held.sel(balls=balls), color, f"{balls} balls")
            panel.set_title(NAMES.get(layer, layer))
            panel.set_xlabel("friction")
            panel.set_ylim(-4.0, 104.0)
            panel.legend(loc="best")
        axes[0].set_ylabel("balls carried (%)")
        heading(figure, title if title is not None else str(study.attrs.get("machine_name", "")))
    return figure


def _curve(panel: Axes, x: xr.DataArray, values: xr.DataArray, color: Any, label: str) -> None:
    """Values over ``x``; with a dimension ``seed`` their means and ranges."""
    if "seed" not in values.dims:
        values = values.expand_dims("seed")
    there = values.notnull().any("seed").values
    if not there.any():
        return
    kept = values.isel({str(x.name): there})
    mean = kept.mean("seed", skipna=True).values
    away = np.stack([mean - kept.min("seed", skipna=True).values, kept.max("seed", skipna=True).values - mean])
    bars = {"yerr": np.maximum(away, 0.0), "capsize": 2.0, "elinewidth": 0.8} if values.sizes["seed"] > 1 else {}
    panel.errorbar(x.values[there], mean, fmt="o-", ms=4, color=color, label=label, **bars)


def chamber_optimal_means(means: Given, *, measure: str = "vertical_amplitude", title: str = "") -> Figure:
    """Mean amplitudes of both chambers beside each other for each friction (Pakuła 2021, figure 12).

    ``means`` are those of :func:`optimal_means`, ``measure`` is one of their amplitudes, ``title`` stands above the picture.
    Bars show the spread over the seeds, where there are several.
    """
    means = result(
        means,
        "plot.chamber_optimal_means",
        "chamber.optimal_means",
        _are_means,
    )
    if measure not in means:
        raise QuestionError(f"measure: given {measure!r}; there are {', '.join(sorted(map(str, means.data_vars)))}")
    layers = [str(layer) for layer in means["layers"].values]
    unit = length_axis(None, float(np.nanmax(means[measure].values, initial=0.0)))
    place = np.arange(means.sizes["friction"])
    width = 0.8 / len(layers)
    with look():
        figure = picture(5.0, 3.4)
        panel = figure.subplots()
        for i, layer in enumerate(layers):
            values = means[measure].sel(layers=layer).values * unit.factor
            at = place + (i - 0.5 * (len(layers) - 1)) * width
            spread = means.get(f"{measure}_spread")
            error = None if spread is None else spread.sel(layers=layer).values * unit.factor
            bars = panel.bar(at, values, width, color=BALLS[i], label=NAMES.get(layer, layer), yerr=error, capsize=2.0)
            panel.bar_label(bars, fmt="%.3g", fontsize=8)
        panel.set_xticks(place, [f"{value:g}" for value in means["friction"].values])
        panel.set_xlabel("friction")
        panel.set_ylabel(f"mean amplitude ({unit.sign})")
        panel.grid(False, axis="x")
        legend(panel)
        heading(figure, title)
    return figure


def chamber_step_size(study: Given, *, title: str = "Central elastic collision") -> Figure:
    """Range and root mean square of the energy error over the step; the dashed line grows with the step to the power 2.5.

    Parameters
    ----------
    study
        From :func:`~autobalancer.chamber.step_size`, or the path of its file.
    title
        Above the picture.

    Returns
    -------
    matplotlib.figure.Figure
    """
    study = result(study, "plot.chamber_step_size", "chamber.step_size", lambda found: "phase_number" in found.dims)
    steps = study["step"].values
    speeds = study["relative_speed"].values
    beside = (
        np.linspace(-0.5, 0.5, len(speeds)) if len(speeds) > 1 else np.zeros(1)
    )  # errors of all speeds are much alike
    apart = 0.12 * float(np.log10(steps.max() / steps.min())) / max(len(steps) - 1, 1)
    with look():
        figure = picture(6.4, 4.6)
        panel = figure.subplots()
        for i, speed in enumerate(speeds):
            chosen, color = study.sel(relative_speed=speed), ball_color(i)
            shown = steps * 10.0 ** (2.0 * apart * beside[i])
            panel.plot(steps, 100.0 * chosen["typical_root_mean_square"], "--", lw=0.9, color=color)
            low, high = (100.0 * np.abs(chosen[bound].values) for bound in ("least", "greatest"))
            panel.plot(shown, 100.0 * chosen["root_mean_square"], "o", ms=4, color=color, label=f"{speed:g} m/s")
            panel.plot(shown, high, "^", ms=4, mfc="none", color=color)
            panel.plot(shown, low, "v", ms=4, mfc="none", color=color)
        panel.set_xscale("log")
        panel.set_yscale("log")
        panel.set_xlabel("step (s), points of one step side by side")
        panel.set_ylabel("energy error (%)")
        panel.plot([], [], "o", color=INK, ms=4, label="root mean square")
        panel.plot([], [], "^", color=INK, mfc="none", ms=4, label="greatest gain")
        panel.plot([], [], "v", color=INK, mfc="none", ms=4, label="greatest loss")
        panel.plot([], [], "--", color=INK, lw=0.9, label="theory, step to the power 2.5")
        panel.legend(loc="upper left")
        heading(figure, title)
    return figure


def chamber_archive(
    table: Given, x: str = "balls", y: str = "vertical_amplitude", by: str | None = None, *, log: bool = False
) -> Figure:
    """One value of the runs of an archive over another, in one color for each value of a third.

    Parameters
    ----------
    table
        From ``ab.chamber.Archive(folder).runs()``, or the path of its file.
    x, y, by
        Names of the values along both axes, and of the one that has its own colors.
    log
        Logarithmic scale of ``y``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If the table has no such value, or it is no number.
    """
    table = result(table, "plot.chamber_archive", "chamber archive", lambda found: "run" in found.dims)
    for name in (x, y, *([by] if by else [])):
        if name not in table:
            raise QuestionError(
                f"catalogue: given {name!r}; the runs have {', '.join(sorted(map(str, table.data_vars)))}"
            )
    for name in (x, y):
        if table[name].dtype == object:
            raise QuestionError(f"catalogue: {name!r} is a text; choose a number for an axis")
    with look():
        figure = picture(6.0, 4.0)
        panel = figure.subplots()
        along, up = _shown(table[x]), _shown(table[y])
        groups = [None] if by is None else sorted(set(table[by].values.tolist()), key=str)
        for i, group in enumerate(groups):
            mine = np.ones(table.sizes["run"], bool) if group is None else table[by].values == group
            order = np.argsort(along.values[mine])
            name = "" if by is None else by.replace("_", " ")
            label = None if group is None else f"{name} {group:g}" if isinstance(group, float) else f"{name} {group}"
            panel.plot(along.values[mine][order], up.values[mine][order], "o-", ms=4, color=ball_color(i), label=label)
        panel.set_xlabel(along.label)
        panel.set_ylabel(up.label)
        for axis, shown in ((panel.xaxis, along), (panel.yaxis, up)):
            if np.array_equal(shown.values, np.round(shown.values)) and not log:
                axis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
        if log:
            panel.set_yscale("log")
            plain_log_ticks(panel, "y")
        legend(panel)
        heading(figure, str(table.attrs.get("title", "")))
    return figure


def _shown(values: xr.DataArray) -> QuantityAxis:
    """Values and label of an axis; lengths in the unit that suits them."""
    if values.attrs.get("units") != "m":
        shown = quantity_axis(values, "rpm")
    else:
        unit = length_axis(None, float(np.nanmax(np.abs(values.values), initial=0.0)))
        shown = QuantityAxis(values.values * unit.factor, f"{values.name} ({unit.sign})", unit, False)
    return shown._replace(label=shown.label.replace("_", " "))


def _is_study(found: xr.Dataset) -> bool:
    return "layers" in found.dims and "balls" in found.dims


def _are_means(found: xr.Dataset) -> bool:
    return "layers" in found.dims and "balls" not in found.dims
