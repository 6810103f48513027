"""A deep chamber and its balls seen from any side: parallel projection, balls drawn from far to near."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection, PolyCollection
from matplotlib.colors import Normalize
from numpy.typing import NDArray

from autobalancer.plots.chamber.bodies import seen_cylinders
from autobalancer.plots.drawing.style import INK, UNBALANCE
from autobalancer.results.chamber.shape import ChamberShape

Floats = NDArray[np.float64]
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
        axes.set_xlim(-1.08 * wide, 1.08 * wide)
        axes.set_ylim(-1.08 * max(high, 0.3 * corner), 1.08 * max(high, 0.3 * corner))
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
        base = _color_map()(self.colors(self.poses.speed[k][order]))
        shine = base.copy()
        shine[:, :3] = 0.45 * base[:, :3] + 0.55
        if self.poses.length.any():
            ends = np.stack([base, shine], axis=1).reshape(-1, 4)
            shapes = seen_cylinders(self.camera.axes(), seen[order, :2], radius, self.poses.length[order])
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


def _color_map() -> Any:
    import matplotlib

    return matplotlib.colormaps[COLORS]


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
