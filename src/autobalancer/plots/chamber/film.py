"""Films of a deep chamber in three dimensions."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.plots.chamber.view import COLORS, Camera, ChamberView, Poses, poses_of
from autobalancer.plots.drawing.style import BALLS, INK, UNBALANCE, look
from autobalancer.plots.film.canvas import FilmCanvas, frames_of
from autobalancer.plots.film.files import write_film
from autobalancer.plots.film.film import Film
from autobalancer.plots.film.question import film_question, frame_times, magnification, pace, size_words
from autobalancer.results.chamber.shape import ChamberShape, chambers_of, unbalance_of
from autobalancer.results.display_units import AxisUnit, length_axis


def animate_chamber(
    run: xr.Dataset,
    path: str | Path,
    *,
    start: float | str | None = None,
    end: float | str | None = None,
    duration: float | str = 10.0,
    fps: int = 25,
    frame: Literal["rotor", "space"] = "space",
    azimuth: float = 35.0,
    elevation: float = 20.0,
    deflection_scale: float | Literal["auto"] = "auto",
    speed_unit: str = "rpm",
    width: int = 960,
    progress: Callable[[int, int], None] | None = None,
) -> Film:
    """Make a film of the balls in their chamber, colored by their speed, beside rotor speed and deflection over time.

    Parameters
    ----------
    run
        From ``simulate`` or an archive; samples are read as the film needs them.
    path
        The film, ``.mp4`` or ``.gif``; replaced when the new one is complete.
    start, end
        Interval of the run in s; by default all of it.
    duration, fps
        Length of the film in s, and frames in a second of it, 1 to 100.
    frame
        ``"space"``: as it is; ``"rotor"``: the rotor stands as under a stroboscope, so that one sees where balls rest.
    azimuth, elevation
        Direction of view in degrees: in the horizontal plane from the rotor's axis, and above it. 0 and 0 look along the
        axis, 90 and 0 from the side, 0 and 90 from above.
    deflection_scale
        How much larger the displacement of the body is drawn; by default so that the greatest is 10 % of the radius.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    width
        Pixels, 320 to 3840.
    progress
        Called with (frames done, frames in all).

    Returns
    -------
    Film
        The path of the file that was written; a notebook shows the film.

    Raises
    ------
    QuestionError
        If the interval is not within the run, or a number, unit or extension is not possible.
    ResultError
        If the file cannot be written.
    """
    asked = film_question(
        path, start=start, end=end, duration=duration, fps=fps, frame=frame, speed_unit=speed_unit, width=width
    )
    if not (np.isfinite(azimuth) and -90.0 <= elevation <= 90.0):
        raise QuestionError(f"elevation: given {elevation:g} degrees, azimuth {azimuth:g}; the first is from -90 to 90")
    times = frame_times(run["time"].values, asked.start, asked.end, asked.frames)
    chambers = chambers_of(run)
    inside = (run["time"].values >= times[0]) & (run["time"].values <= times[-1])
    greatest = float(np.abs(run["body_position"].values[inside]).max(initial=0.0))
    scale = magnification(deflection_scale, greatest, max(chamber.radius for chamber in chambers), 0.1)
    unbalance = unbalance_of(run)
    heavy = float(np.angle(unbalance[0])) if unbalance is not None else 0.0
    with look():
        poses = poses_of(run, times, in_rotor=frame == "rotor", chambers=chambers, scale=scale, heavy=heavy)
        view = "in the frame of the rotor" if frame == "rotor" else "in space"
        caption = f"{view}, {pace(asked.duration, times)}, {size_words('displacement', scale)}"
        scene = _Scene(run, poses, chambers, Camera(azimuth, elevation), asked.unit, caption, width)
        write_film(asked.path, frames_of(scene.frame, asked.frames, progress), fps)
    return Film(asked.path)


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
        figure.text(0.28, 0.955, str(run.attrs.get("machine_name", "")), ha="center", va="center", weight="bold")
        self.text = figure.text(0.28, 0.91, "", ha="center", va="center", fontsize=11, family="monospace")
        figure.text(0.28, 0.02, caption, ha="center", va="bottom", fontsize=8.5, color="#404040")
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
