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
from autobalancer.results.number_text import LENGTHS, length_text, moment_text
from autobalancer.results.verdict_rule import BALANCED, NO_VERDICT, NOT, PARTLY, WORSE

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
VERDICTS = {
    BALANCED: "#009E73",
    PARTLY: "#E69F00",
    NOT: "#D55E00",
    WORSE: "#8C2D04",
    NO_VERDICT: "#56B4E9",
    "failed": "#222222",
}


HELD = LinearSegmentedColormap.from_list("held", ["#EFECF7", "#7B68B5", "#2E1F66"])
FAR = 5.0  # times the greatest of the runs: farther away the value without balls is written, not drawn
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
    verdicts = "vibration" in found
    held = "residual_unbalance" in found and share.get("held by friction", 0.0) > 0.0
    drawn = ("residual_unbalance", "vibration") if verdicts else ("residual_unbalance",) if held else ()
    figure = picture(6.6, 4.8 if drawn else 2.8)
    grid = figure.add_gridspec(2 if drawn else 1, max(len(drawn), 1), height_ratios=(1.0, 2.2) if drawn else (1.0,))
    axes = figure.add_subplot(grid[0, :])
    for column, name in enumerate(drawn):
        _distribution(figure.add_subplot(grid[1, column]), found, name, first=column == 0)
    axes.set_title(f"{title}: {found['state'].size} random starts")
    axes.grid(False)
    names = [name for name, value in share.items() if value > 0.0]
    for place, name in enumerate(names):
        low, high = float(found["share_low"].sel(end=name)), float(found["share_high"].sel(end=name))
        axes.barh(place, 100 * share[name], color=(VERDICTS | COLORS)[name], height=0.6)
        axes.plot([100 * low, 100 * high], [place, place], color="#222222", linewidth=1.2, marker="|")
        axes.text(100 * high + 1.0, place, f"{100 * share[name]:.3g} %", va="center")
    axes.set_yticks(range(len(names)), names)
    axes.set_xlim(0.0, 112.0)
    axes.set_xlabel("share of the starts, with its 95 % interval (%)")
    axes.set_ylim(max(len(names), 2) - 0.5, -0.5)
    return figure


def _distribution(axes: Axes, found: xr.Dataset, quantity: str, *, first: bool) -> None:
    """Share of the starts that end below a residual unbalance or a vibration, with median and 95 %."""
    names = list(found.attrs["states"])
    vibrates, verdicts = quantity == "vibration", "vibration" in found
    counted = [name for name in names if name != "failed"] if verdicts else [name for name in names if name in AT_REST]
    chosen = np.isin(found["state"].values, [names.index(name) for name in counted])
    whole = float(found["vibration_without_balls" if vibrates else "unbalance"])
    left = np.sort(found[quantity].values[chosen])
    left = left[np.isfinite(left)]
    if not left.size:
        axes.set_axis_off()
        return
    farthest = (
        max(left[-1], whole) if whole < FAR * left[-1] else left[-1]
    )  # else the line is too far to show the curve
    factor, unit = _natural(farthest) if vibrates else (1e6, "g mm")
    text = length_text if vibrates else moment_text
    color = COLORS["held by friction"]
    axes.step(left * factor, 100.0 * np.arange(1, left.size + 1) / left.size, where="post", color=color)
    if whole <= farthest:
        axes.axvline(whole * factor, color=INK, linewidth=1.0, linestyle=(0, (5, 3)))
        right = whole > 0.5 * farthest
        place, words = whole * factor, "without balls"
    else:
        right, place, words = True, 1.05 * farthest * factor, f"without balls {text(whole)}"
    axes.annotate(
        words,
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
        )
    axes.set_xlim(0.0, 1.05 * farthest * factor)
    axes.set_ylim(0.0, 118.0)
    axes.set_xlabel(f"{quantity.replace('_', ' ')}{'' if verdicts else ' of the balls at rest'} ({unit})")
    if first:
        axes.set_ylabel("share of the starts (%)")


def _natural(length: float) -> tuple[float, str]:
    """Factor and unit in which a length is a number above one."""
    return next(((factor, sign) for sign, factor in LENGTHS[1:] if length * factor >= 1.0), (1e9, "nm"))
