"""From raw states to a labelled result."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.system import Assembly, unbalance_at
from autobalancer.kernels.integrators.memory import EVENTS_SEEN, NEXT_BIN, NEXT_SAMPLE, NEXT_TURN, TIME, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.system import BALLS, SPEED, THETA, Floats, Matrix, X, Y
from autobalancer.results.labels import label
from autobalancer.results.provenance import provenance


def run_dataset(
    assembly: Assembly, record: Record, state: Memory, events: list[str], attributes: dict[str, Any]
) -> xr.Dataset:
    """Label what a run wrote; whatever was not reached is cut off."""
    balls = assembly.balls
    data: dict[str, Any] = {}
    coordinates: dict[str, Any] = {
        "ball": np.arange(1, len(balls) + 1),
        "balancer": ("ball", np.array([ball.balancer + 1 for ball in balls], np.int64)),
        "race": ("ball", np.array([ball.race + 1 for ball in balls], np.int64)),
        "orbit_radius": ("ball", np.array([ball.orbit_radius for ball in balls], np.float64)),
        "ball_diameter": ("ball", np.array([ball.diameter for ball in balls], np.float64)),
        "ball_moment": ("ball", np.array([ball.moment for ball in balls], np.float64)),
        "race_center_x": ("ball", np.array([ball.eccentricity.real for ball in balls], np.float64)),
        "race_center_y": ("ball", np.array([ball.eccentricity.imag for ball in balls], np.float64)),
    }
    if assembly.stations:
        coordinates["station"] = np.array(list(assembly.stations), dtype=object)
    count = int(state.counts[NEXT_SAMPLE])
    if record.sample_times.size:
        coordinates["time"] = record.sample_times[:count]
        data |= _states(record.samples[:count], record.sample_times[:count], assembly)
        data |= _at_stations("", "time", record.samples[:count], assembly)
    bins = int(state.counts[NEXT_BIN])
    if record.bin_low.size:
        edges, states = record.bin_edges[: bins + 1].copy(), record.bin_states[:bins]
        if bins < record.bin_low.size and np.isfinite(record.bin_high[bins]) and state.clock[TIME] > edges[-1]:
            # the run ended early: its last bin ends there
            bins += 1
            edges = np.append(edges, state.clock[TIME])
            states = np.vstack([states, state.state])
        n = len(balls)
        coordinates["envelope_time"] = ("bin", 0.5 * (edges[:-1] + edges[1:]))
        data["envelope_low"] = ("bin", record.bin_low[:bins])
        data["envelope_high"] = ("bin", record.bin_high[:bins])
        data["envelope_speed"] = ("bin", states[:, SPEED])
        data["envelope_ball_angle_in_rotor"] = (("bin", "ball"), states[:, BALLS : BALLS + n])
        data["envelope_ball_speed_in_rotor"] = (("bin", "ball"), states[:, BALLS + n : BALLS + 2 * n])
    if record.turn_states.shape[0]:
        turns = _ring(record.turn_states, int(state.counts[NEXT_TURN]))
        z = deflection(turns[:, 1:], assembly)
        coordinates["turn_time"] = ("turn", turns[:, 0])
        data["turn_rotor_angle"] = ("turn", turns[:, 1 + THETA])
        data["turn_speed"] = ("turn", turns[:, 1 + SPEED])
        data["turn_x"], data["turn_y"] = ("turn", z.real), ("turn", z.imag)
        data |= _at_stations("turn_", "turn", turns[:, 1:], assembly)
        data["turn_ball_angle_in_rotor"] = (("turn", "ball"), turns[:, 1 + BALLS : 1 + BALLS + len(balls)])
    if events:
        log = record.event_states[: int(state.counts[EVENTS_SEEN])]
        coordinates["event_time"] = ("event", log[:, 1])
        data["event_name"] = ("event", np.array([events[int(e)] for e in log[:, 0]], dtype=object))
        data["event_speed"] = ("event", log[:, 2 + SPEED])
        data["event_deflection"] = ("event", np.hypot(log[:, 2 + X], log[:, 2 + Y]))
        attributes = attributes | {"events_seen": record.event_seen.tolist(), "events_watched": events}
    dataset = label(xr.Dataset(data, coordinates))
    dataset.attrs = {
        "title": f"Run of {attributes['machine_name']}",
        **provenance(),
        **attributes,
    }
    return dataset


def _states(states: Matrix, times: Floats, assembly: Assembly) -> dict[str, Any]:
    n = len(assembly.balls)
    z = deflection(states, assembly)
    angle, speed = states[:, BALLS : BALLS + n], states[:, BALLS + n : BALLS + 2 * n]
    unbalance = np.array([unbalance_at(assembly.system, time) for time in times], np.complex128)
    moment = np.array([ball.moment for ball in assembly.balls], np.float64)
    center = sum(ball.effective_mass * ball.eccentricity for ball in assembly.balls)
    residual = unbalance + center + (moment * np.exp(1j * angle)).sum(axis=1)
    return {
        "speed": ("time", states[:, SPEED]),
        "rotor_angle": ("time", states[:, THETA]),
        "x": ("time", z.real),
        "y": ("time", z.imag),
        "deflection": ("time", np.abs(z)),
        "ball_angle_in_rotor": (("time", "ball"), angle),
        "ball_speed_in_rotor": (("time", "ball"), speed),
        "ball_speed_in_space": (("time", "ball"), speed + states[:, SPEED, None]),
        "unbalance": ("time", np.abs(unbalance)),
        "unbalance_angle_in_rotor": ("time", np.angle(unbalance)),
        "residual_unbalance": ("time", np.abs(residual)),
    }


def deflection(states: Matrix, assembly: Assembly, station: str | None = None) -> Any:
    """x + i y in space, at the reference station or a named one; (times,)."""
    z = states[:, X] + 1j * states[:, Y]
    if station is not None:
        rest = BALLS + 2 * len(assembly.balls)
        row = assembly.stations[station]
        coordinates = np.column_stack([states[:, [X, Y]], states[:, rest : rest + row.shape[1] - 2]])
        z = coordinates @ (row[0] + 1j * row[1])
    return z * np.exp(1j * states[:, THETA]) if assembly.system.rotating else z


def _at_stations(prefix: str, dimension: str, states: Matrix, assembly: Assembly) -> dict[str, Any]:
    """Deflections at all named stations; the dimension ``station`` brings their names."""
    names = list(assembly.stations)
    if not names:
        return {}
    z = np.column_stack([deflection(states, assembly, name) for name in names])
    return {
        f"{prefix}station_x": ((dimension, "station"), z.real),
        f"{prefix}station_y": ((dimension, "station"), z.imag),
    }


def _ring(ring: Matrix, written: int) -> Matrix:
    """The entries of a ring in the order of time."""
    size = ring.shape[0]
    return ring[:written] if written <= size else np.roll(ring, -(written % size), axis=0)
