"""The torsional response of a drive train over the speed."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.quantity_axis import plain_log_ticks
from autobalancer.plots.drawing.style import BALLS, heading, look, picture, with_ignored
from autobalancer.results.display_units import speed_axis
from autobalancer.results.given import Given, result

STYLES = ("-", (0, (5, 2)), (0, (1, 1.2)), (0, (6, 1.5, 1, 1.5)))


def torsional_response(found: Given, *, speed_unit: str = "rpm") -> Figure:
    """Draw torque and twist of every link over the speed, each harmonic with a line style of its own.

    Parameters
    ----------
    found
        From ``ab.rotor.torsional_response``.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Raises
    ------
    QuestionError
        If ``found`` is no torsional response, has fewer than two speeds, or the unit is unknown.
    """
    found = result(found, "plot.torsional_response", "rotor.torsional_response", _is_response)
    if found["speed"].size < 2:
        raise QuestionError("plot.torsional_response: the result has one speed only; ask for several")
    found, unit = found.sortby("speed"), speed_axis(speed_unit)
    speed = found["speed"].values * unit.factor
    with look():
        figure = picture(8.0, 6.0)
        above, below = figure.subplots(2, 1, sharex=True)
        heading(figure, with_ignored(str(found.attrs.get("title", "Torsional response")), found.attrs))
        for i, link in enumerate(found["link"].values):
            for j, harmonic in enumerate(found["harmonic"].values):
                at = found.isel(link=i, harmonic=j)
                drawn = {
                    "color": BALLS[i % len(BALLS)],
                    "ls": STYLES[j % len(STYLES)],
                    "label": f"{link}, harmonic {harmonic:g}",
                }
                above.plot(speed, at["link_torque"].values, **drawn)
                below.plot(speed, np.degrees(at["twist"].values), **drawn)
        for axes, text in ((above, "torque (N m)"), (below, "twist (°)")):
            axes.set_yscale("log")
            plain_log_ticks(axes, "y")
            axes.set_ylabel(text)
        below.set_xlabel(f"rotor speed ({unit.sign})")
        below.set_xlim(speed[0], speed[-1])
        figure.legend(*above.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        figure.align_ylabels([above, below])
    return figure


def _is_response(found: xr.Dataset) -> bool:
    return "link_torque" in found and "harmonic" in found.dims
