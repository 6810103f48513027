"""Pictures of spectra, and of maps of the amplitude over the speed."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, heading, legend, look, picture
from autobalancer.results.display_units import AxisUnit, length_axis, speed_axis
from autobalancer.results.given import Given, result
from autobalancer.results.signals.spectrum import Spectrum

DEEPEST = 3e-4  # of the greatest amplitude, at the lower end of a logarithmic axis
NAMED = 6  # lines with a number, the strongest


def spectrum(found: Given, *, log: bool = True, highest: float | None = None, frequency_unit: str = "Hz") -> Figure:
    """Draw amplitudes over the frequency, with the lines of the first channel named by a number and a legend.

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
    if len({str(u) for u in found["units"].values}) > 1:
        names = names[:1]
    size = found.amplitude_unit(names[0])
    x = found["frequency"].values * unit.factor
    with look():
        figure = picture(7.2, 4.2)
        axes = figure.add_subplot()
        for k, name in enumerate(names):
            y = found["amplitude"].sel(channel=name).values * size.factor
            axes.plot(x[1:], y[1:], color=BALLS[k % len(BALLS)], label=name)
        at = np.flatnonzero(found["line_channel"].values.astype(str) == names[0])
        strongest = at[np.argsort(-found["line_amplitude"].values[at])][:NAMED]
        for number, k in enumerate(sorted(strongest), 1):
            place = found["line_frequency"].values[k] * unit.factor, found["line_amplitude"].values[k] * size.factor
            name = str(found["line_name"].values[k]).partition(":")[0]
            text = f"{number}: {place[0]:.4g} {unit.sign}" + f", {name}" * bool(name)
            axes.plot(*place, "o", ms=4, color=INK, label=text, zorder=5)
            axes.annotate(str(number), place, xytext=(4, 3), textcoords="offset points", fontsize=8.5)
        greatest = size.factor * float(found["amplitude"].sel(channel=names).max())
        if log:
            axes.set_yscale("log")
            axes.set_ylim(DEEPEST * greatest, 2.0 * greatest)
        else:
            axes.set_ylim(0.0, 1.1 * greatest)
        axes.set_xlim(0.0, x[-1] if highest is None else highest * unit.factor)
        axes.set(xlabel=f"frequency ({unit.sign})", ylabel=f"amplitude ({size.sign})")
        axes.legend(loc="upper right")
        heading(figure, found.heading())
    return figure


def order_map(
    found: Given, *, orders: tuple[float, ...] = (1.0, 2.0, 3.0), speed_unit: str = "rpm", frequency_unit: str = "Hz"
) -> Figure:
    """Draw the amplitude over the speed and over order or frequency, with lines of orders.

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
    values = found["amplitude"].values
    si = str(found["amplitude"].attrs.get("units", ""))
    unit = length_axis(None, float(values.max()) or 1.0) if si == "m" else AxisUnit(si, 1.0)
    with look():
        figure = picture(7.2, 4.6)
        axes = figure.add_subplot()
        axes.grid(False)
        level = values * unit.factor
        norm = LogNorm(1e-3 * level.max(), level.max())
        y = found[over].values * shown.factor
        colors = np.maximum(level[order].T, 1e-3 * level.max())
        look_of: Any = {"norm": norm, "cmap": "Blues", "shading": "nearest", "rasterized": True}
        mesh = axes.pcolormesh(speed[order], y, colors, **look_of)
        bar = figure.colorbar(mesh, ax=axes, pad=0.02)
        bar.set_label(f"amplitude ({unit.sign})")
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
        axes.set(xlabel=f"rotor speed ({along.sign})", ylabel=f"{found[over].attrs.get('long_name', over)}{sign}")
        legend(axes)
        heading(figure, str(found.attrs.get("title", "")))
    return figure
