"""Axes of parameters: SI in the result, what people write on the axis."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

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
