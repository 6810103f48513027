"""Marks: round spots of known place, on the rotor or on what stands still around it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.units import argument

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
