"""What is in each picture of a film: the rotor, the balls, or why they cannot be seen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.balls import Background, BallSearch, Circle, Seen, circle, peaks, steps_around
from autobalancer.measurement.film.calibration import Calibration, camera_of, noise_of
from autobalancer.measurement.film.optics import View, in_space, located, mark_outlines, sampled
from autobalancer.measurement.film.setup import FilmSetup, Mark, places_of
from autobalancer.progress import Progress

Floats = NDArray[np.float64]
Gray = NDArray[np.uint8]
FIRST = 12  # pictures from which the camera, the noise and the look of the balls are learned
DARK, WHITE = 0.25, 254  # share of the usual brightness; brightness that is saturated
SATURATED = 0.25  # share of the pixels of the race that may be saturated
NOBODY = Seen(np.empty(0, np.complex128), np.empty(0), np.empty(0))


class Pictures(NamedTuple):
    """What was found in all pictures."""

    calibration: Calibration
    rotor: list[RotorPlace]
    seen: list[Seen]
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

    def read(self, picture: Gray, count: int, known: RotorPlace | None) -> tuple[RotorPlace, Seen, str]:
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


POINTS = 40
LEAST = 0.5  # share of the edges of a mark that must agree


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
            outline = mark_outlines(self.view, where, 0.0, self.radius, POINTS)
            edge = located(picture, outline, rises=False, noise=noise, usable=np.ones(outline.edge.shape[:2], np.bool_))
            good = edge.share >= LEAST
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
