"""The rule by which the end of a run is named, in this order:

- *balanced*: the balls rest and every race with balls that are not in one row runs true (center within 1/1000 of the
  deflection scale of the axis of rotation);
- *coincident*, *in line*: the balls rest in a row with the race center, all on one side, or on both sides;
- *held by friction*: the balls rest where no ball without friction would;
- *stalled*: a ball turns in the rotor, on the mean by more than 1/100 of the rotor speed;
- *chaotic*: the balls keep oscillating, and two runs that start close together diverge exponentially;
- *oscillating*: the balls keep oscillating, and such runs do not diverge.

Starts at which balls of a race would overlap are marked as such and do not count in the shares.

Balls rest when all are slower in the rotor than 1e-5 of its speed over several looks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from autobalancer.assembly.system import Assembly
from autobalancer.catalog.resolve import occupied_angle
from autobalancer.kernels.settle import FAILED, RESTING
from autobalancer.kernels.system import BALLS, THETA, VX, VY, Floats, Matrix, X, Y
from autobalancer.machine import Machine
from autobalancer.stability.basins.turn import Turn
from autobalancer.stability.host.planar import Plane

STATES = (
    "balanced",
    "coincident",
    "in line",
    "held by friction",
    "stalled",
    "oscillating",
    "chaotic",
    "failed",
    "overlapping start",
)
AT_REST = STATES[:4]
REST = 1e-5  # ball speed over rotor speed
TRUE = 1e-3  # distance of a race center over the deflection scale
TURNING = 1e-2  # mean ball speed over rotor speed


@dataclass(frozen=True)
class Question:
    """A machine at a speed, ready to be run from many starts."""

    machine: Machine
    assembly: Assembly
    p: Plane
    speed: float
    hold: float
    tolerance: float
    rubs: bool = False  # whether any race has friction


def end_state(question: Question, end: Floats) -> int:
    """Number of the end state of one row of the answer of :func:`autobalancer.kernels.settle.settle`."""
    p, n = question.p, question.p.moment.size
    size = question.assembly.state.size
    if end[size] == FAILED:
        return STATES.index("failed")
    speed, swing = end[size + 2 : size + 2 + n], end[size + 2 + n :]
    if end[size] != RESTING:
        if np.abs(speed).max() > TURNING * question.speed:
            return STATES.index("stalled")
        if swing.max() > math.radians(1.0):
            return STATES.index("chaotic" if _diverges(question, end) else "oscillating")
    z = complex(end[X], end[Y])
    if not question.assembly.system.rotating:
        z *= np.exp(-1j * end[THETA])
    center = z + p.offset
    scale = float(question.assembly.scale[X])
    along = np.exp(-1j * end[BALLS : BALLS + n]) * center
    row = np.abs(along.imag) <= 0.02 * np.abs(along)
    true = np.abs(center) <= TRUE * scale
    if true.any() and (true | row).all():
        return STATES.index("balanced")
    if question.rubs and not (true | row).all():
        return STATES.index("held by friction")
    if len(set(np.sign(along.real[~true]))) <= 1:
        return STATES.index("coincident")
    return STATES.index("in line")


def overlapping(question: Question, starts: Matrix) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Which rows of ``starts`` put two balls of a race into one another."""
    found = np.zeros(starts.shape[0], np.bool_)
    balls = question.assembly.balls
    for i, one in enumerate(balls):
        for j, other in enumerate(balls[:i]):
            if (one.balancer, one.race) == (other.balancer, other.race):
                apart = np.abs(np.angle(np.exp(1j * (starts[:, BALLS + i] - starts[:, BALLS + j]))))
                found |= apart < 0.5 * occupied_angle([one, other]) * (1.0 - 1e-9)
    return found


def _diverges(question: Question, end: Floats) -> bool:
    """Whether neighboring runs part: growth of a small distance over 200 revolutions, renewed at every one."""
    turn = Turn(question.machine, question.p, question.speed)
    z = complex(end[X], end[Y])
    v = complex(end[VX], end[VY])
    if question.assembly.system.rotating:
        z, v = z * np.exp(1j * end[THETA]), v * np.exp(1j * end[THETA])
    n = question.p.moment.size
    back = np.exp(-1j * end[THETA])
    z, v = z * back, v * back
    state = np.concatenate([[z.real, z.imag, v.real, v.imag], end[BALLS : BALLS + 2 * n]])
    small, total = 1e-7, 0.0
    other = state.copy()
    other[4] += small
    for number in range(300):
        state, other = turn(state), turn(other)
        apart = (other - state) / turn.scale
        distance = float(np.linalg.norm(apart))
        if number >= 100:
            total += math.log(max(distance, 1e-300) / small)
        other = state + (other - state) * small / max(distance, 1e-300)
    return total / 200.0 > 0.01
