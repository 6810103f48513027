"""The response of a rotor with rings of liquid, beside the rotor alone and one with balls."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.quantity_axis import plain_log_ticks
from autobalancer.plots.drawing.style import BALLS, INK, heading, look, picture, with_ignored
from autobalancer.results.display_units import speed_axis
from autobalancer.results.given import Given, result


def liquid_response(
    found: Given, *, balls: tuple[ArrayLike, ArrayLike] | None = None, speed_unit: str = "rpm"
) -> Figure:
    """Draw the steady deflection over the speed: rotor alone, with frozen liquid, with liquid.

    Parameters
    ----------
    found
        From ``ab.rotor.liquid_response``.
    balls
        Speeds (rad/s) and deflections (m) of the same rotor with balls, drawn as points.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Raises
    ------
    QuestionError
        If ``found`` is no such response, has fewer than two speeds, or the unit is unknown.
    """
    found = result(found, "plot.liquid_response", "rotor.liquid_response", _is_response)
    if found["speed"].size < 2:
        raise QuestionError("plot.liquid_response: the result has one speed only; ask for several")
    found, unit = found.sortby("speed"), speed_axis(speed_unit)
    speed, attrs = found["speed"].values * unit.factor, found.attrs
    with look():
        figure = picture(8.0, 4.8)
        axes = figure.subplots()
        heading(figure, with_ignored(str(attrs["title"]), attrs))
        axes.plot(speed, 1e3 * found["without_liquid"].values, color=INK, ls="--", lw=1.1, label="without liquid")
        axes.plot(speed, 1e3 * found["frozen"].values, color=BALLS[2], ls=":", lw=1.3, label="liquid frozen")
        axes.plot(speed, 1e3 * found["deflection"].values, color=BALLS[0], lw=1.8, label="liquid")
        if balls is not None:
            at, deflection = (np.asarray(part, float) for part in balls)
            axes.plot(at * unit.factor, 1e3 * deflection, "o", color=BALLS[1], ms=4.5, label="balls")
        limit = attrs["rotor_mass"] / (attrs["rotor_mass"] + attrs["full_mass"])
        if np.isfinite(attrs["unstable_from"]):
            band = [attrs[key] * unit.factor for key in ("unstable_from", "unstable_to")]
            axes.axvspan(*band, color=BALLS[0], alpha=0.1, lw=0.0, label="self-excited without damping")
        axes.set_yscale("log")
        plain_log_ticks(axes, "y")
        axes.set_xlim(speed[0], speed[-1])
        axes.set_xlabel(f"rotor speed ({unit.sign})")
        axes.set_ylabel("deflection (mm)")
        axes.set_title(f"far above resonance liquid leaves {100.0 * limit:.3g} %", fontsize=9.0)
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _is_response(found: xr.Dataset) -> bool:
    return "without_liquid" in found and "share" in found
