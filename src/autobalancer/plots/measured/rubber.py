"""Stiffness and loss of rubber over the amplitude."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MultipleLocator
from numpy.typing import NDArray

from autobalancer.laws.rubber import Motion, RubberLaw
from autobalancer.plots.drawing.style import BALLS, CRITICAL, FILL, INK, UNBALANCE, heading, legend, look, picture
from autobalancer.results.answers.rubber import RubberFit, RubberPoints, joined
from autobalancer.results.display_units import speed_axis
from autobalancer.results.run_argument import Given, refusal, result

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
    law = _law(found)
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
            axes.set_xscale("log")
            axes.set_xlim(1e3 * a[0], 1e3 * a[-1])
            axes.set_ylim(0.0)
            axes.set_xlabel("amplitude of the rubber (mm)")
            axes.set_ylabel(f"{name} (kN/m)")
        panels[0].legend(loc="lower left")
        heading(figure, "Rubber that softens with the amplitude")
    return figure


def _law(found: object) -> RubberLaw:
    if isinstance(found, RubberFit):
        return found.law
    if isinstance(found, RubberLaw):
        return found
    raise refusal(found, "plot.rubber", "a result of measure.rubber, or a laws.RubberLaw")


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


Floats = NDArray[np.float64]


def receptance(fit: Given, *, frequency_unit: str = "Hz") -> Figure:
    """Amplitude and phase, measured and fitted, and the noise; phases are drawn where the value exceeds the noise.

    Parameters
    ----------
    fit
        From ``ab.measure.receptance``.
    frequency_unit
        Hz or rad/s.

    Raises
    ------
    QuestionError
        If ``fit`` is no fit.
    """
    fit = result(fit, "plot.receptance", "measure.receptance", lambda it: "fitted_real" in it)
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
        dense, curve = _curve(fit)
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


def _curve(fit: xr.Dataset) -> tuple[Floats, NDArray[np.complex128]]:
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


def nyquist(loop: Given, *, speed_unit: str = "rpm", reach: float = 1.6) -> Figure:
    """The loop in the complex plane, with the point +1, which must be on its left.

    Parameters
    ----------
    loop
        From :func:`~autobalancer.measurement.loop.receptance_loop`.
    speed_unit
        rpm, rad/s or Hz.
    reach
        Range of the real and imaginary parts that is drawn.

    Raises
    ------
    QuestionError
        If ``loop`` is no loop.
    """
    loop = result(loop, "plot.nyquist", "measure.receptance_loop", lambda it: "loop_real" in it)
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
        handles, labels = axes.get_legend_handles_labels()
        axes.legend(handles, labels, loc="lower left", frameon=True)
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
