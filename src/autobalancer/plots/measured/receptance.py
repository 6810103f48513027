"""Pictures of measured receptances: the fit, and the loop with its margins."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MultipleLocator
from numpy.typing import NDArray

from autobalancer.plots.drawing.style import BALLS, CRITICAL, FILL, INK, UNBALANCE, heading, legend, look, picture
from autobalancer.results.display_units import speed_axis
from autobalancer.results.given import Given, result

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
        _points(above, frequency, np.abs(measured), used)
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


def _points(axes: Axes, frequency: Floats, amplitude: Floats, used: NDArray[np.bool_]) -> None:
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
        From :func:`~autobalancer.measurement.loop.curve.receptance_loop`.
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
