"""What sensors read at each speed, and what they see of a machine in steady motion."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.measurement.balancing.arrays import Complexes, Floats
from autobalancer.rotordynamics.question import rotor_of
from autobalancer.rotordynamics.response import response
from autobalancer.rotordynamics.rubber import rubber_of


@dataclass(frozen=True)
class Orders:
    """Complex amplitudes (S, C) with their lead over the mark, standard deviations along and across them, and channels.

    Times are nan where orders are over the speed. ``shared`` is the part of the deviations that is one and the same error of all
    speeds of a channel, (C,): that of the run-out that was subtracted. ``course`` has times and speeds of the whole run-up or
    run-down, along which a linear rotor is followed; ``passed`` is what the window or filter of the tracking makes of a response
    there, (S, time).
    """

    times: Floats
    speeds: Floats
    readings: Complexes
    deviations: Floats
    across: Floats
    places: tuple[Any, ...]
    directions: tuple[Any, ...]
    quantities: tuple[str, ...]
    shared: Floats
    course: tuple[Floats, Floats] | None = None
    passed: Floats | None = None

    def at(self, rows: NDArray[Any]) -> Orders:
        """Some of the speeds."""
        names = ["times", "speeds", "readings", "deviations", "across", *["passed"] * (self.passed is not None)]
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


def follows_speed(machine: Machine, known: Orders) -> bool:
    """Whether the response is followed along the measured speed; that of softening rubber is the steady one."""
    return known.course is not None and rubber_of(*rotor_of(machine, balls=False)) is None


def seen_by_channels(machine: Machine, known: Orders, unbalance: Any, owner: str, **options: Any) -> Complexes:
    """Complex amplitudes (S, C) of the response to an unbalance, followed along the course of the speed where that is known.

    Raises
    ------
    QuestionError
        If a channel has no place, and the machine has several.
    """
    places: list[Any] = list(dict.fromkeys(known.places))
    if "" in places and (len(places) > 1 or len(machine.stations) > 1):
        raise QuestionError(
            f"{owner}: channel {known.places.index('') + 1} has no place; name the station at which it was measured"
        )
    speeds, back = np.unique(known.speeds, return_inverse=True)
    passed = None
    if known.course is not None and follows_speed(machine, known):  # a resonance is late when the speed changes
        options["time"], speeds = known.course
        passed = known.passed
    found = np.empty((known.speeds.size, len(known.places)), complex)
    stations = None if places == [""] else places
    for quantity in dict.fromkeys(known.quantities):
        kind_of_all: Any = quantity
        seen: xr.Dataset = response(machine, speeds, stations, unbalance, quantity=kind_of_all, **options)
        both = [(seen[f"{k}_real"] + 1j * seen[f"{k}_imag"]).values for k in "xy"]
        x, y = (one[back] if passed is None else passed @ one for one in both)
        for c, (place, way, kind) in enumerate(zip(known.places, known.directions, known.quantities, strict=True)):
            if kind == quantity:
                s = places.index(place)
                found[:, c] = x[:, s] * np.cos(way) + y[:, s] * np.sin(way)
    return found
