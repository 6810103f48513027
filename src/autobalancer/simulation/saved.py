"""From saved states to a labeled result."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from autobalancer.arrays import Complexes
from autobalancer.assembly.drive_train import link_names, unbalance_factor
from autobalancer.assembly.places import Places, accelerations, desk_for, gauges_of, turning_mass, without_balancing
from autobalancer.assembly.resolved import ball_states
from autobalancer.assembly.rotors import couple_vector
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.derivatives import derivatives, normal_forces
from autobalancer.kernels.integrators.integrator_state import (
    EVENTS_SEEN,
    NEXT_BIN,
    NEXT_SAMPLE,
    NEXT_TURN,
    TIME,
    Memory,
)
from autobalancer.kernels.integrators.recording import Record
from autobalancer.kernels.measures.thresholds import FASTEST, UNKNOWN
from autobalancer.kernels.measures.workspace import HELD, MeasureInputs, Observables
from autobalancer.kernels.records import BALL_SPIN, BALL_X, BALL_Y, COUPLING
from autobalancer.kernels.system import BALLS, SPEED, THETA, Drive, Floats, Matrix, System, X, Y
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.results.answers.answer import provenance
from autobalancer.results.answers.run import Run
from autobalancer.results.labels import label
from autobalancer.results.time_series import directions, sizes
from autobalancer.simulation.steppers import equations

# From raw states to a labelled result.


def run_dataset(
    assembly: Assembly, places: Places, record: Record, state: Memory, events: list[str], attributes: dict[str, Any]
) -> xr.Dataset:
    """Label what a run wrote; whatever was not reached is cut off."""
    balls = assembly.balls
    data: dict[str, Any] = {}
    # which ball, in which race, and what it brings
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
    # samples: states at the times that were asked for, and all that follows from them
    gauges, count = gauges_of(assembly, places, centered=True), int(state.counts[NEXT_SAMPLE])
    if record.sample_times.size:
        coordinates["time"] = record.sample_times[:count]
        seen = observables_at(np.column_stack([record.sample_times[:count], record.samples[:count]]), assembly, gauges)
        data |= _states(record.samples[:count], seen, assembly)
        data |= _at_stations("", "time", record.samples[:count], assembly)
        data |= over_time(seen, places)
        data |= couple_unbalance(places, record.sample_times[:count])
        if assembly.rough and assembly.balls:  # guided balls on races with friction, shape, curved drag or excitation
            data |= on_races(record.samples[:count], record.sample_times[:count], assembly)
        data |= stored_in_forces(record.samples[:count], assembly)
        data |= over_links(record.samples[:count], assembly.system.drive)
    # the envelope: least and greatest deflection of each bin, and the balls at its end
    if record.bin_low.size:
        edges, low, high, states = whole_bins(record, state)
        angle, rate = ball_motion(states, assembly)
        coordinates["envelope_time"] = ("bin", 0.5 * (edges[:-1] + edges[1:]))
        coordinates["envelope_end"] = ("bin", edges[1:])
        data["envelope_low"], data["envelope_high"] = ("bin", low), ("bin", high)
        data["envelope_speed"] = ("bin", states[:, SPEED])
        data["envelope_ball_angle_in_rotor"] = (("bin", "ball"), angle)
        data["envelope_ball_speed_in_rotor"] = (("bin", "ball"), rate)
    # the last revolutions, at equal angles of the rotor
    if record.turn_states.shape[0]:
        turns = in_order(record.turn_states, int(state.counts[NEXT_TURN]))
        z = deflection(turns[:, 1:], assembly)
        coordinates["turn_time"] = ("turn", turns[:, 0])
        data["turn_rotor_angle"] = ("turn", turns[:, 1 + THETA])
        data["turn_speed"] = ("turn", turns[:, 1 + SPEED])
        data["turn_x"], data["turn_y"] = ("turn", z.real), ("turn", z.imag)
        data |= _at_stations("turn_", "turn", turns[:, 1:], assembly)
        data |= over_turns(observables_at(turns, assembly, gauges), places)
        data["turn_ball_angle_in_rotor"] = (("turn", "ball"), ball_motion(turns[:, 1:], assembly)[0])
    # what happened on the way
    if events:
        log = record.event_states[: int(state.counts[EVENTS_SEEN])]
        coordinates["event_time"] = ("event", log[:, 1])
        data["event_name"] = ("event", np.array([events[int(e)] for e in log[:, 0]], dtype=object))
        data["event_speed"] = ("event", log[:, 2 + SPEED])
        data["event_deflection"] = ("event", np.hypot(log[:, 2 + X], log[:, 2 + Y]))
        attributes = attributes | {"events_seen": record.event_seen.tolist(), "events_watched": events}
    # the end of the run, and where all of it comes from
    data |= at_the_end(float(state.clock[TIME]), float(state.state[SPEED]), assembly, places, gauges)
    dataset = label(Run(data, coordinates))
    dataset.attrs = {
        "title": f"Run of {attributes['machine_name']}",
        **provenance(),
        **attributes,
        "turning_mass": turning_mass(places),  # to which an unbalance is compared
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


def _states(states: Matrix, seen: Observables, assembly: Assembly) -> dict[str, Any]:
    z = deflection(states, assembly)
    angle, speed = ball_motion(states, assembly)
    unbalance, residual = seen.unbalance[:, 0], seen.left[:, 0]
    balls = ball_states(states, assembly.system, assembly.places.shape[2]) if assembly.resolved else None
    resolved = _resolved(states, balls, assembly) if assembly.resolved else {}
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
    from autobalancer.kernels.measures.observables import ball_motion as resolved_motion

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


# What a result says of planes, stations and supports: deflections, unbalance against balls, forces.


def place_names(places: Places) -> dict[str, Any]:
    """Coordinates of a result: names of planes, places and supports, and the plane of each ball."""
    place_names: dict[str, Any] = {
        "place": np.array(places.names, dtype=object),
        "place_kind": ("place", np.array(places.kinds, dtype=object)),
        "support": np.array(places.supports, dtype=object),
    }
    if places.planes:
        place_names["plane"] = np.array(places.planes, dtype=object)
        place_names["ball_plane"] = ("ball", np.array(places.plane_of_ball, np.int64) + 1)
    return place_names


def over_time(seen: Observables, places: Places) -> dict[str, Any]:
    """Deflection, unbalance and balls of each plane, and force on each support, over time."""
    forces = _forces("", "time", seen)
    if places.planes:
        z = seen.z[:, : len(places.planes)]
        forces |= {"plane_x": (("time", "plane"), z.real), "plane_y": (("time", "plane"), z.imag)}
        forces |= _unbalances("", "time", seen)
    return forces


def over_turns(seen: Observables, places: Places) -> dict[str, Any]:
    """The same over the last revolutions, with deflection and velocity of all places."""
    both = ("turn", "place")
    values = {
        "turn_place_x": (both, seen.z.real),
        "turn_place_y": (both, seen.z.imag),
        "turn_place_vx": (both, seen.v.real),
        "turn_place_vy": (both, seen.v.imag),
        **_forces("turn_", "turn", seen),
    }
    if places.planes:
        values |= _unbalances("turn_", "turn", seen)
        left, whole = seen.held + seen.wanted, seen.left[:, 0]
        values |= {
            "turn_plane_residual_x": (("turn", "plane"), left.real),
            "turn_plane_residual_y": (("turn", "plane"), left.imag),
            "turn_unbalance": ("turn", sizes(seen.unbalance[:, 0])),
            "turn_residual_x": ("turn", whole.real),
            "turn_residual_y": ("turn", whole.imag),
        }
    return values


def observables_at(states: Matrix, assembly: Assembly, gauges: MeasureInputs) -> Observables:
    """What states say of places, planes and supports; the time stands first in each row."""
    from autobalancer.kernels.measures.observables import observe

    desk = desk_for(gauges, states.shape[0])
    observe(assembly.system, gauges, np.ascontiguousarray(states), 0, states.shape[0], 1, desk)
    return desk.seen


def at_the_end(time: float, speed: float, assembly: Assembly, places: Places, gauges: MeasureInputs) -> dict[str, Any]:
    """What the machine would do at its last speed with its balls held, unless it is shaken; and how it sags at rest."""
    sag = {"rotor_sag": ("place", np.abs(places.sag))} if places.sag.any() else {}
    if gauges.scalars[HELD] == UNKNOWN or not abs(speed) < FASTEST:
        return sag
    vibration, force = without_balancing(assembly, places, gauges, time, speed)
    if places.rubber_rows.size and np.isnan(vibration).all():
        return sag  # its circles would be ellipses, for which the stiffness of rubber is not known
    return {**sag, "vibration_without_balls": ("place", vibration), "force_without_balls": ("support", force)}


def _unbalances(prefix: str, dimension: str, seen: Observables) -> dict[str, Any]:
    unbalances: dict[str, Any] = {}
    for name, vector in (("unbalance", seen.wanted), ("balls", seen.held)):
        unbalances[f"{prefix}plane_{name}"] = ((dimension, "plane"), sizes(vector))
        unbalances[f"{prefix}plane_{name}_angle_in_rotor"] = ((dimension, "plane"), np.angle(vector))
    return unbalances


def _forces(prefix: str, dimension: str, seen: Observables) -> dict[str, Any]:
    return {
        f"{prefix}support_force_x": ((dimension, "support"), seen.force.real),
        f"{prefix}support_force_y": ((dimension, "support"), seen.force.imag),
    }


# What a result says of the links between rotor and motor: twist, speed and torque of each.


def link_coordinates(machine: Machine) -> dict[str, Any]:
    """Names of what is behind each link."""
    names = link_names(machine)
    return {"link": np.array(names, dtype=object)} if names else {}


def over_links(states: Matrix, drive: Drive) -> dict[str, Any]:
    """Twist (rad), speed on the side of the motor (rad/s) and torque towards the rotor (N m), over time and link."""
    if not len(drive.links):
        return {}
    at = drive.links.state
    twist, speed = states[:, at], states[:, at + 1]
    torque, angle, before = np.zeros_like(twist), states[:, THETA], states[:, SPEED]
    for i, link in enumerate(drive.links):
        free, change = twist[:, i].copy(), speed[:, i].copy()
        if link.kind == COUPLING:
            turned = link.order * angle + link.phase
            free -= link.error * np.cos(turned)
            change -= (1.0 - link.error * link.order * np.sin(turned)) * before
            angle, before = angle + twist[:, i], speed[:, i]
        torque[:, i] = link.stiffness * free + link.damping * change
    both = ("time", "link")
    return {"twist": (both, twist), "link_speed": (both, speed), "link_torque": (both, torque)}


# What a result says of balls on real races: who rests, how hard each is pressed, and whether one would have left.


STANDARD_GRAVITY = 9.80665


def on_races(states: Matrix, times: Floats, assembly: Assembly) -> dict[str, Any]:
    """Normal force on each ball, N, and whether adherence holds it; variables over (time, ball)."""
    n = len(assembly.balls)
    force, work = np.zeros((times.size, n)), np.zeros(states.shape[1])
    times, states = np.ascontiguousarray(times), np.ascontiguousarray(states)
    normal_forces(equations(assembly).rates, assembly.system, times, states, work, force)
    holding = assembly.system.balls.adherence > 0.0
    rests = (states[:, BALLS + n : BALLS + 2 * n] == 0.0) & holding
    return {"ball_at_rest": (("time", "ball"), rests), "ball_normal_force": (("time", "ball"), force)}


def stored_in_forces(states: Matrix, assembly: Assembly) -> dict[str, Any]:
    """Potential energy of the forces on balls, J; a variable over time where any has one."""
    if not assembly.system.forces.energy.any():
        return {}
    from autobalancer.kernels.balls.ball_forces import force_energies

    energy = np.zeros(len(states))
    force_energies(assembly.system, np.ascontiguousarray(states), energy)
    return {"force_energy": ("time", energy)}


def wall_forces(states: Matrix, times: Floats, assembly: Assembly, places: Places) -> Matrix:
    """Normal force of a plain race on each guided ball, N, (times, balls): what its motion and its weight ask for."""
    balls, n, system = assembly.balls, len(assembly.balls), assembly.system
    rates = np.zeros_like(states)
    derivatives(equations(assembly).rates, system, np.ascontiguousarray(times), np.ascontiguousarray(states), rates)
    host = _deflections(places, accelerations(states, rates, assembly))[:, list(places.plane_of_ball)]
    speed, change = states[:, SPEED, None], rates[:, SPEED, None]
    angle, slip = states[:, BALLS : BALLS + n], states[:, BALLS + n : BALLS + 2 * n]
    outward = np.exp(-1j * (states[:, THETA, None] + angle))
    orbit = np.array([ball.orbit_radius for ball in balls])
    center = np.array([ball.eccentricity for ball in balls]) * (1j * change - speed**2) * np.exp(-1j * angle)
    felt = ((host + 1j * _gravity(places)) * outward + center).real - orbit * (speed + slip) ** 2
    return np.asarray(-np.array([ball.effective_mass for ball in balls]) * felt, np.float64)


def _deflections(places: Places, q: Matrix) -> Complexes:
    """x + i y of each place for coordinates or their velocities, (T, L)."""
    both = q @ places.rows.reshape(-1, q.shape[1]).T
    return np.asarray(both[:, 0::2] + 1j * both[:, 1::2])


def _gravity(places: Places) -> float:
    """Along -y, m/s^2."""
    return float(places.machine.gravity) if places.machine.axis == "horizontal" else 0.0


def left_race(times: Floats, states: Matrix, run: dict[str, Any], assembly: Assembly, places: Places) -> dict[str, Any]:
    """Attributes where the race had to pull at a guided ball, which it cannot: first ball, how many, its time, and when
    the last one is back to stay.

    A pull of less than a hundredth of the ball's weight is none: so much do balls feel on a rotor at standstill. Plain
    races are asked on a horizontal axis only, where the weight can take balls off.
    """
    if "ball_normal_force" in run and "ball_at_rest" in run:
        force = run["ball_normal_force"][1]
    elif (
        assembly.resolved
        or not (assembly.balls and times.size and _gravity(places))
        or places.machine.tilting_races == "full"
    ):
        return {}
    else:
        force = wall_forces(states, times, assembly, places)
    weight = STANDARD_GRAVITY * np.array([ball.effective_mass for ball in assembly.balls])
    pulled = force < -0.01 * weight
    if not pulled.any():
        return {}
    rows = np.flatnonzero(pulled.any(axis=1))
    when, last = int(rows[0]), int(rows[-1])
    ball, count = int(np.argmax(pulled[when])) + 1, int(pulled.any(axis=0).sum())
    pressed = np.flatnonzero(force[:when, ball - 1] >= 0.0)
    time = float(times[pressed[-1] + 1 if pressed.size else 0])
    back = np.flatnonzero((force[last:][:, pulled[last]] >= 0.0).all(axis=1))
    after = float(times[last + back[0] if back.size else -1])
    return {"left_race_ball": ball, "left_race_balls": count, "left_race_time": time, "left_race_end": after}


# What a result says of the axis: names of balancers, places along it, and couple unbalance.


def axis_coordinates(places: Places, assembly: Assembly) -> dict[str, Any]:
    """Names of the balancers of the balls, and where planes and stations are along the axis, m."""
    machine, balls = places.machine, assembly.balls
    axis_coordinates: dict[str, Any] = {}
    if balls:
        names = balancer_names(machine)
        axis_coordinates["balancer_name"] = ("ball", np.array([names[ball.balancer] for ball in balls], dtype=object))
    if isinstance(machine.rotor, PlanarRotor):
        return axis_coordinates
    if places.planes:
        first: dict[int, float | str | None] = {}
        for ball, plane in zip(balls, places.plane_of_ball, strict=True):
            first.setdefault(plane, machine.balancers[ball.balancer].station)
        where = [_position(machine, first.get(plane)) for plane in range(len(places.planes))]
        axis_coordinates["plane_position"] = ("plane", np.array(where, np.float64))
    if machine.stations:
        axis_coordinates["station_position"] = (
            "station",
            np.array([float(s.position) for s in machine.stations], np.float64),
        )
    return axis_coordinates


def couple_unbalance(places: Places, times: Floats) -> dict[str, Any]:
    """The couple unbalance that a machine is described with, over time; nothing if there is none."""
    total = np.zeros(times.size, np.complex128)
    for number, part in enumerate(places.machine.unbalances):
        if part.is_couple:
            factor = np.array([unbalance_factor(part, float(time)) for time in times])
            total += factor * couple_vector(places.machine, number)
    if not total.any():
        return {}
    return {
        "couple_unbalance": ("time", np.abs(total)),
        "couple_unbalance_angle_in_rotor": ("time", np.angle(total)),
    }


def balancer_names(machine: Machine) -> tuple[str, ...]:
    """What each balancer is called: its name, else that of its station if no other is there, else its number from 1."""
    stations = [balancer.station for balancer in machine.balancers]
    names = []
    for number, balancer in enumerate(machine.balancers):
        place = balancer.station if isinstance(balancer.station, str) and stations.count(balancer.station) == 1 else ""
        names.append(balancer.name or place or f"balancer {number + 1}")
    return tuple(names)


def _position(machine: Machine, place: float | str | None) -> float:
    """Where a place is along the axis, m; nan if that is not said."""
    if isinstance(place, str):
        return next(float(station.position) for station in machine.stations if station.name == place)
    return float("nan") if place is None else float(place)


# Where contact-resolved balls are between their walls, and how walls and floor press them, at saved states.


def wall_contacts(own: Any, system: System) -> tuple[Matrix, Matrix, Matrix]:
    """Distance from the outer wall (m, negative in contact), its normal force and that of the floor (N) on each ball; (times, n).

    ``own`` are the states of the balls, (times, n, BALL_STATES).
    """
    from autobalancer.kernels.balls.resolved_balls import contacts

    states = np.ascontiguousarray(own, np.float64)
    gap, force, floor = (np.zeros(states.shape[:2]) for _ in range(3))
    contacts(states, system, gap, force, floor)
    return gap, force, floor


# How far the fluid around a ball lagged behind its race at the saved states of a run.
