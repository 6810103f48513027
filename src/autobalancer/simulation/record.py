"""The arrays into which a run writes, as the caller wants them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from autobalancer.assembly.system import Assembly
from autobalancer.errors import QuestionError
from autobalancer.kernels.integrators.dense_output import GREATEST, LENGTH, SUM
from autobalancer.kernels.integrators.integrator_state import NEXT_TURN, Memory
from autobalancer.kernels.integrators.recording import Record
from autobalancer.kernels.system import BALLS, SPEED, THETA, X, Y
from autobalancer.units import to_si

LOGGED_EVENTS = 10_000
LARGEST = 2.0  # GB


def record_for(
    wishes: Sequence[Sampling], events: Sequence[Event], assembly: Assembly, end: float, jumps: Sequence[float] = ()
) -> Record:
    """Room for all that was asked for, and for nothing else; bins of an envelope end where the unbalance jumps."""
    n = assembly.state.size
    times, edges = np.zeros(0), np.zeros(0)
    turns, step, revolutions = np.zeros((0, n + 1)), 1.0, 0.0
    asked: set[str] = set()
    # each kind of wish at most once
    for wish in wishes:
        kind = "samples" if isinstance(wish, (Samples, SampleTimes)) else type(wish).__name__
        if kind in asked:
            raise QuestionError(f"save: {kind} is asked for twice; ask once")
        asked.add(kind)
        if isinstance(wish, Samples):
            times = np.linspace(0.0, end, wish.count)
        elif isinstance(wish, SampleTimes):
            times = _checked(wish, end)
        elif isinstance(wish, Envelope):
            edges = _ending_at(np.linspace(0.0, end, wish.bins + 1), jumps)
        elif isinstance(wish, LastRevolutions):
            turns = np.empty((wish.count * wish.per_revolution + 1, n + 1))
            step, revolutions = 2.0 * math.pi / wish.per_revolution, float(wish.count)
            if any(event.ends_run for event in events):
                revolutions = math.inf  # the end is not known beforehand: keep the ring turning all the time
        else:
            raise QuestionError(f"save: {wish!r} is not Samples, SampleTimes, Envelope or LastRevolutions")
    # is there room? the envelope begins with the first state
    bins = max(edges.size - 1, 0)
    room = 8e-9 * (n + 1) * (times.size + bins + turns.shape[0])
    if room > LARGEST:
        raise QuestionError(f"save: {room:.3g} GB of states are asked for, at most {LARGEST:g} GB are kept; take fewer")
    low, high = np.full(bins, np.inf), np.full(bins, -np.inf)
    if bins:
        low[0] = high[0] = math.hypot(assembly.state[X], assembly.state[Y])
    # quantities of the events, as compiled code finds them
    for event in events:
        if event.ball is not None and not 1 <= event.ball <= len(assembly.balls):
            raise QuestionError(f"event: given ball {event.ball}; the machine has balls 1 to {len(assembly.balls)}")
    kinds, firsts, seconds = (
        np.array([event.quantity_of(len(assembly.balls)) for event in events], np.int64).reshape(-1, 3).T.copy()
    )
    return Record(
        sample_times=times,
        samples=np.full((times.size, n), np.nan),
        bin_edges=edges,
        bin_low=low,
        bin_high=high,
        bin_states=np.full((bins, n), np.nan),
        turn_states=np.full_like(turns, np.nan),
        turn_step=step,
        turn_count=revolutions,
        event_kinds=kinds,
        event_firsts=firsts,
        event_seconds=seconds,
        event_levels=np.array([event.level for event in events], np.float64),
        event_directions=np.array([event.way for event in events], np.int64),
        event_terminal=np.array([event.ends_run for event in events], np.int64),
        event_seen=np.zeros(len(events), np.int64),
        event_sides=np.zeros(len(events)),
        event_places=np.zeros(len(events)),
        event_states=np.zeros((LOGGED_EVENTS if events else 0, n + 2)),
    )


def turns_complete(record: Record, memory: Memory, assembly: Assembly) -> bool:
    """Whether the ring holds the last revolutions, as far as the rotor made any, and without a gap."""
    size, begin, end = record.turn_states.shape[0], assembly.state[THETA], memory.state[THETA]
    if size == 0 or math.isinf(record.turn_count):
        return True
    expected = min(size, int(abs(end - begin) / record.turn_step))
    if expected < 2:
        return True
    angles = record.turn_states[: int(memory.counts[NEXT_TURN]), 1 + THETA]
    whole = angles.size >= expected and np.ptp(angles) < (angles.size - 0.5) * record.turn_step
    return bool(whole and np.abs(angles - end).min() < 1.5 * record.turn_step)


def _ending_at(edges: np.ndarray, jumps: Sequence[float]) -> np.ndarray:
    """The same edges, with the nearest inner one moved to each jump."""
    for jump in jumps:
        if edges.size > 2:
            edges[1 + int(np.argmin(np.abs(edges[1:-1] - jump)))] = jump
    return edges


def _checked(wish: SampleTimes, end: float) -> np.ndarray:
    times = np.array(wish.times, np.float64)
    if times.ndim != 1 or times.size == 0 or not np.all(np.isfinite(times)):
        raise QuestionError("SampleTimes: give a list of finite times in seconds")
    if np.any(np.diff(times) <= 0.0) or times[0] < 0.0 or times[-1] > end:
        raise QuestionError(
            f"SampleTimes: the times must increase and lie within 0 and {end:g} s, the duration of the run"
        )
    return times


# What a run keeps. Ask for one of these or for several; memory grows with them only.


MOST = 10_000_000  # of each kind


@dataclass(frozen=True)
class Samples:
    """The state at ``count`` equally spaced times, begin and end included."""

    count: int = 2001

    def __post_init__(self) -> None:
        if not 2 <= self.count <= MOST:
            raise QuestionError(f"Samples(count={self.count}): give 2, for begin and end, to {MOST}")


@dataclass(frozen=True)
class SampleTimes:
    """The state at these times (s, ascending)."""

    times: Sequence[float]


@dataclass(frozen=True)
class Envelope:
    """Least and greatest deflection in each of ``bins`` equal parts of the run, found on the dense output."""

    bins: int = 1000

    def __post_init__(self) -> None:
        if not 1 <= self.bins <= MOST:
            raise QuestionError(f"Envelope(bins={self.bins}): give 1 to {MOST}")


@dataclass(frozen=True)
class LastRevolutions:
    """The state at equal steps of the rotor angle over the last ``count`` revolutions."""

    count: int = 10
    per_revolution: int = 72

    def __post_init__(self) -> None:
        if self.count < 1 or self.per_revolution < 4:
            raise QuestionError(f"{self}: give at least 1 revolution and 4 samples in each")
        if self.count * self.per_revolution > MOST:
            raise QuestionError(f"{self}: give at most {MOST} samples in all")


Sampling = Samples | SampleTimes | Envelope | LastRevolutions


# Events: a quantity passes a level; the run notes it or ends there.


QUANTITIES = ("deflection", "speed", "ball_speed_in_rotor", "ball_speed_in_space", "fastest_ball_in_rotor")


@dataclass(frozen=True)
class Event:
    """The passage of ``quantity`` through ``level`` (SI).

    Parameters
    ----------
    quantity
        ``deflection``, ``speed``, ``ball_speed_in_rotor``, ``ball_speed_in_space`` (these two of one ``ball``, counted
        from 1) or ``fastest_ball_in_rotor`` (the greatest amount among all balls).
    level
        m or rad/s, or a text with a unit.
    direction
        Direction of the passage.
    ends_run
        Whether the run stops there.

    Raises
    ------
    QuestionError
        For an unknown quantity or a missing ball.
    """

    quantity: Literal["deflection", "speed", "ball_speed_in_rotor", "ball_speed_in_space", "fastest_ball_in_rotor"]
    level: float | str
    direction: Literal["rising", "falling", "both"] = "both"
    ends_run: bool = False
    ball: int | None = None

    def __post_init__(self) -> None:
        if self.quantity not in QUANTITIES:
            raise QuestionError(f"event: unknown quantity {self.quantity!r}; known: {', '.join(QUANTITIES)}")
        object.__setattr__(self, "level", to_si(self.level, "m" if self.quantity == "deflection" else "rad/s"))
        if self.quantity in ("ball_speed_in_rotor", "ball_speed_in_space") and self.ball is None:
            raise QuestionError(f"event on {self.quantity}: say which ball, counted from 1")

    @property
    def name(self) -> str:
        """For the result: ``speed rising through 250``."""
        ball = f" of ball {self.ball}" if self.ball is not None else ""
        way = "" if self.direction == "both" else f" {self.direction}"
        return f"{self.quantity}{ball}{way} through {float(self.level):g}"

    def quantity_of(self, balls: int) -> tuple[int, int, int]:
        """The quantity of a machine with so many balls, and its components of the state: kernels/integrators/dense_output.py."""
        own = BALLS + balls + (self.ball or 1) - 1
        return {
            "deflection": (LENGTH, X, Y),
            "speed": (SUM, SPEED, -1),
            "ball_speed_in_rotor": (SUM, own, -1),
            "ball_speed_in_space": (SUM, own, SPEED),
            "fastest_ball_in_rotor": (GREATEST, BALLS + balls, BALLS + 2 * balls),
        }[self.quantity]

    @property
    def way(self) -> int:
        """+1 for a rising passage, -1 for a falling one, 0 for both."""
        return {"rising": 1, "falling": -1, "both": 0}[self.direction]
