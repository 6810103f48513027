"""Whirl orbits at stations and along the axis."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import CRITICAL, INK, UNBALANCE, heading, look, picture, with_ignored
from autobalancer.plots.rotor.campbell import WHIRL
from autobalancer.results.display_units import length_axis, length_text, significant, speed_axis
from autobalancer.results.given import Given, result

STRINGS = 12  # lines from end to end through points of one instant


def whirl_orbits(found: Given, *, deflection_unit: str | None = None, speed_unit: str = "rpm") -> Figure:
    """Draw the orbits at all stations to one scale, with their direction and the point at rotor angle zero.

    Parameters
    ----------
    found
        From :func:`~autobalancer.rotordynamics.orbits.whirl_orbits`.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``; by default what suits.
    speed_unit
        Of the title: ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Raises
    ------
    QuestionError
        If ``found`` are no whirl orbits, or a unit is unknown.
    """
    found = result(found, "plot.whirl_orbits", "rotor.whirl_orbits", _are_orbits)
    span = float(found["semi_major"].max())
    unit = length_axis(deflection_unit, span)
    count = found["station"].size
    columns = min(3, count)
    rows = -(-count // columns)
    with look():
        figure = picture(3.2 * columns + 0.4, 3.5 * rows + 0.7)
        figure.get_layout_engine().set(h_pad=0.1)  # type: ignore[union-attr, call-arg]
        heading(figure, _title(found, speed_unit))
        grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for number, axes in enumerate(grid.ravel()):
            if number >= count:
                axes.set_visible(False)
                continue
            station = found.isel(station=number)
            word = str(station["whirl"].item())
            x, y = station["x"].values * unit.factor, station["y"].values * unit.factor
            axes.set_aspect("equal")
            axes.plot(0.0, 0.0, "+", ms=8, color=CRITICAL, label="_rest")
            axes.plot(x, y, color=WHIRL[word], label="orbit")
            axes.plot(x[0], y[0], "o", ms=5, mfc="white", mec=UNBALANCE, mew=1.6, label="rotor angle 0")
            _arrow(axes, x, y, WHIRL[word])
            axes.set_title(f"{station['station'].item()}: {word}", color=WHIRL[word])
        reach = 1.12 * span * unit.factor or 1.0
        grid[0, 0].set_xlim(-reach, reach)
        grid[0, 0].set_ylim(-reach, reach)
        for axes in grid[-1]:
            axes.set_xlabel(f"x ({unit.sign})")
        for axes in grid[:, 0]:
            axes.set_ylabel(f"y ({unit.sign})")
    return figure


def whirl_along_axis(found: Given, *, deflection_unit: str | None = None, speed_unit: str = "rpm") -> Figure:
    """Draw the orbits along the axis in space: the surface on which the axis runs, and the axis at rotor angle zero.

    Parameters
    ----------
    found, deflection_unit, speed_unit
        As for ``ab.plot.whirl_orbits``.

    Raises
    ------
    QuestionError
        If ``found`` are no whirl orbits, the rotor has one plane only, or a unit is unknown.
    """
    found = result(found, "plot.whirl_along_axis", "rotor.whirl_orbits", _are_orbits)
    if found["place"].size < 2:
        raise QuestionError("plot.whirl_along_axis: the rotor has one plane only; draw it with plot.whirl_orbits")
    place = found["place"].values * 1e3
    x, y = found["axis_x"].values, found["axis_y"].values
    unit = length_axis(deflection_unit, float(np.hypot(x, y).max()))
    x, y = x * unit.factor, y * unit.factor
    known = np.isfinite(found["position"].values)
    with look():
        figure = picture(8.2, 4.8)
        axes = figure.add_subplot(projection="3d")
        axes.set_box_aspect((2.4, 1.0, 1.0))
        step = max(1, (x.shape[1] - 1) // STRINGS)
        for i in range(0, x.shape[1] - 1, step):
            axes.plot(place, x[:, i], y[:, i], color=INK, lw=0.4, alpha=0.35)
        axes.plot(place, x[:, 0], y[:, 0], color=UNBALANCE, lw=1.8, label="rotor angle 0")
        axes.plot(place[[0, -1]], [0.0, 0.0], [0.0, 0.0], color=CRITICAL, lw=0.8, ls=(0, (5, 3)), label="at rest")
        named: set[str] = set()
        reach = float(np.hypot(x, y).max()) or 1.0
        for number in np.flatnonzero(known):
            station = found.isel(station=int(number))
            at = np.full(found["rotor_angle"].size, 1e3 * float(station["position"]))
            word = str(station["whirl"].item())
            ring = station["x"].values * unit.factor, station["y"].values * unit.factor
            name = f"{station['station'].item()}, {length_text(float(station['semi_major']))}"
            axes.plot(at, *ring, color=WHIRL[word], lw=1.6, label="_" if word in named else f"{word} whirl")
            named.add(word)
            axes.text(at[0], 0.0, 1.12 * reach, name, ha="center", fontsize=8.5, color=INK)
            head, tip = at.size // 12, at.size // 12 + max(1, at.size // 24)
            axes.quiver(
                at[0], ring[0][head], ring[1][head], 0.0, *(float(r[tip] - r[head]) for r in ring),
                color=WHIRL[word], arrow_length_ratio=1.0,
            )  # fmt: skip
        axes.set_ylim(-reach, reach)
        axes.set_zlim(-reach, reach)
        axes.set_xlabel("position along the axis (mm)", labelpad=14)
        axes.set_ylabel(f"x ({unit.sign})", labelpad=8)
        axes.set_zlabel(f"y ({unit.sign})")
        for axis in (axes.yaxis, axes.zaxis):
            axis.set_major_locator(MaxNLocator(5))
        heading(figure, f"{_title(found, speed_unit)}\nnumbers: greatest deflection of the station")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


def _are_orbits(found: xr.Dataset) -> bool:
    return "axis_x" in found and "rotor_angle" in found.dims


def _title(found: xr.Dataset, speed_unit: str) -> str:
    unit = speed_axis(speed_unit)
    title = f"{found.attrs.get('title', '')} at {significant(found.attrs['speed'] * unit.factor)} {unit.sign}"
    return with_ignored(title, found.attrs)


def _arrow(axes: Axes, x: np.ndarray, y: np.ndarray, color: str) -> None:
    """An arrow head an eighth of a turn after the start."""
    i = max(1, x.size // 8)
    if np.hypot(x[i + 1] - x[i - 1], y[i + 1] - y[i - 1]) == 0.0:
        return
    axes.annotate(
        "",
        (x[i + 1], y[i + 1]),
        xytext=(x[i - 1], y[i - 1]),
        arrowprops={"arrowstyle": "-|>,head_length=0.8,head_width=0.35", "color": color, "shrinkA": 0, "shrinkB": 0},
    )
