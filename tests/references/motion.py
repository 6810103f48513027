"""Histories of states by name, so that no test needs to know the order of a state."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from autobalancer.catalog.resolve import resolve
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, X
from autobalancer.machine import Machine


class Motion(NamedTuple):
    """What moves, over the times: (times, 2) in m and m/s, (times,) and (times, balls) in rad and rad/s."""

    deflection: np.ndarray
    velocity: np.ndarray
    rotor_angle: np.ndarray
    rotor_speed: np.ndarray
    angles: np.ndarray  # of the balls in the rotor
    speeds: np.ndarray


def motion(machine: Machine, states: np.ndarray) -> Motion:
    """States (times, n) of a machine with guided balls."""
    states, end = np.atleast_2d(states), BALLS + len(resolve(machine))
    return Motion(
        states[:, X : X + 2],
        states[:, VX : VX + 2],
        states[:, THETA],
        states[:, SPEED],
        states[:, BALLS:end],
        states[:, end : 2 * end - BALLS],
    )
