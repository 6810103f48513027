"""Basins of attraction as a picture."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator

from autobalancer.errors import QuestionError
from autobalancer.plots.axis_units import speed_axis
from autobalancer.plots.style import CRITICAL, INK, look, picture
from autobalancer.results.number_text import moment_text

COLORS = {
    "balanced": "#009E73",
    "coincident": "#D55E00",
    "in line": "#E69F00",
    "held by friction": "#7B68B5",
    "stalled": "#0072B2",
    "oscillating": "#56B4E9",
    "chaotic": "#CC79A7",
    "failed": "#222222",
    "overlapping start": "#E3E3E3",
}


HELD = LinearSegmentedColormap.from_list("held", ["#EFECF7", "#7B68B5", "#2E1F66"])
AT_REST = ("balanced", "coincident", "in line", "held by friction")


def plot_basin(found: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
    """The end state over the starts: a map for two axes, a strip for one, bars for random starts.

    Parameters
    ----------
    found
        From :func:`autobalancer.basin`.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If ``found`` holds no basin.
    """
    if "state" not in found or "states" not in found.attrs:
        raise QuestionError("plot_basin: this is not a result of basin()")
    unit = speed_axis(speed_unit)
    names = list(found.attrs["states"])
    share = {name: float(found["share"].sel(end=name)) for name in names}
    title = f"{found.attrs['machine_name']} at {found.attrs['speed'] * unit.factor:.4g} {unit.sign}"
    axes_names = [str(dim) for dim in found["state"].dims if dim != "run"]
    with look():
        if not axes_names:
            return _bars(found, share, title)
        figure = picture(6.6, 5.6 if len(axes_names) == 2 else 2.4)
        axes = figure.add_subplot()
        axes.set_title(title)
        axes.grid(False)
        colors = ListedColormap([COLORS[name] for name in names])
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
        there = set(np.unique(found["state"].values))
        handles = [
            Patch(color=COLORS[name], label=f"{name} {100 * share[name]:.3g} %" if share[name] else name)
            for number, name in enumerate(names)
            if number in there
        ]
        figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 4))
        if len(axes_names) == 2 and all("angle" in name for name in axes_names):
            axes.set_aspect("equal")
            axes.xaxis.set_major_locator(MultipleLocator(90))
            axes.yaxis.set_major_locator(MultipleLocator(90))
    return figure


def _shade(
    figure: Figure,
    axes: Axes,
    found: xr.Dataset,
    held: int,
    x: np.ndarray,
    y: np.ndarray,
    shading: Literal["nearest", "auto"],
) -> None:
    """Held states by what they leave: the darker, the more of the unbalance."""
    left = 100.0 * found["residual_unbalance"].values / max(float(found["unbalance"]), 1e-300)
    left = np.where(found["state"].values == held, left, np.nan)
    left = left if left.ndim == 2 else np.column_stack([left, left])
    drawn = axes.pcolormesh(x, y, left.T, cmap=HELD, vmin=0.0, vmax=100.0, shading=shading, rasterized=True)
    extend = "max" if np.nanmax(left) > 100.0 else "neither"
    bar = figure.colorbar(drawn, ax=axes, pad=0.02, fraction=0.05, extend=extend)
    bar.set_label("residual unbalance (%)" if found["state"].ndim == 2 else "residual\nunbalance (%)")
    bar.outline.set_visible(False)


def _axis(values: xr.DataArray, speed_unit: str) -> tuple[np.ndarray, str]:
    label, unit = str(values.attrs["long_name"]), str(values.attrs["units"])
    if unit == "rad":
        return values.values * 180.0 / math.pi, f"{label} (°)"
    if unit == "rad/s":
        shown = speed_axis(speed_unit)
        return values.values * shown.factor, f"{label} ({shown.sign})"
    return values.values, f"{label} ({unit.replace('^2', '²')})"


def _bars(found: xr.Dataset, share: dict[str, float], title: str) -> Figure:
    several = "residual_unbalance" in found and share.get("held by friction", 0.0) > 0.0
    figure = picture(6.6, 4.8 if several else 2.8)
    grid = figure.add_gridspec(2, 1, height_ratios=(1.0, 2.2)) if several else figure.add_gridspec(1, 1)
    axes = figure.add_subplot(grid[0])
    if several:
        _distribution(figure.add_subplot(grid[1]), found)
    axes.set_title(f"{title}: {found['state'].size} random starts")
    axes.grid(False)
    names = [name for name, value in share.items() if value > 0.0]
    for place, name in enumerate(names):
        low, high = float(found["share_low"].sel(end=name)), float(found["share_high"].sel(end=name))
        axes.barh(place, 100 * share[name], color=COLORS[name], height=0.6)
        axes.plot([100 * low, 100 * high], [place, place], color="#222222", linewidth=1.2, marker="|")
        axes.text(100 * high + 1.0, place, f"{100 * share[name]:.3g} %", va="center")
    axes.set_yticks(range(len(names)), names)
    axes.set_xlim(0.0, 112.0)
    axes.set_xlabel("share of the starts, with its 95 % interval (%)")
    axes.set_ylim(max(len(names), 2) - 0.5, -0.5)
    return figure


def _distribution(axes: Axes, found: xr.Dataset) -> None:
    """Share of the starts that end below a residual unbalance, with median and 95 %."""
    names = list(found.attrs["states"])
    resting = np.isin(found["state"].values, [names.index(name) for name in AT_REST if name in names])
    left = np.sort(found["residual_unbalance"].values[resting]) * 1e6
    axes.step(left, 100.0 * np.arange(1, left.size + 1) / left.size, where="post", color=COLORS["held by friction"])
    whole = float(found["unbalance"]) * 1e6
    axes.axvline(whole, color=INK, linewidth=1.0, linestyle=(0, (5, 3)))
    farthest = max(float(left[-1]), whole)
    axes.annotate(
        "without balls",
        (whole, 107.0),
        (-4.0 if whole > 0.5 * farthest else 4.0, 0.0),
        textcoords="offset points",
        ha="right" if whole > 0.5 * farthest else "left",
        color=INK,
    )
    for share in (0.5, 0.95):
        value = float(np.quantile(left, share))
        axes.plot([0.0, value, value], [100 * share, 100 * share, 0.0], color=CRITICAL, linewidth=0.8, zorder=1)
        right = value > 0.5 * farthest
        axes.annotate(
            f"{100 * share:.0f} % below {moment_text(value * 1e-6)}",
            (value, 100 * share),
            (-6.0, 4.0) if right else (8.0, -14.0),  # off the curve
            textcoords="offset points",
            ha="right" if right else "left",
        )
    axes.set_xlim(0.0, 1.05 * farthest)
    axes.set_ylim(0.0, 118.0)
    axes.set_xlabel("residual unbalance of the balls at rest (g mm)")
    axes.set_ylabel("share of the starts (%)")
