"""Races and balls from measurements: roundness, and where balls came to rest."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from autobalancer.plots.drawing.style import BALLS, CRITICAL, FILL, INK, UNBALANCE, heading, look, picture
from autobalancer.results.display_units import length_axis
from autobalancer.results.given import Given, refusal, result

BINS = 72


def race_shape(found: Given) -> Figure:
    """Draw a measured race: at the left around the circle, enlarged, at the right its waves with their standard deviations.

    Parameters
    ----------
    found
        From ``ab.measure.race_shape``.

    Raises
    ------
    QuestionError
        If it is something else.
    """
    found = result(found, "plot.race_shape", "measure.race_shape", lambda one: "crest" in one and "profile" in one)
    unit = length_axis(None, float(np.abs(found["profile"]).max()))
    phi, profile = found["angle"].values, unit.factor * found["profile"].values
    fine = np.linspace(0.0, 2.0 * np.pi, 721)
    waves = unit.factor * (
        found["amplitude"].values * np.cos(found["order"].values * (fine[:, None] - found["crest"].values))
    ).sum(axis=1)
    middle = 2.5 * float(np.abs(profile).max())
    with look():
        figure = picture(9.4, 4.6)
        left: Any = figure.add_subplot(1, 2, 1, projection="polar")
        right = figure.add_subplot(1, 2, 2)
        left.plot(fine, np.full(fine.size, middle), "--", color=CRITICAL, lw=1.0, label="circle")
        left.plot(phi, middle + profile, ".", color=INK, ms=3.0, label="measured")
        left.plot(fine, middle + waves, "-", color=BALLS[0], label=f"waves up to {int(found['order'].values[-1])}")
        left.set_rlim(0.0, 1.45 * middle)
        left.set_rticks([middle - middle / 2.5, middle, middle + middle / 2.5])
        edge = middle / 2.5
        left.set_yticklabels([f"{-edge:.3g}", f"0 {unit.sign}", f"+{edge:.3g}"], fontsize=7.5)
        left.legend(loc="upper left", bbox_to_anchor=(-0.16, 1.14))
        order = found["order"].values
        right.bar(order, unit.factor * found["amplitude"].values, color=FILL, ec=INK, lw=0.7)
        right.errorbar(
            order,
            unit.factor * found["amplitude"].values,
            unit.factor * found["amplitude_deviation"].values,
            fmt="none",
            ecolor=INK,
            lw=0.9,
        )
        right.set_xlabel("undulations per revolution")
        right.set_ylabel(f"amplitude ({unit.sign})")
        gone = "" if found.attrs["center"] == "axis" else " of the setup"
        away = float(found.attrs["eccentricity"])
        size = length_axis(None, away)
        heading(
            figure,
            f"Shape of a race, without its circle and an eccentricity{gone} of {size.factor * away:.3g} {size.sign}",
        )
    return figure


def rests(found: Any) -> Figure:
    """Draw where a ball came to rest: a polar histogram around the balanced place, with the interval that friction holds.

    Parameters
    ----------
    found
        From ``ab.measure.rest_friction``.

    Raises
    ------
    QuestionError
        If it is something else.
    """
    if not hasattr(found, "adherence") or not hasattr(found, "angles"):
        raise refusal(found, "plot.rests", "a result of measure.rest_friction")
    angles = np.array(found.angles)
    edges = np.linspace(-np.pi, np.pi, BINS + 1)
    counts, _ = np.histogram(angles, edges)
    with look():
        figure = picture(5.6, 5.2)
        axes: Any = figure.add_subplot(projection="polar")
        axes.set_theta_zero_location("N")
        axes.bar(edges[:-1], counts / angles.size, width=np.diff(edges), align="edge", color=FILL, ec=INK, lw=0.7)
        top = 1.12 * float(counts.max()) / angles.size
        for side in (-0.5, 0.5):
            axes.plot([found.middle + side * found.width] * 2, [0.0, top], "--", color=BALLS[0], lw=1.4)
        axes.plot([np.pi, np.pi], [0.0, 0.6 * top], "-", color=UNBALANCE, lw=2.0)
        axes.text(np.pi, 0.72 * top, "unbalance", color=UNBALANCE, ha="center", va="center")
        axes.set_rlim(0.0, top)
        axes.set_rlabel_position(110)
        axes.yaxis.set_major_locator(MaxNLocator(4))
        axes.yaxis.set_major_formatter(lambda value, _: f"{100.0 * value:.0f} %")
        heading(
            figure,
            f"Rests of a ball in {angles.size} run-ups, 0° opposite the unbalance\n"
            f"held between the dashed lines by an adherence\n"
            f"of {found.adherence:.3g} ({found.low:.3g} to {found.high:.3g} with 95 %)",
        )
    return figure
