"""Pictures of measured signals: orders, spectra, orbits, decays."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from scipy.ndimage import binary_opening

from autobalancer.errors import QuestionError, one_of
from autobalancer.plots.answer import asked
from autobalancer.plots.style import (
    ALL_BALLS,
    BALLS,
    CRITICAL,
    FILL,
    INK,
    heading,
    label_point,
    legend,
    look,
    panels_of_units,
    picture,
    plain_log_ticks,
    speed_trend,
    time_runs,
)
from autobalancer.results.display_units import AxisUnit, length_axis, speed_axis, vibration_axis
from autobalancer.results.run_argument import RunArgument
from autobalancer.results.signals import Orders, Spectrum

# Pictures of spectra, and of maps of the amplitude over the speed.


DEEPEST = 3e-4  # of the greatest amplitude, at the lower end of a logarithmic axis
PALEST = 1e-3  # of the greatest amplitude of a map, at the lower end of its colors
NAMED = 6  # lines with a number, the strongest


def spectrum(
    found: RunArgument, *, log: bool = True, highest: float | None = None, frequency_unit: str = "Hz"
) -> Figure:
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
    found = Spectrum.of(asked(found, "spectrum"))
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


def _one_unit(axes: Axes, spectrum: Spectrum, names: list[str], before: int, unit: AxisUnit, log: bool) -> None:
    """Channels of one unit, of which the first ones of the others have ``before`` colors, and the lines of the first."""
    size = spectrum.amplitude_unit(names[0])
    x = spectrum["frequency"].values * unit.factor
    for k, name in enumerate(names, before):
        y = spectrum["amplitude"].sel(channel=name).values * size.factor
        axes.plot(x[1:], y[1:], color=BALLS[k % len(BALLS)], label=name)
    at = np.flatnonzero(spectrum["line_channel"].values.astype(str) == names[0])
    strongest = at[np.argsort(-spectrum["line_amplitude"].values[at])][:NAMED]
    for number, k in enumerate(sorted(strongest), 1):
        place = spectrum["line_frequency"].values[k] * unit.factor, spectrum["line_amplitude"].values[k] * size.factor
        name = str(spectrum["line_name"].values[k]).partition(":")[0]
        text = f"{number}: {place[0]:.4g} {unit.sign}" + f", {name}" * bool(name)
        axes.plot(*place, "o", ms=4, color=INK, label=text, zorder=5)
        label_point(axes, str(number), *place)
    greatest = size.factor * float(spectrum["amplitude"].sel(channel=names).max())
    if log:
        axes.set_yscale("log")
        axes.set_ylim(DEEPEST * greatest, 2.0 * greatest)
    else:
        axes.set_ylim(0.0, 1.1 * greatest)
    axes.set_ylabel(f"amplitude ({size.sign})")
    axes.legend(loc="upper right")


def order_map(
    found: RunArgument,
    *,
    orders: tuple[float, ...] = (1.0, 2.0, 3.0),
    speed_unit: str = "rpm",
    frequency_unit: str = "Hz",
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
        If its speed neither rises nor falls.
    """
    found = asked(found, "order_map")
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


def _window(dataset: xr.Dataset, over: str) -> str:
    """The line of the heading that says it; files of earlier versions do not."""
    if "window_revolutions" not in dataset.attrs:
        return ""
    at = " at the mean speed" * (over == "frequency")
    return f"\n{dataset.attrs['window']} window of {dataset.attrs['window_revolutions']:g} revolutions{at}"


# Pictures of the orders of measured signals: amplitude and phase over the speed.


SURE = 2.0  # standard deviations of the band
SEEN = 3.0  # a phase is drawn where the amplitude exceeds so many standard deviations of it
RUN = 5  # points in line, at least
WIDE = 2.6  # points, of the first of several channels, so that it is seen below others that are alike
LINES = ("-", (0, (5, 2)), (0, (1.5, 1.5)), "-.")  # of the orders


