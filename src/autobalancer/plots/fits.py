"""Picture of a fit: measured and fitted curves, deviations of single values, correlation of the parameters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from textwrap import shorten
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MultipleLocator
from numpy.typing import NDArray

from autobalancer.arrays import Floats
from autobalancer.laws.rubber import Motion, RubberLaw
from autobalancer.plots.style import (
    ALL_BALLS,
    BALLS,
    CRITICAL,
    FILL,
    INK,
    UNBALANCE,
    heading,
    label_point,
    legend,
    look,
    picture,
    plain_log_ticks,
    wrapped,
)
from autobalancer.results.answers.kinds import RubberFit, RubberPoints, joined
from autobalancer.results.display_units import AxisUnit, speed_axis, vibration_axis

OUTLIER = 5.0  # standard deviations
FEW = 6  # parameters whose correlation fits beside the deviations
LONGEST = 24  # characters of a line of a name


def identification(fit: xr.Dataset, *, speed_unit: str = "rpm", log: bool = True) -> Figure:
    """Response curves and orders before and after the fit (if there are any), deviations in standard deviations, correlation.

    Parameters
    ----------
    fit
        ``data`` of an :class:`~autobalancer.rotordynamics.identify.Identification`.
    speed_unit
        rpm, rad/s or Hz.
    log
        Logarithmic amplitudes.
    """
    unit = speed_axis(speed_unit)
    curves, orders = (np.unique(fit["row_label"].values[fit["row_kind"].values == k]) for k in ("response", "orders"))
    with look():
        many = fit.sizes["parameter"] > FEW
        heights = [2.9] * (len(curves) + len(orders)) + [max(1.6 if many else 3.4, 0.8 + 0.24 * len(_single(fit)))]
        heights += [0.9 + 0.28 * fit.sizes["parameter"]] * many
        figure = picture(8.4, sum(heights))
        heading(figure, str(fit.attrs.get("title", "")))
        grid = figure.add_gridspec(len(heights), 2, width_ratios=[1.5, 1.0], height_ratios=heights)
        for i, label in enumerate(orders, len(curves)):
            rows = np.flatnonzero((fit["row_label"].values == label) & (fit["row_kind"].values == "orders"))
            one = [figure.add_subplot(grid[i, k]) for k in range(2)]
            _orders(one[0], one[1], fit.isel(row=rows), unit, str(label))
        for i, label in enumerate(curves):
            wanted = (fit["row_label"].values == label) & (fit["row_kind"].values == "response")
            drawn = np.flatnonzero(fit["curve_label"].values == label)
            part = fit.isel(row=np.flatnonzero(wanted), point=drawn)
            _curve(figure.add_subplot(grid[i, :]), part, unit, str(label), log)
        row = len(curves) + len(orders)
        _deviations(figure.add_subplot(grid[row, :] if many else grid[row, 0]), fit, unit)
        _correlation(figure.add_subplot(grid[row + 1, :] if many else grid[row, 1]), fit)
    return figure


def _curve(axes: Axes, part: xr.Dataset, unit: AxisUnit, label: str, log: bool) -> None:
    order = np.argsort(part["row_speed"].values)
    part = part.isel(row=order)
    shown = vibration_axis(str(part["row_unit"].values[0]), float(part["measured"].max()))
    speed, sign, factor = part["row_speed"].values * unit.factor, shown.sign, shown.factor
    along = part["curve_speed"].values * unit.factor
    axes.plot(along, factor * part["curve_before"].values, color=FILL, lw=3.0, label="before")
    axes.plot(speed, factor * part["measured"].values, ".", ms=4, color=ALL_BALLS, zorder=3, label="measured")
    axes.plot(along, factor * part["curve_after"].values, color=BALLS[0], label="after the fit")
    for i in np.flatnonzero(np.abs(part["deviation"].values) > OUTLIER):
        x, y = float(speed[i]), factor * float(part["measured"].values[i])
        axes.plot(x, y, "o", ms=8, mfc="none", mec=INK, label="_")
        label_point(axes, f"{part['deviation'].values[i]:+.0f} standard deviations", x, y, size=8.0)
    axes.set(xlabel=f"speed ({unit.sign})", ylabel=f"amplitude ({sign})", title=label)
    if log:
        axes.set_yscale("log")
        plain_log_ticks(axes, "y")
    legend(axes)


def _orders(above: Axes, beside: Axes, part: xr.Dataset, unit: AxisUnit, label: str) -> None:
    """Amplitude and phase of every channel over the speed."""
    *signs, _ = str(part["row_unit"].values[0]).split(", ")
    names = list(dict.fromkeys(str(name) for name in part["row_part"].values))
    sizes = [name.endswith(", amplitude") for name in map(str, part["row_part"].values)]
    common = vibration_axis(signs[0], float(part["measured"].values[sizes].max()))
    for k, name in enumerate(names):
        one = part.isel(row=np.flatnonzero(part["row_part"].values == name))
        one = one.isel(row=np.argsort(one["row_speed"].values))
        channel, _, what = name.rpartition(", ")
        factor = common.factor if len(signs) == 1 else 1.0 / float(one["measured"].values.max())
        axes, scale = (beside, 180.0 / np.pi) if what == "phase" else (above, factor)
        color, speed = BALLS[k % (len(names) // 2) % len(BALLS)], one["row_speed"].values * unit.factor
        axes.plot(speed, scale * one["measured"].values, ".", ms=4, color=color, label="_")
        for key, width, alpha, name_of in (("before", 3.0, 0.3, "_"), ("after", 1.0, 1.0, channel)):
            line = wrapped(speed, np.unwrap(one[key].values)) if what == "phase" else (speed, scale * one[key].values)
            axes.plot(*line, color=color, lw=width, alpha=alpha, label=name_of)
    above.plot([], [], ".", ms=4, color=INK, label="measured")
    above.plot([], [], color=INK, lw=3.0, alpha=0.3, label="before the fit")
    above.plot([], [], color=INK, lw=1.0, label="after the fit")
    shown = common.sign if len(signs) == 1 else "each over its greatest"
    above.set(xlabel=f"speed ({unit.sign})", ylabel=f"amplitude ({shown})", title=label, ylim=(0.0, None))
    beside.set(ylim=(-190.0, 190.0), yticks=[-180, -90, 0, 90, 180])
    beside.set(xlabel=f"speed ({unit.sign})", ylabel="lead over the mark (°)")
    legend(above)


def _single(fit: xr.Dataset) -> np.ndarray:
    """Rows that are the only one of their measurement."""
    labels = fit["row_label"].values
    alone = np.array([(labels == label).sum() == 1 for label in labels], bool)
    return np.flatnonzero(alone & (fit["row_kind"].values != "response"))


def _deviations(axes: Axes, fit: xr.Dataset, unit: AxisUnit) -> None:
    labels = fit["row_label"].values
    many = np.array([bool((labels == label).sum() > 1) for label in labels])
    whole = [
        label for label in dict.fromkeys(labels[many]) if "response" not in fit["row_kind"].values[labels == label]
    ]
    single = fit.isel(row=_single(fit))
    if single.sizes["row"] == 0 and not whole:
        axes.axhspan(-1.0, 1.0, color="#EFF2F4", lw=0)
        axes.plot(fit["row_speed"].values * unit.factor, fit["deviation"].values, ".", ms=4, color=INK)
        axes.set(xlabel=f"speed ({unit.sign})", ylabel="deviation (standard deviations)", title="after the fit")
        return
    place = np.arange(len(whole), single.sizes["row"] + len(whole))[::-1]
    before = (single["before"] - single["measured"]).values / single["error"].values
    after = single["deviation"].values
    axes.axvspan(-1.0, 1.0, color="#EFF2F4", lw=0)
    if place.size:
        axes.plot(before, place, "o", mfc="white", color=CRITICAL, label="before")
        axes.plot(after, place, "o", color=BALLS[0], label="after the fit")
    means = [float(np.sqrt((fit["deviation"].values[labels == label] ** 2).mean())) for label in whole]
    if means:
        axes.plot(means, range(len(whole)), "D", ms=5, color=BALLS[0], label="after the fit, root mean square")
    for at, a, b in zip(place, before, after, strict=True):
        axes.plot([a, b], [at, at], color=CRITICAL, lw=0.7, zorder=1)
    counts = [f"{label}\n{(labels == label).sum()} values" for label in whole]
    names = [shorten(str(label), LONGEST, placeholder=" ...") for label in single["row_label"].values]
    axes.set_yticks([*place, *range(len(whole))], [*names, *counts], fontsize=7.5)
    axes.set(ylim=(-0.6, place.size + len(whole) - 0.4), xlabel="deviation (standard deviations)")
    legend(axes)


def _correlation(axes: Axes, fit: xr.Dataset) -> None:
    values, count = fit["correlation"].values, fit.sizes["parameter"]
    names = [str(name) if count > FEW else _broken(str(name)) for name in fit["parameter"].values]
    axes.imshow(values, vmin=-1.0, vmax=1.0, cmap="PuOr", aspect="auto" if count > FEW else "equal")
    axes.grid(False)
    ticks = np.arange(count)
    axes.set_xticks(ticks, [f"{k + 1}" for k in ticks], fontsize=7.5)
    axes.set_yticks(ticks, [f"{name}  {k + 1}" for k, name in enumerate(names)], fontsize=7.5)
    for i in ticks:
        for j in ticks:
            text = "" if np.isnan(values[i, j]) else f"{round(float(values[i, j]), 2) + 0.0:.2f}"  # no "-0.00"
            axes.annotate(
                text, (j, i), ha="center", va="center", fontsize=7.5, color="white" if abs(values[i, j]) > 0.6 else INK
            )
    axes.set_title("correlation")


def _broken(path: str) -> str:
    """A path in lines of about ``LONGEST`` characters that end at its dots."""
    lines = [""]
    for part in path.replace(".", ".\n").split("\n"):
        if lines[-1] and len(lines[-1] + part) > LONGEST:
            lines.append("")
        lines[-1] += part
    return "\n".join(lines)


# A run and a measurement in one picture.


PARTS = 300  # of the time, in each of which the least and the greatest value are drawn
MANY = 10  # samples of a part; with fewer, every sample is drawn
DOTS = 60  # of each ball
SURE = 2.0  # standard deviations of bands


def overlay(found: xr.Dataset, *, speed_unit: str = "rpm") -> Figure:
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
    with look():
        if str(found["units"].values[0]) == "rad":
            figure = picture(7.0, 4.0)
            _balls(figure.subplots(), found)
        elif "measured" not in found:
            figure = picture(7.0, 5.2)
            above, below = figure.subplots(2, sharex=True)
            _overlay_orders(above, below, found, speed_axis(speed_unit))
        else:
            ordered, count = "order_amplitude" in found, found.sizes["channel"]
            figure = picture(8.0, 1.0 + 2.1 * max(count, 2 * ordered))
            grid = figure.add_gridspec(2 * count, 1 + ordered)
            for row in range(count):
                _channel(figure.add_subplot(grid[2 * row : 2 * row + 2, 0]), found.isel(channel=row), row == count - 1)
            if ordered:
                above = figure.add_subplot(grid[: -(-2 * count // 2), 1])
                below = figure.add_subplot(grid[-(-2 * count // 2) :, 1], sharex=above)
                _overlay_orders(above, below, found, speed_axis(speed_unit))
            legend(figure.axes[0])
        heading(figure, str(found.attrs["title"]))
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


def _overlay_orders(above: Axes, below: Axes, it: Any, speed: AxisUnit) -> None:
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


# Stiffness and loss of rubber over the amplitude.


WIDER = 3.0  # than the points, each way
MOTIONS: tuple[tuple[Motion, str, str, str], ...] = (
    ("circle", "in a circle", "-", "o"),
    ("line", "in a line", "--", "s"),
)


def rubber(
    found: RubberFit | RubberLaw,
    points: RubberPoints | Sequence[RubberPoints] | None = None,
    *,
    frequency: float | None = None,
    amplitudes: tuple[float, float] | None = None,
    points_label: str = "measured",
) -> Figure:
    """Draw K' and K'' over the amplitude, in circles and in lines, with measured points and what was fitted to them.

    Parameters
    ----------
    found
        From :func:`~autobalancer.measure.rubber`, with a band of one standard deviation; or a law.
    points
        Of :func:`~autobalancer.measure.rubber_loops` or the like, in place of those of the fit; one or several sets.
    frequency
        Of the curves, rad/s; by default the median of the points.
    amplitudes
        From and to, m; by default somewhat farther than points and elements.
    points_label
        What the legend calls the points, such as where amplitudes are estimates.

    Returns
    -------
    matplotlib.figure.Figure
    """
    law = found.law if isinstance(found, RubberFit) else found
    if points is not None and not isinstance(points, RubberPoints):
        points = joined(list(points))
    shown = points if points is not None else found.points if isinstance(found, RubberFit) else None
    if frequency is None:
        frequency = 0.0 if shown is None else float(np.median(shown.frequency))
    if amplitudes is None:
        marks = [a for _, a in law.friction] if shown is None else shown.amplitude.tolist()
        amplitudes = (min(marks, default=1e-4) / WIDER, max(marks, default=1e-3) * WIDER)
    a = np.geomspace(*amplitudes, 400)
    with look():
        figure = picture(8.0, 3.7)
        panels = figure.subplots(1, 2)
        for motion, text, dash, mark in MOTIONS:
            stiffness = law.stiffness(a, frequency, motion)
            for axes, part in zip(panels, (stiffness.real, stiffness.imag), strict=True):
                axes.plot(
                    1e3 * a, 1e-3 * part, dash, color=BALLS[0], label=f"{text}, {frequency / (2.0 * np.pi):.3g} Hz"
                )
            if isinstance(found, RubberFit) and motion == "circle":
                for axes, part, sure in zip(
                    panels, (stiffness.real, stiffness.imag), found.uncertainty(a, frequency, motion), strict=True
                ):
                    axes.fill_between(
                        1e3 * a, 1e-3 * (part - sure), 1e-3 * (part + sure), color=BALLS[0], alpha=0.15, lw=0
                    )
            if shown is not None:
                _points(panels, shown, motion, f"{points_label} {text}", mark)
        if isinstance(found, RubberFit) and points is None:
            for axes, part in zip(panels, (found.fitted.real, found.fitted.imag), strict=True):
                at = 1e3 * found.points.amplitude
                axes.plot(at, 1e-3 * part, "_", color=BALLS[1], ms=8.0, mew=1.6, label="fitted", zorder=4.0)
        for axes, name in zip(panels, ("stiffness K'", "loss K''"), strict=True):
            axes.set(xscale="log", xlim=(1e3 * a[0], 1e3 * a[-1]))
            axes.set_ylim(0.0)
            axes.set(xlabel="amplitude of the rubber (mm)", ylabel=f"{name} (kN/m)")
        panels[0].legend(loc="lower left")
        heading(figure, "Rubber that softens with the amplitude")
    return figure


def _points(panels: np.ndarray, shown: RubberPoints, motion: Motion, label: str, mark: str) -> None:
    """Measured points with their standard uncertainty."""
    rows = np.array([one == motion for one in shown.motion])
    if not rows.any():
        return
    x = 1e3 * shown.amplitude[rows]
    for axes, name in zip(panels, ("stiffness", "loss"), strict=True):
        y = 1e-3 * getattr(shown, name)[rows]
        bar = 1e-3 * getattr(shown, f"{name}_uncertainty")[rows]
        _bars(axes, x, y, bar, mark, label)


def _bars(axes: Axes, x: np.ndarray, y: np.ndarray, bar: np.ndarray, mark: str, label: str) -> None:
    axes.errorbar(x, y, bar, fmt=mark, color=INK, ms=4.0, lw=0.8, mfc="white", mew=0.9, label=label)


# Pictures of measured receptances: the fit, and the loop with its margins.


def receptance(fit: xr.Dataset, *, frequency_unit: str = "Hz") -> Figure:
    """Amplitude and phase, measured and fitted, and the noise; phases are drawn where the value exceeds the noise.

    Parameters
    ----------
    fit
        From ``ab.measure.receptance``.
    frequency_unit
        Hz or rad/s.
    """
    unit = speed_axis(frequency_unit)
    frequency = fit["frequency"].values * unit.factor
    measured = fit["receptance_real"].values + 1j * fit["receptance_imag"].values
    fitted = fit["fitted_real"].values + 1j * fit["fitted_imag"].values
    used = fit["used"].values.astype(bool)
    with look():
        figure = picture(6.4, 4.6)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
        above.set_yscale("log")
        _receptance_points(above, frequency, np.abs(measured), used)
        dense, curve = _fitted_receptance(fit)
        above.plot(dense * unit.factor, np.abs(curve), color=BALLS[0], zorder=4, label="fitted")
        least = 0.3 * float(min(np.abs(measured).min(), np.abs(fitted).min()))
        noise = fit["noise_deviation"].values
        if (noise[used] > least).any():
            above.fill_between(frequency, least, noise, color=FILL, alpha=0.6, lw=0, zorder=0.5, label="noise")
        above.set(ylabel="receptance (m/N)", ylim=(least, None))
        heading(figure, f"Receptance of {fit.attrs.get('title', 'the measurement')}: {_fitted_by(fit)}")
        legend(above)
        along = np.rad2deg(np.unwrap(np.angle(curve)))
        clear = np.abs(fitted) > np.where(used, noise, np.inf)  # no phase where the noise is greater
        beside = np.interp(fit["frequency"].values, dense, along) + np.rad2deg(np.angle(measured / fitted))
        below.plot(frequency[clear], beside[clear], ".", ms=4, color=BALLS[1], zorder=3)
        below.plot(dense * unit.factor, along, "-", color=BALLS[0], zorder=4)
        below.set(ylabel="phase (°)", xlabel=f"frequency ({unit.sign})")
        below.margins(x=0.01)
        below.yaxis.set_major_locator(MultipleLocator(90.0))
    return figure


def _fitted_receptance(fit: xr.Dataset) -> tuple[Floats, NDArray[np.complex128]]:
    """The fitted receptance between the lines too, where a peak may lie; frequencies in rad/s."""
    every = fit["frequency"].values
    dense = np.unique(np.concatenate([every, np.linspace(every[0], every[-1], 3000)]))
    poles = fit["pole_real"].values + 1j * fit["pole_imag"].values
    residues = fit["residue_real"].values + 1j * fit["residue_imag"].values
    return dense, (residues / (1j * dense[:, None] - poles)).sum(axis=1)


def _receptance_points(axes: Axes, frequency: Floats, amplitude: Floats, used: NDArray[np.bool_]) -> None:
    axes.plot(frequency[used], amplitude[used], ".", ms=4, color=BALLS[1], zorder=3, label="measured")
    if not used.all():
        axes.plot(frequency[~used], amplitude[~used], "x", ms=4, mew=0.8, color=CRITICAL, zorder=2, label="not used")


def _fitted_by(fit: xr.Dataset) -> str:
    count = int(fit.attrs["modes"])
    return f"fit of {count} mode{'s' * (count > 1)}, error {100.0 * fit.attrs['fit_error']:.2g} %"


def nyquist(loop: xr.Dataset, *, speed_unit: str = "rpm", reach: float = 1.6) -> Figure:
    """The loop in the complex plane, with the point +1, which must be on its left.

    Parameters
    ----------
    loop
        From :func:`~autobalancer.measurement.loop.receptance_loop`.
    speed_unit
        rpm, rad/s or Hz.
    reach
        Range of the real and imaginary parts that is drawn.
    """
    unit = speed_axis(speed_unit)
    attrs = loop.attrs
    with look():
        figure = picture(5.6, 5.4)
        axes = figure.add_subplot()
        axes.add_patch(Circle((0.0, 0.0), 1.0, fill=False, color=CRITICAL, lw=0.8, ls=(0, (5, 3))))
        _branches(axes, loop, attrs["speed"])
        measured = loop["measured_loop_real"].values, loop["measured_loop_imag"].values
        axes.plot(*measured, ".", ms=5, color=BALLS[1], zorder=3, label="measured")
        axes.plot([1.0], [0.0], "+", ms=12, mew=2.0, color=UNBALANCE, zorder=4, label="+1: on its left if stable")
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
        axes.set(xlabel="real part of the loop gain L", ylabel="imaginary part of the loop gain L")
        verdict = "stable" if attrs["growth_rate"] < 0.0 else "unstable"
        speed = f"{attrs['speed'] * unit.factor:.4g} {unit.sign}"
        heading(figure, f"Balls spread evenly, {speed}: {verdict}{_margins(attrs)}")
        legend(axes)
    return figure


def _branches(axes: Axes, loop: xr.Dataset, speed: float) -> None:
    """Below and above the speed; between them the curve passes through infinity."""
    frequency = loop["loop_frequency"].values
    sides = ((frequency < speed, "-", "fitted, below the speed"), (frequency > speed, ":", "above it"))
    for part, style, label in sides:
        branch = loop.isel(loop_frequency=np.flatnonzero(part))
        x, y = branch["loop_real"].values, branch["loop_imag"].values
        axes.plot(x, y, style, color=INK, label=label)
        strongest = np.flatnonzero((np.abs(x) < 20.0) & (np.abs(y) < 20.0))
        if style == "-" and strongest.size > 2:
            middle = int(strongest[np.argmin(np.abs(np.hypot(x, y)[strongest] - 1.0))])
            step = (x[middle + 1] - x[middle - 1], y[middle + 1] - y[middle - 1])
            size = math.hypot(*step)
            axes.annotate(
                "",
                (x[middle] + 0.08 * step[0] / size, y[middle] + 0.08 * step[1] / size),
                (x[middle], y[middle]),
                arrowprops={"arrowstyle": "-|>", "color": INK},
            )


def _margins(attrs: dict[str, float]) -> str:
    gain, phase = attrs["gain_margin"], attrs["phase_margin"]
    if math.isnan(gain):
        return ""
    first = f"gain margin {gain:.3g}" if math.isfinite(gain) else "any gain"
    second = f"phase margin {math.degrees(phase):.3g}°" if math.isfinite(phase) else "any phase"
    return f"\n{first}, {second}"
