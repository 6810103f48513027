"""The rotor from above, as artists that are built once and then only moved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from autobalancer.plots.drawing.style import FORCE, INK, RACE, UNBALANCE
from autobalancer.plots.run.body_shapes import CHAMFER, ROD
from autobalancer.results.drawn.forces import ForcesOfRaces, lines_of
from autobalancer.results.drawn.motion import Complexes, Floats, Moments, Races

SWEEP = np.linspace(0.0, 1.0, 60)  # points of the arc that a ball swept since the frame before
MEMORY = 8  # frames for which the path of the rotor center stays visible
PLATE, RIM = "#F7F8F9", "#8A949C"


def unit_length(moments: Moments, races: Races) -> float:
    """The length (m) that is 1 in the picture: the greatest orbit radius, or ten deflections if there is no race."""
    radius = float(races.orbit_radius.max(initial=0.0))
    return radius or 10.0 * float(np.abs(moments.deflection_in_rotor).max(initial=0.0)) or 1.0


class RotorView:
    """Disc, races, balls, unbalance and the path of the center; ``show(k)`` moves them to frame ``k``.

    Lengths are shares of ``length`` (m). ``turned`` is the angle (rad) by which the rotor is drawn in each frame: zero in
    its own frame. ``path`` has ``per_frame`` deflections (m, as drawn) for each frame.
    """

    def __init__(
        self,
        axes: Axes,
        moments: Moments,
        races: Races,
        turned: Floats,
        path: Complexes,
        per_frame: int,
        magnification: float,
        colors: Sequence[str],
        length: float,
        forces: ForcesOfRaces,
    ) -> None:
        self.moments, self.turned, self.per_frame = moments, turned, per_frame
        self.radii, self.places = races.orbit_radius / length, races.center / length
        self.path = path * magnification / length
        self.center = moments.deflection_in_rotor * np.exp(1j * turned) * magnification / length
        self.heavy = np.unwrap(np.angle(moments.unbalance_in_rotor))
        self.artists: list[Artist] = []
        self.placed = Affine2D()
        self.turning = self.placed + axes.transData
        diameter = races.ball_diameter / length
        outside = float((self.radii + 0.5 * diameter).max(initial=1.0))
        axes.set_aspect("equal")
        axes.set_axis_off()
        reach = 1.08 * outside + float(np.abs(self.center).max(initial=0.0))
        room = max(1.22 * outside, reach) + 0.16 * outside
        axes.set_xlim(-room, room)
        axes.set_ylim(-room, room)
        sides = ((1.0, "0°", "right"), (1j, "90°", "center"), (-1.0, "180°", "left"), (-1j, "−90°", "center"))
        for side, degrees, anchor in sides:
            spot = side * (room - (0.0 if anchor != "center" else 0.06 * outside))
            axes.text(spot.real, spot.imag, degrees, ha=anchor, va="center", fontsize=7.5, color="#606060")
        self._races(axes, np.where(races.body == "pendulum", 0.0, diameter), races.channel / length, outside)
        self.races, self.length, self.forces = races, length, forces
        self.symbols = axes.plot([], [], color=FORCE, lw=1.0, transform=self.turning)[0]
        self.artists.append(self.symbols)
        self._balls(axes, diameter, races.body, colors)
        reach = 0.72 * float(self.radii.min(initial=outside))
        self.heavy_line = axes.plot([0.0, reach], [0.0, 0.0], color=UNBALANCE, lw=2.0, transform=self.turning)[0]
        self.heavy_spot = axes.plot([reach], [0.0], "o", ms=9, color=UNBALANCE, transform=self.turning)[0]
        if np.abs(moments.unbalance_in_rotor).any():
            self.artists += [self.heavy_line, self.heavy_spot]
        resolved = np.abs(np.diff(turned)).max(initial=0.0) / per_frame < 0.5
        style: dict[str, Any] = {"lw": 0.9} if resolved else {"lw": 0.0, "marker": ".", "ms": 2.0}
        self.trace = axes.plot([], [], color=INK, alpha=0.7, **style)[0]
        self.artists.append(self.trace)
        self.artists += axes.plot([0.0], [0.0], "o", ms=5, color=INK, transform=self.turning)
        self.artists += axes.plot([0.0], [0.0], "+", ms=14, mew=1.0, color="#606060")
        self.key = [
            Line2D([], [], color=UNBALANCE, lw=2.0, marker="o", ms=6, label="direction of the unbalance"),
            Line2D([], [], color=INK, lw=3.0, label="zero mark"),
            Line2D([], [], color="#606060", lw=0.0, marker="+", ms=9, label="not deflected"),
        ]

    def show(self, k: int) -> None:
        """Move every artist to frame ``k``."""
        center, turned = complex(self.center[k]), float(self.turned[k])
        self.placed.clear().rotate(turned).translate(center.real, center.imag)
        heavy = np.exp(1j * self.heavy[k]) * 0.72 * float(self.radii.min(initial=1.0))
        self.heavy_line.set_data([0.0, heavy.real], [0.0, heavy.imag])
        self.heavy_spot.set_data([heavy.real], [heavy.imag])
        before = max(k - 1, 0)
        away = self.radii - self.moments.ball_inside[k] / self.length
        now, then = self.moments.ball_angle_in_rotor[k], self.moments.ball_angle_in_rotor[before]
        swept = np.clip(then - now + self.turned[before] - turned, -2.0 * np.pi, 2.0 * np.pi)
        for i, (ball, trail) in enumerate(zip(self.balls, self.trails, strict=True)):
            arc = self.places[i] + away[i] * np.exp(1j * (now[i] + swept[i] * SWEEP))
            ball.set_center((arc[0].real, arc[0].imag))
            if i in self.chamfers:
                self.chamfers[i].set_center((arc[0].real, arc[0].imag))
            if i in self.rods:
                for rod in self.rods[i]:
                    rod.set_data([self.places[i].real, arc[0].real], [self.places[i].imag, arc[0].imag])
            trail.set_data(arc.real, arc.imag)
        if self.forces:
            points = self._lines(away * np.exp(1j * now), float(self.moments.speed[k]))
            self.symbols.set_data(points.real, points.imag)
        seen = self.path[max(k - MEMORY, 0) * self.per_frame : k * self.per_frame + 1]
        self.trace.set_data(seen.real, seen.imag)

    def _lines(self, balls: Complexes, speed: float) -> Complexes:
        """Symbols of the forces with balls at these places, one after the other with a gap between."""
        found: list[complex] = []
        for (balancer, race), forces in self.forces.items():
            here = np.flatnonzero((self.races.balancer == balancer) & (self.races.race == race))
            if here.size:
                orbits = self.races.orbit_radius[here]
                places = list(balls[here] * self.length)
                for line in lines_of(forces, float(orbits.mean()), places, speed):
                    found += [*(np.array(line) / self.length + self.places[here[0]]), complex(np.nan, np.nan)]
        return np.array(found, np.complex128)

    def _races(self, axes: Axes, diameter: Floats, channel: Floats, outside: float) -> None:
        """The disc with its zero mark and the walls of its races."""
        circles = [Circle((0.0, 0.0), 1.06 * outside, fc=PLATE, ec=RIM, lw=1.2)]
        rings = {*zip(self.radii, diameter, channel, self.places, strict=True)}
        for radius, thick, wide, place in sorted(rings, key=lambda ring: -ring[0]):
            spot = (place.real, place.imag)
            circles.append(Circle(spot, radius + 0.5 * thick, fc=RACE, ec=RIM, lw=0.9))
            within = radius + 0.5 * thick - (wide if thick > 0.0 else 0.0)
            circles.append(Circle(spot, within, fc=PLATE, ec=RIM, lw=0.9))
        for circle in circles:
            circle.set_transform(self.turning)
            self.artists.append(axes.add_patch(circle))
        mark = [1.0 * outside, 1.06 * outside]
        self.artists += axes.plot(mark, [0.0, 0.0], color=INK, lw=3.0, solid_capstyle="butt", transform=self.turning)

    def _balls(self, axes: Axes, diameter: Floats, bodies: NDArray[np.object_], colors: Sequence[str]) -> None:
        """Balls to scale, points somewhat larger, each before the arc it swept; rods of pendulums below all of them."""
        self.trails: list[Line2D] = []
        self.balls: list[Circle] = []
        self.chamfers: dict[int, Circle] = {}
        self.rods: dict[int, list[Line2D]] = {}
        for i in (i for i, body in enumerate(bodies) if body == "pendulum"):
            style: dict[str, Any] = {"transform": self.turning, "solid_capstyle": "round"}
            edge, core = (
                axes.plot([], [], color=INK, lw=ROD + 1.4, **style),
                axes.plot([], [], color=colors[i], lw=ROD, **style),
            )
            self.rods[i] = [*edge, *core]
            self.artists += self.rods[i]
        for i, thick in enumerate(diameter):
            self.trails += axes.plot([], [], color=colors[i], lw=4.0, alpha=0.35, transform=self.turning)
            size = 0.5 * thick if thick > 0.0 else 0.04
            ball = Circle((0.0, 0.0), size, fc=colors[i], ec=INK, lw=0.8, transform=self.turning)
            axes.add_patch(ball)
            self.balls.append(ball)
            if bodies[i] == "roller":
                self.chamfers[i] = Circle((0.0, 0.0), CHAMFER * size, fc="none", ec=INK, lw=0.6, transform=self.turning)
                axes.add_patch(self.chamfers[i])
        self.artists += [*self.trails, *self.balls, *self.chamfers.values()]
