"""One look for all pictures; applied while a figure is built, never globally."""

from __future__ import annotations

import io
import re
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke
from matplotlib.text import Text
from matplotlib.transforms import Bbox, IdentityTransform
from numpy.typing import NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.results.display_units import AxisUnit, axis_unit
from autobalancer.safe_file import as_path, write_safely

# Okabe and Ito (2008): told apart with every kind of color vision. Vermilion is kept for the unbalance.
INK = "#222222"
FORCE = "#4A5A78"  # symbols of springs, magnets, pins
UNBALANCE = "#D55E00"
CRITICAL = "#707070"
FILL = "#B9C3CC"
RACE = "#E9EDF0"
ALL_BALLS = "#5B6B7A"
BALLS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#8A7A1F")

LOOK: Any = {
    "text.usetex": False,  # whatever a file of settings in the working folder says
    "font.family": "sans-serif",
    "font.size": 9.5,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 9.5,
    "figure.titlesize": 10.5,
    "figure.titleweight": "bold",
    "axes.edgecolor": "#606060",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.7,
    "xtick.color": "#404040",
    "ytick.color": "#404040",
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "lines.linewidth": 1.3,
    "lines.solid_capstyle": "round",
    "legend.fontsize": 8.5,
    "legend.frameon": False,
    "legend.borderpad": 0.2,
    "legend.handlelength": 1.6,
    "legend.columnspacing": 1.4,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
}


# the formulas of this package, the powers of ten of an axis and the symbol at the end of its label; any other dollar sign
# belongs to a name
FORMULA = r"(?:[^$]|\$(?:\\mathdefault\{[^$]*\}|c_[a-z]|J_p/J_t|c_d\\,\\mathrm\{Re\})\$)*"
GREEK = "alpha|beta|gamma|delta|varepsilon|zeta|eta|theta|kappa|lambda|mu|nu|xi|rho|sigma|tau|varphi|chi|psi|omega"
SYMBOL = rf"(?:[A-Za-z]|\\(?:{GREEK}))(?:_(?:[a-z0-9]|\\infty|\\mathrm\{{[a-z]+\}}))?|c_d \\mathrm\{{Re\}}"
OWN_FORMULA = re.compile(rf"{FORMULA}|[^$]*, \$(?:{SYMBOL})\$(?: \([^$]*\))?")


def as_written(text: Text) -> None:
    """Show a text as it is written unless it is a formula of this package: names are data."""
    if "$" in text.get_text() and not OWN_FORMULA.fullmatch(text.get_text()):
        text.set_parse_math(False)


DRAWING = threading.RLock()  # Matplotlib's settings, fonts and formulas are shared: one thread draws at a time


class Picture(Figure):
    """A figure without pyplot that a notebook shows as an image."""

    def draw(self, renderer: RendererBase) -> None:
        """Draw it, with names as they are written."""
        for axes in self.axes:
            axes.get_xticklabels(), axes.get_yticklabels()  # brings their texts up to date
        for text in self.findobj(Text):
            as_written(text)
        engine = self.get_layout_engine()
        if engine is not None:
            if _titles_fit(self, renderer):
                engine.execute(self)
            engine.execute(self)  # once more than matplotlib does: panels of another size have other ticks
        super().draw(renderer)

    def savefig(self, fname: Any, *, transparent: bool | None = None, **kwargs: Any) -> None:
        """As Matplotlib does, one thread at a time."""
        with DRAWING:
            super().savefig(fname, transparent=transparent, **kwargs)

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png", dpi=110)
        return buffer.getvalue()


def _titles_fit(figure: Figure, renderer: RendererBase) -> bool:
    """Break the lines of the title of a figure that is wider than the figure; whether that was so."""
    title: Text | None = figure._suptitle  # type: ignore[attr-defined]
    if title is None or not title.get_text():
        return False
    box = title.get_window_extent(renderer)
    room = figure.bbox.x1 - box.x0
    if box.width <= room:
        return False
    lines = title.get_text().split("\n")
    longest = int(max(map(len, lines)) * room / box.width)
    title.set_text("\n".join(fill(line, max(longest, 20)) for line in lines))
    return True


@contextmanager
def look() -> Iterator[None]:
    """Draw with the look of this package, one thread at a time; the settings of the caller come back afterwards."""
    with DRAWING, matplotlib.rc_context(LOOK):
        yield


