"""Mode shapes along the axis."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, heading, look, picture, with_ignored
from autobalancer.results.display_units import speed_axis
from autobalancer.results.given import Given, result


def modes(found: Given, *, frequency_unit: str = "Hz", modes: int = 6) -> Figure:
    """Draw the lowest mode shapes: deflection along x and y over the axis, at the instant of greatest deflection.

    Shaded is the greatest deflection in the course of a whirl, dots are the stations. Above each shape stand its name,
    natural frequency, damping ratio and direction of whirl.

    Parameters
    ----------
    found
        From ``ab.rotor.modes``.
    frequency_unit
        ``"Hz"``, ``"rad/s"`` or ``"rpm"``.
    modes
        How many.

    Raises
    ------
    QuestionError
        If ``found`` is no result of ``ab.rotor.modes``, or the unit is unknown.
    """
    found = result(found, "plot.modes", "rotor.modes", lambda it: "x_real" in it and "mode" in it.dims)
    if modes < 1:
        raise QuestionError(f"modes: given {modes}; must be at least 1")
    unit = speed_axis(frequency_unit)
    count = min(modes, found["mode"].size)
    columns = min(2, count)
    rows = -(-count // columns)
    with look():
        figure = picture(4.4 * columns, 0.7 + 2.1 * rows)
        heading(figure, with_ignored(str(found.attrs.get("title", "Modes")), found.attrs))
        grid = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
        for number, axes in enumerate(grid.ravel()):
            if number >= count:
                axes.set_visible(False)
                continue
            _shape(axes, found.isel(mode=number))
            mode = found.isel(mode=number)
            axes.set_title(
                f"{_with_whirl(mode)}\n{mode['frequency'].item() * unit.factor:.4g} {unit.sign}, "
                f"damping {100.0 * mode['damping_ratio'].item():.2g} %",
                fontsize=8.5,
                color=INK,
            )
        grid[0, 0].set_ylim(-1.15, 1.15)
        for axes in grid[-1]:
            axes.set_xlabel("position along the axis (mm)")
        for axes in grid[:, 0]:
            axes.set_ylabel("deflection (relative)")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(handles))
    return figure


def _with_whirl(mode: xr.Dataset) -> str:
    """The name of a mode, and its whirl where the name does not contain it."""
    name, whirl = str(mode["name"].item()), str(mode["whirl"].item())
    return name if whirl in name.split() else f"{name}, {whirl} whirl"


def _shape(axes: Axes, mode: xr.Dataset) -> None:
    x, y = (mode[f"{letter}_real"].values + 1j * mode[f"{letter}_imag"].values for letter in "xy")
    place = mode["place"].values * 1e3
    marker = "o" if place.size == 1 else ""
    greatest = np.abs(0.5 * (x + 1j * y)) + np.abs(0.5 * (x - 1j * y))
    top = int(np.argmax(greatest))
    instant = np.exp(-0.5j * np.angle(x[top] ** 2 + y[top] ** 2))
    axes.fill_between(place, -greatest, greatest, color="#E9EDF0", lw=0, label="greatest deflection in a whirl")
    axes.axhline(0.0, color=CRITICAL, lw=0.8)
    for letter, line, color in (("x", x, BALLS[0]), ("y", y, BALLS[2])):
        axes.plot(place, (line * instant).real, color=color, marker=marker, label=f"along {letter}")
        at = mode[f"station_{letter}_real"].values + 1j * mode[f"station_{letter}_imag"].values
        known = np.isfinite(mode["position"].values)
        dots = mode["position"].values[known] * 1e3, (at[known] * instant).real
        axes.plot(*dots, "o", ms=3.5, color=color, label="_stations")
