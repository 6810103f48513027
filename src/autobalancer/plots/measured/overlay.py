"""A run and a measurement in one picture."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer.plots.drawing.style import BALLS, CRITICAL, FILL, INK, heading, legend, look, picture
from autobalancer.results.display_units import AxisUnit, speed_axis, vibration_axis
from autobalancer.results.given import Given, result

PARTS = 300  # of the time, in each of which the least and the greatest value are drawn
MANY = 10  # samples of a part; with fewer, every sample is drawn
DOTS = 60  # of each ball
SURE = 2.0  # standard deviations of bands


def overlay(found: Given, *, speed_unit: str = "rpm") -> Figure:
    """Draw what was measured and what the run gives in its place.

    Parameters
    ----------
    found
        From :func:`autobalancer.compare` of a run and a measurement.
    speed_unit
        rpm, rad/s or Hz.

    Returns
    -------
    matplotlib.figure.Figure
        Signals: each channel over time, of many samples their range, and with a tacho amplitude and phase of the first order
        over the speed. Orders: the same over the speed. Balls: their angles in the rotor over time.
    """
    it = result(found, "plot.overlay", "compare of a run and a measurement", lambda one: "rms_away" in one)
    with look():
        if str(it["units"].values[0]) == "rad":
            figure = picture(7.0, 4.0)
            _balls(figure.subplots(), it)
        elif "measured" not in it:
            figure = picture(7.0, 5.2)
            above, below = figure.subplots(2, sharex=True)
            _orders(above, below, it, speed_axis(speed_unit))
        else:
            ordered, count = "order_amplitude" in it, it.sizes["channel"]
            figure = picture(8.0, 1.0 + 2.1 * max(count, 2 * ordered))
            grid = figure.add_gridspec(2 * count, 1 + ordered)
            for row in range(count):
                _channel(figure.add_subplot(grid[2 * row : 2 * row + 2, 0]), it.isel(channel=row), row == count - 1)
            if ordered:
                above = figure.add_subplot(grid[: -(-2 * count // 2), 1])
                below = figure.add_subplot(grid[-(-2 * count // 2) :, 1], sharex=above)
                _orders(above, below, it, speed_axis(speed_unit))
            legend(figure.axes[0])
        heading(figure, str(it.attrs["title"]))
    return figure


def _channel(axes: Axes, one: Any, last: bool) -> None:
    """Least and greatest value in each part of the time."""
    time, size = one["time"].values, float(np.nanmax(np.abs(one["measured"].values)))
    unit = vibration_axis(str(one["units"].values), size)
    edges = np.unique(np.linspace(0, time.size, min(PARTS, time.size) + 1).astype(int))
    middle = np.array([0.5 * (time[a] + time[b - 1]) for a, b in pairwise(edges)])

    def ends(name: str) -> list[np.ndarray]:
        values = one[name].values * unit.factor
        return [np.array([pick(values[a:b]) for a, b in pairwise(edges)]) for pick in (np.min, np.max)]

    if time.size < MANY * PARTS:
        axes.plot(time, one["measured"].values * unit.factor, color=BALLS[4], lw=3.0, alpha=0.7, label="measured")
        axes.plot(time, one["simulated"].values * unit.factor, color=INK, lw=0.9, label="run")
    else:
        low, high = ends("measured")
        axes.fill_between(middle, low, high, color=FILL, lw=0, label="measured")
        for k, line in enumerate(ends("simulated")):
            axes.plot(middle, line, color=INK, lw=0.9, label="run" if k else "_")
    axes.set(ylabel=f"{one['channel'].item()}\n({unit.sign})", xlabel="time (s)" if last else "")
    axes.margins(x=0.0)


def _orders(above: Axes, below: Axes, it: Any, speed: AxisUnit) -> None:
    order, later = (np.argsort(it[key].values) for key in ("order_speed", "order_speed_simulated"))
    x = it["order_speed"].values[order] * speed.factor
    of_run = it["order_speed_simulated"].values[later] * speed.factor
    units = sorted({str(unit) for unit in it["units"].values})
    for row, name in enumerate(it["channel"].values):
        color, one, run = BALLS[row % len(BALLS)], it.isel(channel=row), it.isel(channel=row, order_time=later)
        greatest, said = float(np.nanmax(one["order_amplitude"].values)), ""
        unit = vibration_axis(units[0], float(np.nanmax(it["order_amplitude"].values)))
        if len(units) > 1:  # each over its own greatest, which the legend says
            unit, said = AxisUnit("", 1.0 / greatest), f", greatest {greatest:.3g} {one['units'].item()}"
        one = one.isel(order_time=order)
        size, sure = (one[key].values * unit.factor for key in ("order_amplitude", "order_amplitude_deviation"))
        above.fill_between(x, size - SURE * sure, size + SURE * sure, color=color, alpha=0.3, lw=0)
        above.plot(x, size, ".", ms=3.0, color=color, label=f"{name}, measured{said}")
        above.plot(of_run, run["order_amplitude_simulated"].values * unit.factor, color=color, lw=1.0, label="_")
        below.plot(x, np.degrees(one["order_phase"].values), ".", ms=3.0, color=color)
        phase = np.degrees(run["order_phase_simulated"].values)
        jumps = np.flatnonzero(np.abs(np.diff(phase)) > 180.0) + 1
        below.plot(np.insert(of_run, jumps, np.nan), np.insert(phase, jumps, np.nan), color=color, lw=1.0)
    sign = "each over its greatest measured" if len(units) > 1 else unit.sign
    above.set(ylabel=f"order 1, amplitude\n({sign})", ylim=(0.0, None))
    above.tick_params(labelbottom=False)
    below.set(ylabel="lead over the mark (°)", xlabel=f"rotor speed ({speed.sign})", yticks=[-180, -90, 0, 90, 180])
    legend(above)


def _balls(axes: Axes, it: Any) -> None:
    time = it["time"].values
    for row, name in enumerate(it["channel"].values):
        color = BALLS[row % len(BALLS)]
        seen, run = (np.degrees(it[key].values[row]) % 360.0 for key in ("measured", "simulated"))
        jumps = np.flatnonzero(np.abs(np.diff(run)) > 180.0) + 1
        dots = slice(None, None, max(1, time.size // DOTS))
        axes.plot(time[dots], seen[dots], "o", ms=3.5, mew=0.0, alpha=0.7, color=color, label=f"{name}, measured")
        axes.plot(np.insert(time, jumps, np.nan), np.insert(run, jumps, np.nan), color=color, lw=1.0)
    axes.plot([], [], color=CRITICAL, lw=1.0, label="run")
    axes.set(xlabel="time (s)", ylabel="ball angle in the rotor (°)", ylim=(0.0, 360.0), yticks=[0, 90, 180, 270, 360])
    axes.margins(x=0.0)
    legend(axes)
