"""Where the balls are in one picture."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.measurement.film.optics import (
    ANYWHERE,
    Calibration,
    Outline,
    View,
    ball_outlines,
    camera_of,
    in_space,
    located,
    mark_outlines,
    noise_of,
    sampled,
)
from autobalancer.measurement.film.setup import FilmSetup, Mark, places_of
from autobalancer.progress import Progress

Gray = NDArray[np.uint8]
POINTS = 56
LEAST = 0.3  # share of the edge of a ball that must be seen
SIDE = 0.5  # of the edge only what faces along the race within 60 degrees counts: beside it are the walls
MIRRORS = 0.05  # share of finds that fit no ball, from which on it is said
CLOSER = 0.6  # of the contact angle: two finds so near each other are one ball


class BallsInPicture(NamedTuple):
    """Balls of one picture, in the order of their angles."""

    place: Complexes  # m, of the centers in space
    deviation: Floats  # m, along the race
    height: Floats  # of the peaks of the search, of 255


class BallSearch:
    """Looks for balls of equal look in a race."""

    def __init__(self, view: View, setup: FilmSetup, background: Background) -> None:
        self.view, self.setup = view, setup
        pixel = view.focal_length / float(np.linalg.norm(view.position))
        self.steps = steps_around(setup.orbit_radius * pixel)
        around = setup.orbit_radius * np.exp(2j * np.pi * np.arange(self.steps) / self.steps)
        self.circle = circle(ball_outlines(view, around, setup.ball_height, 0.5 * setup.ball_diameter, 24))
        self.background = background
        self.dark = False  # balls darker than the race

    def candidates(self, picture: Gray, most: int, center: complex) -> tuple[Floats, Floats]:
        """Angles in space about the middle of the race, and heights, of the highest peaks."""
        there, here = self.view.pixels(in_space(np.array([center, 0j]), self.setup.ball_height))
        score = self.circle.scores(picture, there - here)
        return peaks(-score if self.dark else score, 0.75 * self.setup.contact_angle, most)

    def found(self, picture: Gray, angles: Floats, heights: Floats, center: complex, noise: float) -> BallsInPicture:
        """The balls near these angles, by their edges; an edge behind or beside a ball that touches does not count."""
        place = center + self.setup.orbit_radius * np.exp(1j * angles)
        radius, height = 0.5 * self.setup.ball_diameter, self.setup.ball_height

        def behind(pixels: Floats) -> Floats:
            return self.background.at(pixels, center)

        covariance, share = np.zeros((len(place), 2, 2)), np.zeros(len(place))
        for turn in range(3):
            outline = ball_outlines(self.view, place, height, radius, POINTS)
            usable = _free(outline.edge, self.view.pixels(in_space(place, height)))
            slope = self._slope(place, center)
            usable &= (
                np.abs(np.einsum("tpi,ti->tp", outline.outwards, slope)) > SIDE * np.linalg.norm(slope, axis=1)[:, None]
            )
            edge = located(picture, outline, rises=True, noise=noise, usable=usable, behind=behind)
            pixels = self.view.pixels(in_space(place, height)) + edge.shift
            moved = self.view.places(pixels, height)
            place = moved[:, 0] + 1j * moved[:, 1]
            covariance, share = edge.covariance, edge.share
            if turn == 0:  # from the search they are off by up to some pixels along the race, never across
                place = center + self.setup.orbit_radius * np.exp(1j * np.angle(place - center))
        slope = self._slope(place, center)
        size = (slope**2).sum(axis=1)
        deviation = np.sqrt(np.einsum("ti,tij,tj->t", slope, covariance, slope)) / size
        off = np.abs(np.abs(place - center) - self.setup.orbit_radius)
        kept = np.flatnonzero((share >= LEAST) & (off < 0.4 * self.setup.ball_diameter))
        kept = kept[np.argsort(np.angle(place[kept] - center), kind="stable")]
        kept = _apart(kept, place, heights, center, CLOSER * self.setup.contact_angle)
        return BallsInPicture(place[kept], deviation[kept], heights[kept])

    def _slope(self, place: Complexes, center: complex) -> Floats:
        """Pixels for each meter along the race."""
        away, height = place - center, self.setup.ball_height
        ahead = place + 1e-5 * 1j * away / np.abs(away)
        return np.asarray(
            (self.view.pixels(in_space(ahead, height)) - self.view.pixels(in_space(place, height))) / 1e-5
        )


def mirror_warning(deviation: Floats, setup: FilmSetup) -> str:
    """What to do where edges fit no ball of the known size; ``deviation`` (rad) is that of all angles."""
    anywhere = 0.99 * ANYWHERE * 0.5 * setup.ball_diameter / setup.orbit_radius
    share = float((deviation[np.isfinite(deviation)] >= anywhere).mean()) if np.isfinite(deviation).any() else 0.0
    if share < MIRRORS:
        return ""
    return (
        f"in {100.0 * share:.0f} % of the finds the edges do not fit a ball of diameter {setup.ball_diameter:g} m, so its angle "
        "is known to a part of its radius only; polished balls mirror the room: make them dull or light them from all sides, and "
        "check ball_diameter and ball_height"
    )


def _free(edge: Floats, centers: Floats) -> NDArray[np.bool_]:
    """Points of outlines that are nearer to the middle of their own ball than to that of any other, by some pixels."""
    if len(centers) < 2:
        return np.ones(edge.shape[:2], np.bool_)
    far = np.linalg.norm(edge[:, :, None, :] - centers, axis=-1)
    own = np.take_along_axis(far, np.arange(len(centers))[:, None, None], axis=2)[..., 0]
    others = np.where(np.eye(len(centers), dtype=np.bool_)[:, None, :], np.inf, far).min(axis=-1)
    return np.asarray(others > own + np.minimum(3.0, 0.3 * own))


def _apart(
    kept: NDArray[np.intp], place: Complexes, heights: Floats, center: complex, least: float
) -> NDArray[np.intp]:
    """Of finds at one place the one with the higher peak."""
    chosen: list[int] = []
    for one in kept[np.argsort(-heights[kept], kind="stable")]:
        if all(abs(np.angle((place[one] - center) / (place[other] - center))) >= least for other in chosen):
            chosen.append(int(one))
    return np.array([one for one in kept if one in chosen], np.intp)


# How the race looks without balls: the same all around the axis but for the light, which changes slowly around it.


ANGLES = 180
REACH = 3.0  # ball radii inside and outside of the orbit
WAVES = 2  # of the light around the axis


class Background:
    """Brightness of the race over the radius, the median around the axis, times the light over the angle."""

    def __init__(self, view: View, setup: FilmSetup, pictures: Sequence[Gray], centers: Sequence[complex]) -> None:
        self.view = view
        pixel = float(np.linalg.norm(view.position)) / view.focal_length
        half = 0.5 * REACH * setup.ball_diameter
        count = int(np.clip(2.0 * half / (0.4 * pixel), 8, 400))
        self.radius = np.linspace(
            max(setup.orbit_radius - half, 0.02 * setup.orbit_radius), setup.orbit_radius + half, count
        )
        angle = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
        circles = self.radius[:, None] * np.exp(1j * angle)
        seen = np.array(
            [
                sampled(picture, view.pixels(in_space(at + circles, 0.0)))
                for picture, at in zip(pictures, centers, strict=True)
            ]
        )
        level = np.median(seen, axis=(0, 2))
        waves = _waves(angle)
        share = np.median(seen, axis=0) / np.maximum(level, 1.0)[:, None]
        self.light = np.linalg.lstsq(waves, np.median(share, axis=0), rcond=None)[0]
        light = waves @ self.light
        self.level = np.median(seen / np.maximum(light, 0.1), axis=(0, 2))

    def at(self, pixels: Floats, center: complex) -> Floats:
        """Brightness of pixels (..., 2), of 255, if no ball were there."""
        place = self.view.places(pixels)
        z = place[..., 0] + 1j * place[..., 1] - center
        return np.asarray(np.interp(np.abs(z), self.radius, self.level) * (_waves(np.angle(z)) @ self.light))


def _waves(angle: Floats) -> Floats:
    rows = [np.ones_like(angle)]
    for k in range(1, WAVES + 1):
        rows += [np.cos(k * angle), np.sin(k * angle)]
    return np.stack(rows, axis=-1)


# Round things on a circle, looked for all around it: where a ring of their size separates light from dark.


AWAY = 1.6  # pixels inside and outside of the edge


class Circle(NamedTuple):
    """Rings all around a circle, at equal steps from angle zero."""

    inner: NDArray[np.float64]
    outer: NDArray[np.float64]

    def scores(self, picture: Gray, shift: Floats | float = 0.0) -> Floats:
        """Mean step from outside to inside of each ring, all shifted by some pixels, of 255, less that without things."""
        step = sampled(picture, self.inner + shift) - sampled(picture, self.outer + shift)
        score = step.mean(axis=-1).astype(np.float64)
        return np.asarray(score - np.median(score))


def circle(outline: Outline, away: float = AWAY) -> Circle:
    """Rings from the outlines of a thing at all places of a circle, so many pixels inside and outside."""
    return Circle(outline.beside(-away), outline.beside(away))


def steps_around(radius_in_pixels: float) -> int:
    """Number of places on a circle, a little more than a pixel apart."""
    return int(np.clip(2.0 * np.pi * radius_in_pixels / 1.2, 240, 2400))


def peaks(score: Floats, apart: float, most: int) -> tuple[Floats, Floats]:
    """Angles (rad) and heights of the highest peaks at least ``apart`` (rad) from each other, the highest first."""
    count = score.size
    top = (score >= np.roll(score, 1)) & (score > np.roll(score, -1))
    places = np.flatnonzero(top)
    places = places[np.argsort(-score[places], kind="stable")]
    kept: list[int] = []
    step = 2.0 * np.pi / count
    for place in places:
        gaps = [abs((place - other + count // 2) % count - count // 2) * step for other in kept]
        if all(gap >= apart for gap in gaps):
            kept.append(int(place))
        if len(kept) == most:
            break
    at = np.array(kept, np.intp)
    before, here, after = score[at - 1], score[at], score[(at + 1) % count]
    bend = np.minimum(before - 2.0 * here + after, -1e-12)
    return np.asarray((at + np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) * step), np.asarray(here)


# What is in each picture of a film: the rotor, the balls, or why they cannot be seen.


FIRST = 12  # pictures from which the camera, the noise and the look of the balls are learned
DARK, WHITE = 0.25, 254  # share of the usual brightness; brightness that is saturated
SATURATED = 0.25  # share of the pixels of the race that may be saturated
NOBODY = BallsInPicture(np.empty(0, np.complex128), np.empty(0), np.empty(0))


class Pictures(NamedTuple):
    """What was found in all pictures."""

    calibration: Calibration
    rotor: list[RotorPlace]
    seen: list[BallsInPicture]
    faults: list[str]  # of each picture, empty if there is none
    noise: float  # of a pixel, of 255


class Reader:
    """Reads one picture after the other."""

    def __init__(self, first: list[Gray], setup: FilmSetup) -> None:
        bright = [float(picture[::8, ::8].mean()) for picture in first]
        self.usual = float(np.median(bright))
        if self.usual < 4.0:
            raise QuestionError(
                f"film: pictures 1 to {len(first)} are dark (mean brightness {self.usual:.2g} of 255); use more light, or begin "
                "the film later"
            )
        clear = [picture for picture, mean in zip(first, bright, strict=True) if mean > DARK * self.usual]
        still = np.mean(np.array(clear, np.float32), axis=0) if len(clear) > 1 else clear[0]
        if float((still[::8, ::8] >= WHITE).mean()) > SATURATED:
            raise QuestionError(f"film: pictures 1 to {len(first)} are saturated; use less light or a shorter exposure")
        self.setup, self.before = setup, first[0][:0]
        self.calibration = camera_of(np.round(still).astype(np.uint8), setup)
        self.noise = float(np.median([noise_of(picture) for picture in clear[:4]]))
        self.rotor = RotorMarks(self.calibration.view, tuple(setup.rotor_marks)) if setup.rotor_marks else None
        self.search = BallSearch(self.calibration.view, setup, self._background(clear))
        self._learn(clear)

    def _background(self, clear: list[Gray]) -> Background:
        """The race without balls, from pictures in which the rotor is found."""
        if self.rotor is None:
            return Background(self.calibration.view, self.setup, clear, [0j] * len(clear))
        places = [self.rotor.found(picture, self.noise) for picture in clear]
        known = [k for k, place in enumerate(places) if np.isfinite(place.angle)]
        if not known:
            raise QuestionError(
                f"film: the marks on the rotor are not found in pictures 1 to {len(clear)}; check their places and radius, and "
                "whether the exposure is short enough"
            )
        middle = [places[k].center + complex(*self.setup.race_center) * np.exp(1j * places[k].angle) for k in known]
        return Background(self.calibration.view, self.setup, [clear[k] for k in known], middle)

    def _learn(self, clear: list[Gray]) -> None:
        """Whether balls are lighter or darker than the race, and whether there are as many as was said."""
        scores = [self.search.circle.scores(picture) for picture in clear]
        light, dark = (
            float(np.median([np.sort(sign * score)[-self.search.steps // 100 :].mean() for score in scores]))
            for sign in (1.0, -1.0)
        )
        self.search.dark = dark > light
        if max(light, dark) < max(3.0, self.noise):
            raise QuestionError(
                f"film: no balls in pictures 1 to {len(clear)}: nothing round on the orbit of {self.setup.orbit_radius:g} m "
                "differs from the race; check orbit radius, ball diameter, height and marks"
            )

    def read(self, picture: Gray, count: int, known: RotorPlace | None) -> tuple[RotorPlace, BallsInPicture, str]:
        """Rotor and up to ``count`` balls of a picture, and what is wrong with it."""
        fault = self._fault(picture)
        self.before = picture
        if fault:
            return known or UNKNOWN, NOBODY, fault
        place = known
        if place is None and self.rotor is not None:
            place = self.rotor.found(picture, self.noise)
            if np.isnan(place.angle):
                return place, NOBODY, "marks on the rotor not found"
        place = place or RotorPlace(0.0, 0j, 0.0)
        middle = place.center + complex(*self.setup.race_center) * np.exp(1j * place.angle)
        angles, heights = self.search.candidates(picture, count, middle)
        return place, self.search.found(picture, angles, heights, middle, self.noise), ""

    def _fault(self, picture: Gray) -> str:
        if picture.shape == self.before.shape and np.array_equal(picture, self.before):
            return "the same picture as before"
        if float(picture[::8, ::8].mean()) < DARK * self.usual:
            return "dark"
        race = self.search.circle.inner[:, 0]
        column, row = np.clip(np.nan_to_num(race).astype(int).T, 0, np.array(picture.shape[::-1])[:, None] - 1)
        return "saturated" if float((picture[row, column] >= WHITE).mean()) > SATURATED else ""


def read_all(
    pictures: Iterable[Gray], setup: FilmSetup, known: list[RotorPlace] | None, about: int, progress: Progress
) -> Pictures:
    """Find rotor and balls in all pictures, of which there are about so many.

    Raises
    ------
    QuestionError
        If the film is empty, dark or saturated from the start, or its marks or balls are not found.
    """
    source = iter(pictures)
    first: list[Gray] = []
    for picture in source:
        first.append(picture)
        if len(first) == FIRST:
            break
    if not first:
        raise QuestionError("film: no pictures")
    reader = Reader(first, setup)
    _count(reader, first, known)
    rotor, seen, faults = [], [], []
    number = 0
    for group in (first, source):
        for picture in group:
            if picture.shape != first[0].shape:
                raise QuestionError(f"film: picture {number + 1} has another size than the first")
            where, balls, fault = reader.read(picture, setup.balls, known[number] if known else None)
            rotor.append(where)
            seen.append(balls)
            faults.append(fault)
            number += 1
            progress(min(number, about), about)
            if known and number == len(known):
                return Pictures(reader.calibration, rotor, seen, faults, reader.noise)
    return Pictures(reader.calibration, rotor, seen, faults, reader.noise)


def _count(reader: Reader, first: list[Gray], known: list[RotorPlace] | None) -> None:
    """Refuse a number of balls that the first pictures contradict."""
    balls = reader.setup.balls
    counts = []
    for number in range(0, len(first), 2):
        place = known[number] if known and number < len(known) else None
        _, seen, fault = reader.read(first[number], balls + 3, place)
        if not fault and seen.height.size:
            counts.append(int((seen.height > 0.4 * np.sort(seen.height)[-balls:].mean()).sum()))
    reader.before = first[0][:0]
    if not counts:
        return
    usual = int(np.median(counts))
    if usual > balls:
        raise QuestionError(f"film: given {balls} balls; {usual} are seen in most of the pictures 1 to {len(first)}")
    if usual < balls and max(counts) < balls:
        raise QuestionError(
            f"film: given {balls} balls; {usual} are seen in most of the pictures 1 to {len(first)}, at most {max(counts)}"
        )


# The angle of the rotor and where its axis is, in each picture, from the marks that turn with it.


POINTS_OF_MARK = 40
LEAST_OF_MARK = 0.5  # share of the edges of a mark that must agree


class RotorPlace(NamedTuple):
    """Where the rotor is in one picture."""

    angle: float  # rad, in space; nan if unknown
    center: complex  # m
    deviation: float  # rad, of the angle


UNKNOWN = RotorPlace(np.nan, 0j, np.nan)


class RotorMarks:
    """Looks for marks of known place on the rotor."""

    def __init__(self, view: View, marks: tuple[Mark, ...]) -> None:
        self.view, self.marks = view, marks
        self.places = places_of(marks)
        self.radius = float(marks[0].radius)
        radii, which = np.unique(np.round(np.abs(self.places), 9), return_inverse=True)
        pixel = float(np.linalg.norm(view.position)) / view.focal_length
        self.steps = steps_around(float(radii.max()) / pixel)
        around = np.exp(2j * np.pi * np.arange(self.steps) / self.steps)
        away = max(1.6, 0.5 * self.radius / pixel)  # the axis may be off by as much
        self.circles: list[Circle] = [
            circle(mark_outlines(view, r * around, 0.0, self.radius, 24), away) for r in radii
        ]
        self.which = np.atleast_1d(which)

    def coarse(self, picture: Gray) -> float:
        """The angle at which all marks together are most marked; nan if no angle is by far the best."""
        scores = [circle.scores(picture) for circle in self.circles]
        total = np.zeros(self.steps)
        for place, which in zip(self.places, self.which, strict=True):
            turn = np.angle(place) / (2.0 * np.pi) * self.steps
            total += np.interp(
                np.arange(self.steps) + turn, np.arange(2 * self.steps), np.tile(scores[which], 2), period=self.steps
            )
        size = abs(total)
        apart = 4.0 * self.radius / float(np.abs(self.places).max())
        at, heights = peaks(size, apart, 2)
        if at.size == 0 or heights[0] < 4.0 * len(self.marks) or (at.size > 1 and heights[1] > 0.8 * heights[0]):
            return np.nan
        return float(at[0])

    def found(self, picture: Gray, noise: float) -> RotorPlace:
        """Angle and axis by the edges of the marks."""
        angle, center = self.coarse(picture), 0j
        if np.isnan(angle):
            return UNKNOWN
        deviation = np.nan
        angle, center = self._rough(picture, angle)
        for _ in range(3):
            where = center + self.places * np.exp(1j * angle)
            outline = mark_outlines(self.view, where, 0.0, self.radius, POINTS_OF_MARK)
            edge = located(picture, outline, rises=False, noise=noise, usable=np.ones(outline.edge.shape[:2], np.bool_))
            good = edge.share >= LEAST_OF_MARK
            if not good.any() or (len(self.marks) > 1 and good.sum() < 2):
                return UNKNOWN
            moved = self.view.places(self.view.pixels(in_space(where, 0.0)) + edge.shift)
            z = (moved[:, 0] + 1j * moved[:, 1])[good]
            pixel = float(np.linalg.norm(self.view.position)) / self.view.focal_length
            spread = np.sqrt(np.trace(edge.covariance, axis1=1, axis2=2)[good] / 2.0) * pixel
            angle, center, deviation = _fitted(self.places[good], z, spread, angle, center)
        return RotorPlace(angle, center, deviation)

    def _rough(self, picture: Gray, angle: float) -> tuple[float, complex]:
        """Angle and axis by the middles of light or dark: the axis may be off by half the size of a mark and more."""
        center = 0j
        for _ in range(2):
            z = center + self.places * np.exp(1j * angle)
            grid = self.view.places(self._middles(picture, self.view.pixels(in_space(z, 0.0))))
            result = grid[:, 0] + 1j * grid[:, 1]
            angle, center, _ = _fitted(self.places, result, np.ones(result.size), angle, center)
        return angle, center

    def _middles(self, picture: Gray, pixels: Floats) -> Floats:
        """Middles of what differs from its surroundings in windows about pixels."""
        reach = 1.9 * self.radius * self.view.focal_length / float(np.linalg.norm(self.view.position)) + 2.0
        step = np.linspace(-reach, reach, 25)
        away = np.stack(np.meshgrid(step, step), axis=-1).reshape(-1, 2)
        seen = sampled(picture, pixels[:, None, :] + away).astype(np.float64)
        seen = np.abs(seen - np.median(seen, axis=1, keepdims=True))
        weight = np.maximum(seen - 0.5 * seen.max(axis=1, keepdims=True), 0.0) + 1e-9
        return np.asarray(pixels + np.einsum("mk,ki->mi", weight, away) / weight.sum(axis=1, keepdims=True))


def _fitted(
    marks: NDArray[np.complex128], z: NDArray[np.complex128], spread: Floats, angle: float, center: complex
) -> tuple[float, complex, float]:
    """Rotation and shift that take marks to where they were found; of one mark the rotation alone."""
    weight = 1.0 / spread**2
    if marks.size == 1:
        return (
            angle + float(np.angle((z[0] - center) / (marks[0] * np.exp(1j * angle)))),
            center,
            float(spread[0] / abs(marks[0])),
        )
    middle_marks, middle_z = (weight * marks).sum() / weight.sum(), (weight * z).sum() / weight.sum()
    turn = (weight * (z - middle_z) * np.conj(marks - middle_marks)).sum()
    turned = angle + float(np.angle(turn / abs(turn) * np.exp(-1j * angle)))
    lever = (weight * abs(marks - middle_marks) ** 2).sum()
    return turned, complex(middle_z - middle_marks * np.exp(1j * turned)), float(1.0 / np.sqrt(lever))
