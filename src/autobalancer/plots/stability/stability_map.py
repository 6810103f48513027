"""Stability maps: growth rate over two parameters, with the border speeds by their names."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.axes import QuantityAxis, plain_log_ticks, quantity_axis
from autobalancer.plots.drawing.style import CRITICAL, INK, legend_below, look, picture
from autobalancer.plots.stability.border_curve import BORDERS
from autobalancer.results.display_units import round_down, speed_axis
from autobalancer.results.run_argument import Given, result

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


def _growth(figure: Figure, axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis]) -> list[Any]:
    """Filled contours with the same steps on both sides of zero, and a bar."""
    rates = dataset["growth_rate"].transpose(*dims).values
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
    ignored = dataset.attrs.get("ignores", "")
    bar.set_label("growth rate (1/s), stable below zero" + (f",\nignores {ignored}" if ignored else ""))
    bar.outline.set_visible(False)
    return handles


# Operating points and names of fluids on a stability map.


FAMILIES = ("silicone oil", "mineral oil", "water", "glycerol-water", "air")  # the first has the first choice of room


def operating_points(
    axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]
) -> list[Any]:
    """Marks with their keys; names of those outside go to ``absent``."""
    if "operating_point" not in dataset:
        return []
    markers, handles = "oDs^vP*X", []
    columns = [axis.unit.shown(dataset[f"operating_{dim}"].values) for dim, axis in zip(dims, along, strict=True)]
    for number, name in enumerate(dataset["operating_point"].values):
        px, py = float(columns[0][number]), float(columns[1][number])
        inside = all(a.values[0] <= v <= a.values[-1] for a, v in zip(along, (px, py), strict=True))
        if not inside:
            absent.append(f"{name} (outside)")
            continue
        style: dict[str, Any] = {
            "marker": markers[number % len(markers)],
            "ms": 7.5,
            "mfc": "white",
            "mec": INK,
            "mew": 1.5,
        }
        axes.plot(px, py, ls="none", zorder=5, clip_on=False, **style)
        handles.append(Line2D([], [], ls="none", **style, label=f"{name}"))
    return handles


def fluid_names(axes: Axes, dataset: xr.Dataset, place: int, along: list[QuantityAxis]) -> None:
    """Names on the side opposite to the viscosity's own numbers, as many as have room."""
    axis = along[place]
    low, high = (np.log(v) if axis.log else v for v in (axis.values[0], axis.values[-1]))
    need = 0.034 if place == 1 else 0.03
    taken: list[float] = []
    names, families = dataset["fluid"].values, [str(word) for word in dataset["fluid_family"].values]
    shown = dataset["fluid_viscosity"].values * axis.unit.factor
    order = sorted(
        range(len(names)),
        key=lambda i: (FAMILIES.index(families[i]) if families[i] in FAMILIES else 9, "(" in str(names[i])),
    )
    for i in order:
        value = float(shown[i])
        at = ((np.log(value) if axis.log else value) - low) / (high - low)
        if not 0.0 <= at <= 1.0 or any(abs(at - other) < need for other in taken):
            continue
        taken.append(at)
        name = str(names[i])
        if place == 1:
            axes.annotate(
                name,
                (1.0, value),
                xycoords=("axes fraction", "data"),
                xytext=(6, 0),
                textcoords="offset points",
                va="center",
                fontsize=7.5,
            )
            axes.plot(
                [1.0, 1.012], [value, value], transform=axes.get_yaxis_transform(), color=INK, lw=0.8, clip_on=False
            )
        else:
            axes.annotate(
                name,
                (value, 1.0),
                xycoords=("data", "axes fraction"),
                xytext=(0, 6),
                textcoords="offset points",
                ha="center",
                va="bottom",
                rotation=90,
                fontsize=7.5,
            )
            axes.plot(
                [value, value], [1.0, 1.014], transform=axes.get_xaxis_transform(), color=INK, lw=0.8, clip_on=False
            )


# The border curves on a stability map, and where friction holds balls.
#
# Each function draws, returns the keys of what it drew, and appends to ``absent`` in words what is not in the
# picture.


STALLED = ("release_speed", "capture_speed")


