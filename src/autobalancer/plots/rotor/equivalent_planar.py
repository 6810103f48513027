"""Picture of the planar oscillators of a rotor: receptances, and how far they hold."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, heading, legend, look, picture, with_ignored
from autobalancer.results.display_units import speed_axis
from autobalancer.results.given import Given, result


def equivalent_planar(data: Given, *, direction: str = "x", speed_unit: str = "rpm") -> Figure:
    """Receptance of rotor and oscillators over the speed, and the deviation with the tolerance.

    Parameters
    ----------
    data
        Of an :class:`~autobalancer.rotordynamics.equivalent_planar.EquivalentPlanar`.
    direction
        x or y.
    speed_unit
        rpm, rad/s or Hz.

    Raises
    ------
    QuestionError
        If ``data`` is no such result, or there is no such direction.
    """
    wanted = "rotor.equivalent_planar, its .data"
    data = result(data, "plot.equivalent_planar", wanted, lambda it: "other_modes_share" in it)
    if direction not in ("x", "y"):
        raise QuestionError(f"direction: given {direction!r}; must be x or y")
    unit, one = speed_axis(speed_unit), data.sel(direction=direction)
    speed = one["speed"].values
    with look():
        figure = picture(6.6, 5.0)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[1.6, 1.0])
        above.semilogy(unit.factor * speed, 1e6 * one["receptance"].values, color=INK, lw=2.0, label="rotor")
        for color, way in zip(BALLS, one["way"].values, strict=False):
            k, mass, b = (float(one[name].sel(way=way)) for name in ("stiffness", "mass", "damping"))
            own = 1.0 / np.abs(k - speed**2 * mass + 1j * speed * b)
            above.semilogy(unit.factor * speed, 1e6 * own, "--", color=color, label=f"oscillator, {way}")
            below.plot(unit.factor * speed, 100.0 * one["deviation"].sel(way=way).values, "--", color=color)
            first, last = (float(one[end].sel(way=way)) * unit.factor for end in ("valid_from", "valid_to"))
            if np.isfinite(first):
                below.axvspan(first, last, color=color, alpha=0.12, lw=0, label=f"{way}: valid")
        below.plot(
            unit.factor * speed,
            100.0 * one["other_modes_share"].values,
            ":",
            color=INK,
            label="other modes",
        )
        below.axhline(100.0 * data.attrs["tolerance"], color=CRITICAL, lw=0.8, label="tolerance")
        below.set_ylim(0.0, 400.0 * data.attrs["tolerance"])
        for axes in (above, below):
            axes.axvline(unit.factor * float(one["critical_speed"]), color=CRITICAL, lw=0.8, ls=(0, (2, 2)))
            legend(axes)
        heading(figure, with_ignored(f"{data.attrs['title']}, along {direction}", data.attrs))
        above.set(ylabel="receptance (µm/N)")
        below.set(xlabel=f"speed ({unit.sign})", ylabel="deviation (%)", xlim=(0.0, unit.factor * speed[-1]))
    return figure
