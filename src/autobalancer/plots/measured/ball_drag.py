"""The flow around a ball in its race, and its drag over the Reynolds number."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray

from autobalancer.plots.drawing.style import FILL, INK, ball_color, heading, look, picture
from autobalancer.results.given import Given, result

Floats = NDArray[np.float64]


def ball_drag(found: Given) -> Figure:
    """Draw the flow in the plane of the ball centers, seen from the ball, and c_d Re over the Reynolds number.

    Parameters
    ----------
    found
        From :func:`~autobalancer.flow.ball_drag`; the flow is that at its last Reynolds number.

    Returns
    -------
    matplotlib.figure.Figure
    """
    found = result(found, "plot.ball_drag", "flow.ball_drag", lambda one: "cd_re" in one and "velocity_x" in one)
    moving = found["reynolds"].values > 0.0
    with look():
        figure = picture(8.2, 6.4 if moving.any() else 3.6)
        panels = figure.subplots(
            2 if moving.any() else 1, 1, squeeze=False, height_ratios=[1.25, 1][: 1 + moving.any()]
        )
        _flow(figure, panels[0, 0], found)
        if moving.any():
            _curve(panels[1, 0], found, moving)
        heading(figure, str(found.attrs["title"]))
    return figure


def _flow(figure: Figure, axes: Axes, found: xr.Dataset) -> None:
    x, y = found["x"].values * 1e3, found["y"].values * 1e3
    u, v = found["velocity_x"].values.T, found["velocity_y"].values.T
    speed = np.ma.masked_invalid(np.hypot(u, v))
    shade = axes.pcolormesh(x, y, speed, cmap="cividis", shading="gouraud", rasterized=True, vmin=0.0)
    axes.streamplot(
        x,
        y,
        np.ma.masked_invalid(u),
        np.ma.masked_invalid(v),
        color="white",
        linewidth=0.7,
        density=(1.6, 0.9),
        arrowsize=0.7,
    )
    radius = 0.5e3 * float(found.attrs["ball_diameter"])
    for center in _centers(found):
        axes.add_patch(Circle(center, radius, facecolor=FILL, edgecolor=INK, lw=0.9, zorder=5))
    for wall, beyond in zip(_walls(found, x), (y[0] - radius, y[-1] + radius), strict=True):
        axes.fill_between(x, wall, beyond, color="white", lw=0.0, zorder=2.2)
        axes.plot(x, wall, color=INK, lw=1.6, zorder=2.3)
    axes.set_aspect("equal")
    axes.grid(False)
    axes.set_xlim(x[0], x[-1])
    axes.set_ylim(y[0] - 0.05 * radius, y[-1] + 0.05 * radius)
    axes.set_xlabel("ahead of the ball (mm); outer wall below")
    axes.set_ylabel("inward (mm)")
    axes.set_title(f"seen from the ball, Re = {float(found['reynolds'][-1]):.4g}", fontsize=9.0)
    figure.colorbar(shade, ax=axes, label="speed over that of the ball", shrink=0.8)


def _centers(found: xr.Dataset) -> list[tuple[float, float]]:
    """Of the balls, mm."""
    orbit, along = 1e3 * float(found.attrs["orbit_radius"]), 1e3 * float(found.attrs["ball_ahead"])
    if np.isnan(along):
        return [(0.0, 0.0)]
    angle = along / orbit
    return [(0.0, 0.0), (orbit * np.sin(angle), orbit * (1.0 - np.cos(angle))) if np.isfinite(orbit) else (along, 0.0)]


def _walls(found: xr.Dataset, x: Floats) -> list[Floats]:
    """Both walls over x, mm."""
    attrs = found.attrs
    radius, orbit = 0.5e3 * float(attrs["ball_diameter"]), 1e3 * float(attrs["orbit_radius"])
    outer = radius * (1.0 + float(attrs["mesh_gap"]))
    depths = [0.0, 1e3 * float(attrs["width"])]
    if not np.isfinite(orbit):
        return [np.full(x.size, depth - outer) for depth in depths]
    return [orbit - np.sqrt(np.maximum((orbit + outer - depth) ** 2 - x**2, 0.0)) for depth in depths]


def _curve(axes: Axes, found: xr.Dataset, moving: NDArray[np.bool_]) -> None:
    re, cd_re = found["reynolds"].values, found["cd_re"].values
    axes.plot(re[moving], cd_re[moving], "o-", color=ball_color(0), label="with inertia of the fluid")
    if not moving.all():
        axes.axhline(cd_re[0], color=INK, ls="--", lw=0.9, label="without")
    axes.set_xscale("log")
    axes.set_xticks(re[moving], [f"{number:.4g}" for number in re[moving]])
    axes.minorticks_off()
    axes.set_ylim(0.0, 1.15 * float(cd_re.max()))
    axes.set_xlabel("Reynolds number of the ball")
    axes.set_ylabel(r"$c_d\,\mathrm{Re}$")
    axes.set_title(f"gap of {1e6 * float(found.attrs['gap']):.3g} µm", fontsize=9.0)
    axes.legend(loc="lower left")
