"""Pictures of a decay with its fit, and of measured orbits."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from autobalancer.plots.drawing.style import ALL_BALLS, BALLS, FILL, INK, heading, legend, look, picture
from autobalancer.results.display_units import length_axis, speed_axis, vibration_axis
from autobalancer.results.given import Given, result


def damping(found: Given) -> Figure:
    """Draw a measured decay, its fit with its envelope, and what the fit leaves.

    Parameters
    ----------
    found
        From ``ab.measure.damping`` or ``ab.measure.decay_rate``.

    Raises
    ------
    QuestionError
        If ``found`` is no fitted decay.
    """
    found = result(
        found, "plot.damping", "measure.damping", lambda it: "logarithmic_decrement" in it and "fitted" in it
    )
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


def _modes(found: xr.Dataset) -> list[str]:
    rows = []
    for k in range(found.sizes["mode"]):
        frequency = float(found["frequency"].values[k])
        ratio, spread = (
            100.0 * float(found[name].values[k]) for name in ("damping_ratio", "damping_ratio_uncertainty")
        )
        rows.append(f"{frequency / (2.0 * np.pi):.5g} Hz, damping ratio {ratio:.4g} % ± {spread:.1g} %")
    return rows


SEEN = 0.04  # of the size of an orbit; smaller ellipses have no arrow


def measured_orbit(found: Given, *, speed_unit: str = "rpm") -> Figure:
    """Draw an orbit as measured, and what each order does of it.

    A ring is the place at angle zero of the rotor, an arrow the way in which it is gone around.

    Parameters
    ----------
    found
        From ``ab.measure.orbit``.
    speed_unit
        Unit of the speed in the title.

    Raises
    ------
    QuestionError
        If ``found`` is no measured orbit.
    """
    found = result(found, "plot.measured_orbit", "measure.orbit", lambda it: "filtered_x" in it)
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
            if np.hypot(x, y).max() > SEEN * max(map(np.ptp, path)):
                tip = len(x) // 12
                style = {"arrowstyle": "-|>", "color": BALLS[k % len(BALLS)], "mutation_scale": 14}
                axes.annotate("", (x[tip], y[tip]), (x[tip - 1], y[tip - 1]), arrowprops=style)
        axes.plot([], [], "o", ms=6, mfc="white", mec=INK, mew=1.6, label="where the rotor angle is zero")
        axes.set(xlabel=f"x ({unit.sign})", ylabel=f"y ({unit.sign})")
        axes.margins(0.1)
        figure.legend(loc="outside lower center", ncols=2)
        heading(figure, f"{found.attrs.get('title', '')}\n{found.attrs['speed'] * speed.factor:.4g} {speed.sign}")
    return figure
