"""What has to be known of a film: race, balls, marks and camera."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.marks import Mark
from autobalancer.units import field_arguments


@dataclass(frozen=True)
class FilmSetup:
    """What has to be known to read ball angles from pictures.

    Parameters
    ----------
    orbit_radius, ball_diameter
        m or texts.
    balls
        How many balls are in the race.
    marks
        Four or more that do not move in the picture, each with its pixel: of a camera at rest on what stands still, of a camera
        that turns with the rotor (and of a single photograph) on the rotor.
    rotor_marks
        Marks on the rotor, from which the rotor angle and the deflection are read if the camera is at rest; without pixels.
    ball_height
        Of the centers of the balls above the plane of the marks, m or a text. A ball that lies on this plane: its radius.
    camera
        "rest", or "turning" with the rotor.
    focal_length
        Pixels; by default fitted to the marks.
    distortion
        Number of radial terms fitted to the marks (0, 1 or 2), or the known terms. One by default: five marks determine it, and
        with four the deviations contain what a usual lens may do; 0 for a lens that draws straight lines.
    race_center
        Of an eccentric race in the rotor, x and y, m.
    marks_exact
        Whether the pixels of the marks are taken as they are, with ``pixel_deviation``; by default marks are looked for there.
    pixel_deviation
        Standard deviation of points that a person gave, pixels.

    Raises
    ------
    QuestionError
        If one of them is not possible.
    """

    orbit_radius: float | str
    ball_diameter: float | str
    balls: int
    marks: Sequence[Mark]
    rotor_marks: Sequence[Mark] = ()
    ball_height: float | str = 0.0
    camera: Literal["rest", "turning"] = "rest"
    focal_length: float | None = None
    distortion: int | Sequence[float] = 1
    race_center: tuple[float, float] = (0.0, 0.0)
    marks_exact: bool = False
    pixel_deviation: float = 1.0

    def __post_init__(self) -> None:
        field_arguments(self, orbit_radius="m", ball_diameter="m", ball_height="m")
        if not 0.0 < 0.5 * self.diameter < self.orbit:
            raise QuestionError(
                f"film: orbit radius {self.orbit:g} m, ball diameter {self.diameter:g} m; a ball must be smaller than its orbit"
            )
        most = int(math.pi / math.asin(0.5 * self.diameter / self.orbit) + 1e-9)
        if not 1 <= self.balls <= most:
            raise QuestionError(f"film: given {self.balls} balls; 1 to {most} have room in this race")
        if len(self.marks) < 4:
            raise QuestionError(
                f"film: {len(self.marks)} marks; four or more marks of known place are needed to rectify a picture"
            )
        for number, mark in enumerate(self.marks, 1):
            if mark.pixel is None:
                raise QuestionError(f"film: mark {number} has no pixel; say about where it is in the picture")
        if self.camera not in ("rest", "turning"):
            raise QuestionError(f"film: camera {self.camera!r}; must be 'rest' or 'turning'")
        if not (math.isfinite(self.pixel_deviation) and self.pixel_deviation > 0.0):
            raise QuestionError(f"pixel_deviation: given {self.pixel_deviation}; must be above zero")
        self._check_pattern()

    @property
    def orbit(self) -> float:
        """Orbit radius, m."""
        return float(self.orbit_radius)

    @property
    def diameter(self) -> float:
        """Ball diameter, m."""
        return float(self.ball_diameter)

    @property
    def height(self) -> float:
        """Of the ball centers above the marks, m."""
        return float(self.ball_height)

    @property
    def contact_angle(self) -> float:
        """Angle between two balls that touch, rad."""
        return 2.0 * math.asin(0.5 * self.diameter / self.orbit)

    def _check_pattern(self) -> None:
        """Marks on the rotor must look different after any part of a turn."""
        z = [mark.z for mark in self.rotor_marks]
        for other in z[1:]:
            if not z[0] or abs(abs(other) - abs(z[0])) > 1e-6:
                continue
            turn = other / z[0]
            if all(min(abs(one * turn - place) for place in z) < float(self.rotor_marks[0].radius) for one in z):
                degrees = math.degrees(math.atan2(turn.imag, turn.real)) % 360.0
                raise QuestionError(
                    f"film: the marks on the rotor look the same after {degrees:.3g} degrees; move one of them"
                )
