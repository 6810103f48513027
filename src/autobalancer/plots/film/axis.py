"""The axis of a rotor from the side, with its planes as discs in perspective: how it tilts and bends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from autobalancer.plots.drawing.style import INK, UNBALANCE
from autobalancer.plots.run.places import PlacesInRotor
from autobalancer.results.drawn.motion import Complexes, Floats, Moments, Races

LENGTH = 4.0  # of the axis as drawn, in the greatest orbit radius
DEPTH, SINK = 0.42, 0.3  # of what points to the eye: to the left and down
ROUND = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 73))
RIM = "#8A949C"


class AxisView:
    """Axis, planes, balls and the unbalance of each plane; ``show(k)`` moves them to frame ``k``.

    The axis runs to the right, the zero direction of the picture from above points to the eye, and 90° upwards.
    ``turned`` is the angle (rad) by which the rotor is drawn in each frame, ``length`` (m) is 1 in the picture, ``discs``
    the place of each plane that has balls with the numbers of its balls.
    """

    def __init__(
        self,
        axes: Axes,
        places: PlacesInRotor,
        moments: Moments,
        races: Races,
        turned: Floats,
        magnification: float,
        length: float,
        discs: Sequence[tuple[int, int, NDArray[np.intp]]],
        colors: Sequence[str],
    ) -> None:
        self.moments, self.turned, self.discs = moments, turned, discs
        self.radii, self.length = races.orbit_radius / length, length
        low, high = float(places.position.min()), float(places.position.max())
        self.along = LENGTH * ((places.position - low) / (high - low) - 0.5)
        self.center: Complexes = places.deflection * np.exp(1j * turned)[:, None] * magnification / length
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_xlim(-0.5 * LENGTH - 1.0, 0.5 * LENGTH + 1.0)
        axes.set_ylim(-1.98, 1.2)
        ends = np.array([-0.5 * LENGTH - 0.5, 0.5 * LENGTH + 0.5])
        axes.plot(ends, [0.0, 0.0], color=RIM, lw=0.8, ls=(0, (6, 3, 1, 3)))
        words: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": 7.5, "color": "#404040"}
        axes.text(0.0, -1.7, "the axis from the side, 0° towards the eye", **words)
        for name, place in zip(places.names, self.along, strict=True):
            axes.plot([place, place], [-1.28, -1.36], color=RIM, lw=0.8)
            axes.text(place, -1.4, name, **words)
        self.artists: list[Artist] = []
        self.rings, self.heavy, self.balls = [], [], []
        self.rods: list[list[Line2D | None]] = []  # of pendulums, for each disc
        for _, plane, mine in discs:
            self.rings += axes.plot([], [], color=RIM, lw=1.0)
            self.heavy += axes.plot([], [], color=UNBALANCE, lw=1.6)
            size_of = 26.0 if mine.size <= 6 else 14.0
            at, colored = np.zeros(mine.size), [colors[i] for i in mine]
            self.balls.append(axes.scatter(at, at, s=size_of, c=colored, edgecolors=INK, linewidths=0.5, zorder=3))
            self.rods.append(
                [axes.plot([], [], color=colors[i], lw=1.8)[0] if races.body[i] == "pendulum" else None for i in mine]
            )
            self.heavy[-1].set_visible(bool(np.abs(moments.plane_unbalance_in_rotor[:, plane]).any()))
        self.line = axes.plot([], [], color=INK, lw=1.8)[0]
        self.spots = axes.plot([], [], "o", ms=3.5, color=INK)[0]
        rods = [rod for line in self.rods for rod in line if rod is not None]
        self.artists += [*rods, *self.rings, *self.heavy, self.line, self.spots, *self.balls]

    def show(self, k: int) -> None:
        """Move every artist to frame ``k``."""
        turn = np.exp(1j * self.turned[k])
        center = self.center[k]
        self.line.set_data(*_seen(self.along, center))
        self.spots.set_data(*_seen(self.along, center))
        for i, (place, plane, mine) in enumerate(self.discs):
            reach = float(self.radii[mine].max())
            self.rings[i].set_data(*_seen(self.along[place], center[place] + reach * ROUND))
            heavy = np.exp(1j * np.angle(self.moments.plane_unbalance_in_rotor[k, plane])) * turn
            self.heavy[i].set_data(
                *_seen(self.along[place], center[place] + 0.72 * reach * heavy * np.array([0.0, 1.0]))
            )
            balls = (
                (self.radii - self.moments.ball_inside[k] / self.length)[mine]
                * np.exp(1j * self.moments.ball_angle_in_rotor[k, mine])
                * turn
            )
            for rod, ball in zip(self.rods[i], balls, strict=True):
                if rod is not None:
                    rod.set_data(*_seen(self.along[place], center[place] + ball * np.array([0.0, 1.0])))
            self.balls[i].set_offsets(np.column_stack(_seen(self.along[place], center[place] + balls)))


def _seen(along: Floats | float, z: Complexes) -> tuple[Floats, Floats]:
    """Places along the axis with a deflection, on the page."""
    return np.asarray(along - DEPTH * z.real), np.asarray(z.imag - SINK * z.real)
