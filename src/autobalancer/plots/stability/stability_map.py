"""Stability maps: growth rate over two parameters, with the border speeds by their names."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.quantity_axis import QuantityAxis, plain_log_ticks, quantity_axis
from autobalancer.plots.drawing.style import legend_below, look, picture
from autobalancer.plots.stability.map_borders import borders_on_map, held_on_map
from autobalancer.plots.stability.map_marks import fluid_names, operating_points
from autobalancer.results.display_units import round_down, speed_axis
from autobalancer.results.given import Given, result

COLORS = LinearSegmentedColormap.from_list(
    "growth",
    [
        (0.0, "#2F8F6B"),
        (0.35, "#A5D6C0"),
        (0.4999, "#EAF6F0"),
        (0.5001, "#FDEDE4"),
        (0.65, "#F5B999"),
        (1.0, "#C9501F"),
    ],
)


def map(
    found: Given,
    *,
    speed_unit: str = "rpm",
    x: str | None = None,
    fluids: bool = True,
    title: str | None = None,
) -> Figure:
    """Draw a stability map: contours of the growth rate, border speeds, fluids and operating points.

    Green is stable, red unstable, gray where there is no balanced state. Each border has its own line and its name in
    the legend; one that lies outside is named above the keys. The exact one is the speed above which all is green; stable
    windows below it are green as well.

    Parameters
    ----------
    found
        From :func:`autobalancer.stability.map`.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    x
        Which parameter is along x, as a dimension of ``found``; by default the first.
    fluids
        Name fluids of the catalog along a viscosity.
    title
        By default that of ``found``.

    Raises
    ------
    QuestionError
        If ``found`` is no map, has fewer than two values along an axis, or ``x`` is no parameter of it.
    """
    found = result(found, "plot.map", "stability.map", lambda it: "growth_rate" in it and it["growth_rate"].ndim == 2)
    speed_axis(speed_unit)
    dims = [str(dim) for dim in found["growth_rate"].dims]
    if x is not None and x not in dims:
        raise QuestionError(f"x: given {x!r}; must be one of {', '.join(dims)}")
    if min(found["growth_rate"].shape) < 2:
        raise QuestionError("plot.map: the map has one value along an axis; ask for several")
    if x is not None and x != dims[0]:
        dims = dims[::-1]
    found = found.sortby(dims)
    along = [quantity_axis(found[dim], speed_unit) for dim in dims]
    with look():
        figure = picture(8.4, 6.0)
        axes = figure.add_subplot()
        axes.grid(False)
        handles = _growth(figure, axes, found, dims, along)
        for axis, which in zip(along, ("x", "y"), strict=True):
            if axis.log:
                (axes.set_xscale if which == "x" else axes.set_yscale)("log")
                plain_log_ticks(axes, which)
        axes.set_xlabel(along[0].label)
        axes.set_ylabel(along[1].label)
        absent: list[str] = []
        handles += borders_on_map(axes, found, dims, along, absent)
        handles += held_on_map(axes, found, dims, along, absent)
        handles += operating_points(axes, found, dims, along, absent)
        if fluids and "fluid" in found and "viscosity" in dims:
            fluid_names(axes, found, dims.index("viscosity"), along)
        axes.set_xlim(along[0].values[0], along[0].values[-1])
        axes.set_ylim(along[1].values[0], along[1].values[-1])
        fixed = (
            f" at {found.attrs['speed'] * speed_axis(speed_unit).factor:.4g} {speed_unit}"
            if "speed" in found.attrs
            else ""
        )
        figure.suptitle(title or f"{found.attrs['title']}{fixed}", fontsize=10.5, weight="bold", x=0.02, ha="left")
        legend_below(figure, handles, absent)
    return figure


def _growth(figure: Figure, axes: Axes, found: xr.Dataset, dims: list[str], along: list[QuantityAxis]) -> list[Any]:
    """Filled contours with the same steps on both sides of zero, and a bar."""
    rates = found["growth_rate"].transpose(*dims).values
    known = rates[np.isfinite(rates)]
    handles: list[Any] = []
    if known.size < rates.size:
        axes.set_facecolor("#D5D5D5")
        handles.append(Patch(color="#D5D5D5", label="no balanced state"))
    if not known.size:
        return handles
    sides = [np.quantile(np.abs(side), 0.97) for side in (known[known < 0.0], known[known > 0.0]) if side.size]
    top = round_down(max(float(max(sides, default=1.0)), 1e-12))
    steps = top * np.array([0.05, 0.1, 0.2, 0.5, 1.0])
    levels = np.concatenate([-steps[::-1], [0.0], steps])
    drawn = axes.contourf(
        along[0].values,
        along[1].values,
        np.clip(rates, -10 * top, 10 * top).T,
        levels=levels,
        cmap=COLORS,
        norm=BoundaryNorm(levels, 256, extend="both"),
        extend="both",
    )
    drawn.set_rasterized(True)
    bar = figure.colorbar(drawn, ax=axes, pad=0.02, fraction=0.05, spacing="uniform")
    bar.set_ticks(list(levels))
    bar.set_ticklabels([f"{level:g}" for level in levels])
    ignored = found.attrs.get("ignores", "")
    bar.set_label("growth rate (1/s), stable below zero" + (f",\nignores {ignored}" if ignored else ""))
    bar.outline.set_visible(False)
    return handles
