"""The race seen from above: where the balls are, and what is left of the unbalance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError, one_of
from autobalancer.plots.run.history import Planes, balancer_name, ball_looks, places, planes_of, static_part
from autobalancer.plots.style import ALL_BALLS, FORCE, HALO, INK, RACE, UNBALANCE, heading, legend_width, look, picture
from autobalancer.results.display_units import (
    AxisUnit,
    couple_text,
    length_axis,
    length_text,
    moment_text,
    round_down,
    significant,
    speed_axis,
    times_larger,
)
from autobalancer.results.drawn import ForcesOfRaces, Moments, Motion, Races, cubic, forces_of, lines_of, races_of
from autobalancer.results.run_argument import RunArgument, load_race_run
from autobalancer.units import optional_argument

COLUMNS = 3  # panels side by side
STILL = float(np.deg2rad(5.0))  # in a turn of the rotor; a ball that moves more does not balance


def race(
    run: RunArgument, *, time: float | str | None = None, balancer: int | None = None, speed_unit: str = "rpm"
) -> Figure:
    """Draw balls, races and the vectors of unbalance at one moment, in the frame of the rotor, a panel for each balancer.

    Balls and races are to scale (mm); a point ball is a small ring, a roller has a chamfer, a pendulum its rod; springs, magnets,
    pins and the like are thin lines. Arrows from the rotor center, to one scale but for a plane where they would be too short to
    read, which says how much longer they are there,
    are the unbalance that the balls of this plane have to balance, what they contribute, and the resultant of both; a
    resultant too small to be drawn is a dot. Where a ball moves in the rotor the resultant is dashed: it is that of a moment,
    not what the balls leave. On a rotor that tilts or bends the unbalance of each plane is its share of
    unbalance and couple together; dashed is what the couple puts there, opposite in the other plane. The triangle outside
    the races points where this plane is deflected to: with the unbalance below a critical speed, opposite to it above.
    If gravity also gives a static deflection, the triangle shows the vibration, and the static deflection is written beside it.
    The eccentricity of a race is drawn larger than it is; the picture gives the factor.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, with samples.
    time
        Moment in s, within the samples; by default their end.
    balancer
        Counted from 1; by default each balancer has its own panel.
    speed_unit
        Unit of the speed in the title: ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If the run has no balls or no samples, or the time or balancer does not exist.
    """
    run = load_race_run(run, "plot.race")
    time = optional_argument("time", time, "s")
    speeds, motion, races = speed_axis(speed_unit), Motion(run), races_of(run)
    if not races.orbit_radius.size or not (races.orbit_radius > 0.0).all():
        raise QuestionError("the run has no balls in races, so there is nothing to draw; try plot.run_up or plot.orbit")
    present = sorted(set(races.balancer.tolist()))
    if balancer is not None and balancer not in present:
        raise QuestionError(f"balancer: given {balancer}; the run has {', '.join(map(str, present))}")
    moments = motion.at(np.array([motion.time[-1] if time is None else float(time)]))
    chosen = present if balancer is None else [balancer]
    colors = [ball.color for ball in ball_looks(run)]
    planes, forces = planes_of(run), forces_of(run)
    passed = _passed(motion, moments)
    moving = {number: float(passed[races.balancer == number].max()) for number in chosen}
    vectors = {
        number: vectors_of(races, moments, planes, _plane(races, number), moving[number] > STILL) for number in chosen
    }
    longest = {number: max(abs(vector.value) for vector in each) for number, each in vectors.items()}
    loudest = max(chosen, key=lambda number: longest[number])
    with look():
        columns = min(len(chosen), COLUMNS)
        rows = -(-len(chosen) // columns)
        figure = picture(WIDTH * columns, 6.3 * rows)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel in panels[len(chosen) :]:
            panel.set_axis_off()
        drawn = []
        for panel, number in zip(panels, chosen, strict=False):
            mine = np.flatnonzero(races.balancer == number)
            plane = _plane(races, number)
            drawn.append(RacePanel(panel, races, moments, mine, colors, forces))
            longer = times_larger(longest[number], longest[loudest])
            drawn[-1].arrows(vectors[number], longest[loudest] / longer)
            still = _static(run, motion, moments, plane)
            turned = np.exp(-1j * float(moments.rotor_angle[0]))
            vibration = complex(moments.plane_deflection_in_rotor[0, plane]) - still * turned
            drawn[-1].triangle(vibration)
            words = couple_note(moments, planes)
            if words:
                drawn[-1].couple(complex(moments.couple_in_rotor[0]))
            what = "plane" if len(planes.names) > 1 else "rotor"
            scale = f"arrows {longer:g} times as long as for {balancer_name(run, loudest)}" if longer > 1.0 else ""
            going = ""
            if moving[number] > STILL:
                going = f"balls moved by {np.rad2deg(moving[number]):.0f}° in the last turn of the rotor: they do not balance it"
            eccentric = _eccentric(races, moments, mine, plane)
            drawn[-1].notes([scale, going, words, deflected(vibration, still, what), *eccentric])
            if len(present) > 1:
                drawn[-1].title(balancer_name(run, number))
        lines = max(each.lines for each in drawn)
        height = max(each.room(lines) for each in drawn)
        figure.set_size_inches(WIDTH * columns, height * rows + 0.35)
        heading(figure, _title(run, moments, speeds))
    return figure


def _title(run: xr.Dataset, moments: Moments, unit: AxisUnit) -> str:
    name = run.attrs.get("machine_name", run.attrs.get("title", ""))
    speed = significant(float(moments.speed[0]) * unit.factor)
    return f"{name}, at {moments.time[0]:.6g} s, {speed} {unit.sign}"


def _plane(races: Races, balancer: int) -> int:
    """The plane of a balancer, from 0."""
    return int(races.plane[np.flatnonzero(races.balancer == balancer)[0]])


def _passed(motion: Motion, moments: Moments) -> Floats:
    """How far each ball moved in the rotor in the last turn of the rotor, rad."""
    time = float(moments.time[0])
    turn = 2.0 * np.pi / max(abs(float(moments.speed[0])), 1e-12)
    before, now = motion.at(np.array([max(time - turn, float(motion.time[0])), time])).ball_angle_in_rotor
    return np.asarray(np.abs(now - before))


def _static(run: xr.Dataset, motion: Motion, moments: Moments, plane: int) -> complex:
    in_space = motion.plane_deflection_in_rotor[:, plane] * np.exp(1j * motion.rotor_angle)
    return static_part(run, motion.time, motion.rotor_angle, in_space, float(moments.time[0]))


def _eccentric(races: Races, moments: Moments, balls: np.ndarray, plane: int) -> list[str]:
    """Why a resultant is left where balls balance a race that is off center."""
    center = races.center[balls][int(np.argmax(np.abs(races.center[balls])))]
    if not center:
        return []
    off = complex(moments.plane_deflection_in_rotor[0, plane]) + complex(center)
    if abs(off) > 0.05 * abs(center):
        return []
    return [
        f"the balls balance the race, so its center (×) does not move: the rotor stays {length_text(abs(center))} off,",
        "and the resultant is what holds it there",
    ]


# One balancer from above: protractor, races, balls with their numbers, arrows and words.


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


# The vectors of unbalance in the plane of a balancer.


class Vector(NamedTuple):
    """An arrow in the frame of the rotor."""

    value: complex  # kg m
    label: str
    color: str
    dashed: bool = False


def vectors_of(races: Races, moments: Moments, planes: Planes, plane: int, moving: bool = False) -> list[Vector]:
    """Unbalance, balls and resultant of one plane at the first of the ``moments``; before them what a couple puts there.

    The resultant of ``moving`` balls is dashed, and that of a moment.
    """
    met = complex(moments.plane_unbalance_in_rotor[0, plane])
    balls = complex(races.vectors(moments)[0, races.plane == plane].sum())
    where = " in this plane" if len(planes.names) > 1 else ""
    here = races.plane == plane
    bodies = set(races.body[here].tolist())
    whose = f"{bodies.pop()}s" if len(bodies) == 1 else "balls"
    whose += " of all balancers" if len(set(races.balancer[here].tolist())) > 1 else ""
    return [
        *_couple(moments, planes, plane),
        Vector(met, f"unbalance{where} {moment_text(abs(met))}", UNBALANCE),
        Vector(balls, f"{whose} {moment_text(abs(balls))}", ALL_BALLS),
        Vector(met + balls, f"resultant {'now ' * moving}{moment_text(abs(met + balls))}", INK, moving),
    ]


def _couple(moments: Moments, planes: Planes, plane: int) -> list[Vector]:
    """The share of a couple unbalance: in two planes a pair of opposite vectors; the part at greater z is that of the couple."""
    couple = complex(moments.couple_in_rotor[0])
    away = float(np.ptp(planes.position)) if len(planes.names) == 2 else np.nan
    if not couple or not away > 0.0:
        return []
    sign = 1.0 if planes.position[plane] == planes.position.max() else -1.0
    share = sign * couple / away
    return [Vector(share, f"of which couple {moment_text(abs(share))} ({couple_text(abs(couple))})", UNBALANCE, True)]


def couple_note(moments: Moments, planes: Planes) -> str:
    """A couple unbalance in words, where it cannot be drawn as a pair of vectors."""
    couple = complex(moments.couple_in_rotor[0])
    if not couple or len(planes.names) == 2:
        return ""
    return f"◇ couple unbalance {couple_text(abs(couple))}, at greater z towards {np.rad2deg(np.angle(couple)):.0f}°"


# How a ball, a roller and a pendulum look from above.


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


# The orbits of the rotor center, or of several places on its axis.


POINTS_A_TURN = 8  # fewer do not draw an orbit, only points of it
QUIET = 0.1  # of the greatest orbit; a smaller one has its own scale


def orbit(
    run: RunArgument,
    *,
    start: float | str | None = None,
    end: float | str | None = None,
    frame: Literal["space", "rotor"] = "space",
    place: str | None = None,
    deflection_unit: str | None = None,
    speed_unit: str = "rpm",
) -> Figure:
    """Draw the path of the rotor center about its static position, with start and direction.

    On a rotor that tilts or bends each plane of balancers and each station has its panel, all to one scale: a conical
    motion shows as starts on opposite sides. A place that moves less than a tenth as much as another is drawn larger, and
    says so. Where gravity gives the rotor a static deflection, the picture is centered on that position and states it. A
    vibration below 0.01 nm, or below what the tolerance of the run resolves, is a dot.

    Without ``start`` and ``end`` these are the last revolutions, if the run kept them (``LastRevolutions``), else the
    last twentieth of the samples. Fewer than eight samples per revolution are stroboscopic: in space they are
    drawn as points, because a line through them would not be the orbit; in the frame of the rotor, where the unbalance
    does not move, they are joined by a line.

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`.
    start, end
        Interval in s.
    frame
        ``"space"``: axes that stand still; ``"rotor"``: axes that turn with the rotor.
    place
        Name of a balancer or station; by default all of them.
    deflection_unit
        ``"m"``, ``"mm"``, ``"um"`` or ``"nm"``; by default the one that suits the greatest vibration.
    speed_unit
        Unit of the speed in the title: ``"rpm"``, ``"rad/s"`` or ``"Hz"``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If the run has neither samples nor last revolutions in the interval, has no such place, or a unit or frame is
        unknown.
    """
    run = load_race_run(run, "plot.orbit")
    start = optional_argument("start", start, "s")
    end = optional_argument("end", end, "s")
    one_of("frame", frame, "space", "rotor")
    speeds = speed_axis(speed_unit)
    paths = orbit_paths(run, start, end)
    if place is not None:
        known = [path.name for path in paths]
        paths = [path for path in paths if path.name == place]
        if not paths:
            raise QuestionError(f"place: given {place!r}; the run has {', '.join(map(repr, known))}")
    greatest = max(float(np.abs(path.deflection).max()) for path in paths)
    least = max(NOTHING, _resolved(run))
    with look():
        columns = min(len(paths), COLUMNS)
        rows = -(-len(paths) // columns)
        figure = picture(4.9 * columns + 0.5, 5.2 * rows + 0.9)
        figure.set_layout_engine("constrained", w_pad=0.12, h_pad=0.06)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for panel in panels[len(paths) :]:
            panel.set_axis_off()
        for panel, path in zip(panels, paths, strict=False):
            own = float(np.abs(path.deflection).max())
            larger = times_larger(own, greatest, QUIET) if own >= least else 1.0
            unit = length_axis(deflection_unit, greatest / larger)
            span = 1.15 * greatest / larger * unit.factor if greatest >= least else 1.0
            _draw(panel, path, unit, span, in_space=frame == "space", noise=own < least)
            if len(paths) > 1 or place is not None:
                panel.set_title(path.name if larger == 1.0 else f"{path.name}, drawn {larger:g} times larger")
        handles = {
            label: handle for panel in panels for handle, label in zip(*panel.get_legend_handles_labels(), strict=True)
        }
        figure.legend(handles=list(handles.values()), loc="outside lower center", ncols=4)
        heading(figure, _title_of_orbit(run, paths[0], speeds))
    return figure


def _draw(axes: Axes, path: OrbitPath, unit: AxisUnit, span: float, *, in_space: bool, noise: bool) -> None:
    turned = path.rotor_angle if in_space else np.zeros_like(path.rotor_angle)
    place = path.deflection * np.exp(1j * turned) * unit.factor
    rate = 2.0 * np.pi / max(float(np.abs(np.diff(path.rotor_angle)).max()), 1e-12)
    axes.set_aspect("equal")
    if noise:
        axes.plot(0.0, 0.0, "o", ms=5, color=INK, label="rotor center")
        size = length_text(float(np.abs(path.deflection).max()))
        axes.annotate(f"{size}: no vibration" if size.startswith("<") else f"{size}: below the tolerance of the run",
                      (0.0, 0.0), xytext=(0.0, 9.0), textcoords="offset points", ha="center", fontsize=8.5)  # fmt: skip
    else:
        if rate < POINTS_A_TURN:
            axes.plot(place.real, place.imag, ".", ms=3, color=INK, label=f"samples, {rate:.2g} a revolution")
        if rate >= POINTS_A_TURN or not in_space:
            line = path.between(in_space=in_space) * unit.factor
            axes.plot(line.real, line.imag, color=INK, lw=0.9, alpha=0.8, label="rotor center")
            _direction(axes, line)
        label = f"at {path.time[0]:.5g} s"
        axes.plot(place[0].real, place[0].imag, "o", ms=6, mfc="white", mec=UNBALANCE, mew=1.8, label=label)
    rest = "static position" if path.static else "not deflected"
    axes.plot(0.0, 0.0, "+", ms=9, mew=1.2, color="#808080", label=rest, zorder=1.5)
    axes.set(xlim=(-span, span), ylim=(-span, span))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
    what = "vibration" if path.static else "deflection"
    where = "in space" if in_space else "in the rotor"
    axes.set(xlabel=f"{what} along x {where} ({unit.sign})", ylabel=f"{what} along y {where} ({unit.sign})")
    if path.static:
        digits = 2 - int(np.floor(np.log10(abs(path.static) * 1e6)))
        rounded = (round(value * 1e6, digits) + 0.0 for value in (path.static.real, path.static.imag))
        x, y = (f"{value:g}".replace("-", "−") for value in rounded)
        axes.text(
            0.02, 0.98, f"static position x = {x} µm, y = {y} µm", transform=axes.transAxes, va="top", fontsize=8.5,
            path_effects=HALO,
        )  # fmt: skip


def _resolved(run: xr.Dataset) -> float:
    """Vibration (m) below which only the error of the integration is left to be drawn."""
    peaks = [float(np.nanmax(run[name].values)) for name in ("deflection", "envelope_high") if name in run]
    return float(run.attrs.get("tolerance", 0.0)) * max(peaks, default=0.0)


def _direction(axes: Axes, line: Complexes) -> None:
    """An arrow head on the line, a little after the start."""
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(line)))])
    if length[-1] == 0.0:
        return
    reach = min(length[-1], np.pi * float(np.abs(line).max()))
    i = int(np.clip(np.searchsorted(length, 0.25 * reach), 1, line.size - 1))
    axes.annotate(
        "",
        (line[i].real, line[i].imag),
        xytext=(line[i - 1].real, line[i - 1].imag),
        arrowprops={"arrowstyle": "-|>,head_length=0.8,head_width=0.35", "color": INK, "shrinkA": 0, "shrinkB": 0},
    )


def _title_of_orbit(run: xr.Dataset, path: OrbitPath, unit: AxisUnit) -> str:
    name = run.attrs.get("machine_name", run.attrs.get("title", ""))
    speed = path.speed * unit.factor
    low, high = significant(float(speed.min())), significant(float(speed.max()))
    turns = abs(float(path.rotor_angle[-1] - path.rotor_angle[0])) / (2.0 * np.pi)
    rate = f"{high} {unit.sign}" if low == high else f"{low} to {high} {unit.sign}"
    return f"{name}\n{path.time[0]:.5g} s to {path.time[-1]:.5g} s, {turns:.3g} revolutions at {rate}"


# The paths that an orbit is drawn from: last revolutions or samples of each place on the axis.


class OrbitPath(NamedTuple):
    """Moments of one place as they were kept; the deflection is about the static position."""

    name: str
    time: Floats
    speed: Floats  # rad/s
    rotor_angle: Floats  # rad
    deflection: Complexes  # m, in the rotor
    static: complex  # m, in space

    def between(self, *, in_space: bool) -> Complexes:
        """The path with seven points between two samples, a cubic in the rotor."""
        count = self.time.size
        fine = np.interp(np.linspace(0.0, count - 1.0, 8 * (count - 1) + 1), np.arange(count), self.time)
        path = cubic(fine, self.time, self.deflection, np.gradient(self.deflection, self.time))
        if not in_space:
            return path
        angle = cubic(fine, self.time, self.rotor_angle, self.speed)
        return np.asarray(path * np.exp(1j * angle))


def orbit_paths(run: xr.Dataset, start: float | None, end: float | None) -> list[OrbitPath]:
    """The moments to draw of each place: the last revolutions, else samples.

    Raises
    ------
    QuestionError
        If the run has neither in the interval.
    """
    for prefix, dimension in (("turn_", "turn"), ("", "time")):
        needed = [f"{prefix}{name}" for name in ("time", "speed", "x", "y")]
        if not all(name in run for name in needed) or run[needed[0]].size < 2:
            continue
        time = np.asarray(run[needed[0]].values, np.float64)
        first, last = float(time[0]), float(time[-1])
        begin = start if start is not None else first if prefix else last - 0.05 * (last - first)
        final = last if end is None else end
        if prefix and (begin < first - 1e-9 or final > last + 1e-9) and "time" in run:
            continue  # the samples reach farther
        inside = np.flatnonzero((time >= begin - 1e-9) & (time <= final + 1e-9))
        if inside.size < 2:
            raise QuestionError(
                f"from {begin:g} s to {final:g} s: fewer than two samples; the run has {first:g} s to {last:g} s"
            )
        return _paths(run.isel({dimension: inside}), prefix)
    raise QuestionError("the run has no samples; save Samples() or LastRevolutions() with simulate(..., save=...)")


def _paths(part: xr.Dataset, prefix: str) -> list[OrbitPath]:
    time, speed = (np.asarray(part[f"{prefix}{name}"].values, np.float64) for name in ("time", "speed"))
    if f"{prefix}rotor_angle" in part:
        angle = np.asarray(part[f"{prefix}rotor_angle"].values, np.float64)
    else:  # measured: from the speed, counted from the first sample
        angle = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * np.diff(time))])
    paths = []
    for place in places(part, prefix):
        static = static_part(part, time, angle, place.deflection, float(time[-1]), samples=time.size)
        moved = (place.deflection - static) * np.exp(-1j * angle)
        paths.append(OrbitPath(place.name, time, speed, angle, np.asarray(moved), static))
    return paths
