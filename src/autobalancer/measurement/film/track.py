"""Balls of a film followed, their angles in the rotor with standard deviations."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.measurement.film.balls import (
    FIRST,
    BallsInPicture,
    Pictures,
    Reader,
    RotorPlace,
    mirror_warning,
    read_all,
)
from autobalancer.measurement.film.optics import in_space, sampled
from autobalancer.measurement.film.photograph import Film, Gray, film_facts
from autobalancer.measurement.film.setup import FilmSetup, labeled
from autobalancer.progress import Progress, shows_progress, silent
from autobalancer.results.answers.answer import Answer, Labeled, provenance
from autobalancer.results.time_series import hanging
from autobalancer.units import argument, optional_argument

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
) -> Answer:
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
    Answer
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
    # each picture alone: marks of the rotor, and balls between the walls of the race
    tracked = read_all(pictures, setup, known, about, progress if callable(progress) else silent)
    count = len(tracked.seen)
    if when.size < count and time is not None:
        raise QuestionError(f"time: given {when.size} times; the film has {count} pictures or more")
    when = when[:count] if when.size >= count else np.arange(count) / float(frame_rate or 1.0)
    faults = _judged(tracked, setup, when)
    # the rotor over time; a camera that turns with it sees it at rest
    turns = unwrapped_rotor(when, tracked.rotor, speed) if setup.camera == "rest" or known else np.full(count, np.nan)
    rotor = [
        place._replace(angle=float(a)) if np.isfinite(a) else place
        for place, a in zip(tracked.rotor, turns, strict=True)
    ]
    if setup.camera == "turning":
        rotor = [place._replace(angle=0.0, center=0j, deviation=0.0) for place in rotor]
    # finds become paths of balls; where a path is lost, a fault says when
    followed = follow(when, rotor, tracked.seen, _deviations(tracked, rotor, setup), setup, slip)
    # name pictures in which balls were seen that are no ball which was followed; refuse too many
    lost = np.isnan(followed.angle).sum(axis=1)
    for k, fault in enumerate(faults):
        if not fault and lost[k]:
            faults[k] = (
                f"{lost[k]} of {followed.angle.shape[1]} balls are too far from where they were expected; "
                "is the frame rate right, or first_ball_speed needed?"
            )
    _refuse_faults(faults, when)
    # speeds are taken between impacts, across which they jump
    hits = impacts(when, followed.angle, followed.deviation, setup.contact_angle, setup.orbit_radius)
    breaks = [hits.time[(hits.ball == i) | (hits.partner == i)] for i in range(1, setup.balls + 1)]
    rate, unsure = speeds(when, followed.angle, followed.deviation, breaks)
    rotor_speed = _rotor_speed(when, turns)
    events = stalls(when, rotor_speed, rate, critical) if critical is not None else []
    return ball_film(when, turns, rotor_speed, rotor, followed, (rate, unsure), hits, events, faults, tracked, setup)


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


def _judged(pictures: Pictures, setup: FilmSetup, when: Floats) -> list[str]:
    """Faults of all pictures, balls that are missing among them."""
    usual = np.median([h for seen in pictures.seen for h in seen.height] or [0.0])
    faults = list(pictures.faults)
    for k, seen in enumerate(pictures.seen):
        good = seen.height > 0.35 * usual
        if not good.all():
            pictures.seen[k] = type(seen)(seen.place[good], seen.deviation[good], seen.height[good])
        if not faults[k] and good.sum() < setup.balls:
            faults[k] = f"{int(good.sum())} of {setup.balls} balls seen"
    _refuse_faults(faults, when)
    return faults


def _refuse_faults(faults: list[str], when: Floats) -> None:
    bad = [k for k, fault in enumerate(faults) if fault]
    if len(bad) > MOST_FAULTS * len(faults):
        k = bad[0]
        raise QuestionError(
            f"film: {len(bad)} of {len(faults)} pictures are of no use, first picture {k + 1} at {when[k]:.6g} s: {faults[k]}"
        )


def _deviations(pictures: Pictures, rotor: Sequence[RotorPlace], setup: FilmSetup) -> list[Floats]:
    """Of the angles of the finds: their edges, the rotor and the camera."""
    grid = 2.0 * np.pi * np.arange(72) / 72
    of_camera = pictures.calibration.angle_deviation(setup.orbit_radius * np.exp(1j * grid), setup.ball_height, 0j)
    answer = []
    for seen, place in zip(pictures.seen, rotor, strict=True):
        at = np.angle(seen.place - place.center)
        camera = np.interp(at, grid, of_camera, period=2.0 * np.pi)
        turn = place.deviation if np.isfinite(place.deviation) else 0.0
        answer.append(np.sqrt((seen.deviation / setup.orbit_radius) ** 2 + turn**2 + camera**2))
    return answer


def _rotor_speed(time: Floats, angle: Floats) -> Floats:
    known = np.flatnonzero(np.isfinite(angle))
    if known.size < 2:
        return np.full(time.size, np.nan)
    return np.asarray(np.interp(time, time[known], np.gradient(angle[known], time[known])))


# What was found in a film as one dataset, under the names of runs.


UNSURE = 9.0  # least margin of an identity, in squares of deviations


def ball_film(
    time: Floats,
    rotor_angle: Floats,
    speed: Floats,
    rotor: list[RotorPlace],
    followed: Followed,
    rates: tuple[Floats, Floats],
    hits: Contacts,
    events: list[tuple[float, str]],
    faults: list[str],
    found: Pictures,
    setup: FilmSetup,
) -> Answer:
    """The dataset of :func:`~autobalancer.measurement.film.track.track_balls`."""
    # what was followed, frame by frame, then impacts and events
    both = ("time", "ball")
    center = np.array([place.center for place in rotor])
    moved = bool(setup.rotor_marks) and len(setup.rotor_marks) > 1 and setup.camera == "rest"
    seen = np.isfinite(followed.angle)
    data = xr.Dataset(
        {
            "ball_angle": (both, followed.angle),
            "ball_angle_deviation": (both, followed.deviation),
            "ball_speed": (both, rates[0]),
            "ball_speed_deviation": (both, rates[1]),
            "seen": (both, seen),
            "identity_margin": ("time", followed.margin),
            "fault": ("time", np.array(faults, dtype=object).astype(str)),
            "rotor_angle": ("time", rotor_angle),
            "speed": ("time", speed),
            "impact_speed": ("impact", hits.speed),
            "impact_ball": ("impact", hits.ball),
            "impact_partner": ("impact", hits.partner),
            "event_name": ("event", np.array([name for _, name in events], dtype=object).astype(str)),
        },
        {
            "time": time,
            "ball": np.arange(1, setup.balls + 1),
            "impact_time": ("impact", hits.time),
            "event_time": ("event", np.array([at for at, _ in events], np.float64)),
            "orbit_radius": ("ball", np.full(setup.balls, setup.orbit_radius)),
            "ball_diameter": ("ball", np.full(setup.balls, setup.ball_diameter)),
        },
    )
    if moved:
        angle = np.array([place.angle for place in rotor])
        known = np.where(np.isfinite(angle), center, np.nan)
        data["x"], data["y"] = ("time", known.real), ("time", known.imag)
    labeled(data)
    # how far the result can be trusted
    margin = followed.margin[np.isfinite(followed.margin)]
    data.attrs.update(
        title="balls in a film",
        camera=setup.camera,
        mark_residual=found.calibration.residual,
        focal_length=found.calibration.view.focal_length,
        distortion=list(found.calibration.view.distortion),
        noise=found.noise,
        warnings=mirror_warning(followed.deviation, setup),
        unsure_identities=int((margin < UNSURE).sum()),
        **provenance(),
    )
    return Answer.of(data, "BallFilm")


# What happens to the balls of a film: impacts, release and capture, under the names that runs use.


SURE = 4.0  # standard deviations


class Contacts(NamedTuple):
    """Impacts between balls in the order of time."""

    time: Floats  # s
    speed: Floats  # m/s, at which they approached
    ball: NDArray[np.int64]  # from 1
    partner: NDArray[np.int64]


def impacts(time: Floats, angle: Floats, deviation: Floats, contact: float, orbit: float) -> Contacts:
    """Where neighbors that approach each other are found farther apart than this would lead them.

    From the last two pictures before, the gap is followed to the contact angle; an impact is where it gets there before the next
    picture, and the gap of this picture is wider than it would be without.
    """
    n = angle.shape[1]
    rows: list[tuple[float, float, int, int]] = []
    for i in range(n if n > 2 else n - 1):
        j = (i + 1) % n
        both = np.flatnonzero(np.isfinite(angle[:, i]) & np.isfinite(angle[:, j]))
        t = time[both]
        gap = (angle[both, j] - angle[both, i]) % (2.0 * np.pi)
        if n == 2:
            gap = np.minimum(gap, 2.0 * np.pi - gap)
        spread = np.hypot(deviation[both, i], deviation[both, j])
        before = -2  # number of the picture before the last impact: the slope over an impact is none
        for k in range(1, both.size - 1):
            step, after = t[k] - t[k - 1], t[k + 1] - t[k]
            slope = (gap[k] - gap[k - 1]) / step
            unsure = np.hypot(spread[k], spread[k - 1]) / step
            if k == before + 1 or slope > -max(SURE * unsure, 1e-6):
                continue
            until = (contact - gap[k]) / slope
            ahead = gap[k] + slope * after
            if -step < until <= after and gap[k + 1] - ahead > SURE * np.hypot(spread[k + 1], unsure * after):
                rows.append((t[k] + max(until, 0.0), -slope * orbit, i + 1, j + 1))
                before = k
    rows.sort()
    columns = list(zip(*rows, strict=True)) or [(), (), (), ()]
    return Contacts(*(np.array(column, kind) for column, kind in zip(columns, "ddqq", strict=True)))


def stalls(time: Floats, speed: Floats, rate: Floats, critical: float) -> list[tuple[float, str]]:
    """Times at which balls are captured at the critical speed, and released from it.

    A ball is stalled while it hangs by the rule of ``break_away_speed``; it is captured where that begins after it ran with the
    rotor, and released where it runs with the rotor again.
    """
    stalls: list[tuple[float, str]] = []
    for i in range(rate.shape[1]):
        known = np.flatnonzero(np.isfinite(rate[:, i]) & np.isfinite(speed))
        stalled = hanging(rate[known, i], speed[known], np.array([[critical, 0.0]]))
        with_rotor = np.abs(rate[known, i]) < 0.05 * np.abs(speed[known])
        state = ""
        for k, row in enumerate(known):
            if stalled[k]:
                if state == "with":
                    stalls.append((float(time[row]), f"ball {i + 1} captured at the critical speed"))
                state = "stalled"
            elif with_rotor[k]:
                if state == "stalled":
                    stalls.append((float(time[row]), f"ball {i + 1} released"))
                state = "with"
    return sorted(stalls)


# Balls followed from picture to picture: identity, angle in the rotor and speed.


HALF = 3  # pictures before and after one whose motion gives its speed


class Followed(NamedTuple):
    """Of all balls in all pictures; (pictures, balls)."""

    angle: Floats  # rad, in the rotor, not wrapped; nan if not seen
    deviation: Floats
    margin: Floats  # (pictures,): what the second best match would cost more


def unwrapped_rotor(time: Floats, rotor: list[RotorPlace], first_speed: float) -> Floats:
    """Rotor angle with its turns counted: at each picture the turn nearest to where the last speed leads; nan where unknown."""
    unwrapped_rotor = np.array([place.angle for place in rotor])
    speed, last = first_speed, -1
    for k in np.flatnonzero(np.isfinite(unwrapped_rotor)):
        if last >= 0:
            step = time[k] - time[last]
            expected = unwrapped_rotor[last] + speed * step
            unwrapped_rotor[k] = expected + float(wrapped(np.array(unwrapped_rotor[k] - expected)))
            speed = (unwrapped_rotor[k] - unwrapped_rotor[last]) / step
        last = int(k)
    return np.asarray(unwrapped_rotor)


def angles_in_rotor(seen: BallsInPicture, place: RotorPlace, setup: FilmSetup) -> tuple[Floats, NDArray[np.intp]]:
    """Angles of the finds of one picture in the rotor, increasing, and their order."""
    turned = (seen.place - place.center) * np.exp(-1j * place.angle) - complex(*setup.race_center)
    angle = np.angle(turned)
    order = np.argsort(angle, kind="stable")
    return np.asarray(angle[order]), order


def follow(
    time: Floats,
    rotor: list[RotorPlace],
    seen: list[BallsInPicture],
    deviation: list[Floats],
    setup: FilmSetup,
    first_rate: float,
) -> Followed:
    """Give each find to its ball.

    Parameters
    ----------
    time
        Of the pictures, s.
    rotor, seen, deviation
        What was found in each; deviations of the angles, rad.
    setup
        The film.
    first_rate
        About how fast the balls move in the rotor at first, rad/s.
    """
    n, pictures = setup.balls, len(seen)
    angle, spread = np.full((pictures, n), np.nan), np.full((pictures, n), np.nan)
    margin = np.full(pictures, np.nan)
    now, rate, when = np.zeros(n), np.full(n, first_rate), np.full(n, -np.inf)
    contact = setup.contact_angle
    started = False
    for k in range(pictures):
        if seen[k].place.size == 0 or np.isnan(rotor[k].angle):
            continue
        at, order = angles_in_rotor(seen[k], rotor[k], setup)
        if not started or n == at.size == 1:  # one ball can be no other, wherever it went
            if at.size < n:
                continue
            find = np.arange(n)
            margin[k] = np.inf
            base = now + rate * (time[k] - when) if started else np.zeros(n)
            started = True
        else:
            away = time[k] - when
            base = _apart(now + rate * away, contact)
            gone = float(away.max() / max(away.min(), 1e-12))
            guess = (0.3 * contact + 0.25 * np.abs(rate * away).max()) * min(gone, 10.0) ** 0.5
            match = matched(base, at, min(guess, 0.5))
            find, margin[k] = match.find, match.margin
        for i in np.flatnonzero(find >= 0):
            here = at[find[i]]
            value = here if when[i] == -np.inf else base[i] + float(wrapped(np.array(here - base[i])))
            if when[i] > -np.inf:
                rate[i] = (value - now[i]) / (time[k] - when[i])
            now[i], when[i] = value, time[k]
            angle[k, i], spread[k, i] = value, deviation[k][order[find[i]]]
    return Followed(angle, spread, margin)


def _apart(expected: Floats, contact: float) -> Floats:
    """Expected angles in order, none nearer to its neighbor than balls that touch."""
    if expected.size < 2:
        return expected
    out = expected.copy()
    for _ in range(4):
        following = np.append(out[1:], out[0] + 2.0 * np.pi * np.ceil((out[-1] - out[0]) / (2.0 * np.pi)))
        lack = np.maximum(contact - (following - out), 0.0)
        out -= 0.5 * lack
        out += 0.5 * np.roll(lack, 1)
    return out


def speeds(time: Floats, angle: Floats, deviation: Floats, breaks: list[Floats]) -> tuple[Floats, Floats]:
    """Speed of each ball and its deviation: slopes of parabolas through neighboring pictures.

    None reaches across an impact; ``breaks`` has their times for each ball.
    """
    rate, spread = np.full(angle.shape, np.nan), np.full(angle.shape, np.nan)
    for i in range(angle.shape[1]):
        rows = np.flatnonzero(np.isfinite(angle[:, i]))
        part = np.searchsorted(np.sort(breaks[i]), time[rows])
        for j, k in enumerate(rows):
            near = np.arange(max(0, j - HALF), min(rows.size, j + HALF + 1))
            near = near[part[near] == part[j]]
            if near.size < 2:
                continue
            t, weight = time[rows[near]] - time[k], 1.0 / deviation[rows[near], i]
            size = max(float(np.abs(t).max()), 1e-12)
            power = (t[:, None] / size) ** np.arange(min(3, near.size))
            solution = np.linalg.pinv(power * weight[:, None])
            rate[k, i] = solution[1] @ (weight * (angle[rows[near], i] - angle[k, i])) / size
            spread[k, i] = np.linalg.norm(solution[1]) / size
    return rate, spread


# Which ball is which: balls in one race cannot pass each other, so their order around it stays.
#
# The balls that are seen are matched with where they are expected, in the same order around the race; of all such
# matches the one with the least sum of squares is taken, by dynamic programming. How much worse the second best would
# be says how sure it is.


MISSING = 16.0  # what a ball that is seen, but not matched, costs, in the units of squares of deviations


class Match(NamedTuple):
    """Number of the find of each ball, -1 if it is not seen, and what the second best match would cost more."""

    find: NDArray[np.intp]
    margin: float


def wrapped(angle: Floats) -> Floats:
    """Within -pi to pi."""
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)


def matched(expected: Floats, seen: Floats, spread: float) -> Match:
    """Finds for balls.

    Parameters
    ----------
    expected
        Angles of the balls in the order around the race, increasing by less than a turn in all, rad.
    seen
        Angles of the finds in increasing order, rad.
    spread
        Standard deviation of what is expected, rad.
    """
    n, m = expected.size, seen.size
    if m == 0:
        return Match(np.full(n, -1, np.intp), 0.0)
    cost = np.minimum((wrapped(seen[None, :] - expected[:, None]) / spread) ** 2, 1e6)
    options: dict[tuple[int, ...], float] = {}
    for first in range(m):  # the find with which the count begins
        order = (first + np.arange(m)) % m
        total, find = _aligned(cost[:, order])
        chosen = np.where(find >= 0, order[np.maximum(find, 0)], -1)
        key = tuple(chosen.tolist())
        options[key] = min(options.get(key, np.inf), total)
    ranked = sorted(options.items(), key=lambda item: item[1])
    best = np.array(ranked[0][0], np.intp)
    other = next((value for key, value in ranked[1:] if _differs(key, ranked[0][0])), np.inf)
    return Match(best, float(min(other - ranked[0][1], 1e6)))


def _differs(values: tuple[int, ...], other: tuple[int, ...]) -> bool:
    """Whether a ball has another find, not just none."""
    return any(a != b and a >= 0 and b >= 0 for a, b in zip(values, other, strict=True))


def _aligned(cost: Floats) -> tuple[float, NDArray[np.intp]]:
    """Cheapest match in order, (balls, finds); finds and balls may be left out."""
    n, m = cost.shape
    best = np.full((n + 1, m + 1), np.inf)
    best[0, :] = MISSING * np.arange(m + 1)
    best[:, 0] = MISSING * np.arange(n + 1)
    for i in range(1, n + 1):
        for j in range(1, m + 1):
            best[i, j] = min(
                best[i - 1, j - 1] + cost[i - 1, j - 1], best[i - 1, j] + MISSING, best[i, j - 1] + MISSING
            )
    find, i, j = np.full(n, -1, np.intp), n, m
    while i and j:
        if best[i, j] == best[i - 1, j - 1] + cost[i - 1, j - 1]:
            i, j = i - 1, j - 1
            find[i] = j
        elif best[i, j] == best[i - 1, j] + MISSING:
            i -= 1
        else:
            j -= 1
    return float(best[n, m]), find


# One picture of a film seen from straight above, with the balls that were found.


SIZE = 600  # pixels of the rectified picture


def rectified_picture(film: Film, setup: FilmSetup, number: int) -> Labeled:
    """A picture in the plane of the ball centers, to see whether marks, race and balls are where they should be.

    Parameters
    ----------
    film
        With its pictures.
    setup
        Race, marks and camera.
    number
        Of the picture, from 1.

    Returns
    -------
    Labeled
        Dataset over ``y`` and ``x`` (m): ``brightness`` (of 255); over ``ball`` the places ``ball_x``, ``ball_y`` found in it.

    Raises
    ------
    QuestionError
        If there is no such picture, or the film cannot be evaluated.
    """
    first: list[Gray] = []
    picture = None
    for k, one in enumerate(film, 1):
        if len(first) < FIRST:
            first.append(one)
        if k == number:
            picture = one
        if k >= number and len(first) == FIRST:
            break
    if picture is None:
        raise QuestionError(f"picture: given {number}; the film has fewer, counted from 1")
    reader = Reader(first, setup)
    _, seen, fault = reader.read(picture, setup.balls, None)
    reach = 1.15 * max([setup.orbit_radius + setup.ball_diameter, *(abs(mark.z) for mark in setup.marks)])
    side = np.linspace(-reach, reach, SIZE)
    pixels = reader.calibration.view.pixels(in_space(side[None, :] + 1j * side[:, None], setup.ball_height))
    data = xr.Dataset(
        {
            "brightness": (("y", "x"), sampled(picture, pixels), {"long_name": "brightness", "units": ""}),
            "ball_x": ("ball", seen.place.real, {"long_name": "place of a ball along x", "units": "m"}),
            "ball_y": ("ball", seen.place.imag, {"long_name": "place of a ball along y", "units": "m"}),
        },
        {"x": ("x", side, {"units": "m"}), "y": ("y", side, {"units": "m"})},
        {
            "title": f"picture {number} rectified" + (f": {fault}" if fault else ""),
            "orbit_radius": setup.orbit_radius,
            "ball_diameter": setup.ball_diameter,
            **provenance(),
        },
    )
    return Labeled.of(data)
