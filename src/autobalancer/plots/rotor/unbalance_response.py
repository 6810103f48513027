"""The unbalance response: amplitude and phase over the speed (Bode), and in the complex plane (polar, Nyquist)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.angles import wrapped
from autobalancer.plots.drawing.labels import label_point
from autobalancer.plots.drawing.quantity_axis import plain_log_ticks
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, heading, legend, look, picture, with_ignored
from autobalancer.results.display_units import AxisUnit, length_axis, significant, speed_axis
from autobalancer.results.given import Given, result

STYLES = ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))


def response(
    found: Given,
    *,
    speed_unit: str = "rpm",
    deflection_unit: str | None = None,
    log: bool = True,
    critical_speeds: Sequence[float] = (),
) -> Figure:
    """Draw the Bode diagram: above the amplitudes at each station along x and y, below the phases to the unbalance.

    Thick is the mean over the stations of the greatest deflections. Shaded are the speeds at which the whirl at a station is
    backward. Phases are within ±180 degrees.

    Parameters
    ----------
    found
        From ``ab.rotor.response``; with ``smooth=True`` there, every peak is drawn in full.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"``, ``"nm"``, with /s or /s² for velocities and accelerations; by default what suits.
    log
        Logarithmic amplitudes.
    critical_speeds
        Marked by vertical lines, rad/s.

    Raises
    ------
    QuestionError
        If ``found`` is no unbalance response, has fewer than two speeds, or a unit is unknown.
    """
    found = result(found, "plot.response", "rotor.response", _is_response)
    unit, size = _checked(found, "plot.response", speed_unit, deflection_unit)
    found = found.sortby("speed")
    speed = found["speed"].values * unit.factor
    with look():
        figure = picture(8.0, 6.0)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.7, 1.0])
        heading(figure, with_ignored(str(found.attrs.get("title", "")), found.attrs))
        mean = found["mean_of_greatest"].values * size.factor
        label = "mean of the greatest" if found.sizes["station"] > 1 else "greatest"
        above.plot(speed, mean, color=INK, lw=2.6, alpha=0.35, label=label)
        for number, name in enumerate(found["station"].values):
            station = found.isel(station=number)
            for style, letter in zip(STYLES, "xy", strict=False):
                line = np.hypot(station[f"{letter}_real"].values, station[f"{letter}_imag"].values) * size.factor
                color = BALLS[number % len(BALLS)]
                above.plot(speed, line, color=color, ls=style, label=f"{name}, {letter}")
                phase = wrapped(speed, np.unwrap(station[f"{letter}_phase"].values))
                below.plot(*phase, color=color, ls=style, label=f"{name}, {letter}")
            _underlay(above, speed, station["whirl"].values == "backward", number, f"{name}, backward whirl")
        for level in critical_speeds:
            for axes in (above, below):
                axes.axvline(level * unit.factor, color=CRITICAL, lw=0.9, ls=(0, (1, 2)))
        if log:
            above.set_yscale("log")
            plain_log_ticks(above, "y")
        above.set_ylabel(f"{found.attrs['quantity']} ({size.sign})")
        below.set_ylabel("phase to the unbalance (°)")
        below.set_yticks(np.arange(-180.0, 181.0, 90.0))
        below.set_xlabel(f"rotor speed ({unit.sign})")
        below.set_xlim(speed[0], speed[-1])
        figure.legend(*above.get_legend_handles_labels(), loc="outside lower center", ncols=4)
        figure.align_ylabels([above, below])
    return figure


def polar_response(
    found: xr.Dataset, *, part: str = "forward", speed_unit: str = "rpm", deflection_unit: str | None = None
) -> Figure:
    """Draw the response in the complex plane of the rotor: every resonance is a loop, passed through clockwise.

    The unbalance points to the right; the rotor follows it at the start of the loop, and is opposite after it. Dots mark
    the peaks and both ends.

    Parameters
    ----------
    found
        From ``ab.rotor.response``.
    part
        ``"forward"``, ``"x"`` or ``"y"``.
    speed_unit, deflection_unit
        As for ``ab.plot.response``.

    Raises
    ------
    QuestionError
        If ``found`` is no unbalance response, has fewer than two speeds, or a unit or part is unknown.
    """
    found = result(found, "plot.polar_response", "rotor.response", _is_response)
    unit, size = _checked(found, "plot.polar_response", speed_unit, deflection_unit)
    if part not in ("forward", "x", "y"):
        raise QuestionError(f"part: given {part!r}; must be forward, x or y")
    found = found.sortby("speed")
    speed = found["speed"].values
    with look():
        figure = picture(5.8, 5.9)
        axes = figure.subplots()
        axes.axhline(0.0, color=CRITICAL, lw=0.8)
        axes.axvline(0.0, color=CRITICAL, lw=0.8)
        for number, name in enumerate(found["station"].values):
            station = found.isel(station=number)
            if part == "forward":
                radius, angle = station["forward"].values, station["phase"].values
            else:
                radius = np.hypot(station[f"{part}_real"].values, station[f"{part}_imag"].values)
                angle = station[f"{part}_phase"].values
            curve = radius * size.factor * np.exp(1j * angle)
            color = BALLS[number % len(BALLS)]
            between = _between(speed, curve)
            axes.plot(between.real, between.imag, color=color, label=str(name))
            for place in _marked(curve):
                axes.plot(curve[place].real, curve[place].imag, "o", ms=4, color=color, label="_")
                shown = speed[place] * unit.factor
                text = significant(shown) if shown < 1e3 else f"{shown:.0f}"
                label_point(axes, text, curve[place].real, curve[place].imag, size=8.0)
        axes.set_aspect("equal", adjustable="datalim")
        where = "forward circle" if part == "forward" else f"{found.attrs['quantity']} along {part}"
        axes.set_xlabel(f"{where}, in the direction of the unbalance ({size.sign})")
        axes.set_ylabel(f"{where}, 90° ahead of it ({size.sign})")
        heading(
            figure, with_ignored(f"{found.attrs.get('title', '')}\nnumbers: rotor speed in {unit.sign}", found.attrs)
        )
        legend(axes)
    return figure


def _is_response(found: xr.Dataset) -> bool:
    return "mean_of_greatest" in found and "quantity" in found.attrs


def _checked(found: xr.Dataset, owner: str, speed_unit: str, deflection_unit: str | None) -> tuple[AxisUnit, AxisUnit]:
    if found["speed"].size < 2:
        raise QuestionError(f"{owner}: the result has one speed only; ask for several")
    plain = length_axis(deflection_unit, float(found["semi_major"].max()))
    rate = {"displacement": "", "velocity": "/s", "acceleration": "/s²"}[found.attrs["quantity"]]
    return speed_axis(speed_unit), AxisUnit(plain.sign + rate, plain.factor)


def _underlay(axes: Axes, speed: np.ndarray, backward: np.ndarray, number: int, label: str) -> None:
    ends = np.flatnonzero(np.diff(np.concatenate([[False], backward, [False]]).astype(np.int64)))
    for first, last in zip(ends[::2], ends[1::2], strict=True):
        color = BALLS[number % len(BALLS)]
        axes.axvspan(speed[first], speed[last - 1], color=color, alpha=0.12, lw=0, label=label)
        label = "_"


def _between(speed: np.ndarray, curve: np.ndarray) -> np.ndarray:
    """A smooth line through the values: a loop near a resonance is a circle, not a polygon."""
    fine = np.concatenate([np.linspace(a, b, 8, endpoint=False) for a, b in pairwise(speed)] + [speed[-1:]])
    return np.asarray(CubicSpline(speed, curve)(fine))


def _marked(curve: np.ndarray) -> list[int]:
    """Both ends and the places where the amplitude is greatest."""
    size = np.abs(curve)
    peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:])) + 1
    return sorted({0, curve.size - 1, *peaks[size[peaks] > 0.05 * size.max()].tolist()})
