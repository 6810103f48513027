"""One state of rest in the rotor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.stability.host.planar import Complexes, Floats
from autobalancer.stability.host.stations import Stations

ORDER = ("balanced", "mixed", "spread", "coincident", "in line")  # of names
TRUE = 1e-9  # deflection, over that of the balls alone, at which a race runs true
ALIGNED = 1e-6  # part across a ball of the deflection of its race


@dataclass(frozen=True)
class StationState:
    """One state of rest in the rotor; ``freedom`` is the dimension of the continuum to which it belongs."""

    name: str  # balanced, mixed, coincident, in line; with forces on the balls spread, too
    angles: Floats  # (n,) ball angles in the rotor, rad
    whirl: Complexes  # (P,) deflections of the stations in the rotor, m
    freedom: int
    outward: int  # balls that stand outward in races that do not run true

    @property
    def rank(self) -> tuple[int, float]:
        """By which states are listed: name, then the greatest deflection."""
        return ORDER.index(self.name), float(np.abs(self.whirl).max(initial=0.0))


def state_vector(st: Stations, speed: float, angles: Floats) -> Floats:
    """The state of the vector field with the balls at rest at these angles: Q, V, ball angles and ball speeds."""
    whirl = st.coordinates(speed, angles)
    rate = 1j * speed * whirl
    return np.concatenate([whirl.real, whirl.imag, rate.real, rate.imag, angles, np.zeros(angles.size)])


def named_at_rest(st: Stations, speed: float, angles: Floats, freedom: int) -> StationState:
    """The state of balls with forces at these angles, named by what they do.

    *Coincident* or *in line* where all stand along the deflection of their race, *balanced* where they make the greatest
    deflection smaller than without them, *spread* otherwise.
    """
    flat = st.plain_at(speed)
    answer = flat.rows @ st.compliance(speed) * speed**2
    whirl = st.rows @ st.coordinates(speed, angles)
    center, alone = whirl[st.station] + st.offset, (answer @ flat.fixed_load)[st.station] + st.offset
    size, along = np.abs(center), np.exp(-1j * angles) * center
    true = size < TRUE * np.abs(answer @ flat.rows.T).max() * st.moment.max()
    out = ~true & (along.real > 0.0)
    if not true.any() and (np.abs(along.imag) < ALIGNED * size.max()).all():
        sides = [out[st.station == place] for place in range(len(st.names))]
        name = "coincident" if all(side.all() or not side.any() for side in sides) else "in line"
    else:
        name = "balanced" if true.all() or size.max() < np.abs(alone).max() else "spread"
    return StationState(name, angles, whirl, freedom, int(out.sum()))