def picture(width: float, height: float, dpi: float = 110.0) -> Figure:
    """An empty figure of ``width`` by ``height`` inches with its own Agg canvas and constrained layout."""
    figure = Picture(figsize=(width, height), dpi=dpi, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def heading(figure: Figure, text: str) -> None:
    """The title of a figure with several panels: left and bold, as that of a panel."""
    if text:
        figure.suptitle(text, x=0.1 / figure.get_figwidth(), ha="left")


def with_ignored(title: str, attributes: Mapping[Any, Any], verb: str = "ignores") -> str:
    """A title that names what the theory of the result ignores of its machine."""
    ignored = str(attributes.get("ignores", ""))
    return f"{title}\n{verb} {ignored}" if ignored else title


def ball_color(number: int) -> str:
    """Color of ball ``number``, counted from 0."""
    return BALLS[number % len(BALLS)]


def ball_label(number: int, count: int) -> str:
    """Legend entry of ball ``number``: one for each of a few balls, one for all of many; "_" hides an entry."""
    if count <= 6:
        return f"ball {number + 1}"
    return f"{count} balls" if number == 0 else "_"


def legend(axes: Axes, extra: Sequence[Artist] = ()) -> None:
    """A legend above the panel, where it hides nothing, in as few rows as fit; ``extra`` keys first; none if there is nothing."""
    handles, _ = axes.get_legend_handles_labels()
    handles = [*extra, *handles]
    labels = [str(handle.get_label()) for handle in handles]
    if not handles:
        return
    figure = axes.get_figure(root=True)
    assert figure is not None
    room = 72.0 * axes.get_position().width * figure.get_figwidth()
    room *= 1.0 if figure.get_layout_engine() is None else 1.12  # constrained layout makes panels wider later
    columns = len(labels)
    while columns > 1 and legend_width(labels, columns) > room:
        columns = min(columns - 1, -(-len(labels) // (-(-len(labels) // (columns - 1)))))
    axes.legend(handles, labels, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.1)


def legend_below(figure: Figure, handles: Sequence[Artist], absent: Sequence[str]) -> None:
    """A legend below all panels; above its keys stands in words what is ``absent`` from the picture."""
    words = fill(f"not in the picture: {', '.join(absent)}", 105) if absent else None
    place: Any = {"loc": "outside lower center", "ncols": 3, "handlelength": 2.8}
    figure.legend(handles=list(handles), title=words, title_fontsize=8.5, **place)


def legend_width(labels: list[str], columns: int) -> float:
    """Points that a legend takes, entries going down the columns."""
    most, longer = divmod(len(labels), columns)  # the first columns have one more
    ends = [0, *((i + 1) * most + min(i + 1, longer) for i in range(columns))]
    widest = [max(map(len, labels[first:last])) for first, last in pairwise(ends)]
    return sum(4.7 * width + 33.0 for width in widest)


# Pictures to files.


FORMATS = ("png", "svg", "pdf")


def save_picture(figure: Figure, path: str | Path, *, dpi: float = 150.0) -> Path:
    """Write a picture; the extension says how: ``.png``, ``.svg`` or ``.pdf``.

    Parameters
    ----------
    figure
        From a function of ``ab.plot``.
    path
        The file; its folder is made if there is none.
    dpi
        Pixels per inch of a PNG.

    Returns
    -------
    pathlib.Path
        The file that was written.

    Raises
    ------
    QuestionError
        If the extension is none of these.
    ResultError
        If the file cannot be written.
    """
    path = as_path(path)
    kind = path.suffix.lower().removeprefix(".")
    if kind not in FORMATS:
        raise QuestionError(f"{path}: pictures are saved as .png, .svg or .pdf; end the name with one of these")
    when = {"png": None, "svg": {"Date": None}, "pdf": {"CreationDate": None}}[kind]  # equal runs, equal files
    with DRAWING, matplotlib.rc_context({"svg.hashsalt": "autobalancer"}):
        return write_safely(path, lambda file: figure.savefig(file, format=kind, dpi=dpi, metadata=when))


# Labels of points and lines that do not cover one another, nor a curve where there is room beside it.
#
# Where a label goes is decided when the picture is drawn, from the places on the page, whatever the axes then are. All
# labels of one pair of axes share one :class:`Labels`, so that they know of one another.


HALO = [withStroke(linewidth=2.6, foreground="white", alpha=0.85)]  # of letters, so that a curve below them stays seen
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
        drawn = Text(0.0, 0.0, text, color=color, fontsize=size, path_effects=HALO, va="bottom", ha="left")
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


# Axes of parameters: SI in the result, what people write on the axis.


class QuantityAxis(NamedTuple):
    """How the values of a coordinate are shown."""

    values: np.ndarray  # shown
    label: str
    unit: AxisUnit
    log: bool


def quantity_axis(values: xr.DataArray, speed_unit: str) -> QuantityAxis:
    """Shown values and label; logarithmic for values that ascend by equal ratios over more than a decade."""
    unit = axis_unit(values, speed_unit)
    numbers = np.asarray(values.values, np.float64)
    return QuantityAxis(unit.shown(numbers), axis_label(values, unit), unit, _geometric(numbers))


def axis_label(values: xr.DataArray, unit: AxisUnit) -> str:
    """Name, symbol and unit of a coordinate: ``mass of a ball, $m$ (g)``."""
    text, symbol = str(values.attrs.get("long_name", values.name)), values.attrs.get("symbol", "")
    return text + f", ${symbol}$" * bool(symbol) + f" ({unit.sign})" * bool(unit.sign)


def plain_log_ticks(axes: Axes, which: str, write: Callable[[float], str] = "{:g}".format) -> None:
    """1, 2, 5, 10, ... as plain numbers on a logarithmic axis, or as ``write`` says; more of them on a short one."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis = axes.xaxis if which == "x" else axes.yaxis
    low, high = axis.get_view_interval()
    steps: tuple[float, ...] = (1.0, 2.0, 5.0) if high / low < 2e3 else (1.0,)
    if high / low < 8.0:
        steps = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
    axis.set_major_locator(LogLocator(subs=steps, numticks=30))
    axis.set_major_formatter(FuncFormatter(lambda value, _: write(value)))
    axis.set_minor_formatter(NullFormatter())


def _geometric(values: np.ndarray) -> bool:
    if values.size < 3 or values.min() <= 0.0 or values.max() / values.min() < 10.0:
        return False
    ratios, steps = np.diff(np.log(values)), np.diff(values)
    return bool(np.ptp(ratios) / abs(ratios.mean()) < np.ptp(steps) / abs(steps.mean()))


# Angles that go round and round, as lines on an axis from -180 to 180 degrees.


def wrapped(time: Floats, angle: Floats) -> tuple[Floats, Floats]:
    """A continuous angle (rad) as degrees within ±180, broken where it passes the edge.

    Each passage becomes three points: the edge left, a gap (nan), the edge entered; so no line runs across the axis.

    Parameters
    ----------
    time
        Ascending, s.
    angle
        Not wrapped, rad, of the same length.

    Returns
    -------
    time, degrees
        Arrays for one line.
    """
    turn = np.floor((angle + np.pi) / (2.0 * np.pi))
    inside = np.rad2deg(angle - 2.0 * np.pi * turn)
    passes = np.flatnonzero(np.diff(turn))
    at, when, value = [], [], []
    for i in passes:
        up = turn[i + 1] > turn[i]
        edges = np.pi * (2.0 * np.arange(turn[i], turn[i + 1]) + 1.0)
        if not up:
            edges = np.pi * (2.0 * np.arange(turn[i], turn[i + 1], -1.0) - 1.0)
        for edge in edges:
            part = (edge - angle[i]) / (angle[i + 1] - angle[i])
            moment = time[i] + part * (time[i + 1] - time[i])
            side = 180.0 if up else -180.0
            at += [i + 1] * 3
            when += [moment] * 3
            value += [side, np.nan, -side]
    return np.insert(time, at, when), np.insert(inside, at, value)


def slipping(time: Floats, angle: Floats, span: float) -> NDArray[np.bool_]:
    """Where an angle goes round over 2.5 times in 1/100 of ``span`` (s), so that its line would be a solid block."""
    if time.size < 2:
        return np.zeros(time.shape, np.bool_)
    window = 0.01 * span
    ahead = np.interp(time + 0.5 * window, time, angle)
    behind = np.interp(time - 0.5 * window, time, angle)
    fast: NDArray[np.bool_] = np.abs(ahead - behind) > 5.0 * np.pi
    return fast


# Panels over the rotor speed: amplitudes of each unit by themselves, and which way time runs.


BACK = 0.05  # share of the whole way of the speed; what goes the other way less than this is noise


def panels_of_units(figure: Figure, units: Sequence[str], place: Any = None) -> list[Axes]:
    """A panel for the amplitudes of each unit, in the order in which they come first, and one below all for the phases.

    Parameters
    ----------
    figure
        In which they are drawn.
    units
        Of each channel.
    place
        Cell of a grid; by default the whole figure.
    """
    count = len(set(units))
    inner: Any = figure.add_gridspec if place is None else place.subgridspec
    panels = inner(count + 1, 1, height_ratios=[3] * count + [2]).subplots(sharex=True)
    return list(panels)


def speed_trend(speed: NDArray[np.float64]) -> int:
    """1 of a run-up, -1 of a run-down, 0 of a speed that goes both ways."""
    steps = np.diff(speed[np.isfinite(speed)])
    up, down = float(steps[steps > 0.0].sum()), float(-steps[steps < 0.0].sum())
    if min(up, down) > BACK * (up + down):
        return 0
    return 1 if up >= down else -1


def time_runs(speed: NDArray[np.float64]) -> str:
    """What the label of an axis of the speed says of time: nothing of a run-up."""
    return {1: "", -1: ", time runs to the left", 0: ", up and down"}[speed_trend(speed)]
