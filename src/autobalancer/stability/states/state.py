"""One state of rest in the rotor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.host.stations import Stations


@dataclass(frozen=True)
class StationState:
    """One state of rest in the rotor; ``freedom`` is the dimension of the continuum to which it belongs."""

    name: str  # balanced, mixed, coincident, in line
    angles: Floats  # (n,) ball angles in the rotor, rad
    whirl: Complexes  # (P,) deflections of the stations in the rotor, m
    freedom: int
    outward: int  # balls that stand outward in races that do not run true


def state_vector(st: Stations, speed: float, angles: Floats) -> Floats:
    """The state of the vector field with the balls at rest at these angles: Q, V, ball angles and ball speeds."""
    whirl = st.coordinates(speed, angles)
    rate = 1j * speed * whirl
    return np.concatenate([whirl.real, whirl.imag, rate.real, rate.imag, angles, np.zeros(angles.size)])
