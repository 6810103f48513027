"""Labels of points and lines that do not cover one another, nor a curve where there is room beside it.

Where a label goes is decided when the picture is drawn, from the places on the page, whatever the axes then are. All
labels of one pair of axes share one :class:`Labels`, so that they know of one another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.text import Text
from matplotlib.transforms import Bbox, IdentityTransform
from numpy.typing import NDArray

from autobalancer.plots.drawing.style import INK, as_written

Floats = NDArray[np.float64]
BEHIND = {"fc": "white", "ec": "none", "alpha": 0.8, "pad": 0.8}
SIDES = ((1, 1), (-1, 1), (1, -1), (-1, -1), (0, 1), (0, -1), (1, 0), (-1, 0))  # of a point, the best one first
FAR = (5.0, 14.0, 26.0, 40.0)  # points from the thing to its label
NEEDS_LINE = 10.0  # points; a label farther away is joined to its thing
COVERED, OUTSIDE, CURVE, DISTANCE, ORDER = 1000.0, 300.0, 25.0, 1.0, 0.6  # what is worse than what
CROSSED, ALONG = 150.0, 3.0  # a label crossed by the line of another; one step back along its curve
AIR = 2.5  # points between two labels


@dataclass(frozen=True)
class _Label:
    text: Text
    x: float
    y: float
    edge: bool  # of a level, at the right edge; else of a point
    back: float | None = None  # of a level line: x of its other end, up to which the label may move


class Labels(Artist):
    """The labels of one pair of axes; made by :func:`label_point` and :func:`label_level`."""

    def __init__(self, axes: Axes) -> None:
        super().__init__()
        self.set_figure(axes.figure)
        self.panel = axes
        self.entries: list[_Label] = []
        self.placed: list[Bbox] = []  # in pixels, as drawn last
        self.joints: list[Line2D] = []
        self.held = False  # whether the places found first are kept, as in a film
        self.set_zorder(7.0)
        self.set_in_layout(False)

    def add(
        self, text: str, x: float, y: float, *, edge: bool, color: str, size: float, back: float | None = None
    ) -> None:
        """One more label."""
        drawn = Text(0.0, 0.0, text, color=color, fontsize=size, bbox=dict(BEHIND), va="bottom", ha="left")
        as_written(drawn)
        drawn.set_figure(self.panel.figure)
        drawn.set_transform(IdentityTransform())
        self.entries.append(_Label(drawn, x, y, edge, back))

    def draw(self, renderer: Any) -> None:
        """Find the places and draw."""
        if not self.get_visible():
            return
        if self.held and self.placed:
            for artist in (*self.joints, *(label.text for label in self.entries)):
                artist.draw(renderer)
            return
        pixel = renderer.points_to_pixels(1.0)
        frame = self.panel.get_window_extent(renderer)
        curves = self._curves(frame)
        self.placed, self.joints = [], []
        self._levels(renderer, frame, curves, pixel)
        for label in self.entries:
            if not label.edge:
                self._point(label, renderer, frame, curves, pixel)

    def _levels(self, renderer: Any, frame: Bbox, curves: Floats, pixel: float) -> None:
        """Labels of levels above their lines, near the right edge unless curves are there; close ones in a stack."""
        labels = sorted((label for label in self.entries if label.edge), key=lambda label: label.y)
        if not labels:
            return
        sizes = [label.text.get_window_extent(renderer) for label in labels]
        level = np.array([self.panel.transData.transform((label.x, label.y))[1] for label in labels])
        height = max(size.height for size in sizes) + pixel
        bottom = stacked(level + 2.0 * pixel, height, frame.y1 - height)
        for label, size, low, line in zip(labels, sizes, bottom, level, strict=True):
            steps = np.linspace(frame.x1 - 2.0 * pixel - size.width, frame.x0 + 2.0 * pixel, 9)
            boxes = [Bbox.from_bounds(left, low, size.width, size.height) for left in steps]
            costs = [self._cost(box, frame, curves, pixel) + 4.0 * i for i, box in enumerate(boxes)]
            box = boxes[int(np.argmin(costs))]
            self._put(label, box, renderer)
            if low - line > NEEDS_LINE * pixel:
                left = box.x0 - 3.0 * pixel
                self._join((left, low + 0.5 * size.height), (left - 8.0 * pixel, line), label, renderer)

    def _point(self, label: _Label, renderer: Any, frame: Bbox, curves: Floats, pixel: float) -> None:
        """The best of some places around a point."""
        size = label.text.get_window_extent(renderer)
        best: tuple[float, Bbox, tuple[float, float], tuple[float, float]] | None = None
        places = [label.x] if label.back is None else np.linspace(label.x, label.back, 6)[:-1].tolist()
        for step, place in enumerate(places):
            x, y = self.panel.transData.transform((place, label.y))
            for order, (side, up) in enumerate(SIDES):
                for far in FAR:
                    gap = far * pixel
                    left = x + gap * side - (0.0, 0.5, 1.0)[1 - side] * size.width
                    if up and frame.x0 <= x <= frame.x1:  # above or below its point it need not leave the axes
                        left = float(np.clip(left, frame.x0, frame.x1 - 2.0 * pixel - size.width))
                    low = y + gap * up * (0.7 if side else 1.0) - (0.0, 0.5, 1.0)[1 - up] * size.height
                    box = Bbox.from_bounds(left, low, size.width, size.height)
                    corner = (float(np.clip(x, box.x0, box.x1)), float(np.clip(y, box.y0, box.y1)))
                    cost = self._cost(box, frame, curves, pixel) + DISTANCE * far + ORDER * order + ALONG * step
                    cost += CROSSED * sum(_passes(corner, (x, y), other) for other in self.placed)
                    if best is None or cost < best[0]:
                        best = cost, box, corner, (x, y)
        assert best is not None
        _, box, corner, point = best
        self._put(label, box, renderer)
        if np.hypot(corner[0] - point[0], corner[1] - point[1]) > NEEDS_LINE * pixel:
            self._join(corner, point, label, renderer)

    def _cost(self, box: Bbox, frame: Bbox, curves: Floats, pixel: float) -> float:
        area = box.width * box.height
        near = box.padded(AIR * pixel)
        cost = sum(COVERED * _common(near, other) / area for other in self.placed)
        for joint in self.joints:
            start, end = np.asarray(joint.get_xydata(), np.float64).tolist()
            cost += CROSSED * _passes((start[0], start[1]), (end[0], end[1]), box)
        cost += OUTSIDE * (1.0 - _common(box, frame) / area)
        inside = (curves[:, 0] > near.x0) & (curves[:, 0] < near.x1) & (curves[:, 1] > box.y0) & (curves[:, 1] < box.y1)
        return float(cost + CURVE * min(float(inside.sum()) / box.height, 6.0))

    def _put(self, label: _Label, box: Bbox, renderer: Any) -> None:
        label.text.set_position((box.x0, box.y0))
        label.text.draw(renderer)
        self.placed.append(box)

    def _join(self, start: tuple[float, float], end: tuple[float, float], label: _Label, renderer: Any) -> None:
        line = Line2D([start[0], end[0]], [start[1], end[1]], color=label.text.get_color(), lw=0.6, alpha=0.7)
        line.set_figure(self.panel.figure)
        line.set_transform(IdentityTransform())
        line.draw(renderer)
        self.joints.append(line)

    def _curves(self, frame: Bbox) -> Floats:
        """Points of all curves in pixels, close enough to each other that no label slips between them."""
        items = [np.empty((0, 2))]
        for line in self.panel.get_lines():
            if not line.get_visible() or line.get_animated():
                continue
            place = np.asarray(line.get_transform().transform(line.get_xydata()), np.float64)
            place = place[np.isfinite(place).all(axis=1)]
            if place.shape[0] < 2:
                items.append(place)
                continue
            way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(place, axis=0).T))])
            if way[-1] > 0.0:
                even = np.linspace(0.0, way[-1], int(np.clip(way[-1], 2.0, 20000.0)))
                place = np.column_stack([np.interp(even, way, column) for column in place.T])
            items.append(place)
        every = np.concatenate(items)
        return np.asarray(every[(every[:, 1] > frame.y0 - 1.0) & (every[:, 1] < frame.y1 + 1.0)])


def label_point(
    axes: Axes, text: str, x: float, y: float, *, color: str = INK, size: float = 8.5, back: float | None = None
) -> None:
    """Label a point of data near it, where it covers least; of a level line anywhere between ``x`` and ``back``."""
    labels_of(axes).add(text, x, y, edge=False, color=color, size=size, back=back)


def label_level(axes: Axes, text: str, y: float, *, color: str = INK, size: float = 8.5) -> None:
    """Label a horizontal line at ``y`` at the right edge of the axes."""
    labels_of(axes).add(text, axes.get_xlim()[1], y, edge=True, color=color, size=size)


def labels_of(axes: Axes) -> Labels:
    """The labels of these axes, made when there are none yet."""
    for artist in axes.artists:
        if isinstance(artist, Labels):
            return artist
    labels = Labels(axes)
    axes.add_artist(labels)
    labels.set_clip_on(False)
    return labels


def stacked(wanted: Floats, height: float, highest: float) -> Floats:
    """Ascending places of things ``height`` high at or above those wanted, none above another's line, up to ``highest``.

    Things whose places would overlap stand in a stack on the highest of their places.
    """
    stacks: list[list[int]] = []
    for number in range(len(wanted)):
        stacks.append([number])
        while len(stacks) > 1 and wanted[stacks[-2][-1]] + height * len(stacks[-2]) > wanted[stacks[-1][0]]:
            above = stacks.pop()
            stacks[-1] += above
    result = np.empty(len(wanted))
    top = np.inf
    for stack in reversed(stacks):
        base = min(float(wanted[stack[-1]]), highest - height * (len(stack) - 1), top - height * len(stack))
        result[stack] = base + height * np.arange(len(stack))
        top = base
    return result


def _common(box: Bbox, other: Bbox) -> float:
    """Area of what two boxes have in common."""
    wide = min(box.x1, other.x1) - max(box.x0, other.x0)
    high = min(box.y1, other.y1) - max(box.y0, other.y0)
    return float(max(wide, 0.0) * max(high, 0.0))


def _passes(start: tuple[float, float], end: tuple[float, float], box: Bbox) -> bool:
    """Whether a line passes through a box."""
    share = np.linspace(0.0, 1.0, 9)
    x, y = start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])
    return bool(((x > box.x0) & (x < box.x1) & (y > box.y0) & (y < box.y1)).any())


# Names of curves at their right ends, outside the axes: one for coincident curves, none on another.


SAME = 2e-3  # of the axis; ends nearer to each other are one line in the picture


class End(NamedTuple):
    """The right end of a curve: its height in data, its name, and a number about it, written after the name."""

    height: float
    name: str
    note: str


def joint_name(group: Sequence[End]) -> str:
    """One name for coincident curves: what their names begin with once, and a common note once; forward comes first."""
    group = sorted(group, key=lambda end: "backward" in end.name)
    names = [end.name.split() for end in group]
    common = 0
    while len(group) > 1 and all(len(words) > common + 1 and words[common] == names[0][common] for words in names):
        common += 1
    notes = list(dict.fromkeys(end.note for end in group))
    each = [" ".join(words[common:]) for words in names]
    if len(notes) > 1:
        each = [f"{name} {end.note}" for name, end in zip(each, group, strict=True)]
    text = " ".join([*names[0][:common], ", ".join(each)])
    return text if len(notes) > 1 else f"{text}, {notes[0]}"


def moved_apart(wanted: Floats, gap: float) -> Floats:
    """Ascending places at least ``gap`` apart, together as near as possible to those wanted."""
    stacks: list[tuple[float, int]] = []  # mean of wanted places less their order, and how many
    for number, place in enumerate(wanted):
        stacks.append((float(place) - number * gap, 1))
        while len(stacks) > 1 and stacks[-2][0] >= stacks[-1][0]:
            (low, few), (high, many) = stacks[-2:]
            stacks[-2:] = [((low * few + high * many) / (few + many), few + many)]
    bases = np.repeat([base for base, _ in stacks], [count for _, count in stacks])
    return np.asarray(bases + gap * np.arange(len(wanted)), np.float64)
