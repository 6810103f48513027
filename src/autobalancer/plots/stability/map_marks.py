"""Operating points and names of fluids on a stability map."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from autobalancer.plots.drawing.quantity_axis import QuantityAxis
from autobalancer.plots.drawing.style import INK

FAMILIES = ("silicone oil", "mineral oil", "water", "glycerol-water", "air")  # the first has the first choice of room


def operating_points(
    axes: Axes, found: xr.Dataset, dims: list[str], along: list[QuantityAxis], absent: list[str]
) -> list[Any]:
    """Marks with their keys; names of those outside go to ``absent``."""
    if "operating_point" not in found:
        return []
    markers, handles = "oDs^vP*X", []
    columns = [axis.unit.shown(found[f"operating_{dim}"].values) for dim, axis in zip(dims, along, strict=True)]
    for number, name in enumerate(found["operating_point"].values):
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


def fluid_names(axes: Axes, found: xr.Dataset, place: int, along: list[QuantityAxis]) -> None:
    """Names on the side opposite to the viscosity's own numbers, as many as have room."""
    axis = along[place]
    low, high = (np.log(v) if axis.log else v for v in (axis.values[0], axis.values[-1]))
    need = 0.034 if place == 1 else 0.03
    taken: list[float] = []
    names, families = found["fluid"].values, [str(word) for word in found["fluid_family"].values]
    shown = found["fluid_viscosity"].values * axis.unit.factor
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