def borders_on_map(
    axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]
) -> list[Any]:
    """The border curves over the other axis; without the speed as an axis the zero of the growth rate."""
    if "speed" not in dims:
        limit = _limit(axes, dataset, dims, along, absent)
        return [*limit, *(one for name in STALLED for one in _stalled(axes, dataset, dims, along, name, absent))]
    place = dims.index("speed")
    other = dims[1 - place]
    coordinate = f"{other}_of_border"
    if coordinate not in dataset:
        return []
    values, unit = along[1 - place].unit.shown(dataset[coordinate].values), along[place].unit
    high = 1e3 * float(along[place].values[-1])
    handles: list[Any] = []
    lines = {"critical_speed": {"color": CRITICAL, "lw": 1.0, "ls": (0, (5, 3)), "label": "critical speed"}, **BORDERS}
    for name, style in lines.items():
        if name not in dataset or np.isnan(dataset[name].values).all():
            continue
        speeds = dataset[name].values * unit.factor
        drawn = np.where(np.isposinf(speeds), high, speeds)
        inside = np.isfinite(speeds) & (speeds >= along[place].values[0]) & (speeds <= along[place].values[-1])
        if not inside.any():
            absent.append(f"{style['label']} ({_where(speeds, along[place].values)})")
            continue
        axes.plot(*((drawn, values) if place == 0 else (values, drawn)), **style)
        handles.append(Line2D([], [], **style))
    return handles


def _limit(axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]) -> list[Any]:
    """The line on which the growth rate is zero."""
    rates = dataset["growth_rate"].transpose(*dims).values
    known = rates[np.isfinite(rates)]
    if not known.size or known.max() < 0.0 or known.min() > 0.0:
        if known.size:
            absent.append(f"limit of stability ({'stable' if known.max() < 0.0 else 'unstable'} everywhere)")
        return []
    axes.contour(along[0].values, along[1].values, rates.T, levels=[0.0], colors=INK, linewidths=2.0)
    return [Line2D([], [], color=INK, lw=2.0, label="limit of stability, full equations")]


def held_on_map(
    axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]
) -> list[Any]:
    """Hatched where the unbalance alone does not move balls that friction holds."""
    if "held_share" not in dataset:
        return []
    shares = dataset["held_share"].transpose(*(f"{dim}_of_friction" for dim in dims))
    text = "friction holds balls at rest"
    if (shares.values < 1.0).all():
        absent.append(f"where {text} (nowhere)")
        return []
    if min(shares.shape) > 1:
        x, y = (axis.unit.shown(shares[f"{dim}_of_friction"].values) for dim, axis in zip(dims, along, strict=True))
        over = np.log(np.clip(shares.values, 1e-6, 1e6)).T
        drawn = axes.contourf(x, y, over, levels=[0.0, 1e3], colors="none", hatches=["//"], zorder=3)
        drawn.set_edgecolor(INK)
        drawn.set_linewidth(0.0)
        axes.contour(x, y, over, levels=[0.0], colors=INK, linewidths=1.0, zorder=3)
    everywhere = ": everywhere" if (shares.values >= 1.0).all() else ""
    return [Patch(fc="none", ec=INK, lw=0.6, hatch="//", label=f"{text}{everywhere}")]


def _stalled(
    axes: Axes, dataset: xr.Dataset, dims: list[str], along: list[QuantityAxis], name: str, absent: list[str]
) -> list[Any]:
    """Where the speed of the map is that border of stalled balls; nan where no ball stalls."""
    if name not in dataset or "speed" not in dataset.attrs:
        return []
    speed, style = float(dataset.attrs["speed"]), BORDERS[name]
    rates = dataset[name].transpose(*(f"{dim}_of_border" for dim in dims))
    if np.isnan(rates.values).all():
        return []
    over = np.log(np.clip(np.nan_to_num(rates.values, nan=0.0, posinf=np.inf), 0.1 * speed, 10.0 * speed) / speed)
    label = f"{style['label']} as high as the speed of the map"
    if (over > 0.0).all() or (over <= 0.0).all():
        side = "above" if over.min() > 0.0 else "below"
        absent.append(f"{style['label']} ({side} the speed of the map everywhere)")
        return []
    x, y = (axis.unit.shown(rates[f"{dim}_of_border"].values) for dim, axis in zip(dims, along, strict=True))
    axes.contour(x, y, over.T, levels=[0.0], colors=style["color"], linewidths=style["lw"], linestyles=[style["ls"]])
    return [Line2D([], [], **{**style, "label": label})]


def _where(speeds: np.ndarray, shown: np.ndarray) -> str:
    finite = speeds[np.isfinite(speeds)]
    if not finite.size:
        return "never"
    return "above it" if finite.min() > shown[-1] else "below it"
