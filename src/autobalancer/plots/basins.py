"""Basins of attraction as a picture."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import xarray as xr
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator

from autobalancer.errors import QuestionError
from autobalancer.plots.axis_units import speed_axis
from autobalancer.plots.style import look, picture

COLORS = {
    "balanced": "#009E73",
    "coincident": "#D55E00",
    "in line": "#E69F00",
    "stalled": "#0072B2",
    "oscillating": "#56B4E9",
    "chaotic": "#CC79A7",
    "failed": "#222222",
    "overlapping start": "#E3E3E3",
}


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
        raise QuestionError("plot_basin: this is no result of basin()")
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


def _axis(values: xr.DataArray, speed_unit: str) -> tuple[np.ndarray, str]:
    label, unit = str(values.attrs["long_name"]), str(values.attrs["units"])
    if unit == "rad":
        return values.values * 180.0 / math.pi, f"{label} [deg]"
    if unit == "rad/s":
        shown = speed_axis(speed_unit)
        return values.values * shown.factor, f"{label} [{shown.sign}]"
    return values.values, f"{label} [{unit.replace('^2', '²')}]"


def _bars(found: xr.Dataset, share: dict[str, float], title: str) -> Figure:
    figure = picture(6.6, 2.8)
    axes = figure.add_subplot()
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
    axes.set_xlabel("share of the starts, with its 95 % interval [%]")
    axes.invert_yaxis()
    return figure
