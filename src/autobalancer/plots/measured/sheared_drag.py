"""The drag of a ball in a sheared fluid over its velocity."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from autobalancer.plots.drawing.style import BALLS, INK, heading, look, picture
from autobalancer.results.given import Given, result


def sheared_drag(found: Given) -> Figure:
    """Draw the drag over that with the viscosity at rest: finite elements, one effective rate of shear, first order.

    Parameters
    ----------
    found
        From ``ab.flow.sheared_drag``.

    Returns
    -------
    matplotlib.figure.Figure
    """
    found = result(found, "plot.sheared_drag", "flow.sheared_drag", _is_drag)
    attrs, velocity = found.attrs, found["velocity"].values
    with look():
        figure = picture(7.4, 4.4)
        axes = figure.subplots()
        axes.plot(velocity, found["share"].values, "o", color=BALLS[0], label="finite elements")
        label = f"at_ball = {attrs['at_ball']:.3g}, off by at most {100.0 * attrs['greatest_error']:.2g} %"
        axes.plot(
            velocity, found["reduced_share"].values, "s--", color=BALLS[1], ms=8.0, mfc="none", lw=1.0, label=label
        )
        axes.plot(velocity, found["first_order"].values, ":", color=INK, lw=1.0, label="to first order")
        axes.set_xscale("log")
        axes.set_xticks(velocity, [f"{one:g}" for one in velocity])
        axes.minorticks_off()
        axes.set_ylim(0.0, 1.1 * max(1.0, float(found["share"].max())))
        axes.set_xlabel("velocity of the ball along its walls (m/s)")
        axes.set_ylabel("drag over that at rest")
        axes.legend()
        heading(figure, str(attrs["title"]))
    return figure


def _is_drag(found: xr.Dataset) -> bool:
    return "share" in found and "rate_factor" in found
