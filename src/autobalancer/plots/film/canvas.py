"""The canvas of a film: what never moves is drawn once, the rest on top of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, cast

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from autobalancer.plots.drawing.labels import labels_of
from autobalancer.plots.drawing.style import INK, picture
from autobalancer.plots.film.files import Frame

WIDTH, SHAPE = 9.6, 17.0 / 30.0  # inches, and height by width; the width in pixels sets the resolution


class FilmCanvas:
    """A figure of ``width`` pixels for many frames; artists are placed, then :meth:`freeze` is called once."""

    def __init__(self, width: int) -> None:
        even = width - width % 2
        dpi, height = even / WIDTH, 2 * round(0.5 * SHAPE * even)  # video needs even numbers of pixels
        self.figure = picture(WIDTH, (height + 0.01) / dpi, dpi=dpi)
        self.figure.set_layout_engine("none")  # fixed places: the picture must not shift with its labels
        self.canvas = cast(Any, FigureCanvasAgg(self.figure))
        self.moving: list[Artist] = []
        self.cursors: list[Line2D] = []

    def panels(self, left: float, first: float, last: float) -> tuple[Axes, Axes]:
        """Two axes over the time of the film, one above the other, right of ``left``, each with a cursor at ``first``."""
        wide = 0.975 - left
        upper = self.figure.add_axes((left, 0.55, wide, 0.35))
        lower = self.figure.add_axes((left, 0.09, wide, 0.345), sharex=upper)
        lower.set_xlabel("time (s)")
        lower.set_xlim(first, last)
        self.cursors = [panel.axvline(first, color=INK, lw=1.0, zorder=6, clip_on=False) for panel in (upper, lower)]
        return upper, lower

    def freeze(self, moving: Sequence[Artist]) -> None:
        """Draw everything but ``moving``, the cursors and the labels before which they pass, which each frame draws so."""
        labels = [labels_of(panel) for panel in self.figure.axes if any(line in self.cursors for line in panel.lines)]
        for each in labels:
            each.held = True
        self.moving = [*moving, *self.cursors, *labels]
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)

    def pixels(self, time: float) -> NDArray[np.uint8]:
        """The frame with the cursors at ``time``: rows, columns, red-green-blue."""
        for cursor in self.cursors:
            cursor.set_xdata([time, time])
        self.canvas.restore_region(self.still)
        renderer = self.canvas.get_renderer()
        for artist in self.moving:
            artist.draw(renderer)
        return np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy()


def frames_of(
    draw: Callable[[int], Frame], count: int, progress: Callable[[int, int], None] | None = None
) -> Iterator[Frame]:
    """Frames 0 to ``count`` - 1 of ``draw``; ``progress`` is called with (frames done, frames in all)."""
    for k in range(count):
        yield draw(k)
        if progress is not None:
            progress(k + 1, count)
