"""The border curves on a stability map, and where friction holds balls.

Each function draws, returns the keys of what it drew, and appends to ``absent`` in words what is not in the picture.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from autobalancer.plots.drawing.quantity_axis import QuantityAxis
from autobalancer.plots.drawing.style import CRITICAL, INK
from autobalancer.plots.stability.border_curve import BORDERS

STALLED = ("release_speed", "capture_speed")


def borders_on_map(
    axes: Axes, found: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]
) -> list[Any]:
    """The border curves over the other axis; without the speed as an axis the zero of the growth rate."""
    if "speed" not in dims:
        limit = _limit(axes, found, dims, along, absent)
        return [*limit, *(one for name in STALLED for one in _stalled(axes, found, dims, along, name, absent))]
    place = dims.index("speed")
    other = dims[1 - place]
    coordinate = f"{other}_of_border"
    if coordinate not in found:
        return []
    values, unit = along[1 - place].unit.shown(found[coordinate].values), along[place].unit
    high = 1e3 * float(along[place].values[-1])
    handles: list[Any] = []
    lines = {"critical_speed": {"color": CRITICAL, "lw": 1.0, "ls": (0, (5, 3)), "label": "critical speed"}, **BORDERS}
    for name, style in lines.items():
        if name not in found or np.isnan(found[name].values).all():
            continue
        speeds = found[name].values * unit.factor
        drawn = np.where(np.isposinf(speeds), high, speeds)
        inside = np.isfinite(speeds) & (speeds >= along[place].values[0]) & (speeds <= along[place].values[-1])
        if not inside.any():
            absent.append(f"{style['label']} ({_where(speeds, along[place].values)})")
            continue
        axes.plot(*((drawn, values) if place == 0 else (values, drawn)), **style)
        handles.append(Line2D([], [], **style))
    return handles


def _limit(axes: Axes, found: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]) -> list[Any]:
    """The line on which the growth rate is zero."""
    rates = found["growth_rate"].transpose(*dims).values
    known = rates[np.isfinite(rates)]
    if not known.size or known.max() < 0.0 or known.min() > 0.0:
        if known.size:
            absent.append(f"limit of stability ({'stable' if known.max() < 0.0 else 'unstable'} everywhere)")
        return []
    axes.contour(along[0].values, along[1].values, rates.T, levels=[0.0], colors=INK, linewidths=2.0)
    return [Line2D([], [], color=INK, lw=2.0, label="limit of stability, full equations")]


def held_on_map(
    axes: Axes, found: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]
) -> list[Any]:
    """Hatched where the unbalance alone does not move balls that friction holds."""
    if "held_share" not in found:
        return []
    shares = found["held_share"].transpose(*(f"{dim}_of_friction" for dim in dims))
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
    axes: Axes, found: xr.Dataset, dims: list[str], along: list[QuantityAxis], name: str, absent: list[str]
) -> list[Any]:
    """Where the speed of the map is that border of stalled balls; nan where no ball stalls."""
    if name not in found or "speed" not in found.attrs:
        return []
    speed, style = float(found.attrs["speed"]), BORDERS[name]
    rates = found[name].transpose(*(f"{dim}_of_border" for dim in dims))
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
