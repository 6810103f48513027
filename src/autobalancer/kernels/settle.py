"""Many runs of one machine to their ends: the compiled loop behind basins of attraction."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import njit, types, void

from autobalancer.kernels.flags import KEPT
from autobalancer.kernels.integrators.memory import (
    COUNTS,
    END,
    ERROR,
    FRESH,
    STEP,
    TIME,
    Memory,
    memory_type,
)
from autobalancer.kernels.integrators.record import Record, record_type
from autobalancer.kernels.integrators.runge_kutta import FINISHED, RUNNING, advance
from autobalancer.kernels.integrators.switching import switch_type
from autobalancer.kernels.integrators.tableau import Tableau, tableau_type
from autobalancer.kernels.system import (
    BALLS,
    SPEED,
    Floats,
    Matrix,
    System,
    matrix_type,
    rhs_type,
    system_type,
    vector_type,
)

# columns of the answer, after the final state: status, time, then for each ball the mean speed and the swing (rad)
RESTING, UNDECIDED, FAILED = 0.0, 1.0, 2.0
STEPS_BETWEEN_LOOKS = 12
LOOKS_AT_REST = 4
WINDOW = 0.25  # the last part of a run over which motion is judged


@njit(inline="always", error_model="numpy")
def _rests(m: Memory, count: int, limit: float) -> bool:
    for i in range(count):  # noqa: SIM110
        if abs(m.state[BALLS + count + i]) > limit:
            return False
    return True


@njit(
    void(
        rhs_type, switch_type, system_type, tableau_type, record_type, memory_type, matrix_type, vector_type, types.float64,
        types.float64, types.float64, matrix_type,
    ),
    cache=KEPT,
    nogil=True,
    error_model="numpy",
)  # fmt: skip
def settle(
    rhs: Callable[[float, Floats, Floats, System], None],
    switch: Callable[[int, float, Any, Any, Any], float],
    p: System,
    t: Tableau,
    r: Record,
    m: Memory,
    starts: Matrix,
    rates: Floats,
    hold: float,
    rest: float,
    earliest: float,
    ends: Matrix,
) -> None:
    """Run from each row of ``starts`` until all balls rest (slower than ``rest``), or for the time ``hold``.

    Balls that friction holds may be shaken loose until the rotor is steady: rest counts from the time ``earliest`` on.
    With ``rates[k]`` > 0 the run begins with a ramp at that rate up to the speed of the last segment; the time counts
    from its end. ``ends`` is (rows, state + 2 + 2 n).
    """
    size = m.state.size
    count, segments = p.ball_count, p.drive.segments
    last = segments.shape[0] - 1
    target = segments[last].value
    for k in range(starts.shape[0]):
        for i in range(size):
            m.state[i] = starts[k, i]
        ramp = 0.0
        if rates[k] > 0.0 and last == 1:
            ramp = (target - starts[k, SPEED]) / rates[k]
            segments[0].value = starts[k, SPEED]
            segments[0].rate = rates[k]
            segments[1].start = ramp
        p.drive.now[0] = 0
        for i in range(COUNTS):
            m.counts[i] = 0
        m.clock[TIME], m.clock[STEP], m.clock[ERROR] = 0.0, 0.0, 1.0
        m.clock[END] = ramp + (1.0 - WINDOW) * hold
        status, quiet = RUNNING, 0
        while status == RUNNING and quiet < LOOKS_AT_REST:
            status = advance(rhs, switch, p, t, r, m, STEPS_BETWEEN_LOOKS)
            quiet = quiet + 1 if m.clock[TIME] > ramp + earliest and _rests(m, count, rest) else 0
        for i in range(count):
            ends[k, size + 2 + i] = 0.0
            ends[k, size + 2 + count + i] = 0.0
        verdict = RESTING if quiet >= LOOKS_AT_REST else UNDECIDED
        if verdict == UNDECIDED and status == FINISHED:
            begin = m.clock[TIME]
            m.clock[END] = ramp + hold
            m.counts[FRESH] = 0
            for i in range(count):
                ends[k, size + 2 + i] = m.state[BALLS + i]
            # least and greatest ball angle, kept in the stages' place of the answer
            status = RUNNING
            for i in range(count):
                ends[k, i] = m.state[BALLS + i]
                ends[k, count + i] = m.state[BALLS + i]
            while status == RUNNING:
                status = advance(rhs, switch, p, t, r, m, 2)
                for i in range(count):
                    ends[k, i] = min(ends[k, i], m.state[BALLS + i])
                    ends[k, count + i] = max(ends[k, count + i], m.state[BALLS + i])
            for i in range(count):
                swing = ends[k, count + i] - ends[k, i]
                ends[k, size + 2 + count + i] = swing
                ends[k, size + 2 + i] = (m.state[BALLS + i] - ends[k, size + 2 + i]) / (m.clock[TIME] - begin)
        if status != FINISHED and status != RUNNING:
            verdict = FAILED
        for i in range(size):
            ends[k, i] = m.state[i]
        ends[k, size] = verdict
        ends[k, size + 1] = m.clock[TIME]
