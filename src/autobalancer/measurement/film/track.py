"""Balls of a film followed, their angles in the rotor with standard deviations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.answer import ball_film
from autobalancer.measurement.film.follow import Followed, follow, speeds, unwrapped_rotor
from autobalancer.measurement.film.happenings import impacts, stalls
from autobalancer.measurement.film.pictures import Pictures, read_all
from autobalancer.measurement.film.rotor import RotorPlace
from autobalancer.measurement.film.setup import FilmSetup
from autobalancer.measurement.film.video import Film, film_facts
from autobalancer.patience import Progress, shows_progress, silent
from autobalancer.results.answers.ball_film import BallFilm
from autobalancer.units import argument, optional_argument

Floats = NDArray[np.float64]
MOST_FAULTS = 0.5  # share of the pictures that may be of no use


@shows_progress
def track_balls(
    film: Film | str | Path | ArrayLike,
    setup: FilmSetup,
    *,
    frame_rate: float | str | None = None,
    time: ArrayLike | None = None,
    rotor_angle: ArrayLike | None = None,
    first_speed: float | str = 0.0,
    first_ball_speed: float | str = 0.0,
    critical_speed: float | str | None = None,
    progress: Progress | Literal[False] | None = None,
) -> BallFilm:
    """Follow the balls of a race through a film.

    Parameters
    ----------
    film
        Path of a film, pictures (frames, rows, columns) of 8 bits, or a :class:`~autobalancer.measure.Film`.
    setup
        Race, marks and camera.
    frame_rate
        Pictures a second, a number or a text such as "240 Hz", if the film does not say it rightly (slow motion); of an array it
        is needed unless ``time`` is given.
    time
        Of each picture, s; of a stroboscope that follows the rotor the times of its flashes.
    rotor_angle
        Of each picture, rad, from a tacho; by default read from the marks on the rotor. A camera that turns with the rotor
        needs it only for speeds in space.
    first_speed
        Rotor speed at the first picture, rad/s or a text: needed where the rotor turns by more than half between pictures.
    first_ball_speed
        About how fast the balls move in the rotor at first, rad/s or a text: needed where a ball moves by half the distance
        to the next one between pictures.
    critical_speed
        rad/s or a text, for events of release and capture.
    progress
        Called with (pictures, about how many there are). ``None`` shows a bar where a person is looking, ``False`` none.

    Returns
    -------
    BallFilm
        Dataset over ``time`` and ``ball``: ``ball_angle`` (rad), ``ball_angle_deviation`` (one standard deviation),
        ``ball_speed``, ``ball_speed_deviation``, ``seen``; over ``time`` ``rotor_angle``, ``speed``, ``x``, ``y`` (where
        marks on the rotor show the deflection), ``fault`` (why a picture is of no use) and ``identity_margin``; impacts and
        events as in runs.

    Raises
    ------
    QuestionError
        If the setup does not fit the film, more than half of the pictures are of no use, or the balls cannot be
        followed; with the first such picture.
    ResultError
        If the film cannot be read.
    """
    frame_rate = optional_argument("frame_rate", frame_rate, "Hz")
    pictures, when, about = _opened(film, frame_rate, time)
    known = _known(setup, rotor_angle, when)
    speed, slip = argument("first_speed", first_speed, "rad/s"), argument("first_ball_speed", first_ball_speed, "rad/s")
    critical = optional_argument("critical_speed", critical_speed, "rad/s")
    found = read_all(pictures, setup, known, about, progress if callable(progress) else silent)
    count = len(found.seen)
    if when.size < count and time is not None:
        raise QuestionError(f"time: given {when.size} times; the film has {count} pictures or more")
    when = when[:count] if when.size >= count else np.arange(count) / float(frame_rate or 1.0)
    faults = _judged(found, setup, when)
    turns = unwrapped_rotor(when, found.rotor, speed) if setup.camera == "rest" or known else np.full(count, np.nan)
    rotor = [
        place._replace(angle=float(a)) if np.isfinite(a) else place for place, a in zip(found.rotor, turns, strict=True)
    ]
    if setup.camera == "turning":
        rotor = [place._replace(angle=0.0, center=0j, deviation=0.0) for place in rotor]
    followed = follow(when, rotor, found.seen, _deviations(found, rotor, setup), setup, slip)
    _judge_lost(faults, followed, when)
    hits = impacts(when, followed.angle, followed.deviation, setup.contact_angle, setup.orbit)
    breaks = [hits.time[(hits.ball == i) | (hits.partner == i)] for i in range(1, setup.balls + 1)]
    rate, unsure = speeds(when, followed.angle, followed.deviation, breaks)
    rotor_speed = _rotor_speed(when, turns)
    events = stalls(when, rotor_speed, rate, critical) if critical is not None else []
    return ball_film(when, turns, rotor_speed, rotor, followed, (rate, unsure), hits, events, faults, found, setup)


def _opened(
    film: Film | str | Path | ArrayLike, frame_rate: float | None, time: ArrayLike | None
) -> tuple[Film, Floats, int]:
    """The film, when its pictures were taken, and about how many there are."""
    given = None if time is None else np.asarray(time, np.float64)
    if frame_rate is not None and not (np.isfinite(frame_rate) and frame_rate > 0.0):
        raise QuestionError(f"frame_rate: given {frame_rate}; must be above zero pictures a second")
    if given is not None and (given.ndim != 1 or not np.isfinite(given).all() or np.any(np.diff(given) <= 0.0)):
        raise QuestionError("time: must be finite and increase from picture to picture")
    if isinstance(film, Film):
        return film, film.time if given is None else given, film.time.size
    if isinstance(film, str | Path):
        rate, about, _ = film_facts(film)
        rate = rate if frame_rate is None else frame_rate
        when = np.arange(about + 1000) / rate if given is None else given
        return Film(Path(film), when, np.empty(0)), when, about
    pictures = np.asarray(film)
    if pictures.ndim != 3 or pictures.dtype != np.uint8:
        raise QuestionError(
            f"film: an array {pictures.shape} of {pictures.dtype}; must be (frames, rows, columns) of uint8, in shades of gray"
        )
    if given is None and frame_rate is None:
        raise QuestionError("film: an array has no times; give frame_rate or time")
    when = np.arange(len(pictures)) / float(frame_rate or 1.0) if given is None else given
    return Film(pictures, when, np.empty(0)), when, len(pictures)


def _known(setup: FilmSetup, rotor_angle: ArrayLike | None, when: Floats) -> list[RotorPlace] | None:
    """The rotor where a tacho says it is."""
    if rotor_angle is None:
        if setup.camera == "rest" and not setup.rotor_marks:
            raise QuestionError(
                "film: no marks on the rotor and no rotor_angle; a camera at rest needs one of them to know where a ball is in "
                "the rotor"
            )
        return None
    angle = np.asarray(rotor_angle, np.float64)
    if angle.ndim != 1 or not np.isfinite(angle).all() or angle.size > when.size:
        raise QuestionError(
            f"rotor_angle: given {angle.shape}; one finite angle for each of the {when.size} pictures is needed"
        )
    return [RotorPlace(float(a), 0j, 0.0) for a in angle]


def _judged(found: Pictures, setup: FilmSetup, when: Floats) -> list[str]:
    """Faults of all pictures, balls that are missing among them."""
    usual = np.median([h for seen in found.seen for h in seen.height] or [0.0])
    faults = list(found.faults)
    for k, seen in enumerate(found.seen):
        good = seen.height > 0.35 * usual
        if not good.all():
            found.seen[k] = type(seen)(seen.place[good], seen.deviation[good], seen.height[good])
        if not faults[k] and good.sum() < setup.balls:
            faults[k] = f"{int(good.sum())} of {setup.balls} balls seen"
    _refuse_many(faults, when)
    return faults


def _judge_lost(faults: list[str], followed: Followed, when: Floats) -> None:
    """Name pictures in which balls were seen that are no ball which was followed; refuse too many."""
    lost = np.isnan(followed.angle).sum(axis=1)
    for k, fault in enumerate(faults):
        if not fault and lost[k]:
            faults[k] = (
                f"{lost[k]} of {followed.angle.shape[1]} balls are too far from where they were expected; "
                "is the frame rate right, or first_ball_speed needed?"
            )
    _refuse_many(faults, when)


def _refuse_many(faults: list[str], when: Floats) -> None:
    bad = [k for k, fault in enumerate(faults) if fault]
    if len(bad) > MOST_FAULTS * len(faults):
        k = bad[0]
        raise QuestionError(
            f"film: {len(bad)} of {len(faults)} pictures are of no use, first picture {k + 1} at {when[k]:.6g} s: {faults[k]}"
        )


def _deviations(found: Pictures, rotor: Sequence[RotorPlace], setup: FilmSetup) -> list[Floats]:
    """Of the angles of the finds: their edges, the rotor and the camera."""
    grid = 2.0 * np.pi * np.arange(72) / 72
    of_camera = found.calibration.angle_deviation(setup.orbit * np.exp(1j * grid), setup.height, 0j)
    answer = []
    for seen, place in zip(found.seen, rotor, strict=True):
        at = np.angle(seen.place - place.center)
        camera = np.interp(at, grid, of_camera, period=2.0 * np.pi)
        turn = place.deviation if np.isfinite(place.deviation) else 0.0
        answer.append(np.sqrt((seen.deviation / setup.orbit) ** 2 + turn**2 + camera**2))
    return answer


def _rotor_speed(time: Floats, angle: Floats) -> Floats:
    known = np.flatnonzero(np.isfinite(angle))
    if known.size < 2:
        return np.full(time.size, np.nan)
    return np.asarray(np.interp(time, time[known], np.gradient(angle[known], time[known])))
