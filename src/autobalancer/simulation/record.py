"""The arrays into which a run writes, as the caller wants them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from autobalancer.assembly.system import Assembly
from autobalancer.errors import QuestionError
from autobalancer.kernels.integrators.memory import NEXT_TURN, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.system import THETA, X, Y
from autobalancer.simulation.events import Event
from autobalancer.simulation.sampling import Envelope, LastRevolutions, Samples, SampleTimes, Sampling

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
    bins = max(edges.size - 1, 0)
    room = 8e-9 * (n + 1) * (times.size + bins + turns.shape[0])
    if room > LARGEST:
        raise QuestionError(f"save: {room:.3g} GB of states are asked for, at most {LARGEST:g} GB are kept; take fewer")
    low, high = np.full(bins, np.inf), np.full(bins, -np.inf)
    if bins:
        low[0] = high[0] = math.hypot(assembly.state[X], assembly.state[Y])
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
