"""Where the balls of a deep chamber are: from the front, and along the unrolled race (Pakuła 2021, figures 9 and 11)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import Collection, EllipseCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from autobalancer.errors import QuestionError
from autobalancer.plots.chamber.bodies import rectangles
from autobalancer.plots.chamber.view import COLORS, Floats, Poses, poses_of, speed_colors
from autobalancer.plots.drawing.style import RACE, UNBALANCE, heading, look, picture
from autobalancer.plots.run.body_shapes import CHAMFER
from autobalancer.results.chamber.shape import ChamberShape, bodies_of, chambers_of, unbalance_of
from autobalancer.results.given import Given, given_chamber_run
from autobalancer.units import list_argument

RIM = "#8A949C"


def chamber_arrangement(
    run: Given, times: Sequence[float | str] | None = None, *, chamber: int = 1, title: str | None = None
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
    run = given_chamber_run(run, "plot.chamber_arrangement")
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
    unbalance = unbalance_of(run)
    heavy = float(np.angle(unbalance[0])) if unbalance is not None else 0.0
    shape = shapes[chamber - 1]
    body = bodies_of(run)[:-1]
    inside = np.flatnonzero(run["chamber"].values.astype(int) == chamber)
    with look():
        poses = poses_of(
            run.isel(ball=inside), np.asarray(times, float), in_rotor=False, chambers=shapes, scale=0.0, heavy=heavy
        )
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
    axes.set_aspect("equal")
    axes.set_xlim(-1.06 * size, 1.06 * size)
    axes.set_ylim(-1.06 * size, 1.06 * size)
    axes.set_xlabel("y (mm)")
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
    axes.set_ylim(-reach, reach)
    axes.set_xticks([0, 90, 180, 270, 360])
    axes.set_xlabel("angle from the unbalance (°)")
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
