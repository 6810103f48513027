"""Films of a deep chamber in three dimensions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.plots.axis_units import AxisUnit, length_axis, round_down, significant, speed_axis
from autobalancer.plots.chamber_view import COLORS, Camera, ChamberView, Poses, poses_of
from autobalancer.plots.film_files import Frame, film_format, write_film
from autobalancer.plots.style import BALLS, INK, UNBALANCE, look, picture
from autobalancer.results.chamber_shape import ChamberShape, chambers_of, unbalance_of

Floats = NDArray[np.float64]
WIDTH, SHAPE = 9.6, 17.0 / 30.0


def animate_chamber(
    run: xr.Dataset,
    path: str | Path,
    *,
    start: float | None = None,
    end: float | None = None,
    duration: float = 10.0,
    fps: int = 25,
    frame: Literal["rotor", "space"] = "space",
    azimuth: float = 35.0,
    elevation: float = 20.0,
    deflection_scale: float | Literal["auto"] = "auto",
    speed_unit: str = "rpm",
    width: int = 960,
    progress: Callable[[int, int], None] | None = None,
) -> Path:
    """Make a film of the balls in their chamber, colored by their speed, beside rotor speed and deflection over time.

    Parameters
    ----------
    run
        From ``simulate_chamber`` or an archive; samples are read as the film needs them.
    path
        The film, ``.mp4`` or ``.gif``; replaced when the new one is complete.
    start, end
        Interval of the run in s; by default all of it.
    duration, fps
        Length of the film in s, and frames in a second of it, 1 to 100.
    frame
        ``"space"``: as it is; ``"rotor"``: the rotor stands as under a stroboscope, so that one sees where balls rest.
    azimuth, elevation
        Degrees: where one looks from, in the horizontal plane from the rotor's axis, and above it. 0 and 0 look along the
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
    pathlib.Path
        The file that was written.

    Raises
    ------
    QuestionError
        If the interval is not within the run, or a number, unit or extension makes no sense.
    ResultError
        If the file cannot be written.
    """
    path = Path(path)
    film_format(path)
    unit = speed_axis(speed_unit)
    count = round(duration * fps) if np.isfinite(duration) else 0
    _check(frame, fps, duration, count, width, azimuth, elevation)
    times = _times(run, start, end, count)
    chambers = chambers_of(run)
    scale = _scale(run, times, chambers, deflection_scale)
    unbalance = unbalance_of(run)
    heavy = float(np.angle(unbalance[0])) if unbalance is not None else 0.0
    with look():
        poses = poses_of(run, times, in_rotor=frame == "rotor", chambers=chambers, scale=scale, heavy=heavy)
        pace = duration / max(float(np.ptp(times)), 1e-12)
        told = f"{significant(max(pace, 1.0 / pace))} times {'slower' if pace > 1.0 else 'faster'} than real"
        told = "real time" if 0.95 < pace < 1.05 else told
        view = "in the frame of the rotor" if frame == "rotor" else "in space"
        caption = f"{view}, {told}, displacement drawn {scale:g} times larger"
        scene = _Scene(run, poses, chambers, Camera(azimuth, elevation), unit, caption, width - width % 2)
        write_film(path, _frames(scene, count, progress), fps)
    return path


class _Scene:
    """What never moves is drawn once, the rest on top of it."""

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
        self.poses, self.unit = poses, unit
        dpi, height = width / WIDTH, 2 * round(0.5 * SHAPE * width)
        figure = picture(WIDTH, (height + 0.01) / dpi, dpi=dpi)
        figure.set_layout_engine("none")
        self.canvas = cast(Any, FigureCanvasAgg(figure))
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
        self.cursors = self._panels(run, figure)
        self.moving: list[Artist] = [*self.view.artists, self.text, *self.cursors]
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(figure.bbox)

    def frame(self, k: int) -> NDArray[np.uint8]:
        """Pixels of frame ``k``."""
        self.view.show(k)
        time = float(self.poses.time[k])
        for cursor in self.cursors:
            cursor.set_xdata([time, time])
        fastest = float(self.poses.speed[k].max(initial=0.0))
        self.text.set_text(f"{time:8.3f} s   fastest ball {fastest:5.2f} m/s")
        self.canvas.restore_region(self.still)
        renderer = self.canvas.get_renderer()
        for artist in sorted(self.moving, key=lambda artist: artist.get_zorder()):
            artist.draw(renderer)
        return np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy()

    def _panels(self, run: xr.Dataset, figure: Any) -> list[Line2D]:
        first, last = float(self.poses.time[0]), float(self.poses.time[-1])
        time = run["time"].values
        inside = np.flatnonzero((time >= first) & (time <= last))
        if inside.size < 2:
            inside = np.arange(time.size)
        shown = run.isel(time=slice(int(inside[0]), int(inside[-1]) + 1))
        upper = figure.add_axes((0.69, 0.565, 0.29, 0.37))
        lower = figure.add_axes((0.69, 0.09, 0.29, 0.37), sharex=upper)
        upper.plot(shown["time"], shown["speed"] * self.unit.factor, color=INK)
        upper.set_ylabel(f"rotor speed ({self.unit.sign})")
        body = shown["body_position"].values
        body = body - body.mean(axis=0)
        axis = length_axis(None, float(np.abs(body[:, 1:]).max(initial=0.0)))
        for column, name, color in ((1, "horizontal", BALLS[4]), (2, "vertical", BALLS[0])):
            lower.plot(shown["time"], body[:, column] * axis.factor, color=color, lw=0.8, label=name)
        lower.set_ylabel(f"displacement ({axis.sign})")
        lower.set_xlabel("time (s)")
        lower.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
        lower.set_xlim(first, last)
        figure.align_ylabels([upper, lower])
        return [panel.axvline(first, color=INK, lw=1.0, zorder=6) for panel in (upper, lower)]


def _frames(scene: _Scene, count: int, progress: Callable[[int, int], None] | None) -> Iterator[Frame]:
    for k in range(count):
        yield scene.frame(k)
        if progress is not None:
            progress(k + 1, count)


def _check(frame: str, fps: int, duration: float, count: int, width: int, azimuth: float, elevation: float) -> None:
    if frame not in ("rotor", "space"):
        raise QuestionError(f"frame: given {frame!r}; must be 'rotor' or 'space'")
    if not 1 <= fps <= 100:
        raise QuestionError(f"fps: given {fps}; must be between 1 and 100 frames a second")
    if not 2 <= count <= 100000:
        raise QuestionError(f"duration: given {duration:g} s at {fps} frames a second; a film has 2 to 100000 frames")
    if not 320 <= width <= 3840:
        raise QuestionError(f"width: given {width} pixels; must be between 320 and 3840")
    if not (np.isfinite(azimuth) and -90.0 <= elevation <= 90.0):
        raise QuestionError(f"elevation: given {elevation:g} degrees, azimuth {azimuth:g}; the first is from -90 to 90")


def _times(run: xr.Dataset, start: float | None, end: float | None, count: int) -> Floats:
    samples = run["time"].values
    if samples.size < 2:
        raise QuestionError(f"the run has {samples.size} samples; a film needs two")
    first = float(samples[0]) if start is None else float(start)
    last = float(samples[-1]) if end is None else float(end)
    if not samples[0] - 1e-9 <= first < last <= samples[-1] + 1e-9:
        raise QuestionError(
            f"from {first:g} s to {last:g} s: the samples go from {samples[0]:g} s to {samples[-1]:g} s; "
            "choose an interval within"
        )
    return np.linspace(first, last, count)


def _scale(run: xr.Dataset, times: Floats, chambers: list[ChamberShape], asked: float | Literal["auto"]) -> float:
    if asked != "auto":
        if not (np.isfinite(asked) and asked > 0.0):
            raise QuestionError(f"deflection_scale: given {asked!r}; must be 'auto' or a number greater than zero")
        return float(asked)
    inside = (run["time"].values >= times[0]) & (run["time"].values <= times[-1])
    greatest = float(np.abs(run["body_position"].values[inside]).max(initial=0.0))
    size = max(chamber.radius for chamber in chambers)
    return max(round_down(0.1 * size / greatest), 1.0) if greatest > 1e-12 * size else 1.0
