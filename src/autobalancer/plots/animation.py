"""Films of a run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle
from matplotlib.text import Text
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.plots.film_frames import FilmCanvas, FilmQuestion, frame_times, magnification, pace, size_words
from autobalancer.plots.run.history import (
    Deflections,
    PlacesInRotor,
    ball_looks,
    critical_speeds_of,
    deflections_of,
    ends_at,
    history_of,
    places_in_rotor,
    planes_of,
    quiet,
)
from autobalancer.plots.run.race_and_orbit import CHAMFER, ROD
from autobalancer.plots.run.run_up import deflection_panel, speed_panel
from autobalancer.plots.style import FORCE, INK, RACE, UNBALANCE
from autobalancer.results.display_units import EACH_ITS_OWN, AxisUnit, length_axis, length_text, significant
from autobalancer.results.drawn import ForcesOfRaces, Moments, Motion, Races, forces_of, lines_of, races_of

PATH_POINTS = 16  # points of the path of the rotor center for each frame


def race_scene(run: xr.Dataset, film: FilmQuestion) -> Scene:
    """What a ``film`` of a run of balls in races shows.

    Raises
    ------
    QuestionError
        If the run has no samples there, or the deflection is to be drawn in an impossible size.
    """
    motion, races, turns = Motion(run), races_of(run), film.frame == "space"
    times = _frame_times(motion.time, film.start, film.end, film.frames)
    moments = motion.at(times)
    index = np.arange(times.size)
    fine = motion.at(np.interp(np.arange((times.size - 1) * PATH_POINTS + 1) / PATH_POINTS, index, times))
    along = places_in_rotor(run, times)
    drawn = [fine.deflection_in_rotor, fine.plane_deflection_in_rotor, *([] if along is None else [along.deflection])]
    greatest = max(float(np.abs(z).max()) for z in drawn)
    scale = magnification(film.scale, greatest, unit_length(moments, races), 0.15)
    return Scene(
        run,
        moments,
        fine,
        races,
        in_space=turns,
        per_frame=PATH_POINTS,
        magnification=scale,
        unit=film.unit,
        caption=_caption(moments, turns, film.duration, scale, bool(races.orbit_radius.size)),
        width=film.width,
    )


def _frame_times(samples: Floats, start: float | None, end: float | None, count: int) -> Floats:
    """Equal steps, moved to the nearest sample where the samples are the denser."""
    times = frame_times(samples, start, end, count)
    inner = samples[(samples >= times[0]) & (samples <= times[-1])]
    if inner.size < 2 or np.diff(inner).max() > times[1] - times[0]:
        return times
    right = np.clip(np.searchsorted(inner, times), 1, inner.size - 1)
    nearest = np.where(times - inner[right - 1] < inner[right] - times, right - 1, right)
    return np.asarray(inner[nearest])


def _caption(moments: Moments, turns: bool, duration: float, scale: float, with_race: bool) -> str:
    fastest = float(np.abs(np.diff(moments.rotor_angle)).max()) / (2.0 * np.pi)
    if not turns:
        view = "in the frame of the rotor, as under a stroboscope"
    elif fastest < 0.1:
        view = "in space"
    else:
        view = f"in space, up to {significant(fastest)} turns between two frames"
    size = size_words("deflection", scale) if with_race else "not to scale"
    return f"{view}\n{pace(duration, moments.time)}, {size}"


# The scene of a film: each plane of the rotor from above, the axis from the side, beside panels over time.


LEFT, RIGHT = 0.52, 0.575  # how far the rotor reaches, and where the panels begin
BOTTOM, TOP = 0.125, 0.885


class Scene(FilmCanvas):
    """Draws frame after frame on one canvas.

    ``fine`` has ``per_frame`` moments for each frame of ``moments``, for the path of the centers; ``turned`` (rad) is the
    angle by which the rotor is drawn, zero in its own frame, for both.
    """

    def __init__(
        self,
        run: xr.Dataset,
        moments: Moments,
        fine: Moments,
        races: Races,
        *,
        in_space: bool,
        per_frame: int,
        magnification: float,
        unit: AxisUnit,
        caption: str,
        width: int,
    ) -> None:
        super().__init__(width)
        self.moments, self.unit = moments, unit
        self.turned = moments.rotor_angle if in_space else np.zeros_like(moments.rotor_angle)
        figure, middle = self.figure, 0.5 * LEFT
        colors = [ball.color for ball in ball_looks(run)]
        planes = [plane for plane in range(moments.plane_deflection_in_rotor.shape[1]) if (races.plane == plane).any()]
        names = planes_of(run).names
        several = len(planes) > 1
        along = places_in_rotor(run, moments.time)
        ground = BOTTOM if along is None else BOTTOM + (0.34 if several else 0.28)
        self.views: list[RotorView] = []
        self.sizes: list[tuple[Text, int]] = []
        for number, plane in enumerate(planes or [0]):
            mine = np.flatnonzero(races.plane == plane)
            wide = LEFT / max(len(planes), 1)
            above = figure.add_axes(
                (number * wide, ground, wide, TOP - ground - (0.0, 0.0, 0.03, 0.06)[min(len(planes), 3)])
            )
            path = _of_plane(fine, plane, mine).deflection_in_rotor
            path = path * np.exp(1j * fine.rotor_angle) if in_space else path
            view = RotorView(
                above, _of_plane(moments, plane, mine), races.of(mine), self.turned, path, per_frame, magnification,
                [colors[i] for i in mine], unit_length(moments, races), forces_of(run),
            )  # fmt: skip
            self.views.append(view)
            if several:
                x = (number + 0.5) * wide
                words: dict[str, Any] = {"va": "center", "fontsize": 8.5}
                pair = len(planes) == 2  # else there is no room in one line
                named, sized = ("right", "left") if pair else ("center", "center")
                off, below = (0.005, 0.01) if pair else (0.0, 0.038)
                figure.text(x - off, TOP - 0.01, names[plane], ha=named, weight="bold", **words)
                size = figure.text(x + off, TOP - below, "", ha=sized, family="monospace", **words)
                self.sizes.append((size, plane))
        self.axis: AxisView | None = None
        if along is not None:
            beside = figure.add_axes((0.0, BOTTOM, LEFT, ground - BOTTOM))
            discs = [
                (along.names.index(names[p]), p, np.flatnonzero(races.plane == p))
                for p in planes
                if names[p] in along.names
            ]
            length = unit_length(moments, races)
            self.axis = AxisView(beside, along, moments, races, self.turned, magnification, length, discs, colors)
        self.write(run, middle, (0.965, 0.92, 0.012), caption)
        figure.legend(handles=self.views[0].key, loc="lower center", bbox_to_anchor=(middle, 0.08), ncols=3)
        self._panels(run)
        beside_artists = [] if self.axis is None else self.axis.artists
        sizes = [size for size, _ in self.sizes]
        self.freeze([*(artist for view in self.views for artist in view.artists), *beside_artists, self.text, *sizes])

    def frame(self, k: int) -> NDArray[np.uint8]:
        """Pixels of frame ``k``: rows, columns, red-green-blue."""
        for view in self.views:
            view.show(k)
        if self.axis is not None:
            self.axis.show(k)
        for text, plane in self.sizes:
            text.set_text(f"{length_text(float(np.abs(self.moments.plane_deflection_in_rotor[k, plane])))}")
        self.text.set_text(self._words(k))
        return self.pixels(float(self.moments.time[k]))

    def _words(self, k: int) -> str:
        step = float(np.ptp(self.moments.time)) / max(self.moments.time.size - 1, 1)
        digits = int(np.clip(np.ceil(-np.log10(step) - 1e-6), 0, 9)) if step > 0.0 else 3
        speed = significant(float(self.moments.speed[k]) * self.unit.factor)
        words = f"{self.moments.time[k]:.{digits}f} s  {speed:>6} {self.unit.sign}"
        if self.sizes:
            return words
        return f"{words}  {length_text(float(np.abs(self.moments.deflection_in_rotor[k]))):>10}"

    def _panels(self, run: xr.Dataset) -> None:
        """Speeds and deflection over the time of the film, each with a cursor."""
        first, last = float(self.moments.time[0]), float(self.moments.time[-1])
        upper, lower = self.panels(RIGHT + 0.02, first, last)
        history, deflections = history_of(run, first, last), deflections_of(run, first, last)
        if history is not None and history.time.size > 1:
            speed_panel(upper, history, critical_speeds_of(run), self.unit, ball_looks(run))
        if deflections is None or deflections.time.size < 2:  # a short film between two bins or samples
            size = np.abs(self.moments.deflection_in_rotor)
            deflections = Deflections(self.moments.time, size, size, False, ends=ends_at(run, last))
        log = quiet(deflections)
        unit = EACH_ITS_OWN if log else length_axis(None, float(deflections.high.max()))
        deflection_panel(lower, deflections, unit, log=log, brief=True)
        lower.set(xlabel="time (s)", xlim=(first, last))
        self.figure.align_ylabels([upper, lower])


def _of_plane(moments: Moments, plane: int, balls: NDArray[np.intp]) -> Moments:
    """The moments as one plane sees them."""
    deflection: Floats | NDArray[np.complex128] = moments.plane_deflection_in_rotor[:, plane]
    return moments._replace(
        deflection_in_rotor=np.asarray(deflection, np.complex128),
        ball_angle_in_rotor=moments.ball_angle_in_rotor[:, balls],
        ball_inside=moments.ball_inside[:, balls],
        unbalance_in_rotor=moments.plane_unbalance_in_rotor[:, plane],
    )


# The axis of a rotor from the side, with its planes as discs in perspective: how it tilts and bends.


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
        axes.set(xlim=(-0.5 * LENGTH - 1.0, 0.5 * LENGTH + 1.0), ylim=(-1.98, 1.2))
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
        self.line.set_data(*_on_page(self.along, center))
        self.spots.set_data(*_on_page(self.along, center))
        for i, (place, plane, mine) in enumerate(self.discs):
            reach = float(self.radii[mine].max())
            self.rings[i].set_data(*_on_page(self.along[place], center[place] + reach * ROUND))
            heavy = np.exp(1j * np.angle(self.moments.plane_unbalance_in_rotor[k, plane])) * turn
            self.heavy[i].set_data(
                *_on_page(self.along[place], center[place] + 0.72 * reach * heavy * np.array([0.0, 1.0]))
            )
            balls = (
                (self.radii - self.moments.ball_inside[k] / self.length)[mine]
                * np.exp(1j * self.moments.ball_angle_in_rotor[k, mine])
                * turn
            )
            for rod, ball in zip(self.rods[i], balls, strict=True):
                if rod is not None:
                    rod.set_data(*_on_page(self.along[place], center[place] + ball * np.array([0.0, 1.0])))
            self.balls[i].set_offsets(np.column_stack(_on_page(self.along[place], center[place] + balls)))


def _on_page(along: Floats | float, z: Complexes) -> tuple[Floats, Floats]:
    """Places along the axis with a deflection, on the page."""
    return np.asarray(along - DEPTH * z.real), np.asarray(z.imag - SINK * z.real)


# The rotor from above, as artists that are built once and then only moved.


SWEEP = np.linspace(0.0, 1.0, 60)  # points of the arc that a ball swept since the frame before
MEMORY = 8  # frames for which the path of the rotor center stays visible
PLATE, ROTOR_RIM = "#F7F8F9", "#8A949C"


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
        axes.set(xlim=(-room, room), ylim=(-room, room))
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
        paths: list[complex] = []
        for (balancer, race), forces in self.forces.items():
            here = np.flatnonzero((self.races.balancer == balancer) & (self.races.race == race))
            if here.size:
                orbits = self.races.orbit_radius[here]
                places = list(balls[here] * self.length)
                for line in lines_of(forces, float(orbits.mean()), places, speed):
                    paths += [*(np.array(line) / self.length + self.places[here[0]]), complex(np.nan, np.nan)]
        return np.array(paths, np.complex128)

    def _races(self, axes: Axes, diameter: Floats, channel: Floats, outside: float) -> None:
        """The disc with its zero mark and the walls of its races."""
        circles = [Circle((0.0, 0.0), 1.06 * outside, fc=PLATE, ec=ROTOR_RIM, lw=1.2)]
        rings = {*zip(self.radii, diameter, channel, self.places, strict=True)}
        for radius, thick, wide, place in sorted(rings, key=lambda ring: -ring[0]):
            spot = (place.real, place.imag)
            circles.append(Circle(spot, radius + 0.5 * thick, fc=RACE, ec=ROTOR_RIM, lw=0.9))
            within = radius + 0.5 * thick - (wide if thick > 0.0 else 0.0)
            circles.append(Circle(spot, within, fc=PLATE, ec=ROTOR_RIM, lw=0.9))
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
