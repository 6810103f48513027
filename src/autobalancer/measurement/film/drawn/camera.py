"""What films a simulated race: where the camera stands, and how it takes pictures."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.optics.view import View, looking
from autobalancer.units import argument, field_arguments


@dataclass(frozen=True)
class Camera:
    """A camera above a rotor; the z axis points towards it, so that the rotor turns counterclockwise.

    Parameters
    ----------
    position, look_at
        Points of space, m: x, y in the plane of the marks and z above it.
    focal_length
        In pixels: width of the picture over twice the tangent of half the angle of view.
    width, height
        Of the picture, pixels.
    roll
        Rotation of the picture about the axis of the lens, rad or a text.
    distortion
        One or two radial terms.
    turning
        Whether the camera is fixed to the rotor and turns with it.

    Raises
    ------
    QuestionError
        If such a camera sees nothing.
    """

    position: tuple[float, float, float]
    focal_length: float
    look_at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    width: int = 1280
    height: int = 720
    roll: float | str = 0.0
    distortion: tuple[float, ...] = ()
    turning: bool = False

    def __post_init__(self) -> None:
        field_arguments(self, roll="rad")
        if not (np.isfinite([*self.position, *self.look_at]).all() and self.position[2] > self.look_at[2]):
            raise QuestionError(f"camera: at {self.position} m; z must be above the point at which it looks")
        if not (math.isfinite(self.focal_length) and self.focal_length > 0.0):
            raise QuestionError(f"focal_length: given {self.focal_length}; must be greater than zero pixels")
        if not (64 <= self.width <= 7680 and 64 <= self.height <= 4320):
            raise QuestionError(f"width, height: given {self.width} x {self.height}; 64 x 64 to 7680 x 4320 pixels")
        if self.width % 2 or self.height % 2:
            raise QuestionError(f"width, height: given {self.width} x {self.height}; films have even numbers of pixels")
        if len(self.distortion) > 2:
            raise QuestionError(f"distortion: given {len(self.distortion)} terms; one or two radial terms are possible")

    @classmethod
    def above(
        cls,
        radius: float | str,
        *,
        tilt: float | str = 0.0,
        distance: float | str = 0.0,
        width: int = 1280,
        height: int = 720,
        distortion: tuple[float, ...] = (),
        turning: bool = False,
    ) -> Camera:
        """A camera that sees a circle about the axis in full, from the side of -y by ``tilt`` from the axis.

        Parameters
        ----------
        radius
            Of the circle, m or a text.
        tilt
            Angle between the lens and the axis of the rotor, rad or a text.
        distance
            From the middle of the circle; by default eight times the radius.
        width, height, distortion, turning
            As of the camera.

        Raises
        ------
        QuestionError
            If the tilt is 80 degrees or more.
        """
        reach, angle = argument("radius", radius, "m"), argument("tilt", tilt, "rad")
        away = argument("distance", distance, "m") or 8.0 * reach
        if not (0.0 <= angle < math.radians(80.0) and 0.0 < reach < away):
            raise QuestionError(
                f"camera: tilt {math.degrees(angle):g} degrees, {away:g} m from a circle of radius {reach:g} m; the tilt must be "
                "from 0 to below 80 degrees, and the camera outside of the circle"
            )
        near = away - reach * math.sin(angle)
        focal_length = 0.49 * min(width, height) * near / reach
        place = (0.0, -away * math.sin(angle), away * math.cos(angle))
        return cls(place, focal_length, width=width, height=height, distortion=distortion, turning=turning)

    def view(self) -> View:
        """Its projection."""
        k1, k2 = (*self.distortion, 0.0, 0.0)[:2]
        return View(
            looking(self.position, self.look_at, float(self.roll)),
            np.array(self.position, np.float64),
            float(self.focal_length),
            (0.5 * (self.width - 1), 0.5 * (self.height - 1)),
            (float(k1), float(k2)),
        )


@dataclass(frozen=True)
class Exposure:
    """When and how pictures are taken.

    Parameters
    ----------
    frame_rate
        Pictures a second, in Hz or a text such as ``"240 Hz"`` (turns play no part here: 240 Hz are 240 pictures a second).
    time
        How long the shutter is open, or a flash lasts, s or a text.
    stroboscope
        "" for a shutter; "turn" for one flash and one picture each time the zero mark passes the x axis (every second, third ...
        turn where the camera is slower than the rotor); a number for flashes of a lamp with this rate, in Hz: then the shutter is
        open all the time, and a picture has all flashes that fall into it.
    brightness
        Gain of the camera: 1 shows white as nearly full.
    gradient
        Change of the light from the middle to the right and to the lower edge, as a share.
    noise
        Standard deviation of a pixel, share of full scale.
    lost
        Share of the pictures that are lost, at random; they are black in the film.

    Raises
    ------
    QuestionError
        If one of them is not possible.
    """

    frame_rate: float = 240.0
    time: float | str = 2e-4
    stroboscope: str | float = ""
    brightness: float = 1.0
    gradient: tuple[float, float] = (0.0, 0.0)
    noise: float = 0.01
    lost: float = 0.0

    def __post_init__(self) -> None:
        field_arguments(self, time="s")
        if not (math.isfinite(self.frame_rate) and 0.0 < self.frame_rate <= 1e6):
            raise QuestionError(f"frame_rate: given {self.frame_rate}; must be above 0 and up to 1e6 pictures a second")
        if not 0.0 <= float(self.time) * self.frame_rate <= 1.0 + 1e-9:
            raise QuestionError(
                f"exposure time: given {self.time:g} s at {self.frame_rate:g} pictures a second; a picture has "
                f"{1.0 / self.frame_rate:g} s at most"
            )
        lamp = isinstance(self.stroboscope, int | float) and 0.0 < self.stroboscope <= 1e5
        if not lamp and self.stroboscope not in ("", "turn"):
            raise QuestionError(
                f"stroboscope: given {self.stroboscope!r}; must be 'turn', a rate up to 1e5 Hz, or '' for a shutter"
            )
        if not (0.0 <= self.noise <= 1.0 and 0.0 <= self.lost < 1.0 and self.brightness > 0.0):
            raise QuestionError(
                f"noise {self.noise:g}, lost {self.lost:g}, brightness {self.brightness:g}: noise is from 0 to 1, lost from 0 to "
                "below 1, brightness above 0"
            )
