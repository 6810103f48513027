"""Pictures of spectra, and of maps of the amplitude over the speed."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.labels import label_point
from autobalancer.plots.drawing.quantity_axis import plain_log_ticks
from autobalancer.plots.drawing.speed_panels import speed_trend, time_runs
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, heading, legend, look, picture
from autobalancer.results.display_units import AxisUnit, speed_axis, vibration_axis
from autobalancer.results.given import Given, result
from autobalancer.results.signals.spectrum import Spectrum

DEEPEST = 3e-4  # of the greatest amplitude, at the lower end of a logarithmic axis
PALEST = 1e-3  # of the greatest amplitude of a map, at the lower end of its colors
NAMED = 6  # lines with a number, the strongest


def spectrum(found: Given, *, log: bool = True, highest: float | None = None, frequency_unit: str = "Hz") -> Figure:
    """Draw amplitudes over the frequency, each unit in its panel; lines of its first channel have a number and are in the legend.

    Parameters
    ----------
    found
        From ``ab.measure.spectrum``.
    log
        Logarithmic amplitudes.
    highest
        Frequency up to which it is drawn, rad/s.
    frequency_unit
        Hz, rad/s or rpm.

    Raises
    ------
    QuestionError
        If ``found`` is no spectrum.
    """
    found = Spectrum.of(result(found, "plot.spectrum", "measure.spectrum", lambda it: "line_frequency" in it))
    unit = speed_axis(frequency_unit)
    names = [str(name) for name in found["channel"].values]
    groups: dict[str, list[int]] = {}
    for c, si in enumerate(found["units"].values):
        groups.setdefault(str(si), []).append(c)
    x = found["frequency"].values * unit.factor
    with look():
        figure = picture(7.2, 4.2 + 3.2 * (len(groups) - 1))
        panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
        for axes, rows in zip(panels, groups.values(), strict=True):
            _one_unit(axes, found, [names[c] for c in rows], rows[0], unit, log)
        panels[-1].set_xlim(0.0, x[-1] if highest is None else highest * unit.factor)
        panels[-1].set_xlabel(f"frequency ({unit.sign})")
        heading(figure, found.heading())
    return figure


def _one_unit(axes: Axes, found: Spectrum, names: list[str], before: int, unit: AxisUnit, log: bool) -> None:
    """Channels of one unit, of which the first ones of the others have ``before`` colors, and the lines of the first."""
    size = found.amplitude_unit(names[0])
    x = found["frequency"].values * unit.factor
    for k, name in enumerate(names, before):
        y = found["amplitude"].sel(channel=name).values * size.factor
        axes.plot(x[1:], y[1:], color=BALLS[k % len(BALLS)], label=name)
    at = np.flatnonzero(found["line_channel"].values.astype(str) == names[0])
    strongest = at[np.argsort(-found["line_amplitude"].values[at])][:NAMED]
    for number, k in enumerate(sorted(strongest), 1):
        place = found["line_frequency"].values[k] * unit.factor, found["line_amplitude"].values[k] * size.factor
        name = str(found["line_name"].values[k]).partition(":")[0]
        text = f"{number}: {place[0]:.4g} {unit.sign}" + f", {name}" * bool(name)
        axes.plot(*place, "o", ms=4, color=INK, label=text, zorder=5)
        label_point(axes, str(number), *place)
    greatest = size.factor * float(found["amplitude"].sel(channel=names).max())
    if log:
        axes.set_yscale("log")
        axes.set_ylim(DEEPEST * greatest, 2.0 * greatest)
    else:
        axes.set_ylim(0.0, 1.1 * greatest)
    axes.set_ylabel(f"amplitude ({size.sign})")
    axes.legend(loc="upper right")


def order_map(
    found: Given, *, orders: tuple[float, ...] = (1.0, 2.0, 3.0), speed_unit: str = "rpm", frequency_unit: str = "Hz"
) -> Figure:
    """Draw the amplitude over the speed and over order or frequency, with lines of orders.

    Colors are logarithmic over three decades; what is below has the palest one.

    Parameters
    ----------
    found
        From ``ab.measure.order_map``.
    orders
        Whose lines are drawn.
    speed_unit, frequency_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If ``found`` is no map, or its speed neither rises nor falls.
    """
    found = result(found, "plot.order_map", "measure.order_map", lambda it: "amplitude" in it and "speed" in it.coords)
    over = "order" if "order" in found.dims else "frequency"
    shown = AxisUnit("", 1.0) if over == "order" else speed_axis(frequency_unit)
    along = speed_axis(speed_unit)
    speed = found["speed"].values * along.factor
    order = np.argsort(speed, kind="stable")
    if np.ptp(speed) < 0.01 * np.abs(speed).max():
        raise QuestionError("plot.order_map: the speed hardly changes; ab.measure.spectrum is for one speed")
    if speed_trend(speed) == 0:
        raise QuestionError(
            "plot.order_map: the speed rises and falls; take one of both, with start and end of ab.measure.load_signals "
            "(--start, --end)"
        )
    values = found["amplitude"].values
    si = str(found["amplitude"].attrs.get("units", ""))
    unit = vibration_axis(si, float(values.max()))
    with look():
        figure = picture(7.2, 4.6)
        axes = figure.add_subplot()
        axes.grid(False)
        level = values * unit.factor
        norm = LogNorm(PALEST * level.max(), level.max())
        y = found[over].values * shown.factor
        colors = np.maximum(level[order].T, PALEST * level.max())
        look_of: Any = {"norm": norm, "cmap": "Blues", "shading": "nearest", "rasterized": True}
        mesh = axes.pcolormesh(speed[order], y, colors, **look_of)
        bar = figure.colorbar(mesh, ax=axes, pad=0.02, extend="min")
        bar.set_label(f"amplitude of {found.attrs.get('channel', 'the signal')} ({unit.sign})")
        plain_log_ticks(bar.ax, "y")
        ends = np.array([speed.min(), speed.max()])
        for number in orders:
            rise = np.array([number, number]) if over == "order" else number * ends / along.factor * shown.factor
            if rise[0] < y[-1]:
                axes.plot(
                    ends, rise, color=CRITICAL, lw=0.9, ls=(0, (6, 4)), label="orders" if number == orders[0] else "_"
                )
                right = rise[1] <= y[-1]
                spot = (ends[1], rise[1]) if right else (np.interp(y[-1], rise, ends), y[-1])
                shift = (-10, 2) if right else (-10, -10)
                axes.annotate(f"{number:g}", spot, xytext=shift, textcoords="offset points", fontsize=8.5)
        axes.set_xlim(*ends)
        axes.set_ylim(0.0, y[-1])
        sign = f" ({shown.sign})" * bool(shown.sign)
        axes.set(
            xlabel=f"rotor speed ({along.sign}){time_runs(speed)}",
            ylabel=f"{found[over].attrs.get('long_name', over)}{sign}",
        )
        legend(axes)
        heading(figure, f"{found.attrs.get('title', '')}{_window(found, over)}")
    return figure


def _window(found: xr.Dataset, over: str) -> str:
    """The line of the heading that says it; files of earlier versions do not."""
    if "window_revolutions" not in found.attrs:
        return ""
    at = " at the mean speed" * (over == "frequency")
    return f"\n{found.attrs['window']} window of {found.attrs['window_revolutions']:g} revolutions{at}"
