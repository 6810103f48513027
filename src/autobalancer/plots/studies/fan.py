"""Percentiles of the deflection of many runs over the time, with the speed above them."""

from __future__ import annotations

from matplotlib.figure import Figure

from autobalancer.plots.drawing.style import ALL_BALLS, BALLS, INK, heading, legend, look, picture
from autobalancer.results.display_units import length_axis, speed_axis
from autobalancer.results.given import Given, result

SHALLOW = 1e-5  # of the greatest deflection, below which nobody looks


def envelopes(found: Given, *, speed_unit: str = "rpm", deflection_unit: str | None = None, log: bool = True) -> Figure:
    """The deflection of many runs as a fan: bands of 50 % and 90 % of them, the median, the greatest; the rotor speed above.

    Parameters
    ----------
    found
        From :func:`autobalancer.envelopes`.
    speed_unit
        rpm, rad/s or Hz.
    deflection_unit
        m, mm, um or nm; by default one that suits.
    log
        Whether the deflection has a logarithmic axis.
    """
    given = result(found, "plot.envelopes", "envelopes", lambda it: "below_50" in it)
    unit, speeds = length_axis(deflection_unit, float(given.attrs["greatest"])), speed_axis(speed_unit)
    level = {percent: unit.shown(given[f"below_{percent}"].values) for percent in (5, 25, 50, 75, 95, 100)}
    time = given["time"].values
    with look():
        figure = picture(7.0, 4.4)
        above, below = figure.subplots(2, sharex=True, height_ratios=[1.0, 2.6])
        heading(figure, str(given.attrs["title"]))
        above.plot(time, speeds.shown(given["speed"].values), color=ALL_BALLS)
        above.set_ylabel(f"speed ({speeds.sign})")
        below.fill_between(
            time, level[5], level[95], color=BALLS[0], alpha=0.18, linewidth=0.0, label="90 % of the runs"
        )
        below.fill_between(time, level[25], level[75], color=BALLS[0], alpha=0.35, linewidth=0.0, label="50 %")
        below.plot(time, level[50], color=BALLS[0], label="median")
        below.plot(time, level[100], color=INK, linewidth=0.8, linestyle=":", label="greatest")
        if log:
            below.set_yscale("log")
            below.set_ylim(bottom=max(SHALLOW * float(level[100].max()), 0.7 * float(level[5].min())))
        else:
            below.set_ylim(bottom=0.0)
        below.set_ylabel(f"deflection ({unit.sign})")
        below.set_xlabel("time (s)")
        below.set_xlim(0.0, float(time[-1]))
        legend(below)
    return figure
