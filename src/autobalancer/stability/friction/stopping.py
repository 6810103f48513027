"""Where balls with friction stop, from many starts at rest in the rotor at constant speed.

The rotor follows its balls without delay: Z = W^2 (H_u U + H s) at each instant. Each ball moves with its inertia, linear
drag and rolling resistance along its race, and stays where its speed reaches zero and adherence can hold it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.patience import still_time
from autobalancer.stability.host.planar import Complexes, Floats

STEPS = 6000
STEP = 0.15  # of the shortest period of a ball over 2 pi
QUIET = 1e-6  # speed of a ball that creeps to its place, over the same frequency: it has arrived
SLOWEST = 0.02  # least decay rate over that frequency: thinner fluids only take longer


class Races(NamedTuple):
    """Balls in their races at one speed: n balls at P stations."""

    whirl: Complexes  # (P,) of the stations under all that does not move, m
    host: Complexes  # (P, P) whirl per moment, 1/kg
    place: NDArray[np.int64]  # (n,)
    offset: Complexes  # (n,) race centers, m
    moment: Floats  # (n,) kg m
    orbit: Floats  # (n,) m
    adherence: Floats  # (n,)
    rolling: Floats  # (n,)
    push: Floats  # (n,) angular acceleration per distance of the race from the axis, m eps W^2 / I
    decay: Floats  # (n,) drag over inertia, 1/s


def stopped(races: Races, starts: Floats) -> tuple[Complexes, NDArray[np.bool_]]:
    """Whirl of the stations where all balls have stopped, (runs, P) m, and which runs came to rest."""
    angle = np.array(starts, np.float64)
    speed = np.zeros_like(angle)
    moving = np.zeros(angle.shape, np.bool_)
    belongs = np.zeros((races.place.size, races.whirl.size))
    belongs[np.arange(races.place.size), races.place] = 1.0
    farthest = np.abs(races.whirl) + np.abs(races.host) @ (belongs.T @ races.moment)
    frequency = math.sqrt(float((races.push * (farthest[races.place] + np.abs(races.offset))).max()) or 1.0)
    step = STEP / frequency
    decay = 1.0 + step * np.maximum(races.decay, SLOWEST * frequency)
    whirl = np.zeros((angle.shape[0], races.whirl.size), np.complex128)
    for _ in range(STEPS):
        still_time()
        along = np.exp(1j * angle)
        whirl = races.whirl + (races.moment * along) @ belongs @ races.host.T
        seen = (whirl[:, races.place] + races.offset) * along.conj()
        push = races.push * seen.imag
        wall = races.push * np.maximum(races.orbit + seen.real, 0.0)
        loose = np.abs(push) > races.adherence * wall
        free = moving | loose
        way = np.where(moving, np.sign(speed), np.sign(push))
        after = (speed + step * (push - races.rolling * wall * way)) / decay
        moving = free & (after * way > 0.0)
        speed = np.where(moving, after, 0.0)
        if not (loose | (np.abs(speed) > QUIET * frequency)).any():
            break
        angle += step * speed
    return whirl, ~(loose | (np.abs(speed) > QUIET * frequency)).any(axis=1)
