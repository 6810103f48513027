"""A machine from the side: its axis to the right, the balls of each race in section above and below it."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle

from autobalancer.catalog.resolve import Ball
from autobalancer.plots.drawing.labels import label_point
from autobalancer.plots.drawing.style import INK, RACE, UNBALANCE, ball_color
from autobalancer.sketch.layout import Block, Filling, Layout, Spring

RIM, STANDING, TURNING, GREY = "#8A949C", "#F4F1EA", "#DDE3E8", "#606060"
LEAST = 0.018  # of the picture: what a point ball or an unbalance is drawn as


def side_view(axes: Axes, layout: Layout, balls: tuple[Ball, ...], mm: float = 1e3) -> None:
    """Draw it to scale, in mm."""
    high = max([block.radius for block in layout.blocks] + [ball.orbit_radius + ball.radius for ball in balls])
    low, up = min(block.start for block in layout.blocks), max(block.end for block in layout.blocks)
    size = max(up - low, 2.0 * high)
    for block in layout.blocks:
        _block(axes, block, mm)
    for spring in layout.springs:
        _spring(axes, spring, size, mm)
    for number, place in enumerate(layout.planes):
        _section(axes, place, [(k, ball) for k, ball in enumerate(balls) if ball.balancer == number], size, mm)
    for filling in layout.fillings:
        _filling(axes, filling, mm)
    for place, angle in layout.unbalances:
        at = 0.55 * layout.radius_at(place) * (1.0 if math.sin(angle) >= 0.0 else -1.0)
        axes.plot([place * mm], [at * mm], marker="D", ms=7, color=UNBALANCE, mec="white", mew=0.8, zorder=6)
    for place, name in layout.stations:
        axes.plot([place * mm], [0.0], marker="|", ms=16, mew=1.2, color=INK, zorder=5)
        label_point(axes, name, place * mm, 0.0, color=INK)
    more = 0.06 * size * mm
    axes.axhline(0.0, color=INK, lw=0.7, ls=(0, (12, 3, 2, 3)), zorder=4)
    axes.update_datalim([(low * mm - more, -high * mm - 2.6 * more), (up * mm + more, high * mm + 1.5 * more)])
    axes.margins(0.0)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("along the axis, z (mm)" if not layout.fillings else "along the axis, x (mm)")
    axes.set_ylabel("radius (mm)")
    axes.grid(False)
    couples = f"{layout.couples} couple unbalance{'s' * (layout.couples > 1)} not drawn" if layout.couples else ""
    axes.set_title(
        "; ".join(text for text in (layout.note, couples) if text), fontsize=8.5, weight="normal", color=GREY
    )


def _filling(axes: Axes, filling: Filling, mm: float) -> None:
    """A row of balls on the lower wall, as many as lie side by side."""
    fit = max(int((filling.end - filling.start) / filling.ball_width), 1)
    places = filling.start + 0.5 * (filling.end - filling.start) * (1.0 + (2.0 * np.arange(fit) - fit + 1.0) / fit)
    for place in places:
        center = (place * mm, (filling.ball_radius - filling.radius) * mm)
        axes.add_patch(Circle(center, filling.ball_radius * mm, fc=ball_color(0), ec=INK, lw=0.7, zorder=5))
    label_point(axes, filling.text, 0.5 * (filling.start + filling.end) * mm, filling.radius * mm)


def _block(axes: Axes, block: Block, mm: float) -> None:
    fill = TURNING if block.turning else STANDING
    line = "-" if block.known else (0, (4, 2))
    for low, high in (
        ((block.bore, block.radius), (-block.radius, -block.bore)) if block.bore else ((-block.radius, block.radius),)
    ):
        shape = Rectangle(
            (block.start * mm, low * mm), (block.end - block.start) * mm, (high - low) * mm, fc=fill, ec=RIM, lw=1.0,
            ls=line, zorder=1.2 if block.turning else 1.0,
        )  # fmt: skip
        axes.add_patch(shape)
    if block.name and block.radius > 0.0:
        label_point(axes, block.name, 0.5 * (block.start + block.end) * mm, block.radius * mm, color="#606060")


def _spring(axes: Axes, spring: Spring, size: float, mm: float) -> None:
    """A zigzag down to the ground, or a short one between two bodies."""
    length = 0.09 * size if spring.grounded else 0.05 * size
    across = 0.012 * size
    steps = np.linspace(0.0, 1.0, 12)
    sway = np.where(np.arange(12) % 2, 1.0, -1.0) * across
    sway[[0, 1, -2, -1]] = 0.0
    for side in (-1.0,) if spring.grounded else (-1.0, 1.0):
        start = side * spring.radius
        down = start + side * steps * length
        axes.plot((spring.place + sway) * mm, down * mm, color=INK, lw=1.1, zorder=3)
        if spring.grounded:
            wide = 3.0 * across
            axes.plot([(spring.place - wide) * mm, (spring.place + wide) * mm], [down[-1] * mm] * 2, color=INK, lw=1.6)
            axes.add_patch(
                Rectangle(
                    ((spring.place - wide) * mm, (down[-1] - across) * mm), 2.0 * wide * mm, across * mm, fc="none",
                    ec=RIM, lw=0.0, hatch="/////", zorder=2,
                )
            )  # fmt: skip


def _section(axes: Axes, place: float, balls: list[tuple[int, Ball]], size: float, mm: float) -> None:
    """The races of a plane: a channel and a ball above and below the axis."""
    for race in sorted({ball.race for _, ball in balls}):
        inside = [(k, ball) for k, ball in balls if ball.race == race]
        thick = max(ball.diameter for _, ball in inside)
        number, ball = inside[0]
        radius = 0.5 * thick or 0.5 * LEAST * size
        for side in (-1.0, 1.0):
            center = side * ball.orbit_radius
            channel = ((place - radius) * mm, (center - radius) * mm)
            if ball.body != "pendulum":
                axes.add_patch(
                    Rectangle(channel, 2.0 * radius * mm, 2.0 * radius * mm, fc=RACE, ec=INK, lw=1.0, zorder=3)
                )
            else:
                axes.plot([place * mm] * 2, [0.0, center * mm], color=INK, lw=2.0, zorder=3)
            looks = {"fc": ball_color(number), "ec": INK, "lw": 0.8, "zorder": 5}
            if not thick:
                looks |= {"fc": "white", "ec": ball_color(number), "lw": 1.6}
            axes.add_patch(Circle((place * mm, center * mm), radius * mm, **looks))
