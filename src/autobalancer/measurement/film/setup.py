"""What has to be known of a film: race, balls, marks and camera."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field, PlainValidator

from autobalancer.errors import Problem
from autobalancer.files.machine_file import part_text
from autobalancer.files.text_files import built_of, read_toml
from autobalancer.machine.keys import document
from autobalancer.machine.part import Length, Position, Positive, Quantity, Question, key
from autobalancer.results.labels import LABELS, Label
from autobalancer.safe_file import as_path, write_text_safely
from autobalancer.units import shortened, to_si

# Marks: round spots of known place, on the rotor or on what stands still around it.


FAR = 1000.0  # m: no mark of a rotor is so far away
Pair = tuple[Annotated[float, Quantity("")], Annotated[float, Quantity("")]]


class Mark(Question):
    """A round mark: on the rotor in the frame of the rotor, with the zero mark on the x axis."""

    place: tuple[Position, Position] = key("its true place x, y")
    radius: Length = key("of the spot")
    pixel: Pair | None = key(
        "about where it is in the picture (column, row), or exactly; of marks that move not needed", None
    )

    def contradictions(self) -> Iterator[Problem]:
        """A place that is too far."""
        if not (self.radius < FAR and math.hypot(*self.place) < FAR):
            yield (), f"given place {list(self.place)}, radius {self.radius:g}; must be all within {FAR:g} m"

    @property
    def z(self) -> complex:
        """The place as x + i y, m."""
        return complex(*self.place)


def places_of(marks: Sequence[Mark]) -> NDArray[np.complex128]:
    """Places of marks as x + i y, m."""
    return np.array([mark.z for mark in marks], np.complex128)


def _terms(argument: Any) -> Any:
    """The number of terms of the distortion, or the terms."""
    if isinstance(argument, int) and not isinstance(argument, bool) and 0 <= argument <= 2:
        return argument
    if not isinstance(argument, (list, tuple)):
        raise ValueError(f"given {shortened(argument)}; must be the number of terms, 0, 1 or 2, or a list of the terms")
    return tuple(float(to_si(one, "")) for one in argument)


class FilmSetup(Question):
    """What has to be known to read ball angles from pictures.

    ``marks`` do not move in the picture, and each has its pixel: of a camera at rest they are on what stands still, of a camera
    that turns with the rotor (and of a single photograph) on the rotor.
    """

    orbit_radius: Length = key("of the balls")
    ball_diameter: Length = key("of a ball")
    balls: Annotated[int, Field(strict=True, ge=1)] = key("how many are in the race")
    marks: tuple[Mark, ...] = key("four or more that do not move in the picture")
    rotor_marks: tuple[Mark, ...] = key(
        "on the rotor, without pixels: its angle and deflection are read from them if the camera is at rest", ()
    )
    ball_height: Position = key(
        "of the centers of the balls above the plane of the marks; of balls that lie on it their radius", 0.0
    )
    camera: Literal["rest", "turning"] = key("at rest, or turning with the rotor", "rest")
    focal_length: Positive | None = key("pixels; fitted to the marks unless given", None)
    distortion: Annotated[int | tuple[float, ...], PlainValidator(_terms, json_schema_input_type=int | list[float])] = (
        key(
            "number of radial terms fitted to the marks, or the known terms. Five marks determine one; with four the deviations "
            "contain what a usual lens may do. 0 for a lens that draws straight lines",
            1,
            value="0, 1 or 2, or list of numbers",
        )
    )
    race_center: tuple[Position, Position] = key("of an eccentric race in the rotor, x and y", (0.0, 0.0))
    marks_exact: bool = key("the pixels of the marks are taken as they are; else marks are looked for there", False)
    pixel_deviation: Positive = key("standard deviation of points that a person gave, pixels", 1.0)

    def contradictions(self) -> Iterator[Problem]:
        """Balls that have no room, and marks that do not say where the picture is, or where the rotor."""
        if not 0.5 * self.ball_diameter < self.orbit_radius:
            sizes = f"given {self.ball_diameter:g} m on an orbit of {self.orbit_radius:g} m"
            yield ("ball_diameter",), f"{sizes}; a ball must be smaller than its orbit"
        else:
            most = int(math.pi / math.asin(0.5 * self.ball_diameter / self.orbit_radius) + 1e-9)
            if self.balls > most:
                yield ("balls",), f"given {self.balls}; 1 to {most} have room in this race"
        if len(self.marks) < 4:
            text = f"given {len(self.marks)}; four or more marks of known place are needed to rectify a picture"
            yield ("marks",), text
        for number, mark in enumerate(self.marks):
            if mark.pixel is None:
                yield ("marks", number, "pixel"), "missing; say about where the mark is in the picture"
        yield from self._alike()

    @property
    def contact_angle(self) -> float:
        """Angle between two balls that touch, rad."""
        return 2.0 * math.asin(0.5 * self.ball_diameter / self.orbit_radius)

    def _alike(self) -> Iterator[Problem]:
        """Marks on the rotor must look different after any part of a turn."""
        z = [mark.z for mark in self.rotor_marks]
        for other in z[1:]:
            if not z[0] or abs(abs(other) - abs(z[0])) > 1e-6:
                continue
            turn = other / z[0]
            if all(min(abs(one * turn - place) for place in z) < self.rotor_marks[0].radius for one in z):
                degrees = math.degrees(math.atan2(turn.imag, turn.real)) % 360.0
                yield ("rotor_marks",), f"they look the same after {degrees:.3g} degrees; move one of them"
                return


document(FilmSetup)


# Set-ups as TOML files.


def load_film_setup(path: str | Path) -> FilmSetup:
    """Read a set-up from a TOML file.

    Parameters
    ----------
    path
        With the keys of :class:`FilmSetup`; ``[[marks]]`` and ``[[rotor_marks]]`` have ``place``,
        ``radius`` and ``pixel``.

    Raises
    ------
    QuestionError
        If the file, a key or a value is wrong; the message names it.
    """
    path = as_path(path)
    return built_of(lambda data: FilmSetup(**data), read_toml(path), str(path))


def save_film_setup(setup: FilmSetup, path: str | Path) -> Path:
    """Write a set-up as a TOML file that :func:`load_film_setup` reads.

    Parameters
    ----------
    setup
        To be written.
    path
        Of the file.

    Raises
    ------
    ResultError
        If the file cannot be written.
    """
    return write_text_safely(path, part_text(setup))


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


def labeled(dataset: xr.Dataset) -> xr.Dataset:
    """The same data with long names, units and frames."""
    for name, variable in dataset.variables.items():
        entry = OWN.get(str(name)) or LABELS[str(name)]
        variable.attrs.update(long_name=entry.long_name, units=entry.units)
        if entry.frame:
            variable.attrs["frame"] = entry.frame
    return dataset
