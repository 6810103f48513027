"""Axes of parameters: SI in the result, what people write on the axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from autobalancer.results.display_units import AxisUnit, axis_unit


class QuantityAxis(NamedTuple):
    """How the values of a coordinate are shown."""

    values: np.ndarray  # shown
    label: str
    unit: AxisUnit
    log: bool


def quantity_axis(values: xr.DataArray, speed_unit: str) -> QuantityAxis:
    """Shown values and label; logarithmic for values that ascend by equal ratios over more than a decade."""
    unit = axis_unit(values, speed_unit)
    numbers = np.asarray(values.values, np.float64)
    return QuantityAxis(unit.shown(numbers), axis_label(values, unit), unit, _geometric(numbers))


def axis_label(values: xr.DataArray, unit: AxisUnit) -> str:
    """Name, symbol and unit of a coordinate: ``mass of a ball, $m$ (g)``."""
    text, symbol = str(values.attrs.get("long_name", values.name)), values.attrs.get("symbol", "")
    return text + f", ${symbol}$" * bool(symbol) + f" ({unit.sign})" * bool(unit.sign)


def plain_log_ticks(axes: Axes, which: str, write: Callable[[float], str] = "{:g}".format) -> None:
    """1, 2, 5, 10, ... as plain numbers on a logarithmic axis, or as ``write`` says; more of them on a short one."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis = axes.xaxis if which == "x" else axes.yaxis
    low, high = axis.get_view_interval()
    steps: tuple[float, ...] = (1.0, 2.0, 5.0) if high / low < 2e3 else (1.0,)
    if high / low < 8.0:
        steps = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
    axis.set_major_locator(LogLocator(subs=steps, numticks=30))
    axis.set_major_formatter(FuncFormatter(lambda value, _: write(value)))
    axis.set_minor_formatter(NullFormatter())


def _geometric(values: np.ndarray) -> bool:
    if values.size < 3 or values.min() <= 0.0 or values.max() / values.min() < 10.0:
        return False
    ratios, steps = np.diff(np.log(values)), np.diff(values)
    return bool(np.ptp(ratios) / abs(ratios.mean()) < np.ptp(steps) / abs(steps.mean()))


# Angles that go round and round, as lines on an axis from -180 to 180 degrees.


Floats = NDArray[np.float64]


def wrapped(time: Floats, angle: Floats) -> tuple[Floats, Floats]:
    """A continuous angle (rad) as degrees within ±180, broken where it passes the edge.

    Each passage becomes three points: the edge left, a gap (nan), the edge entered; so no line runs across the axis.

    Parameters
    ----------
    time
        Ascending, s.
    angle
        Not wrapped, rad, of the same length.

    Returns
    -------
    time, degrees
        Arrays for one line.
    """
    turn = np.floor((angle + np.pi) / (2.0 * np.pi))
    inside = np.rad2deg(angle - 2.0 * np.pi * turn)
    passes = np.flatnonzero(np.diff(turn))
    at, when, value = [], [], []
    for i in passes:
        up = turn[i + 1] > turn[i]
        edges = np.pi * (2.0 * np.arange(turn[i], turn[i + 1]) + 1.0)
        if not up:
            edges = np.pi * (2.0 * np.arange(turn[i], turn[i + 1], -1.0) - 1.0)
        for edge in edges:
            part = (edge - angle[i]) / (angle[i + 1] - angle[i])
            moment = time[i] + part * (time[i + 1] - time[i])
            side = 180.0 if up else -180.0
            at += [i + 1] * 3
            when += [moment] * 3
            value += [side, np.nan, -side]
    return np.insert(time, at, when), np.insert(inside, at, value)


def slipping(time: Floats, angle: Floats, span: float) -> NDArray[np.bool_]:
    """Where an angle goes round over 2.5 times in 1/100 of ``span`` (s), so that its line would be a solid block."""
    if time.size < 2:
        return np.zeros(time.shape, np.bool_)
    window = 0.01 * span
    ahead = np.interp(time + 0.5 * window, time, angle)
    behind = np.interp(time - 0.5 * window, time, angle)
    fast: NDArray[np.bool_] = np.abs(ahead - behind) > 5.0 * np.pi
    return fast


# Panels over the rotor speed: amplitudes of each unit by themselves, and which way time runs.


BACK = 0.05  # share of the whole way of the speed; what goes the other way less than this is noise


def panels_of_units(figure: Figure, units: Sequence[str], place: Any = None) -> list[Axes]:
    """A panel for the amplitudes of each unit, in the order in which they come first, and one below all for the phases.

    Parameters
    ----------
    figure
        In which they are drawn.
    units
        Of each channel.
    place
        Cell of a grid; by default the whole figure.
    """
    count = len(set(units))
    inner: Any = figure.add_gridspec if place is None else place.subgridspec
    panels = inner(count + 1, 1, height_ratios=[3] * count + [2]).subplots(sharex=True)
    return list(panels)


def speed_trend(speed: NDArray[np.float64]) -> int:
    """1 of a run-up, -1 of a run-down, 0 of a speed that goes both ways."""
    steps = np.diff(speed[np.isfinite(speed)])
    up, down = float(steps[steps > 0.0].sum()), float(-steps[steps < 0.0].sum())
    if min(up, down) > BACK * (up + down):
        return 0
    return 1 if up >= down else -1


def time_runs(speed: NDArray[np.float64]) -> str:
    """What the label of an axis of the speed says of time: nothing of a run-up."""
    return {1: "", -1: ", time runs to the left", 0: ", up and down"}[speed_trend(speed)]
