"""The scene of a film: each plane of the rotor from above, the axis from the side, beside panels over time."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.text import Text
from numpy.typing import NDArray

from autobalancer.plots.film.axis import AxisView
from autobalancer.plots.film.canvas import FilmCanvas
from autobalancer.plots.film.rotor import RotorView, unit_length
from autobalancer.plots.run.ball_looks import ball_looks, planes_of
from autobalancer.plots.run.history import Deflections, critical_speeds_of, deflections_of, ends_at, history_of, quiet
from autobalancer.plots.run.panels import deflection_panel, speed_panel
from autobalancer.plots.run.places import places_in_rotor
from autobalancer.results.display_units import EACH_ITS_OWN, AxisUnit, length_axis, length_text, significant
from autobalancer.results.drawn.forces import forces_of
from autobalancer.results.drawn.motion import Floats, Moments, Races

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
        figure.text(middle, 0.965, str(run.attrs.get("machine_name", "")), ha="center", va="center", weight="bold")
        self.text = figure.text(middle, 0.92, "", ha="center", va="center", fontsize=11, family="monospace")
        figure.text(middle, 0.012, caption, ha="center", va="bottom", fontsize=8.5, color="#404040")
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
        lower.set_xlabel("time (s)")
        lower.set_xlim(first, last)
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
