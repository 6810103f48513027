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

from autobalancer.plots.drawing.style import look, picture, with_ignored
from autobalancer.plots.stability.basin_shares import COLORS, VERDICTS, shares_of_ends
from autobalancer.results.display_units import speed_axis
from autobalancer.results.given import Given, result

WIDE = 72  # letters of four keys side by side that do not fit the picture
HELD = LinearSegmentedColormap.from_list("held", ["#EFECF7", "#7B68B5", "#2E1F66"])


def basin(found: Given, *, speed_unit: str = "rpm") -> Figure:
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
    found = result(found, "plot.basin", "basin", lambda it: "state" in it and "states" in it.attrs)
    unit = speed_axis(speed_unit)
    names = list(found.attrs["states"])
    share = {name: float(found["share"].sel(end=name)) for name in names}
    title = f"{found.attrs['machine_name']} at {found.attrs['speed'] * unit.factor:.4g} {unit.sign}"
    title = with_ignored(title, found.attrs)
    axes_names = [str(dim) for dim in found["state"].dims if dim != "run"]
    with look():
        if not axes_names:
            return shares_of_ends(found, title)
        figure = picture(6.6, 5.6 if len(axes_names) == 2 else 2.4)
        axes = figure.add_subplot()
        axes.set_title(title)
        axes.grid(False)
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


def _verdicts(found: xr.Dataset) -> str:
    """The shares of the verdicts in one line; empty without unbalance."""
    if "verdict_share" not in found or not float(found["unbalance"]) > 0.0:
        return ""
    shares = {str(word): float(found["verdict_share"].sel(verdict=word)) for word in found["verdict"].values}
    return "Verdict: " + ", ".join(f"{word} {100 * share:.3g} %" for word, share in shares.items() if share > 0.0)


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
