"""The border speeds of a machine side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import BALLS, CRITICAL, INK, look, picture
from autobalancer.results.display_units import speed_axis

STALLED = ("release speed", "capture speed")  # of balls that stall; the others are those of the balanced state


class BorderSpeed(Protocol):
    """One border speed, rad/s: infinite for never, nan for none."""

    name: str
    speed: float
    known: bool


def borders(found: Sequence[BorderSpeed], *, speed_unit: str = "rpm", title: str = "Border speeds") -> Figure:
    """Draw border speeds, one below the other: blue those of the balanced state, orange those of stalled balls.

    Parameters
    ----------
    found
        From ``ab.stability.borders``, or the borders of ``ab.check``.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    title
        Above the picture.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If there is no border, or the unit is unknown.
    """
    if hasattr(found, "rotor"):
        raise QuestionError("plot.borders: given a machine; it draws a result of stability.borders")
    if not isinstance(found, Sequence) or not found or not all(hasattr(border, "speed") for border in found):
        raise QuestionError("plot.borders: give the result of stability.borders")
    unit = speed_axis(speed_unit)
    speeds = [border.speed * unit.factor for border in found]
    far = max((speed for speed in speeds if math.isfinite(speed)), default=1.0)
    with look():
        figure = picture(7.2, 0.95 + 0.36 * len(found))
        axes = figure.subplots()
        axes.set_title(title)
        for row, (border, speed) in enumerate(zip(found, speeds, strict=True)):
            color = BALLS[1] if border.name in STALLED else BALLS[0]
            if math.isfinite(speed):
                axes.plot([0.0, speed], [row, row], color=color, lw=1.2, alpha=0.45)
                axes.plot([speed], [row], "o", ms=7, color=color, mec=INK, mew=0.6)
                text = f"  {speed:.5g} {unit.sign}"
            else:
                text = "  never" if speed > 0.0 else "  none" if border.known else "  not known"
            at = speed if math.isfinite(speed) else 0.0
            axes.text(at, row, text, va="center", color=INK if math.isfinite(speed) else CRITICAL, fontsize=8.5)
        axes.set_yticks(range(len(found)), [border.name for border in found])
        axes.set_ylim(len(found) - 0.4, -0.6)
        axes.set_xlim(0.0, 1.22 * far)
        axes.set_xlabel(f"rotor speed ({unit.sign})")
        axes.grid(False, axis="y")
    return figure
