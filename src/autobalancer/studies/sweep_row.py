"""The measures of one run of a sweep, as plain numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.assembly.drive import unbalance_at, unbalances_at
from autobalancer.assembly.place_response import plane_unbalances
from autobalancer.assembly.places import Places, coordinates, deflections
from autobalancer.assembly.profile import unbalance_jumps
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators.memory import ACCEPTED, NEXT_TURN, TIME, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.integrators.runge_kutta import FINISHED
from autobalancer.kernels.system import SPEED, THETA, Floats, Matrix
from autobalancer.results.impacts import Impacts
from autobalancer.results.measure_table import SWEPT, numbers
from autobalancer.results.places import turns_of
from autobalancer.results.recorded import Balls, Bins, Recorded
from autobalancer.results.series import wrapped
from autobalancer.results.standing import NONE, standing, static_load
from autobalancer.results.verdict.rule import NO_VERDICT, Course, changing_because, goes_round, verdict_word
from autobalancer.simulation.outcome import outcome
from autobalancer.simulation.saved.at_places import at_the_end, ball_moments, forces_on_supports
from autobalancer.simulation.saved.dataset import ball_motion, in_order, whole_bins


def sweep_row(
    status: int,
    assembly: Assembly,
    places: Places,
    record: Record,
    memory: Memory,
    end: float,
    impacts: Impacts | None = None,
) -> dict[str, Any]:
    """All that a sweep keeps of a run with an envelope and its last revolutions; what it cannot say is left out."""
    steps = int(memory.counts[ACCEPTED])
    ended = outcome(status, memory.clock[TIME], end, interrupted=False, steps=steps).name
    unknown = np.full(len(assembly.balls), np.nan)
    found: dict[str, Any] = {"outcome": ended, "verdict": NO_VERDICT, **{m.name: unknown for m in SWEPT if m.per_ball}}
    edges, low, high, states = whole_bins(record, memory)
    if high.size == 0:
        return found
    angle, rate = ball_motion(states, assembly)
    time, speed, clock = edges[1:], states[:, SPEED], float(memory.clock[TIME])
    middle = 0.5 * (edges[:-1] + time)
    moving = Balls(float(edges[0]), time, speed, angle, rate) if assembly.balls else None
    recorded = Recorded(
        end=clock,
        centered=static_load(places.machine) == NONE,
        critical_speed=min(assembly.critical_speeds, default=math.nan),
        bins=Bins(middle, 2.0 * (time - middle), low, high, speed),
        balls=moving,
        jumps=unbalance_jumps(places.machine, end),
        impacts=impacts,
        final_angle=wrapped(angle[-1] - np.angle(unbalance_at(assembly.system, float(time[-1])))) if moving else None,
        **_of_turns(assembly, places, record, memory),
    )
    found |= numbers(recorded)
    without = found.get("vibration_without_balls", 0.0)
    course = Course(clock, recorded.centered, time, speed, goes_round(time, angle, clock), middle, low, high)
    if status == FINISHED and without > 0.0 and not changing_because(course, without):
        found["verdict"] = verdict_word(found["vibration"] / without)
    return found


def _of_turns(assembly: Assembly, places: Places, record: Record, memory: Memory) -> dict[str, Any]:
    """What the last revolutions say; nothing without a whole one."""
    turns = in_order(record.turn_states, int(memory.counts[NEXT_TURN]))
    turns = turns[turns_of(turns[:, 1 + THETA])]
    if not turns.size:
        return {}
    states, times, speed = turns[:, 1:], turns[:, 0], turns[:, 1 + SPEED]
    q, v = coordinates(states, assembly)
    z, force, rotor = deflections(places, q), forces_on_supports(states, q, v, assembly, places), states[:, THETA]
    in_space = rotor[:, None] + ball_motion(states, assembly)[0]
    static, pressed = (standing(part, rotor, in_space, static_load(places.machine)) for part in (z, force))
    told: dict[str, Any] = {"turns": (z, deflections(places, v), static), "forces": (force, pressed)}
    if assembly.balls:
        told["rotor"] = _unbalances(states, times, speed, assembly, places)
        held = at_the_end(float(memory.clock[TIME]), float(memory.state[SPEED]), assembly, places)
        if "vibration_without_balls" in held:
            told["without_balls"] = held["vibration_without_balls"][1]
    return told


def _unbalances(
    states: Matrix, times: Floats, speed: Floats, assembly: Assembly, places: Places
) -> tuple[Floats, Floats]:
    """Unbalance of the rotor and what is left of it: sums over several planes, else resultants, kg m, (times,)."""
    balls = ball_moments(states, assembly)
    if len(places.planes) > 1:
        wanted = plane_unbalances(places, times, speed)
        sums = np.zeros_like(wanted)
        np.add.at(sums.T, np.array(places.plane_of_ball, np.int64), balls.T)
    else:
        wanted = unbalances_at(assembly.system, times)[:, None]
        sums = balls.sum(axis=1, keepdims=True)
    return np.abs(wanted).sum(axis=1), np.abs(wanted + sums).sum(axis=1)
