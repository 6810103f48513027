"""One balancer from above: protractor, races, balls with their numbers, arrows and words."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch
from numpy.typing import NDArray

from autobalancer.plots.drawing.style import FORCE, INK, RACE, legend_width
from autobalancer.plots.run.body_shapes import draw_body
from autobalancer.plots.run.race_vectors import Vector
from autobalancer.results.display_units import length_text, round_down
from autobalancer.results.drawn.forces import ForcesOfRaces, lines_of
from autobalancer.results.drawn.motion import Floats, Moments, Races

RIM = "#8A949C"
NOTHING = 1e-11  # m; a deflection below it is none
ROOM = 10.0  # points that a number on a ball needs
WIDTH = 5.6  # inches of a panel
TOP, BOTTOM, SIDE = 1.26, 1.3, 1.3  # reaches from the center to the edges of the picture proper
LINE = 14.0  # points of a line of text


class RacePanel:
    """Draws into ``axes``, lengths in mm, the balls ``mine`` of one balancer at the first of the ``moments``."""

    def __init__(
        self,
        axes: Axes,
        races: Races,
        moments: Moments,
        mine: NDArray[np.intp],
        colors: list[str],
        forces: ForcesOfRaces,
    ) -> None:
        self.axes, self.mine = axes, mine
        self.radius, self.diameter = races.orbit_radius[mine] * 1e3, races.ball_diameter[mine] * 1e3
        self.away = self.radius - moments.ball_inside[0, mine] * 1e3  # of the ball centers
        self.body, self.channel = races.body[mine], races.channel[mine] * 1e3
        self.angle, self.speed = moments.ball_angle_in_rotor[0, mine], float(moments.speed[0])
        self.outside = float((self.radius + 0.5 * self.diameter).max())
        centers = races.center[mine]
        self.center = complex(centers[int(np.argmax(np.abs(centers)))])
        eccentric = abs(self.center) * 1e3
        self.larger = max(1.0, round_down(0.06 * self.outside / eccentric)) if eccentric else 1.0
        self.centers = centers * 1e3 * self.larger
        self.reach = self.outside + float(np.abs(self.centers).max())
        self.size = 0.95 * WIDTH * 72.0 / (2.0 * SIDE * self.reach)  # points for a mm
        self.lines, self.top = 0, TOP * self.reach  # of text below, and the upper edge
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_xlim(-SIDE * self.reach, SIDE * self.reach)
        self._protractor()
        self._races()
        self._forces(races, forces)
        least = 0.03 * self.outside
        for i, place in enumerate(self.centers + self.away * np.exp(1j * self.angle)):
            draw_body(axes, self.body[i], self.centers[i], place, self.diameter[i], colors[mine[i]], least)
        self._numbers(colors, least)
        axes.plot(0.0, 0.0, "+", ms=9, mew=1.3, color=INK)

    def arrows(self, vectors: Sequence[Vector], longest: float) -> None:
        """The ``longest`` (kg m) would end well within the races; their sizes in a legend below."""
        length = 0.72 * float((self.radius + 0.5 * self.diameter - self.channel).min())
        scale = length / (longest or 1.0)
        for order, vector in enumerate(vectors):
            tip = vector.value * scale
            if abs(tip) > 0.05 * length:
                arrow = FancyArrowPatch(
                    (0.0, 0.0),
                    (tip.real, tip.imag),
                    arrowstyle="-|>,head_length=7,head_width=3.2",
                    color=vector.color,
                    lw=1.4 if vector.dashed else 2.2,
                    ls=(0, (4, 2)) if vector.dashed else "-",
                    fill=not vector.dashed,
                    shrinkA=0,
                    shrinkB=0,
                    zorder=3.0 + 0.1 * order,
                )
                self.axes.add_patch(arrow)
            elif not vector.dashed:
                self.axes.plot(tip.real, tip.imag, "o", ms=4, color=vector.color, zorder=3.5)
        handles = [
            Line2D([], [], color=v.color, lw=1.4 if v.dashed else 2.6, ls="--" if v.dashed else "-", label=v.label)
            for v in vectors
        ]
        columns = 3 if len(vectors) == 3 and legend_width([v.label for v in vectors], 3) < 72.0 * WIDTH else 2
        self.axes.legend(
            handles=handles, loc="upper center", bbox_to_anchor=(0.0, -BOTTOM * self.reach), ncols=columns,
            bbox_transform=self.axes.transData, borderaxespad=0.0, handlelength=1.5, columnspacing=1.1,
        )  # fmt: skip
        self.lines += -(-len(vectors) // columns)

    def triangle(self, deflection: complex) -> None:
        """Where the plane is deflected to (m, in the rotor)."""
        if abs(deflection) > NOTHING:
            side = deflection / abs(deflection) * 1.06 * self.reach
            turned = (3, 0, float(np.rad2deg(np.angle(deflection))) - 90.0)
            self.axes.plot(side.real, side.imag, marker=turned, ms=10, color=INK, clip_on=False)

    def couple(self, direction: complex) -> None:
        """A mark on both sides for a couple unbalance that is not drawn as arrows."""
        side = direction / abs(direction) * 0.9 * float((self.radius - 0.5 * self.diameter).min())
        for sign, fill in ((1.0, "full"), (-1.0, "none")):
            self.axes.plot(
                sign * side.real, sign * side.imag, "D", ms=6, color="#D55E00", fillstyle=fill, mew=1.2, zorder=3.4
            )

    def notes(self, more: Sequence[str]) -> None:
        """Sizes, then ``more`` lines, below the legend."""
        sizes = ["orbit radius " + _and([f"{r:.4g}" for r in sorted({*self.radius})]) + " mm"]
        sizes += [_named(*kind) for kind in sorted({*zip(self.body, self.diameter, strict=True)})]
        lines = [", ".join(sizes), *more]
        if self.center:
            drawn = f", drawn {self.larger:g} times larger (×)" if self.larger > 1.0 else " (×)"
            direction = np.rad2deg(np.angle(self.center))
            lines.insert(1, f"eccentricity {length_text(abs(self.center))} at {direction:.0f}°{drawn}")
        lines = [line for line in lines if line]
        below = -BOTTOM * self.reach - (6.0 + LINE * self.lines) / self.size
        self.axes.text(0.0, below, "\n".join(lines), ha="center", va="top", fontsize=8.5)
        self.lines += len(lines)

    def title(self, text: str) -> None:
        """A name above, at the left."""
        self.top += 1.3 * LINE / self.size
        self.axes.text(-SIDE * self.reach, self.top, text, va="top", weight="bold", fontsize=10.5)

    def room(self, lines: int) -> float:
        """Leave room for so many lines of text below; returns the height in inches that the panel then takes."""
        below = BOTTOM * self.reach + (8.0 + LINE * lines) / self.size
        self.axes.set_ylim(-below, self.top)
        return (below + self.top) * self.size / 72.0

    def _forces(self, races: Races, forces: ForcesOfRaces) -> None:
        """Symbols of the forces on the balls, race by race."""
        for place in sorted(forces):
            here = np.flatnonzero((races.balancer[self.mine] == place[0]) & (races.race[self.mine] == place[1]))
            if here.size:
                orbit = float(self.radius[here].mean()) * 1e-3
                balls = list(1e-3 * self.away[here] * np.exp(1j * self.angle[here]))
                for line in lines_of(forces[place], orbit, balls, self.speed):
                    points = np.array(line) * 1e3 + self.centers[here[0]]
                    self.axes.plot(points.real, points.imag, color=FORCE, lw=1.1, zorder=1.6)

    def _protractor(self) -> None:
        """Angles from the zero mark of the rotor."""
        for degrees in range(0, 360, 30):
            ray = np.exp(1j * np.deg2rad(degrees))
            tip = 1.12 * self.reach * ray
            self.axes.plot([0.0, tip.real], [0.0, tip.imag], color="#E3E3E3", lw=0.7, zorder=0)
            shown = degrees if degrees <= 180 else degrees - 360
            place = 1.19 * self.reach * ray
            weight = "bold" if degrees == 0 else "normal"
            self.axes.text(
                place.real, place.imag, f"{shown}°".replace("-", "−"), ha="center", va="center", fontsize=8.5,
                weight=weight, color="#606060",
            )  # fmt: skip

    def _races(self) -> None:
        """The walls of each race, or the circle on which points and pendulums move; from the outermost inwards."""
        walls = np.where(self.body == "pendulum", 0.0, self.diameter)
        rings = sorted({*zip(self.radius, walls, self.channel, self.centers, strict=True)}, key=lambda ring: -ring[0])
        for depth, (radius, diameter, channel, center) in enumerate(rings):
            place, order = (center.real, center.imag), 1.0 + 0.1 * depth
            if diameter > 0.0:
                self.axes.add_patch(Circle(place, radius + 0.5 * diameter, fc=RACE, ec=RIM, lw=1.0, zorder=order))
                within = radius + 0.5 * diameter - channel
                inner = Circle(place, within, fc="white", ec=RIM, lw=1.0, zorder=order + 0.02)
                self.axes.add_patch(inner)
            path = Circle(place, radius, fc="none", ec=RIM, lw=0.7, ls=(0, (6, 4)), zorder=order + 0.04)
            self.axes.add_patch(path)
            if center:
                self.axes.plot(*place, "x", ms=6, mew=1.2, color=RIM)

    def _numbers(self, colors: list[str], least: float) -> None:
        """On the balls where they are large enough; else beside them, outside the outermost race and inside the others."""
        for i, (number, angle) in enumerate(zip(self.mine + 1, self.angle, strict=True)):
            if self.diameter[i] * self.size >= ROOM:
                place, color = self.away[i] * np.exp(1j * angle), _readable(colors[self.mine[i]])
            else:
                outer = self.radius[i] == self.radius.max() and len({*self.radius}) > 1
                away = max(0.5 * self.diameter[i], least) + 1.7 * least
                beside = self.radius[i] + (away if outer or self.body[i] == "pendulum" else -away)
                same = np.flatnonzero(self.radius == self.radius[i])
                spread = spread_angles(self.angle[same], 13.0 / (self.size * beside))
                place = beside * np.exp(1j * spread[int(np.flatnonzero(same == i)[0])])
                color = INK
            place = place + self.centers[i]
            self.axes.text(
                place.real, place.imag, f"{number}", ha="center", va="center_baseline", fontsize=8.0, color=color,
                zorder=5,
            )  # fmt: skip


def deflected(vibration: complex, static: complex, what: str = "rotor") -> str:
    """The deflection of the rotor, or its plane, in words: m, the static part in space."""
    if abs(static) > NOTHING:
        side = f"{np.rad2deg(np.angle(static)):.0f}°".replace("-", "−")
        moving = (
            f"▲ vibration {length_text(abs(vibration))}" if abs(vibration) > NOTHING else "no vibration (< 0.01 nm)"
        )
        return f"{moving} about a static deflection of {length_text(abs(static))} at {side} in space"
    if abs(vibration) <= NOTHING:
        return f"{what} not deflected (< 0.01 nm)"
    return f"▲ {what} deflected {length_text(abs(vibration))} this way"


def spread_angles(angle: Floats, gap: float) -> Floats:
    """Angles for numbers: those of the balls, pushed apart to ``gap`` (rad) where balls are close."""
    placed = angle % (2.0 * np.pi)
    if angle.size < 2 or angle.size * gap >= 2.0 * np.pi:
        return placed
    for _ in range(50):
        order = np.argsort(placed)
        ring = np.append(placed[order], placed[order[0]] + 2.0 * np.pi)
        lacking = np.maximum(gap - np.diff(ring), 0.0)
        if lacking.max() < 1e-3:
            break
        placed[order] += 0.5 * (np.roll(lacking, 1) - lacking)
    return placed


def _named(body: str, diameter: float) -> str:
    """Bodies of one size in words."""
    if diameter > 0.0:
        return f"{body}s {diameter:.4g} mm"
    return "pendulums" if body == "pendulum" else "point balls"


def _readable(color: str) -> str:
    """White on dark balls, ink on light ones."""
    red, green, blue = (int(color[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    return "white" if 0.299 * red + 0.587 * green + 0.114 * blue < 0.5 else INK


def _and(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
