"""The measures of one run of a sweep, as plain numbers."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.assembly.drive import unbalance_at
from autobalancer.assembly.place_response import plane_unbalances, without_balancing
from autobalancer.assembly.places import Places, coordinates, deflections, support_forces
from autobalancer.assembly.profile import unbalance_jumps
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators.memory import ACCEPTED, NEXT_BIN, NEXT_TURN, TIME, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.integrators.runge_kutta import RUNNING
from autobalancer.kernels.system import BALLS, SPEED, THETA, Floats, Matrix
from autobalancer.machine import Machine
from autobalancer.results.places import moved, turns_of
from autobalancer.results.series import counted, end_of_run_up, release_rows, settled_from, wrapped
from autobalancer.results.standing import standing, static_load
from autobalancer.results.verdict.rule import NO_VERDICT, Course, changing_because, goes_round, verdict_word
from autobalancer.simulation.outcome import outcome
from autobalancer.simulation.saved.at_places import ball_moments
from autobalancer.simulation.saved.dataset import in_order

PER_BALL = "ball_angle_to_unbalance"
LABELS = {
    "peak_deflection": ("greatest deflection at the reference station", "m"),
    "peak_speed": ("rotor speed at the greatest deflection", "rad/s"),
    "residual_vibration": ("vibration at the end of the run at the reference station", "m"),
    "vibration": ("greatest vibration of all places in the last revolutions", "m"),
    "vibration_without_balls": ("the same with the balls spread and held", "m"),
    "velocity_rms": ("greatest root mean square of the velocity of all places in the last revolutions", "m/s"),
    "static_deflection": ("greatest static deflection of all places in the last revolutions", "m"),
    "support_force": ("greatest vibrating force of all supports in the last revolutions", "N"),
    "residual_unbalance": ("residual unbalance, of several planes the sum, in the last revolutions", "kg m"),
    "residual_share": ("residual unbalance over unbalance", "1"),
    "settling_time": (
        "settling time of the last ball, from its release, a jump of the unbalance or the end of the run-up",
        "s",
    ),
    "settled_at": ("time in the run at which the last ball has settled", "s"),
    "release_speed": ("greatest break-away speed of a stalled ball", "rad/s"),
    PER_BALL: ("final ball angle from the unbalance", "rad"),
}


def sweep_row(
    status: int, assembly: Assembly, places: Places, record: Record, memory: Memory, end: float
) -> dict[str, Any]:
    """All that a sweep keeps of a run with an envelope and its last revolutions; what it cannot say is left out."""
    steps, n = int(memory.counts[ACCEPTED]), len(assembly.balls)
    ended = outcome(status, memory.clock[TIME], end, interrupted=False, steps=steps).name
    found: dict[str, Any] = {
        "outcome": ended if status != RUNNING else "budget spent",
        "verdict": NO_VERDICT,
        PER_BALL: np.full(n, np.nan),
    }
    count = int(memory.counts[NEXT_BIN])
    if count == 0:
        return found
    course = _course(assembly, places, record, count)
    peak = int(np.argmax(course.high))
    found |= {"peak_deflection": course.high[peak], "peak_speed": course.speed[peak]}
    if course.vertical:
        found["residual_vibration"] = course.high[course.time > 0.95 * course.time[-1]].max()
    if n:
        found |= _balls(places.machine, assembly, course, record.bin_states[:count, BALLS : BALLS + 2 * n], end)
    turns = in_order(record.turn_states, int(memory.counts[NEXT_TURN]))
    turns = turns[turns_of(turns[:, 1 + THETA])]
    return found | (_turns(found, turns, assembly, places, course) if turns.size else {})


def _course(assembly: Assembly, places: Places, record: Record, count: int) -> Course:
    edges, states = record.bin_edges[: count + 1], record.bin_states[:count]
    angle, end = states[:, BALLS : BALLS + len(assembly.balls)], float(edges[-1])
    return Course(
        end=end,
        vertical=places.machine.axis == "vertical",
        time=edges[1:],
        speed=states[:, SPEED],
        uneven=goes_round(edges[1:], angle, end),
        envelope_time=0.5 * (edges[:-1] + edges[1:]),
        low=record.bin_low[:count],
        high=record.bin_high[:count],
    )


def _balls(machine: Machine, assembly: Assembly, course: Course, motion: Matrix, end: float) -> dict[str, Any]:
    time, speed = course.time, course.speed
    angle, rates = np.split(motion, 2, axis=1)
    rows = release_rows(speed, rates + speed[:, None], min(assembly.critical_speeds, default=math.nan))
    released = np.interp(rows, np.arange(time.size), time)
    settled = settled_from(time, angle, speed, math.radians(2.0))
    jumps = unbalance_jumps(machine, end)
    duration, _ = counted(settled, released, end_of_run_up(time, speed), 0.0, jumps)
    last = int(np.argmax(settled))  # nan is the greatest
    return {
        "settling_time": duration[last],
        "settled_at": settled[last],
        "release_speed": np.interp(np.nanmax(rows), np.arange(time.size), speed) if np.isfinite(rows).any() else np.nan,
        PER_BALL: wrapped(angle[-1] - np.angle(unbalance_at(assembly.system, end))),
    }


def _turns(found: dict[str, Any], turns: Matrix, assembly: Assembly, places: Places, course: Course) -> dict[str, Any]:
    states, times, speed = turns[:, 1:], turns[:, 0], turns[:, 1 + SPEED]
    q, v = coordinates(states, assembly)
    z, force = deflections(places, q), support_forces(places, speed, q, v)
    rotor, count = states[:, THETA], len(assembly.balls)
    in_space = rotor[:, None] + states[:, BALLS : BALLS + count]
    static, pressed = (standing(part, rotor, in_space, static_load(places.machine)) for part in (z, force))
    greatest, _, velocity = moved(z, deflections(places, v), static)
    if course.vertical:
        greatest[0] = max(greatest[0], found["residual_vibration"])
    told = {
        "residual_vibration": greatest[0],
        "vibration": greatest.max(),
        "velocity_rms": velocity.max(),
        "static_deflection": np.abs(static).max(),
        "support_force": np.abs(force - pressed).max(initial=0.0),
    }
    if not assembly.balls:
        return told
    unbalance, residual = _unbalances(states, times, speed, assembly, places)
    told |= {"residual_unbalance": residual, "residual_share": residual / unbalance if unbalance > 0.0 else np.nan}
    if places.machine.excitations:
        return told
    without = float(without_balancing(places, float(times[-1]), float(speed[-1]))[0].max())
    told["vibration_without_balls"] = without
    settled = found["outcome"] == "finished" and without > 0.0 and not changing_because(course, without)
    return told | {"verdict": verdict_word(told["vibration"] / without) if settled else NO_VERDICT}


def _unbalances(
    states: Matrix, times: Floats, speed: Floats, assembly: Assembly, places: Places
) -> tuple[float, float]:
    """Unbalance of the rotor and what is left of it: sums over several planes, else resultants, kg m."""
    balls = ball_moments(states, assembly)
    if len(places.planes) > 1:
        wanted = plane_unbalances(places, times, speed)
        sums = np.zeros_like(wanted)
        np.add.at(sums.T, np.array(places.plane_of_ball, np.int64), balls.T)
    else:
        wanted = np.array([[unbalance_at(assembly.system, float(time))] for time in times], np.complex128)
        sums = balls.sum(axis=1, keepdims=True)
    return float(np.abs(wanted).sum(axis=1).mean()), float(np.abs(wanted + sums).sum(axis=1).mean())
