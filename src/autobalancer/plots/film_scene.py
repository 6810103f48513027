"""The scene of a film: the rotor from above beside two panels over time."""

from __future__ import annotations

from typing import Any, cast

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from autobalancer.plots.axis_units import AxisUnit, length_axis, length_text, significant
from autobalancer.plots.film_rotor import RotorView
from autobalancer.plots.history import Deflections, critical_speeds_of, deflections_of, history_of
from autobalancer.plots.motion import Complexes, Floats, Moments, Races
from autobalancer.plots.panels import deflection_panel, speed_panel
from autobalancer.plots.style import INK, picture

WIDTH, SHAPE = 9.6, 17.0 / 30.0  # inches, and height by width; the width in pixels sets the resolution


class Scene:
    """Draws frame after frame on one canvas: what never moves is drawn once, the rest on top of it."""

    def __init__(
        self,
        run: xr.Dataset,
        moments: Moments,
        races: Races,
        turned: Floats,
        path: Complexes,
        *,
        per_frame: int,
        magnification: float,
        unit: AxisUnit,
        caption: str,
        width: int,
    ) -> None:
        self.moments, self.unit = moments, unit
        dpi, height = width / WIDTH, 2 * round(0.5 * SHAPE * width)  # video needs even numbers of pixels
        figure = picture(WIDTH, (height + 0.01) / dpi, dpi=dpi)
        figure.set_layout_engine("none")  # fixed places: the picture must not shift with its labels
        self.canvas = cast(Any, FigureCanvasAgg(figure))
        above = figure.add_axes((0.0, 0.13, 0.49, 0.75))
        self.rotor = RotorView(above, moments, races, turned, path, per_frame, magnification)
        figure.text(0.245, 0.955, str(run.attrs.get("machine_name", "")), ha="center", va="center", weight="bold")
        self.text = figure.text(0.245, 0.91, "", ha="center", va="center", fontsize=11, family="monospace")
        figure.text(0.245, 0.015, caption, ha="center", va="bottom", fontsize=8.5, color="#404040")
        figure.legend(handles=self.rotor.key, loc="lower center", bbox_to_anchor=(0.245, 0.085), ncols=3)
        upper = figure.add_axes((0.57, 0.565, 0.405, 0.37))
        lower = figure.add_axes((0.57, 0.09, 0.405, 0.37), sharex=upper)
        cursors = self._panels(run, upper, lower)
        figure.align_ylabels([upper, lower])
        self.cursors = cursors
        self.moving: list[Artist] = [*self.rotor.artists, self.text, *cursors]
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(figure.bbox)

    def frame(self, k: int) -> NDArray[np.uint8]:
        """Pixels of frame ``k``: rows, columns, red-green-blue."""
        time = float(self.moments.time[k])
        self.rotor.show(k)
        for cursor in self.cursors:
            cursor.set_xdata([time, time])
        self.text.set_text(self._words(k))
        self.canvas.restore_region(self.still)
        renderer = self.canvas.get_renderer()
        for artist in self.moving:
            artist.draw(renderer)
        return np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy()

    def _words(self, k: int) -> str:
        step = float(np.ptp(self.moments.time)) / max(self.moments.time.size - 1, 1)
        digits = int(np.clip(np.ceil(-np.log10(step) - 1e-6), 0, 9)) if step > 0.0 else 3
        speed = significant(float(self.moments.speed[k]) * self.unit.factor)
        deflection = length_text(float(np.abs(self.moments.deflection_in_rotor[k])))
        return f"{self.moments.time[k]:.{digits}f} s  {speed:>6} {self.unit.sign}  {deflection:>10}"

    def _panels(self, run: xr.Dataset, upper: Axes, lower: Axes) -> list[Line2D]:
        """Speeds and deflection over the time of the film, each with a cursor."""
        first, last = float(self.moments.time[0]), float(self.moments.time[-1])
        history, deflections = history_of(run, first, last), deflections_of(run, first, last)
        if history is not None and history.time.size > 1:
            speed_panel(upper, history, critical_speeds_of(run), self.unit)
        if deflections is None or deflections.time.size < 2:  # a short film between two bins or samples
            size = np.abs(self.moments.deflection_in_rotor)
            deflections = Deflections(self.moments.time, size, size, False)
        deflection_panel(lower, deflections, length_axis(None, float(deflections.high.max())))
        lower.set_xlabel("time (s)")
        lower.set_xlim(first, last)
        return [panel.axvline(first, color=INK, lw=1.0, zorder=6, clip_on=False) for panel in (upper, lower)]
