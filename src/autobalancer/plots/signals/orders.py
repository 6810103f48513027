"""Pictures of the orders of measured signals: amplitude and phase over the speed."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from scipy.ndimage import binary_opening

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.speed_panels import panels_of_units, speed_trend, time_runs
from autobalancer.plots.drawing.style import BALLS, heading, legend, look, picture
from autobalancer.results.display_units import AxisUnit, speed_axis, vibration_axis
from autobalancer.results.given import Given, result
from autobalancer.results.signals.orders import Orders

SURE = 2.0  # standard deviations of the band
SEEN = 3.0  # a phase is drawn where the amplitude exceeds so many standard deviations of it
RUN = 5  # points in line, at least
WIDE = 2.6  # points, of the first of several channels, so that it is seen below others that are alike
LINES = ("-", (0, (5, 2)), (0, (1.5, 1.5)), "-.")  # of the orders


def orders(
    found: Given,
    *,
    over: str = "speed",
    channels: list[str] | str | None = None,
    speed_unit: str = "rpm",
) -> Figure:
    """Draw amplitude and phase of each order of each channel, with bands of two standard deviations.

    Each unit has a panel of amplitudes. A phase is drawn where the amplitude is at least three of its standard deviations. Over
    the speed the picture says when time runs to the left, as in a run-down; where it turns, a ring is at the first point.

    Parameters
    ----------
    found
        From ``ab.measure.orders``.
    over
        ``"speed"`` or ``"time"``.
    channels
        Names; by default all.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If ``found`` has no orders, or a channel is unknown.
    """
    found = Orders.of(result(found, "plot.orders", "measure.orders", lambda it: "amplitude_deviation" in it))
    if over not in ("speed", "time"):
        raise QuestionError(f"over: given {over!r}; must be 'speed' or 'time'")
    names = _names(found, channels)
    found = Orders.of(found.sel(channel=names))
    along = speed_axis(speed_unit) if over == "speed" else AxisUnit("s", 1.0)
    x = found[over].values * along.factor
    units = list(map(str, found["units"].values))
    with look():
        figure = picture(6.6, 5.0 + 2.2 * (len(set(units)) - 1))
        *panels, below = panels_of_units(figure, units)
        for panel, si in zip(panels, dict.fromkeys(units), strict=True):
            rows = [c for c, its in enumerate(units) if its == si]
            unit = vibration_axis(si, float(np.nanmax(found["amplitude"].values[:, rows])))
            for n, c in enumerate(rows):
                for o, order in enumerate(found["order"].values):
                    style = {
                        "color": BALLS[c % len(BALLS)],
                        "ls": LINES[o % len(LINES)],
                        "lw": WIDE if n == 0 and len(rows) > 1 else None,
                    }
                    label = f"{names[c]}, order {order:g}"
                    _one(panel, below, x, found.isel(channel=c, order=o), unit, style, label)
                    if over == "speed" and speed_trend(x) == 0:
                        first = found["amplitude"].values[o, c, 0] * unit.factor
                        panel.plot(
                            x[0], first, "o", mfc="white", color=style["color"], label="_" if c or o else "first point"
                        )
            panel.set(ylabel=f"amplitude ({unit.sign})", ylim=(0.0, None))
        label = f"{'rotor speed' if over == 'speed' else 'time'} ({along.sign})"
        below.set(ylabel="lead over the mark (°)", xlabel=label + time_runs(x) * (over == "speed"))
        below.set_ylim(-190.0, 190.0)
        below.yaxis.set_major_locator(MultipleLocator(90.0))
        below.margins(x=0.01)
        for panel in panels:
            legend(panel)
        heading(figure, f"{found.heading()}\n{found.attrs.get('method', '')}")
    return figure


def _one(above: Axes, below: Axes, x: np.ndarray, one: Any, unit: AxisUnit, style: dict[str, Any], label: str) -> None:
    size, spread = one["amplitude"].values * unit.factor, one["amplitude_deviation"].values * unit.factor
    above.plot(x, size, label=label, **style)
    above.fill_between(
        x, np.maximum(size - SURE * spread, 0.0), size + SURE * spread, color=style["color"], alpha=0.2, lw=0
    )
    seen = binary_opening(size >= SEEN * spread, np.ones(RUN))
    phase = np.where(seen, np.rad2deg(one["phase"].values), np.nan)
    jumps = np.flatnonzero(np.abs(np.diff(phase)) > 180.0) + 1
    below.plot(np.insert(x, jumps, np.nan), np.insert(phase, jumps, np.nan), **style)
    sure = SURE * np.rad2deg(one["phase_deviation"].values)
    below.fill_between(x, phase - sure, phase + sure, color=style["color"], alpha=0.2, lw=0)


def _names(found: Orders, channels: list[str] | str | None) -> list[str]:
    there = [str(name) for name in found["channel"].values]
    names = there if channels is None else [channels] if isinstance(channels, str) else list(channels)
    for name in names:
        if name not in there:
            raise QuestionError(f"channels: no channel {name!r}; there are {', '.join(there)}")
    return names
