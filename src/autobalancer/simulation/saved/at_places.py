"""What a result says of planes, stations and supports: deflections, unbalance against balls, forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.assembly.bearings.hardening import hardening_forces, has_hardening
from autobalancer.assembly.drive import unbalances_at
from autobalancer.assembly.place_response import plane_unbalances, without_balancing
from autobalancer.assembly.places import Places, coordinates, deflections, rubber_forces, support_forces, turning_mass
from autobalancer.assembly.resolved.balls import ball_states
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.records.resolved import BALL_X, BALL_Y
from autobalancer.kernels.system import BALLS, SPEED, Floats, Matrix


def place_names(places: Places) -> dict[str, Any]:
    """Coordinates of a result: names of planes, places and supports, and the plane of each ball."""
    found: dict[str, Any] = {
        "place": np.array(places.names, dtype=object),
        "place_kind": ("place", np.array(places.kinds, dtype=object)),
        "support": np.array(places.supports, dtype=object),
    }
    if places.planes:
        found["plane"] = np.array(places.planes, dtype=object)
        found["ball_plane"] = ("ball", np.array(places.plane_of_ball, np.int64) + 1)
    return found


FASTEST = 1e12  # rad/s; a run that came here is on its way out of all numbers


def over_time(states: Matrix, times: Floats, assembly: Assembly, places: Places) -> dict[str, Any]:
    """Deflection, unbalance and balls of each plane, and force on each support, over time."""
    q, v = coordinates(states, assembly)
    z = deflections(places, q)[:, : len(places.planes)]
    found = _forces("", "time", states, q, v, assembly, places)
    if places.planes:
        found |= {"plane_x": (("time", "plane"), z.real), "plane_y": (("time", "plane"), z.imag)}
        found |= _unbalances("", "time", states, times, assembly, places)
    return found


def over_turns(states: Matrix, times: Floats, assembly: Assembly, places: Places) -> dict[str, Any]:
    """The same over the last revolutions, with deflection and velocity of all places."""
    q, v = coordinates(states, assembly)
    z, rate, both = deflections(places, q), deflections(places, v), ("turn", "place")
    found = {
        "turn_place_x": (both, z.real),
        "turn_place_y": (both, z.imag),
        "turn_place_vx": (both, rate.real),
        "turn_place_vy": (both, rate.imag),
        **_forces("turn_", "turn", states, q, v, assembly, places),
    }
    if places.planes:
        found |= _unbalances("turn_", "turn", states, times, assembly, places)
        unbalance = unbalances_at(assembly.system, times)
        left = unbalance + ball_moments(states, assembly).sum(axis=1)
        found |= {"turn_unbalance": ("turn", np.abs(unbalance)), "turn_residual_unbalance": ("turn", np.abs(left))}
    return found


def at_the_end(time: float, speed: float, assembly: Assembly, places: Places) -> dict[str, Any]:
    """What the machine would do at its last speed with its balls held, unless it is shaken; and how it sags at rest."""
    sag = {"rotor_sag": ("place", np.abs(places.sag))} if places.sag.any() else {}
    unknown = places.machine.excitations or has_hardening(places.machine)
    if not assembly.balls or unknown or not abs(speed) < FASTEST:
        return sag
    vibration, force = without_balancing(places, time, speed)
    if places.rubber_rows.size and np.isnan(vibration).all():
        return sag  # its circles would be ellipses, for which the stiffness of rubber is not known
    return {**sag, "vibration_without_balls": ("place", vibration), "force_without_balls": ("support", force)}


def mass_attributes(places: Places) -> dict[str, float]:
    """Mass of all that turns, to which an unbalance is compared."""
    return {"turning_mass": turning_mass(places)}


def ball_states_of(states: Matrix, assembly: Assembly) -> Any:
    """States of resolved balls in their races, (T, n, ...)."""
    return ball_states(states, assembly.system, assembly.places.shape[2])


def ball_moments(states: Matrix, assembly: Assembly) -> Any:
    """Effective mass times place in the rotor of each ball, race centers included, complex kg m, (T, n)."""
    balls, n = assembly.balls, len(assembly.balls)
    mass = np.array([ball.effective_mass for ball in balls], np.float64)
    center = np.array([ball.eccentricity for ball in balls], np.complex128)
    if assembly.resolved:
        own = ball_states_of(states, assembly)
        return mass * (center + own[..., BALL_X] + 1j * own[..., BALL_Y])
    moment = np.array([ball.moment for ball in balls], np.float64)
    return mass * center + moment * np.exp(1j * states[:, BALLS : BALLS + n])


def forces_on_supports(states: Matrix, q: Matrix, v: Matrix, assembly: Assembly, places: Places) -> Any:
    """Force of the rotor on each support with all rubber and bearings, x + i y in N, (T, S)."""
    force = support_forces(places, states[:, SPEED], q, v, rubber_forces(states, assembly))
    pushed = hardening_forces(assembly.hard, assembly.system.bearings.rows[:, : q.shape[1]], q)
    return force + np.einsum("sdh,th->tsd", places.hard_rows, pushed) @ (1.0, 1j)


def _unbalances(
    prefix: str, dimension: str, states: Matrix, times: Floats, assembly: Assembly, places: Places
) -> dict[str, Any]:
    wanted = plane_unbalances(places, times, states[:, SPEED])
    balls = np.zeros_like(wanted)
    np.add.at(balls.T, np.array(places.plane_of_ball, np.int64), ball_moments(states, assembly).T)
    found: dict[str, Any] = {}
    for name, vector in (("unbalance", wanted), ("balls", balls)):
        found[f"{prefix}plane_{name}"] = ((dimension, "plane"), np.abs(vector))
        found[f"{prefix}plane_{name}_angle_in_rotor"] = ((dimension, "plane"), np.angle(vector))
    return found


def _forces(
    prefix: str, dimension: str, states: Matrix, q: Matrix, v: Matrix, assembly: Assembly, places: Places
) -> dict[str, Any]:
    force = forces_on_supports(states, q, v, assembly, places)
    return {
        f"{prefix}support_force_x": ((dimension, "support"), force.real),
        f"{prefix}support_force_y": ((dimension, "support"), force.imag),
    }
