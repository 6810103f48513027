"""Curves of Hopf points or folds over two parameters."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.quantity_axis import quantity_axis
from autobalancer.plots.drawing.style import BALLS, INK, look, picture, with_ignored
from autobalancer.results.given import Given, result


def bifurcation_curves(curves: Given, *, speed_unit: str = "rpm") -> Figure:
    """Draw curves of Hopf points or folds: the second parameter across, the first one upwards.

    A Hopf curve is solid where a small stable oscillation begins (supercritical), dashed where the balls jump (subcritical).

    Parameters
    ----------
    curves
        From :func:`bifurcation_curves`.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``, for a parameter that is a speed.

    Returns
    -------
    matplotlib.figure.Figure
        Save it with ``savefig`` or :func:`save_picture`.

    Raises
    ------
    QuestionError
        If there is nothing to draw or the unit is unknown.
    """
    wanted = "stability.bifurcation_curves"
    curves = result(curves, "plot.bifurcation_curves", wanted, lambda it: "second_parameter" in it)
    if not curves.sizes.get("point"):
        raise QuestionError("bifurcation curves: there is no point to draw")
    across, up = (quantity_axis(curves[name], speed_unit) for name in ("second_parameter", "parameter"))
    hopf = "criticality" in curves
    bad = curves["criticality"].values == "subcritical" if hopf else np.zeros(across.values.size, bool)
    with look():
        figure = picture(7.2, 4.6)
        axes = figure.add_subplot()
        axes.set_title(with_ignored(str(curves.attrs.get("title", "Bifurcation curves")), curves.attrs))
        named: set[str] = set()
        for number in np.unique(curves["curve"].values):
            points = np.flatnonzero(curves["curve"].values == number)
            for dashed in (False, True):
                wanted = bad[points] == dashed
                shown = np.where(wanted | np.roll(wanted, 1), up.values[points], np.nan)
                style = (0, (4, 2.2)) if dashed else "-"
                text = "Hopf, subcritical" if dashed else "Hopf, supercritical" if hopf else "fold"
                label = text if wanted.any() and text not in named else "_"
                named.add(label)
                axes.plot(across.values[points], shown, ls=style, lw=1.6, color=BALLS[0], label=label)
        for i, name in enumerate(curves["special_type"].values):
            place = (
                across.unit.shown(float(curves["special_second_parameter"].values[i])),
                up.unit.shown(float(curves["special_parameter"].values[i])),
            )
            text = f"{name} point" if name == "Bautin" else str(name)
            axes.plot(*place, "D", ms=6, mfc="white", mec=INK, label="_" if text in named else text)
            named.add(text)
        axes.set_xlabel(across.label)
        axes.set_ylabel(up.label)
        if float(across.values.min()) > 0.0 and across.values.max() / across.values.min() > 20.0:
            axes.set_xscale("log")
        axes.legend(loc="best")
    return figure
