"""What is in each picture of a film: the rotor, the balls, or why they cannot be seen."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.background import Background
from autobalancer.measurement.film.balls import BallSearch, Seen
from autobalancer.measurement.film.optics.calibration import Calibration
from autobalancer.measurement.film.optics.finding import camera_of, noise_of
from autobalancer.measurement.film.rotor import UNKNOWN, RotorMarks, RotorPlace
from autobalancer.measurement.film.setup import FilmSetup
from autobalancer.patience import Progress

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
                f"film: no balls in pictures 1 to {len(clear)}: nothing round on the orbit of {self.setup.orbit:g} m differs "
                "from the race; check orbit radius, ball diameter, height and marks"
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