def orders(
    found: RunArgument,
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
        If a channel is unknown.
    """
    found = Orders.of(asked(found, "orders"))
    one_of("over", over, "speed", "time")
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


def _names(orders: Orders, channels: list[str] | str | None) -> list[str]:
    there = [str(name) for name in orders["channel"].values]
    names = there if channels is None else [channels] if isinstance(channels, str) else list(channels)
    for name in names:
        one_of("channels", name, *there)
    return names


# Pictures of a decay with its fit, and of measured orbits.


def damping(found: xr.Dataset) -> Figure:
    """Draw a measured decay, its fit with its envelope, and what the fit leaves.

    Parameters
    ----------
    found
        From ``ab.measure.damping`` or ``ab.measure.decay_rate``.
    """
    time, signal, fitted = (found[name].values for name in ("time", "signal", "fitted"))
    size = float(np.abs(signal).max())
    units = str(found["signal"].attrs.get("units", ""))
    unit = vibration_axis(units, size)
    sign = f" ({unit.sign})" * bool(unit.sign)
    with look():
        figure = picture(6.8, 4.6)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 1])
        offset = float(found.attrs.get("offset", 0.0))
        decay = found["amplitude"].values[:, None] * np.exp(-found["decay_rate"].values[:, None] * (time - time[0]))
        envelope = decay.sum(axis=0) * unit.factor
        middle = offset * unit.factor
        above.fill_between(time, middle - envelope, middle + envelope, color=FILL, alpha=0.35, lw=0, label="envelope")
        above.plot(time, signal * unit.factor, ".", ms=3, color=BALLS[1], label="measured")
        above.plot(time, fitted * unit.factor, color=BALLS[0], lw=1.0, label="fitted")
        above.set(ylabel=f"vibration{sign}")
        legend(above)
        below.plot(time, (signal - fitted) * unit.factor, ".", ms=2, color=INK)
        below.set(xlabel="time (s)", ylabel=f"rest{sign}")
        below.margins(x=0.01)
        heading(figure, "\n".join([str(found.attrs.get("title", "decay")), *_modes(found)]))
    return figure


def _modes(dataset: xr.Dataset) -> list[str]:
    rows = []
    for k in range(dataset.sizes["mode"]):
        frequency = float(dataset["frequency"].values[k])
        ratio, spread = (
            100.0 * float(dataset[name].values[k]) for name in ("damping_ratio", "damping_ratio_uncertainty")
        )
        rows.append(f"{frequency / (2.0 * np.pi):.5g} Hz, damping ratio {ratio:.4g} % ± {spread:.1g} %")
    return rows


LEAST_ELLIPSE = 0.04  # of the size of an orbit; smaller ellipses have no arrow


def measured_orbit(found: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
    """Draw an orbit as measured, and what each order does of it.

    A ring is the place at angle zero of the rotor, an arrow the way in which it is gone around.

    Parameters
    ----------
    found
        From ``ab.measure.orbit``.
    speed_unit
        Unit of the speed in the title.
    """
    unit = length_axis(None, float(max(np.abs(found["x"]).max(), np.abs(found["y"]).max())))
    speed = speed_axis(speed_unit)
    with look():
        figure = picture(5.2, 5.2)
        axes = figure.add_subplot()
        axes.set_aspect("equal")
        measured = (
            f"measured, {found.attrs['revolutions']:g} revolutions" if "revolutions" in found.attrs else "measured"
        )
        path = found["x"].values * unit.factor, found["y"].values * unit.factor
        axes.plot(*path, color=ALL_BALLS, lw=0.7, label=measured)
        for k, order in enumerate(found["order"].values):
            x, y = (found[f"filtered_{name}"].values[k] * unit.factor for name in "xy")
            axes.plot(x, y, color=BALLS[k % len(BALLS)], label=f"order {order:g}")
            axes.plot(x[0], y[0], "o", ms=6, mfc="white", mec=BALLS[k % len(BALLS)], mew=1.6)
            if np.hypot(x, y).max() > LEAST_ELLIPSE * max(map(np.ptp, path)):
                tip = len(x) // 12
                style = {"arrowstyle": "-|>", "color": BALLS[k % len(BALLS)], "mutation_scale": 14}
                axes.annotate("", (x[tip], y[tip]), (x[tip - 1], y[tip - 1]), arrowprops=style)
        axes.plot([], [], "o", ms=6, mfc="white", mec=INK, mew=1.6, label="where the rotor angle is zero")
        axes.set(xlabel=f"x ({unit.sign})", ylabel=f"y ({unit.sign})")
        axes.margins(0.1)
        figure.legend(loc="outside lower center", ncols=2)
        heading(figure, f"{found.attrs.get('title', '')}\n{found.attrs['speed'] * speed.factor:.4g} {speed.sign}")
    return figure
