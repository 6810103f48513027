"""Films of a run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal

import numpy as np
import xarray as xr

from autobalancer.patience import shows_progress
from autobalancer.plots.drawing.style import look
from autobalancer.plots.film.canvas import frames_of
from autobalancer.plots.film.files import write_film
from autobalancer.plots.film.film import Film
from autobalancer.plots.film.question import film_question, frame_times, magnification, pace, size_words
from autobalancer.plots.film.rotor import unit_length
from autobalancer.plots.film.scene import Scene
from autobalancer.plots.run.places import places_in_rotor
from autobalancer.results.display_units import significant
from autobalancer.results.drawn.motion import Floats, Moments, Motion, races_of

PATH_POINTS = 16  # points of the path of the rotor center for each frame


@shows_progress
def animate_races(
    run: xr.Dataset,
    path: str | Path,
    *,
    start: float | str | None = None,
    end: float | str | None = None,
    duration: float | str = 10.0,
    fps: int = 25,
    frame: Literal["rotor", "space"] = "rotor",
    deflection_scale: float | Literal["auto"] = "auto",
    speed_unit: str = "rpm",
    width: int = 960,
    progress: Callable[[int, int], None] | None = None,
) -> Film:
    """Make a film of a run: rotor, races, balls and unbalance beside speeds and deflection over time.

    Balancers in different planes have a disc each, with the unbalance of their plane; below them the axis is seen from
    the side, with these planes in perspective, so that its tilt or bending is visible.

    A rotor at 3000 rpm turns twice between two frames of a film in real time, so its picture would seem to stand still or
    to rotate slowly. In the frame of the rotor, the default, it stands still as under a stroboscope, and one sees what
    matters: how the balls move relative to it, and to which side it is deflected. In space the rotor rotates;
    choose a short interval, so that the film is slow motion. The caption says how fast the film is, how much larger
    the deflection is drawn, and, in space, how often the rotor turns between two frames. The pale arc behind a ball
    is its path since the previous frame; a full ring means that it circled at least once.

    Frames lie on the samples of the run where the samples are denser than the frames; between samples the motion is a
    cubic in the frame of the rotor. For slow motion of a machine that is not isotropic save some ten samples to a
    revolution (``SampleTimes``).

    Parameters
    ----------
    run
        From :func:`simulate` or :func:`load_run`, with samples.
    path
        The film, ``.mp4`` or ``.gif``. MP4 needs no program on the system. An existing film is replaced when the new
        one is complete.
    start, end
        Interval of the run in s; by default all samples.
    duration
        Length of the film in s.
    fps
        Frames in a second of film, 1 to 100.
    frame
        ``"rotor"``: the rotor stands still; ``"space"``: it turns.
    deflection_scale
        How much larger the deflection is drawn; by default so that the greatest is 15 % of the orbit radius.
    speed_unit
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``.
    width
        Pixels, 320 to 3840; the height follows.
    progress
        Called with (frames done, frames in all).

    Returns
    -------
    Film
        The path of the file that was written; a notebook shows the film.

    Raises
    ------
    QuestionError
        If the run has no samples there, or the extension, a unit or a number is not possible.
    ResultError
        If the file cannot be written.
    """
    asked = film_question(
        path, start=start, end=end, duration=duration, fps=fps, frame=frame, speed_unit=speed_unit, width=width
    )
    motion, races = Motion(run), races_of(run)
    times = _frame_times(motion.time, asked.start, asked.end, asked.frames)
    moments = motion.at(times)
    index = np.arange(times.size)
    fine = motion.at(np.interp(np.arange((times.size - 1) * PATH_POINTS + 1) / PATH_POINTS, index, times))
    turns = frame == "space"
    along = places_in_rotor(run, times)
    drawn = [fine.deflection_in_rotor, fine.plane_deflection_in_rotor, *([] if along is None else [along.deflection])]
    greatest = max(float(np.abs(z).max()) for z in drawn)
    scale = magnification(deflection_scale, greatest, unit_length(moments, races), 0.15)
    with look():
        scene = Scene(
            run,
            moments,
            fine,
            races,
            in_space=turns,
            per_frame=PATH_POINTS,
            magnification=scale,
            unit=asked.unit,
            caption=_caption(moments, turns, asked.duration, scale, bool(races.orbit_radius.size)),
            width=width,
        )
        write_film(asked.path, frames_of(scene.frame, times.size, progress), fps)
    return Film(asked.path)


def _frame_times(samples: Floats, start: float | None, end: float | None, count: int) -> Floats:
    """Equal steps, moved to the nearest sample where the samples are the denser."""
    times = frame_times(samples, start, end, count)
    inner = samples[(samples >= times[0]) & (samples <= times[-1])]
    if inner.size < 2 or np.diff(inner).max() > times[1] - times[0]:
        return times
    right = np.clip(np.searchsorted(inner, times), 1, inner.size - 1)
    nearest = np.where(times - inner[right - 1] < inner[right] - times, right - 1, right)
    return np.asarray(inner[nearest])


def _caption(moments: Moments, turns: bool, duration: float, scale: float, with_race: bool) -> str:
    fastest = float(np.abs(np.diff(moments.rotor_angle)).max()) / (2.0 * np.pi)
    if not turns:
        view = "in the frame of the rotor, as under a stroboscope"
    elif fastest < 0.1:
        view = "in space"
    else:
        view = f"in space, up to {significant(fastest)} turns between two frames"
    size = size_words("deflection", scale) if with_race else "not to scale"
    return f"{view}\n{pace(duration, moments.time)}, {size}"
