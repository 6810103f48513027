"""A deep chamber and its balls seen from any side: parallel projection, balls drawn from far to near."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import Collection, EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle
from numpy.typing import NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.plots.film_frames import FilmCanvas, FilmQuestion, frame_times, magnification, pace, size_words
from autobalancer.plots.run.race_and_orbit import CHAMFER
from autobalancer.plots.style import BALLS, INK, RACE, UNBALANCE, heading, look, picture
from autobalancer.results.chamber_measures import ChamberShape, bodies_of, chambers_of, unbalance_of
from autobalancer.results.display_units import AxisUnit, length_axis
from autobalancer.results.run_argument import RunArgument, load_chamber_run
from autobalancer.units import list_argument

ROUND = np.linspace(0.0, 2.0 * np.pi, 121)
RIBS = 12  # lines along the wall
NEAR, FAR = "#8A949C", "#C9D0D6"
LIGHT = np.array([-0.35, 0.4])  # where a ball shines, in its radii
COLORS = "viridis"


@dataclass(frozen=True)
class Camera:
    """Where one looks from.

    Attributes
    ----------
    azimuth
        Degrees in the horizontal plane, from the rotor's axis (x) towards y.
    elevation
        Degrees above the horizontal plane.
    """

    azimuth: float = 35.0
    elevation: float = 20.0

    def axes(self) -> Floats:
        """Right, up and towards the eye, as rows."""
        a, e = np.deg2rad(self.azimuth), np.deg2rad(self.elevation)
        right = [-np.sin(a), np.cos(a), 0.0]
        up = [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]
        near = [np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)]
        return np.array([right, up, near])

    def seen(self, points: Floats) -> Floats:
        """Points (..., 3) in the picture: right, up, nearness."""
        return np.asarray(points @ self.axes().T)


@dataclass(frozen=True)
class Poses:
    """Where everything is at some times, in the axes in which it is drawn.

    ``balls`` (time, ball, 3) in m from the middle of the rotor, ``speed`` (time, ball) in m/s, ``heavy`` (time,) angle of
    the unbalance in the plane of y and z, ``body`` (time, 3) displacement as drawn, ``length`` (ball,) of cylinders, 0 of balls.
    """

    time: Floats
    balls: Floats
    speed: Floats
    radius: Floats
    heavy: Floats
    turned: Floats
    body: Floats
    length: Floats


def speed_colors(speed: Floats) -> Normalize:
    """From standstill to the fastest ball."""
    return Normalize(0.0, max(float(speed.max(initial=0.0)), 1e-12))


class ChamberView:
    """Walls, balls and unbalance; ``show(k)`` moves them to time ``k``."""

    def __init__(self, axes: Axes, poses: Poses, chambers: list[ChamberShape], camera: Camera, marked: bool) -> None:
        self.poses, self.camera, self.chambers = poses, camera, chambers
        self.colors = speed_colors(poses.speed)
        size = max(chamber.radius for chamber in chambers)
        length = max(abs(chamber.place) + 0.5 * chamber.depth for chamber in chambers)
        corner = np.hypot(size, length) * 1.06
        axes.set_aspect("equal")
        axes.set_axis_off()
        seen = np.abs(camera.axes()[:2])
        wide, high = (size * np.hypot(row[1], row[2]) + length * row[0] for row in seen)
        axes.set(
            xlim=(-1.08 * wide, 1.08 * wide), ylim=(-1.08 * max(high, 0.3 * corner), 1.08 * max(high, 0.3 * corner))
        )
        self.behind = LineCollection([], colors=FAR, linewidths=0.9, zorder=1)
        axes.add_collection(self.behind)
        n = poses.balls.shape[1]
        self.balls = EllipseCollection(
            np.ones(2 * n), np.ones(2 * n), np.zeros(2 * n), units="xy", offsets=np.zeros((2 * n, 2)),
            offset_transform=axes.transData, zorder=2,
        )  # fmt: skip
        axes.add_collection(self.balls)
        self.cylinders = PolyCollection([], zorder=2)
        axes.add_collection(self.cylinders)
        self.before = LineCollection([], colors=NEAR, linewidths=0.8, alpha=0.55, zorder=3)
        axes.add_collection(self.before)
        self.mark = axes.plot([], [], "-o", color=UNBALANCE, lw=1.6, ms=5, zorder=4, visible=marked)[0]
        self.axis = axes.plot([], [], color=INK, lw=0.8, ls=(0, (6, 3, 1, 3)), zorder=1)[0]
        words: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 8.5, "color": "#404040", "zorder": 5}
        self.ends = [axes.text(0.0, 0.0, text, **words) for text in ("−x", "+x")]
        self.artists: list[Artist] = [
            self.behind,
            self.axis,
            self.balls,
            self.cylinders,
            self.before,
            self.mark,
            *self.ends,
        ]

    def show(self, k: int) -> None:
        """Move everything to time ``k``."""
        shift = self.poses.body[k]
        self._walls(float(self.poses.turned[k]), shift)
        self._balls(k, shift)
        end = max(self.chambers, key=lambda chamber: chamber.place + 0.5 * chamber.depth)
        face = end.place + 0.5 * end.depth * np.sign(self.camera.axes()[2, 0] or 1.0)
        angle = float(self.poses.heavy[k])
        tip = end.radius * 0.98
        spot = self.camera.seen(np.array([[face, 0.0, 0.0], [face, tip * np.cos(angle), tip * np.sin(angle)]]) + shift)
        self.mark.set_data(spot[:, 0], spot[:, 1])
        reach = 1.15 * max(abs(chamber.place) + 0.5 * chamber.depth for chamber in self.chambers)
        line = self.camera.seen(np.array([[-reach, 0.0, 0.0], [reach, 0.0, 0.0]]) + shift)
        self.axis.set_data(line[:, 0], line[:, 1])
        if np.hypot(*(line[1] - line[0])[:2]) > 0.2 * reach:  # else one looks along the axis
            for text, at in zip(self.ends, 1.07 * (line - line.mean(axis=0)) + line.mean(axis=0), strict=True):
                text.set_position((float(at[0]), float(at[1])))
        else:
            for text in self.ends:
                text.set_visible(False)

    def _balls(self, k: int, shift: Floats) -> None:
        seen = self.camera.seen(self.poses.balls[k] + shift)
        order = np.argsort(seen[:, 2])
        radius = self.poses.radius[order]
        import matplotlib

        base = matplotlib.colormaps[COLORS](self.colors(self.poses.speed[k][order]))
        shine = base.copy()
        shine[:, :3] = 0.45 * base[:, :3] + 0.55
        if self.poses.length.any():
            ends = np.stack([base, shine], axis=1).reshape(-1, 4)
            shapes = cylinder_outlines(self.camera.axes(), seen[order, :2], radius, self.poses.length[order])
            self.balls.set_visible(False)
            self.cylinders.set(verts=list(shapes), facecolors=ends, edgecolors=(0.1, 0.1, 0.1, 0.9), linewidths=0.6)
            return
        place, size = np.empty((2 * order.size, 2)), np.empty(2 * order.size)
        face, edge = np.empty((2 * order.size, 4)), np.empty((2 * order.size, 4))
        place[0::2], place[1::2] = seen[order, :2], seen[order, :2] + radius[:, None] * LIGHT
        size[0::2], size[1::2] = 2.0 * radius, 0.55 * radius
        face[0::2], face[1::2] = base, shine
        edge[0::2], edge[1::2] = (0.1, 0.1, 0.1, 0.9), (0.0, 0.0, 0.0, 0.0)
        self.balls.set(offsets=place, facecolors=face, edgecolors=edge, linewidths=np.tile([0.6, 0.0], order.size))
        self.balls.set_widths(size)
        self.balls.set_heights(size)

    def _walls(self, turned: float, shift: Floats) -> None:
        """Rims and ribs; what lies on the far side of the cylinder goes behind the balls."""
        far: list[Floats] = []
        near: list[Floats] = []
        away = self.camera.axes()[2]
        for chamber in self.chambers:
            for side in (-0.5, 0.5):
                rim = _rim(chamber, side, ROUND)
                facing = chamber.depth and np.sign(side) * away[0] > 0.0
                for part, visible in _split(rim, away):
                    (near if visible or facing else far).append(self.camera.seen(part + shift)[:, :2])
            for angle in turned + 2.0 * np.pi * np.arange(RIBS) / RIBS:
                rib = np.concatenate([_rim(chamber, side, np.array([angle])) for side in (-0.5, 0.5)])
                outward = np.array([0.0, np.cos(angle), np.sin(angle)])
                (near if outward @ away > 0.0 else far).append(self.camera.seen(rib + shift)[:, :2])
        self.behind.set_segments(far)
        self.before.set_segments(near)


def _rim(chamber: ChamberShape, side: float, angle: Floats) -> Floats:
    along = np.full_like(angle, chamber.place + side * chamber.depth)
    return np.stack([along, chamber.radius * np.cos(angle), chamber.radius * np.sin(angle)], axis=1)


def _split(rim: Floats, away: Floats) -> list[tuple[Floats, bool]]:
    """The rim in pieces that face the eye or do not."""
    outward = rim * np.array([0.0, 1.0, 1.0])
    visible = outward @ away > 0.0
    cuts = np.flatnonzero(np.diff(visible.astype(int))) + 1
    edges = [0, *cuts.tolist(), rim.shape[0]]
    return [(rim[max(a - 1, 0) : b], bool(visible[a])) for a, b in pairwise(edges)]


def poses_of(
    run: xr.Dataset, times: Floats, *, in_rotor: bool, chambers: list[ChamberShape], scale: float, heavy: float
) -> Poses:
    """Places at ``times``, straight between samples, with the displacement of the body drawn ``scale`` times larger."""
    samples = run["time"].values
    right = np.clip(np.searchsorted(samples, times), 1, samples.size - 1)
    part = np.clip((times - samples[right - 1]) / (samples[right] - samples[right - 1]), 0.0, 1.0)

    def at(name: str, *dims: str) -> Floats:
        held, which = np.unique(np.concatenate([right - 1, right]), return_inverse=True)
        values = run[name].isel(time=held).transpose("time", *dims).values
        share = part.reshape(-1, *[1] * len(dims))
        return np.asarray((1.0 - share) * values[which[: times.size]] + share * values[which[times.size :]])

    angle = at("rotor_angle")
    places = at("ball_position", "ball", "axis")
    place_of = np.array([chamber.place for chamber in chambers])
    places[:, :, 0] += place_of[run["chamber"].values.astype(int) - 1]
    turned = angle - at("body_rotation", "axis")[:, 0]
    body = scale * at("body_position", "axis")
    if in_rotor:
        around = (places[:, :, 1] + 1j * places[:, :, 2]) * np.exp(-1j * turned)[:, None]
        places[:, :, 1], places[:, :, 2] = around.real, around.imag
        wound = (body[:, 1] + 1j * body[:, 2]) * np.exp(-1j * turned)
        body[:, 1], body[:, 2] = wound.real, wound.imag
        turned = np.zeros_like(turned)
    speed = np.linalg.norm(at("ball_velocity", "ball", "axis"), axis=2)
    radius = run["ball_radius"].values
    length = run["ball_length"].values if "ball_length" in run else np.zeros_like(radius)
    return Poses(times, places, speed, radius, heavy + turned, turned, body, length)


# Films of a deep chamber in three dimensions.


def chamber_scene(run: xr.Dataset, film: FilmQuestion, azimuth: float = 35.0, elevation: float = 20.0) -> _Scene:
    """What a ``film`` of a run of deep chambers shows, seen from a direction in degrees.

    Raises
    ------
    QuestionError
        If the run has no samples there, or a number is not possible.
    """
    if not (np.isfinite(azimuth) and -90.0 <= elevation <= 90.0):
        raise QuestionError(f"elevation: given {elevation:g} degrees, azimuth {azimuth:g}; the first is from -90 to 90")
    times = frame_times(run["time"].values, film.start, film.end, film.frames)
    chambers, in_rotor = chambers_of(run), film.frame == "rotor"
    inside = (run["time"].values >= times[0]) & (run["time"].values <= times[-1])
    greatest = float(np.abs(run["body_position"].values[inside]).max(initial=0.0))
    scale = magnification(film.scale, greatest, max(chamber.radius for chamber in chambers), 0.1)
    poses = poses_of(run, times, in_rotor=in_rotor, chambers=chambers, scale=scale, heavy=_heavy(run))
    frame = "in the frame of the rotor" if in_rotor else "in space"
    caption = f"{frame}, {pace(film.duration, times)}, {size_words('displacement', scale)}"
    return _Scene(run, poses, chambers, Camera(azimuth, elevation), film.unit, caption, film.width)


def _heavy(run: xr.Dataset) -> float:
    """Direction of the unbalance in the rotor, rad."""
    unbalance = unbalance_of(run)
    return float(np.angle(unbalance[0])) if unbalance is not None else 0.0


class _Scene(FilmCanvas):
    """Chamber and balls from one side, beside two panels over time."""

    def __init__(
        self,
        run: xr.Dataset,
        poses: Poses,
        chambers: list[ChamberShape],
        camera: Camera,
        unit: AxisUnit,
        caption: str,
        width: int,
    ) -> None:
        super().__init__(width)
        self.poses, self.unit = poses, unit
        figure = self.figure
        self.view = ChamberView(figure.add_axes((0.0, 0.09, 0.56, 0.80)), poses, chambers, camera, True)
        self.write(run, 0.28, (0.955, 0.91, 0.02), caption)
        key = [Line2D([], [], color=UNBALANCE, marker="o", ms=5, label="unbalance")]
        figure.legend(handles=key, loc="lower left", bbox_to_anchor=(0.01, 0.05))
        bar = figure.add_axes((0.575, 0.2, 0.012, 0.6))
        figure.colorbar(ScalarMappable(self.view.colors, COLORS), cax=bar)
        bar.set_title("m/s", fontsize=8.5, weight="normal", loc="left")
        bar.grid(False)
        self._panels(run)
        self.freeze(sorted([*self.view.artists, self.text], key=lambda artist: artist.get_zorder()))

    def frame(self, k: int) -> NDArray[np.uint8]:
        """Pixels of frame ``k``."""
        self.view.show(k)
        time = float(self.poses.time[k])
        fastest = float(self.poses.speed[k].max(initial=0.0))
        body = "cylinder" if self.poses.length.any() else "ball"
        self.text.set_text(f"{time:8.3f} s   fastest {body} {fastest:5.2f} m/s")
        return self.pixels(time)

    def _panels(self, run: xr.Dataset) -> None:
        first, last = float(self.poses.time[0]), float(self.poses.time[-1])
        upper, lower = self.panels(0.69, first, last)
        time = run["time"].values
        inside = np.flatnonzero((time >= first) & (time <= last))
        if inside.size < 2:
            inside = np.arange(time.size)
        shown = run.isel(time=slice(int(inside[0]), int(inside[-1]) + 1))
        upper.plot(shown["time"], shown["speed"] * self.unit.factor, color=INK)
        upper.set_ylabel(f"rotor speed ({self.unit.sign})")
        body = shown["body_position"].values
        body = body - body.mean(axis=0)
        axis = length_axis(None, float(np.abs(body[:, 1:]).max(initial=0.0)))
        for column, name, color in ((1, "horizontal", BALLS[1]), (2, "vertical", BALLS[0])):
            lower.plot(shown["time"], body[:, column] * axis.factor, color=color, lw=0.8, label=name)
        lower.set_ylabel(f"displacement ({axis.sign})")
        lower.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
        lower.set_xlim(first, last)
        self.figure.align_ylabels([upper, lower])


# Where the balls of a deep chamber are: from the front, and along the unrolled race (Pakuła 2021, figures 9 and 11).


RIM = "#8A949C"


def chamber_arrangement(
    run: RunArgument, times: Sequence[float | str] | None = None, *, chamber: int = 1, title: str | None = None
) -> Figure:
    """The balls of a chamber at some times, colored by speed, with the unbalance in space.

    Above, the chamber from the front, seen against the rotor's axis; below, its race unrolled, with places along the axis
    over the angle from the unbalance: balls on the light side are near 180 degrees.

    Parameters
    ----------
    run
        From ``simulate`` or an archive.
    times
        s; by default begin, middle and end of the run.
    chamber
        Number of the chamber, from 1.
    title
        Above the picture; by default the name of the machine.

    Raises
    ------
    QuestionError
        If a time is not in the run, or there is no such chamber.
    """
    run = load_chamber_run(run, "plot.chamber_arrangement")
    times = None if times is None else list_argument("times", times, "s")
    time = run["time"].values
    if times is None:
        times = [float(time[0]), 0.5 * float(time[0] + time[-1]), float(time[-1])]
    outside = [at for at in times if not time[0] - 1e-9 <= at <= time[-1] + 1e-9]
    if outside or len(times) == 0:
        raise QuestionError(f"times: given {list(times)}; the run goes from {time[0]:g} s to {time[-1]:g} s")
    shapes = chambers_of(run)
    if not 1 <= chamber <= len(shapes):
        raise QuestionError(f"chamber: given {chamber}; the machine has {len(shapes)}")
    shape = shapes[chamber - 1]
    body = bodies_of(run)[:-1]
    inside = np.flatnonzero(run["chamber"].values.astype(int) == chamber)
    with look():
        at_times = np.asarray(times, float)
        poses = poses_of(run.isel(ball=inside), at_times, in_rotor=False, chambers=shapes, scale=0.0, heavy=_heavy(run))
        figure = picture(2.9 * len(times) + 0.9, 5.2)
        axes = figure.subplots(2, len(times), squeeze=False, sharey="row", height_ratios=[1.5, 1.0])
        for k, at in enumerate(times):
            _front(axes[0, k], poses, k, shape)
            _unrolled(axes[1, k], poses, k, shape)
            axes[0, k].set_title(f"{at:.4g} s")
        axes[0, 0].set_ylabel("seen from +x: z (mm)")
        axes[1, 0].set_ylabel("unrolled: along the axis,\nx (mm)")
        figure.colorbar(
            ScalarMappable(speed_colors(poses.speed), COLORS),
            ax=axes,
            label=f"speed of a {body} (m/s)",
            aspect=40,
            pad=0.01,
        )
        heading(figure, title if title is not None else str(run.attrs.get("machine_name", "")))
    return figure


def _front(axes: Axes, poses: Poses, k: int, shape: ChamberShape) -> None:
    size = 1e3 * shape.radius
    axes.add_patch(Circle((0.0, 0.0), size, fc=RACE, ec=RIM, lw=1.2))
    places = poses.balls[k]
    order = np.argsort(places[:, 0])
    at, width, speed = 1e3 * places[order, 1:], 2e3 * poses.radius[order], poses.speed[k][order]
    if poses.length.any():  # a second circle makes the end of a cylinder, and the next one hides both
        at, speed = np.repeat(at, 2, axis=0), np.repeat(speed, 2)
        width = np.outer(width, [1.0, CHAMFER]).ravel()
    _draw(axes, at, width, speed, poses)
    tip = 0.97 * size * np.array([np.cos(poses.heavy[k]), np.sin(poses.heavy[k])])
    axes.plot([0.0, tip[0]], [0.0, tip[1]], "-o", color=UNBALANCE, lw=1.6, ms=5, markevery=[1], zorder=3.5)
    axes.set(aspect="equal", xlim=(-1.06 * size, 1.06 * size), ylim=(-1.06 * size, 1.06 * size), xlabel="y (mm)")
    axes.grid(False)


def _unrolled(axes: Axes, poses: Poses, k: int, shape: ChamberShape) -> None:
    places = poses.balls[k]
    angle = np.rad2deg(np.mod(np.arctan2(places[:, 2], places[:, 1]) - poses.heavy[k], 2.0 * np.pi))
    half = 0.5e3 * shape.depth
    axes.add_patch(Rectangle((0.0, -half), 360.0, 2.0 * half, fc=RACE, ec=RIM, lw=1.2))
    width = np.rad2deg(2.0 * poses.radius / (shape.radius - poses.radius))
    along = 1e3 * (places[:, 0] - shape.place)
    for shift in (-360.0, 0.0, 360.0):
        at = np.stack([angle + shift, along], axis=1)
        if poses.length.any():
            _colored(axes, rectangles(at, width, 1e3 * poses.length), poses.speed[k], poses)
        else:
            _draw(axes, at, width, poses.speed[k], poses, height=2e3 * poses.radius)
    axes.axvline(0.0, color=UNBALANCE, lw=2.0)
    axes.axvline(360.0, color=UNBALANCE, lw=2.0)
    axes.set_xlim(-6.0, 366.0)
    reach = max(1.08 * half, 1e3 * float(poses.radius.max(initial=0.0)) * 1.5)
    axes.set(ylim=(-reach, reach), xticks=[0, 90, 180, 270, 360], xlabel="angle from the unbalance (°)")
    axes.grid(False)


def _draw(axes: Axes, at: Floats, width: Floats, speed: Floats, poses: Poses, height: Floats | None = None) -> None:
    balls = EllipseCollection(
        width, width if height is None else height, np.zeros_like(width), units="xy", offsets=at,
        offset_transform=axes.transData,
    )  # fmt: skip
    _colored(axes, balls, speed, poses)


def _colored(axes: Axes, bodies: Collection, speed: Floats, poses: Poses) -> None:
    """Add balls or cylinders, each in the color of its speed."""
    bodies.set(edgecolors="#222222", linewidths=0.6, cmap=COLORS, norm=speed_colors(poses.speed), zorder=3, array=speed)
    axes.add_collection(bodies)


# How cylinders parallel to the rotor look from any side.


CIRCLE_ANGLES = np.linspace(0.0, 2.0 * np.pi, 41)[:-1]


def cylinder_outlines(camera: Floats, places: Floats, radius: Floats, length: Floats) -> Floats:
    """Outlines (2 n, points, 2) of cylinders at ``places`` (n, 2): of each the whole and the end that faces the eye.

    ``camera`` (3, 3) are the directions right, up and towards the eye; cylinders point along the first axis.
    """
    rim = np.stack(
        [
            np.outer(np.cos(CIRCLE_ANGLES), camera[row, 1:2]) + np.outer(np.sin(CIRCLE_ANGLES), camera[row, 2:])
            for row in (0, 1)
        ]
    )
    rim = rim[..., 0].T  # (points, 2) of an end with radius one
    along = camera[:2, 0]
    # an edge of the outline belongs to the end towards which it lies outward
    ahead = np.roll(rim, -1, axis=0) - rim
    outward = np.stack([ahead[:, 1], -ahead[:, 0]], axis=1) * np.sign(camera[2, 0] or 1.0)
    side = np.repeat(np.where(outward @ along > 0.0, 0.5, -0.5), 2)[:, None]
    facing = np.full_like(side, 0.5 * np.sign(camera[2, 0] or 1.0))
    corners = np.stack([rim, np.roll(rim, -1, axis=0)], axis=1).reshape(-1, 2)
    shapes = np.empty((2 * len(places), len(corners), 2))
    for k, ends in enumerate((side, facing)):
        shapes[k::2] = places[:, None] + corners * radius[:, None, None] + ends * along * length[:, None, None]
    return shapes


def rectangles(at: Floats, width: Floats, height: Floats) -> PolyCollection:
    """Rectangles around the places ``at`` (n, 2)."""
    corner = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    size = np.stack([width, height], axis=1)
    return PolyCollection(list(at[:, None] + corner * size[:, None]))
