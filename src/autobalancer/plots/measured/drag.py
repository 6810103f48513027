"""Drag coefficients against the Reynolds number."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from autobalancer import drag
from autobalancer.errors import QuestionError
from autobalancer.laws.drag_coefficient import DragLaw, SampledLaw, TableLaw
from autobalancer.plots.drawing.style import BALLS, look, picture

LINES = ("-", (0, (6, 2)), (0, (5, 1.5, 1, 1.5)), (0, (1, 1.2)))


def drag_laws(
    laws: Sequence[DragLaw] | None = None, *, first: float = 0.1, last: float = 1e6, labels: Sequence[str] | None = None
) -> Figure:
    """Draw c_d, and below it c_d Re, which is a constant where the drag is linear.

    Dotted: beyond the range of a law, where its coefficient is kept constant. The points of a table are marked.

    Parameters
    ----------
    laws
        Such as :func:`sphere_on_plane`; by default all that need no further parameter.
    first, last
        Reynolds numbers between which.
    labels
        One for each law, by default its name and plateau.

    Raises
    ------
    QuestionError
        If there is no law, too few labels, or the range is empty.
    """
    laws = drag.drag_laws() if laws is None else tuple(laws)
    if not laws or (labels is not None and len(labels) != len(laws)):
        raise QuestionError(
            f"plot.drag_laws: given {len(laws)} laws and {len(labels or laws)} labels; give a label for each"
        )
    if not 0.0 < first < last:
        raise QuestionError(
            f"plot.drag_laws: given Reynolds numbers from {first:g} to {last:g}; they must increase from above 0"
        )
    names = list(labels) if labels is not None else [_label(law) for law in laws]
    with look():
        figure = picture(7.2, 6.4)
        upper, lower = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [3, 2]})
        for number, (law, name) in enumerate(zip(laws, names, strict=True)):
            color, line = BALLS[number % len(BALLS)], LINES[number // len(BALLS) % len(LINES)]
            inside = np.geomspace(first, max(min(last, law.highest), first), 600)
            beyond = np.geomspace(max(law.highest, first), last, 60) if law.highest < last else np.empty(0)
            for axes, power in ((upper, 1.0), (lower, 0.0)):
                axes.plot(inside, law.product(inside) / inside**power, color=color, ls=line, lw=1.7, label=name)
                axes.plot(beyond, law.product(beyond) / beyond**power, color=color, ls=(0, (1, 2)), lw=1.1)
                if isinstance(law, TableLaw) and not isinstance(law, SampledLaw):
                    re = np.array(law.reynolds)
                    axes.plot(re, law.product(re) / re**power, "o", ms=3.5, color=color)
        _axes(upper, "drag coefficient $c_d$")
        _axes(lower, r"$c_d\,\mathrm{Re}$")
        lower.set_ylim(10.0, 3e4)
        lower.set_xlim(first, last)
        lower.set_xlabel("Reynolds number of the ball")
        upper.legend(loc="upper right")
    return figure


def _label(law: DragLaw) -> str:
    plateau = float(law.product(law.kept_from)) / law.kept_from
    return f"{law.name.replace('_', ' ')}, {law.cd_re:.4g}/Re to {plateau:.2g}"


def _axes(axes: Axes, label: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylabel(label)
