"""What every film asks: which part of a run, how long and how large, and how fast it then is."""

from __future__ import annotations

from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.plots.film.files import film_format
from autobalancer.results.display_units import AxisUnit, round_down, significant, speed_axis
from autobalancer.safe_file import as_path
from autobalancer.units import argument, optional_argument

Floats = NDArray[np.float64]


class FilmQuestion(NamedTuple):
    """What was asked of a film, in SI."""

    path: Path
    start: float | None  # s
    end: float | None  # s
    duration: float  # s, of the film
    frames: int
    unit: AxisUnit  # of speeds


def film_question(
    path: str | Path,
    *,
    start: float | str | None,
    end: float | str | None,
    duration: float | str,
    fps: int,
    frame: str,
    speed_unit: str,
    width: int,
) -> FilmQuestion:
    """The arguments that all films have, read and checked.

    Raises
    ------
    QuestionError
        If one of them is not possible.
    """
    first, last = optional_argument("start", start, "s"), optional_argument("end", end, "s")
    seconds = argument("duration", duration, "s")
    film_format(as_path(path))
    unit = speed_axis(speed_unit)
    return FilmQuestion(as_path(path), first, last, seconds, frame_count(frame, fps, seconds, width), unit)


def frame_count(frame: str, fps: int, duration: float, width: int) -> int:
    """Number of frames of a film.

    Raises
    ------
    QuestionError
        If the frame of reference is neither rotor nor space, or a number makes no film.
    """
    if frame not in ("rotor", "space"):
        raise QuestionError(f"frame: given {frame!r}; must be 'rotor' or 'space'")
    if not 1 <= fps <= 100:
        raise QuestionError(f"fps: given {fps}; must be between 1 and 100 frames a second")
    count = round(duration * fps) if np.isfinite(duration) else 0
    if not 2 <= count <= 100000:
        raise QuestionError(f"duration: given {duration:g} s at {fps} frames a second; a film has 2 to 100000 frames")
    if not 320 <= width <= 3840:
        raise QuestionError(f"width: given {width} pixels; must be between 320 and 3840")
    return count


def frame_times(samples: Floats, start: float | None, end: float | None, count: int) -> Floats:
    """Equal steps from ``start`` to ``end``, by default over all samples.

    Raises
    ------
    QuestionError
        If the interval is not within the samples.
    """
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


def magnification(asked: float | Literal["auto"], greatest: float, size: float, share: float) -> float:
    """How much larger a deflection is drawn; by default so that ``greatest`` is at most ``share`` of ``size``.

    Raises
    ------
    QuestionError
        If a number is asked for that is not greater than zero.
    """
    if asked != "auto":
        if not (np.isfinite(asked) and asked > 0.0):
            raise QuestionError(f"deflection_scale: given {asked!r}; must be 'auto' or a number greater than zero")
        return float(asked)
    return round_down(share * size / greatest) if greatest > 1e-12 * size else 1.0


def size_words(thing: str, scale: float) -> str:
    """How large a ``thing`` is drawn, in words: ``"deflection drawn 20 times larger"``, ``"... at half size"``."""
    if scale == 1.0:
        return f"{thing} to scale"
    if scale > 1.0:
        return f"{thing} drawn {scale:g} times larger"
    return f"{thing} drawn at " + ("half size" if scale == 0.5 else f"1/{significant(1.0 / scale)} of its size")


def pace(duration: float, times: Floats) -> str:
    """How fast a film of ``duration`` (s) over ``times`` (s) is, in words."""
    ratio = duration / max(float(np.ptp(times)), 1e-12)
    if 0.95 < ratio < 1.05:
        return "real time"
    if ratio > 1.0:
        return f"slow motion, {significant(ratio)} times slower"
    return f"{significant(1.0 / ratio)} times faster than real"
