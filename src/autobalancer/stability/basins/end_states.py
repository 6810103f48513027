"""The rule by which the end of a run is named, in this order:

- *balanced*: the balls rest and every race with balls that are not in one row runs true (center within 1/1000 of the
  deflection scale of the axis of rotation), in all planes; *mixed*: in some of several planes;
- *coincident*, *in line*: the balls rest in a row with the race center, all on one side, or on both sides;
- *held by friction*: the balls rest where no ball without friction would;
- *stalled*: a ball turns in the rotor, on the mean by more than 1/100 of the rotor speed;
- *chaotic*: the balls keep oscillating, and two runs that start close together diverge exponentially;
- *oscillating*: the balls keep oscillating, and such runs do not diverge.

Starts at which balls of a race would overlap are marked as such and do not count in the shares.

Balls rest when all are slower in the rotor than 1e-5 of its speed over several looks; on rotors with several coordinates,
where modes may decay very slowly, when they are near enough to their places. Each plane has a name of its own, too: where balls
of another plane move, one whose balls swing by less than a degree is *at rest*.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from autobalancer.assembly.places import in_frame
from autobalancer.assembly.system import Assembly
from autobalancer.catalog.resolve import occupied_angle
from autobalancer.kernels.system import BALLS, THETA, Floats, Matrix, X, Y
from autobalancer.machine import Machine
from autobalancer.stability.basins.turn import Turn
from autobalancer.stability.host.planar import Complexes
from autobalancer.stability.host.stations import Stations

STATES = (
    "balanced",
    "mixed",
    "coincident",
    "in line",
    "held by friction",
    "stalled",
    "oscillating",
    "chaotic",
    "failed",
    "overlapping start",
)
PLANE_STATES = (*(name for name in STATES if name != "mixed"), "at rest")
AT_REST = STATES[:5]
REST = 1e-5  # ball speed over rotor speed
TRUE = 1e-3  # distance of a race center over the deflection scale
TURNING = 1e-2  # mean ball speed over rotor speed
NOT_RUN, RESTING, UNDECIDED, FAILED = -1.0, 0.0, 1.0, 2.0  # how a run ended


@dataclass(frozen=True)
class Question:
    """A machine at a speed, ready to be run from many starts."""

    machine: Machine
    assembly: Assembly
    st: Stations
    speed: float
    hold: float
    tolerance: float
    rest: float  # ball speed below which balls rest, rad/s
    earliest: float = 0.0  # s at the speed, before which balls do not count as at rest
    rubs: bool = False  # whether any race has friction


@dataclass(frozen=True)
class End:
    """Names of the end state of a run: of all, and of each plane."""

    state: str
    planes: tuple[str, ...]


def end_state(question: Question, end: Floats) -> End:
    """The end state of a run: its last state, how it ended and when, then mean speeds and swings of balls that do not rest."""
    st, n = question.st, question.st.moment.size
    size, planes = question.assembly.state.size, range(len(question.st.names))
    if end[size] == FAILED:
        return End("failed", ("failed",) * len(planes))
    speed, swing = end[size + 2 : size + 2 + n], end[size + 2 + n :]
    if end[size] != RESTING:
        stalled = np.abs(speed) > TURNING * question.speed
        swinging = swing > math.radians(1.0)
        if stalled.any() or swinging.any():
            moving = "stalled" if stalled.any() else "chaotic" if _diverges(question, end) else "oscillating"
            own = "oscillating" if moving == "stalled" else moving
            return End(
                moving,
                tuple(
                    "stalled"
                    if stalled[st.station == p].any()
                    else own
                    if swinging[st.station == p].any()
                    else "at rest"
                    for p in planes
                ),
            )
    center = centers(question, end)
    own_names = tuple(_at_rest(question, end[BALLS : BALLS + n], center, st.station == p) for p in planes)
    return End(_together(own_names), own_names)


def centers(question: Question, end: Floats) -> Complexes:
    """Race center of each ball in the rotor, from the axis of rotation, (n,) m.

    Of rotors with several coordinates, some of which may hardly be damped, once the transient of the rotor is gone.
    """
    st, n = question.st, question.st.moment.size
    if st.model.pairs > 1:
        return np.asarray((st.rows @ st.coordinates(question.speed, end[BALLS : BALLS + n]))[st.station] + st.offset)
    whirl = deflections(question, end)
    if not question.assembly.system.rotating:
        whirl = whirl * np.exp(-1j * end[THETA])
    return np.asarray(whirl + st.offset)


def deflections(question: Question, end: Floats) -> Complexes:
    """Of the race of each ball, in the axes of the frame, (n,) m."""
    assembly = question.assembly
    if not assembly.general:
        return np.full(question.st.moment.size, complex(end[X], end[Y]))
    q, _ = in_frame(end[None, : assembly.state.size], assembly)
    x, y = np.moveaxis(assembly.places @ q[0], -1, 0)
    return np.asarray((x + 1j * y)[[ball.balancer for ball in assembly.balls]])


def _at_rest(question: Question, angles: Floats, center: Complexes, here: np.ndarray[Any, Any]) -> str:
    """The name of one plane whose balls rest."""
    along = (np.exp(-1j * angles) * center)[here]
    row = np.abs(along.imag) <= 0.02 * np.abs(along)
    true = np.abs(center[here]) <= TRUE * float(question.assembly.scale[X])
    if (true.any() or not here.any()) and (true | row).all():
        return "balanced"
    if question.rubs and not (true | row).all():
        return "held by friction"
    return "coincident" if len(set(np.sign(along.real[~true]))) <= 1 else "in line"


def _together(planes: tuple[str, ...]) -> str:
    """The name of all planes, whose balls rest."""
    if "held by friction" in planes:
        return "held by friction"
    if "balanced" in planes:
        return "balanced" if set(planes) == {"balanced"} else "mixed"
    return "in line" if "in line" in planes else "coincident"


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
    rotating = bool(question.assembly.system.rotating)  # seen from its axes, the rotor is at the angle zero
    turn = Turn(question.machine, question.st, question.speed, 0.0 if rotating else float(end[THETA]))
    state = end[turn.kept]
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
