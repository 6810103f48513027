"""Pictures of measured receptances: the fit, and the loop with its margins."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from autobalancer.errors import QuestionError
from autobalancer.plots.axis_units import speed_axis
from autobalancer.plots.style import BALLS, CRITICAL, INK, UNBALANCE, heading, legend, look, picture


def plot_receptance(fit: xr.Dataset, *, frequency_unit: str = "Hz") -> Figure:
    """Amplitude and phase, measured and fitted.

    Parameters
    ----------
    fit
        From :func:`~autobalancer.measurement.rational_fit.fit_receptance`.
    frequency_unit
        Hz or rad/s.

    Raises
    ------
    QuestionError
        If ``fit`` is no fit.
    """
    if "fitted_real" not in fit:
        raise QuestionError("plot_receptance: this is not a fit of a receptance; see fit_receptance")
    unit = speed_axis(frequency_unit)
    frequency = fit["frequency"].values * unit.factor
    measured = fit["receptance_real"].values + 1j * fit["receptance_imag"].values
    fitted = fit["fitted_real"].values + 1j * fit["fitted_imag"].values
    with look():
        figure = picture(6.4, 4.6)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
        above.semilogy(frequency, np.abs(measured), ".", ms=4, color=BALLS[1], zorder=3, label="measured")
        above.semilogy(frequency, np.abs(fitted), color=BALLS[0], label="fitted")
        above.set_ylabel("receptance (m/N)")
        count = int(fit.attrs["modes"])
        fitted_by = f"fit of {count} mode{'s' * (count > 1)}, error {100.0 * fit.attrs['fit_error']:.2g} %"
        heading(figure, f"Receptance of {fit.attrs.get('title', 'the measurement')}: {fitted_by}")
        legend(above)
        below.plot(frequency, np.rad2deg(np.angle(measured)), ".", ms=4, color=BALLS[1], zorder=3)
        below.plot(frequency, np.rad2deg(np.angle(fitted)), color=BALLS[0])
        below.set_ylabel("phase (°)")
        below.set_xlabel(f"frequency ({unit.sign})")
    return figure


def plot_nyquist(loop: xr.Dataset, *, speed_unit: str = "rpm", reach: float = 1.6) -> Figure:
    """The loop in the complex plane, with the point +1, which must be on its left.

    Parameters
    ----------
    loop
        From :func:`~autobalancer.measurement.receptance_loop.receptance_loop`.
    speed_unit
        rpm, rad/s or Hz.
    reach
        Range of the real and imaginary parts that is drawn.

    Raises
    ------
    QuestionError
        If ``loop`` is no loop.
    """
    if "loop_real" not in loop:
        raise QuestionError("plot_nyquist: this is not a loop; see receptance_loop")
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
