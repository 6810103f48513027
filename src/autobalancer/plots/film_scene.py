"""The scene of a film: the rotor from above beside two panels over time."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.plots.axis_units import AxisUnit, length_axis, length_text, significant
from autobalancer.plots.ball_looks import ball_looks
from autobalancer.plots.film_canvas import FilmCanvas
from autobalancer.plots.film_rotor import RotorView
from autobalancer.plots.history import Deflections, critical_speeds_of, deflections_of, history_of
from autobalancer.plots.motion import Complexes, Floats, Moments, Races
from autobalancer.plots.panels import deflection_panel, speed_panel


class Scene(FilmCanvas):
    """Draws frame after frame on one canvas."""

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
        super().__init__(width)
        self.moments, self.unit = moments, unit
        figure = self.figure
        above = figure.add_axes((0.0, 0.13, 0.49, 0.75))
        self.rotor = RotorView(
            above, moments, races, turned, path, per_frame, magnification, [ball.color for ball in ball_looks(run)]
        )
        figure.text(0.245, 0.955, str(run.attrs.get("machine_name", "")), ha="center", va="center", weight="bold")
        self.text = figure.text(0.245, 0.91, "", ha="center", va="center", fontsize=11, family="monospace")
        figure.text(0.245, 0.015, caption, ha="center", va="bottom", fontsize=8.5, color="#404040")
        figure.legend(handles=self.rotor.key, loc="lower center", bbox_to_anchor=(0.245, 0.085), ncols=3)
        self._panels(run)
        self.freeze([*self.rotor.artists, self.text])

    def frame(self, k: int) -> NDArray[np.uint8]:
        """Pixels of frame ``k``: rows, columns, red-green-blue."""
        self.rotor.show(k)
        self.text.set_text(self._words(k))
        return self.pixels(float(self.moments.time[k]))

    def _words(self, k: int) -> str:
        step = float(np.ptp(self.moments.time)) / max(self.moments.time.size - 1, 1)
        digits = int(np.clip(np.ceil(-np.log10(step) - 1e-6), 0, 9)) if step > 0.0 else 3
        speed = significant(float(self.moments.speed[k]) * self.unit.factor)
        deflection = length_text(float(np.abs(self.moments.deflection_in_rotor[k])))
        return f"{self.moments.time[k]:.{digits}f} s  {speed:>6} {self.unit.sign}  {deflection:>10}"

    def _panels(self, run: xr.Dataset) -> None:
        """Speeds and deflection over the time of the film, each with a cursor."""
        first, last = float(self.moments.time[0]), float(self.moments.time[-1])
        upper, lower = self.panels(0.57, first, last)
        history, deflections = history_of(run, first, last), deflections_of(run, first, last)
        if history is not None and history.time.size > 1:
            speed_panel(upper, history, critical_speeds_of(run), self.unit, ball_looks(run))
        if deflections is None or deflections.time.size < 2:  # a short film between two bins or samples
            size = np.abs(self.moments.deflection_in_rotor)
            deflections = Deflections(self.moments.time, size, size, False)
        deflection_panel(lower, deflections, length_axis(None, float(deflections.high.max())))
        lower.set_xlabel("time (s)")
        lower.set_xlim(first, last)
        self.figure.align_ylabels([upper, lower])
