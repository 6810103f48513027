"""How a ball, a roller and a pendulum look from above."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.patches import Circle

from autobalancer.plots.drawing.style import INK

CHAMFER = 0.7  # of the diameter of a roller: the inner edge of its chamfer
ROD = 2.6  # points


def draw_body(
    axes: Axes, body: str, center: complex, place: complex, diameter: float, color: str, least: float
) -> None:
    """A body to scale around ``place``; a point is a ring, and a pendulum has a rod from the ``center`` of its race."""
    spot = (place.real, place.imag)
    if body == "pendulum":
        axes.plot([center.real, place.real], [center.imag, place.imag], color=INK, lw=ROD + 1.4, zorder=3.8)
        axes.plot([center.real, place.real], [center.imag, place.imag], color=color, lw=ROD, zorder=3.81)
        axes.add_patch(Circle((center.real, center.imag), 0.8 * least, fc="white", ec=INK, lw=0.8, zorder=3.82))
        axes.add_patch(Circle(spot, 0.5 * diameter or 1.2 * least, fc=color, ec=INK, lw=0.8, zorder=4))
    elif diameter > 0.0:
        axes.add_patch(Circle(spot, 0.5 * diameter, fc=color, ec=INK, lw=0.8, alpha=0.9, zorder=4))
        if body == "roller":
            axes.add_patch(Circle(spot, 0.5 * CHAMFER * diameter, fc="none", ec=INK, lw=0.6, zorder=4.01))
    else:
        axes.add_patch(Circle(spot, least, fc="white", ec=color, lw=2.2, alpha=0.9, zorder=4))
