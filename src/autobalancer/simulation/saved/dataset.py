"""From raw states to a labelled result."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.assembly.gauges import gauges_of
from autobalancer.assembly.places import Places
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.integrators.memory import EVENTS_SEEN, NEXT_BIN, NEXT_SAMPLE, NEXT_TURN, TIME, Memory
from autobalancer.kernels.integrators.record import Record
from autobalancer.kernels.measures.gauges import Seen
from autobalancer.kernels.records.resolved import BALL_SPIN, BALL_X, BALL_Y
from autobalancer.kernels.system import BALLS, SPEED, THETA, Floats, Matrix, X, Y
from autobalancer.results.answers.run import Run
from autobalancer.results.labels import label
from autobalancer.results.places import directions, sizes
from autobalancer.results.provenance import provenance
from autobalancer.simulation.saved.along_axis import axis_coordinates, couple_unbalance
from autobalancer.simulation.saved.at_places import (
    at_the_end,
    ball_states_of,
    mass_attributes,
    over_time,
    over_turns,
    place_names,
    seen_at,
)
from autobalancer.simulation.saved.race_forces import has_real_races, left_race, on_races, stored_in_forces
from autobalancer.simulation.saved.resolved_walls import wall_contacts
from autobalancer.simulation.saved.torsion import link_coordinates, over_links


def run_dataset(
    assembly: Assembly, places: Places, record: Record, state: Memory, events: list[str], attributes: dict[str, Any]
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
    if any(ball.body != "ball" for ball in balls):
        coordinates["ball_body"] = ("ball", np.array([ball.body for ball in balls], dtype=object))
    coordinates |= place_names(places) | axis_coordinates(places, assembly) | link_coordinates(places.machine)
    if assembly.stations:
        coordinates["station"] = np.array(list(assembly.stations), dtype=object)
    gauges, count = gauges_of(assembly, places, centered=True), int(state.counts[NEXT_SAMPLE])
    if record.sample_times.size:
        coordinates["time"] = record.sample_times[:count]
        seen = seen_at(np.column_stack([record.sample_times[:count], record.samples[:count]]), assembly, gauges)
        data |= _states(record.samples[:count], seen, assembly)
        data |= _at_stations("", "time", record.samples[:count], assembly)
        data |= over_time(seen, places)
        data |= couple_unbalance(places, record.sample_times[:count])
        if has_real_races(assembly):
            data |= on_races(record.samples[:count], record.sample_times[:count], assembly)
        data |= stored_in_forces(record.samples[:count], assembly)
        data |= over_links(record.samples[:count], assembly.system.drive)
    if record.bin_low.size:
        edges, low, high, states = whole_bins(record, state)
        angle, rate = ball_motion(states, assembly)
        coordinates["envelope_time"] = ("bin", 0.5 * (edges[:-1] + edges[1:]))
        coordinates["envelope_end"] = ("bin", edges[1:])
        data["envelope_low"], data["envelope_high"] = ("bin", low), ("bin", high)
        data["envelope_speed"] = ("bin", states[:, SPEED])
        data["envelope_ball_angle_in_rotor"] = (("bin", "ball"), angle)
        data["envelope_ball_speed_in_rotor"] = (("bin", "ball"), rate)
    if record.turn_states.shape[0]:
        turns = in_order(record.turn_states, int(state.counts[NEXT_TURN]))
        z = deflection(turns[:, 1:], assembly)
        coordinates["turn_time"] = ("turn", turns[:, 0])
        data["turn_rotor_angle"] = ("turn", turns[:, 1 + THETA])
        data["turn_speed"] = ("turn", turns[:, 1 + SPEED])
        data["turn_x"], data["turn_y"] = ("turn", z.real), ("turn", z.imag)
        data |= _at_stations("turn_", "turn", turns[:, 1:], assembly)
        data |= over_turns(seen_at(turns, assembly, gauges), places)
        data["turn_ball_angle_in_rotor"] = (("turn", "ball"), ball_motion(turns[:, 1:], assembly)[0])
    if events:
        log = record.event_states[: int(state.counts[EVENTS_SEEN])]
        coordinates["event_time"] = ("event", log[:, 1])
        data["event_name"] = ("event", np.array([events[int(e)] for e in log[:, 0]], dtype=object))
        data["event_speed"] = ("event", log[:, 2 + SPEED])
        data["event_deflection"] = ("event", np.hypot(log[:, 2 + X], log[:, 2 + Y]))
        attributes = attributes | {"events_seen": record.event_seen.tolist(), "events_watched": events}
    data |= at_the_end(float(state.clock[TIME]), float(state.state[SPEED]), assembly, places, gauges)
    dataset = label(Run(data, coordinates))
    dataset.attrs = {
        "title": f"Run of {attributes['machine_name']}",
        **provenance(),
        **attributes,
        **mass_attributes(places),
        **left_race(record.sample_times[:count], record.samples[:count], data, assembly, places),
    }
    return dataset


def whole_bins(record: Record, state: Memory) -> tuple[Floats, Floats, Floats, Matrix]:
    """Edges (s), least and greatest deflection (m) and last states of the bins; a run that ended early ends its last."""
    bins = int(state.counts[NEXT_BIN])
    edges, states = record.bin_edges[: bins + 1].copy(), record.bin_states[:bins]
    if bins < record.bin_low.size and np.isfinite(record.bin_high[bins]) and state.clock[TIME] > edges[-1]:
        bins += 1
        edges = np.append(edges, state.clock[TIME])
        states = np.vstack([states, state.state])
    return edges, record.bin_low[:bins], record.bin_high[:bins], states


def _states(states: Matrix, seen: Seen, assembly: Assembly) -> dict[str, Any]:
    z = deflection(states, assembly)
    angle, speed = ball_motion(states, assembly)
    unbalance, residual = seen.unbalance[:, 0], seen.left[:, 0]
    resolved = _resolved(states, ball_states_of(states, assembly), assembly) if assembly.resolved else {}
    return {
        "speed": ("time", states[:, SPEED]),
        "rotor_angle": ("time", states[:, THETA]),
        "x": ("time", z.real),
        "y": ("time", z.imag),
        "deflection": ("time", np.abs(z)),
        "ball_angle_in_rotor": (("time", "ball"), angle),
        "ball_speed_in_rotor": (("time", "ball"), speed),
        "ball_speed_in_space": (("time", "ball"), speed + states[:, SPEED, None]),
        "unbalance": ("time", sizes(unbalance)),
        "unbalance_angle_in_rotor": ("time", directions(unbalance)),
        "residual_unbalance": ("time", sizes(residual)),
        **resolved,
    }


def ball_motion(states: Matrix, assembly: Assembly) -> tuple[Matrix, Matrix]:
    """Angles and speeds of the balls in the rotor, (times, n) each."""
    n = len(assembly.balls)
    angle, speed = states[:, BALLS : BALLS + n], states[:, BALLS + n : BALLS + 2 * n]
    if not assembly.resolved:
        return angle, speed
    from autobalancer.kernels.measures.seen import ball_motion as resolved_motion

    angle, speed = np.empty((len(states), n)), np.empty((len(states), n))
    resolved_motion(np.ascontiguousarray(states), n, assembly.places.shape[2], 1, angle, speed)
    return angle, speed


def _resolved(states: Matrix, own: Any, assembly: Assembly) -> dict[str, Any]:
    """What only balls in resolved contact have: place in space, spin, distance from the wall, forces of wall and floor."""
    place = own[..., BALL_X] + 1j * own[..., BALL_Y]
    centers = np.array([ball.eccentricity for ball in assembly.balls], np.complex128)
    rest, size = BALLS + 2 * len(assembly.balls), assembly.places.shape[2]
    coordinates = np.column_stack([states[:, [X, Y]], states[:, rest : rest + size - 2]])
    rows = assembly.places[:, 0] + 1j * assembly.places[:, 1]
    hosts = coordinates @ rows[[ball.balancer for ball in assembly.balls]].T
    turn = np.exp(1j * states[:, THETA, None])
    if assembly.system.rotating:
        hosts = hosts * turn
    z = hosts + turn * (centers + place)
    gap, force, floor = wall_contacts(own, assembly.system)
    floors = {"ball_floor_force": (("time", "ball"), floor)} if assembly.system.free_balls["floor"].any() else {}
    return {
        "ball_x": (("time", "ball"), z.real),
        "ball_y": (("time", "ball"), z.imag),
        "ball_gap": (("time", "ball"), gap),
        "ball_spin": (("time", "ball"), own[..., BALL_SPIN] + states[:, SPEED, None]),
        "ball_normal_force": (("time", "ball"), force),
        **floors,
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


def in_order(ring: Matrix, written: int) -> Matrix:
    """The entries of a ring in the order of time."""
    size = ring.shape[0]
    return ring[:written] if written <= size else np.roll(ring, -(written % size), axis=0)
