"""What has to be known of a film: race, balls, marks and camera."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.results.labels import LABELS, Label
from autobalancer.units import argument, field_arguments

# Marks: round spots of known place, on the rotor or on what stands still around it.


FAR = 1000.0  # m: no mark of a rotor is so far away


@dataclass(frozen=True)
class Mark:
    """A round mark.

    Parameters
    ----------
    place
        Its true place x, y, m or texts: on the rotor in the frame of the rotor, with the zero mark on the x axis.
    radius
        m or a text.
    pixel
        About where it is in the picture (column, row), or exactly; not needed of marks that move through the picture.

    Raises
    ------
    QuestionError
        If a number is not finite or the radius not above zero.
    """

    place: tuple[float | str, float | str]
    radius: float | str
    pixel: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        x, y = (argument("place of a mark", one, "m") for one in self.place)
        radius = argument("radius of a mark", self.radius, "m")
        known = [x, y, radius, *(self.pixel or ())]
        if not (all(map(math.isfinite, known)) and 0.0 < radius < FAR and math.hypot(x, y) < FAR):
            raise QuestionError(
                f"mark: given place {self.place}, radius {self.radius}, pixel {self.pixel}; finite numbers, radius > 0, "
                f"all within {FAR:g} m"
            )
        object.__setattr__(self, "place", (x, y))
        object.__setattr__(self, "radius", radius)

    @property
    def z(self) -> complex:
        """The place as x + i y, m."""
        return complex(float(self.place[0]), float(self.place[1]))


def places_of(marks: Sequence[Mark]) -> NDArray[np.complex128]:
    """Places of marks as x + i y, m."""
    return np.array([mark.z for mark in marks], np.complex128)


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


# Long names and units of what films and photographs give; the rest has those of runs.


OWN = {
    "ball_angle": Label("ball angle in the rotor, measured", "rad", "rotor"),
    "ball_speed": Label("ball speed in the rotor, measured", "rad/s", "rotor"),
    "ball_angle_deviation": Label("standard deviation of the ball angle in the rotor", "rad", "rotor"),
    "ball_speed_deviation": Label("standard deviation of the ball speed in the rotor", "rad/s", "rotor"),
    "seen": Label("whether the ball was seen in the picture", ""),
    "identity_margin": Label("what the second best match of balls would cost more, in squares of deviations", ""),
    "fault": Label("why the picture is of no use; empty if it is", ""),
}


def labeled(found: xr.Dataset) -> xr.Dataset:
    """The same data with long names, units and frames."""
    for name, variable in found.variables.items():
        entry = OWN.get(str(name)) or LABELS[str(name)]
        variable.attrs.update(long_name=entry.long_name, units=entry.units)
        if entry.frame:
            variable.attrs["frame"] = entry.frame
    return found
