"""What a result says of planes, stations and supports: deflections, unbalance against balls, forces."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.assembly.gauges import desk_for
from autobalancer.assembly.place_response import without_balancing
from autobalancer.assembly.places import Places, turning_mass
from autobalancer.assembly.resolved.balls import ball_states
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.measures.gauges import HELD, Gauges, Seen
from autobalancer.kernels.measures.limits import FASTEST, UNKNOWN
from autobalancer.kernels.system import Matrix
from autobalancer.results.places import sizes


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


def over_time(seen: Seen, places: Places) -> dict[str, Any]:
    """Deflection, unbalance and balls of each plane, and force on each support, over time."""
    found = _forces("", "time", seen)
    if places.planes:
        z = seen.z[:, : len(places.planes)]
        found |= {"plane_x": (("time", "plane"), z.real), "plane_y": (("time", "plane"), z.imag)}
        found |= _unbalances("", "time", seen)
    return found


def over_turns(seen: Seen, places: Places) -> dict[str, Any]:
    """The same over the last revolutions, with deflection and velocity of all places."""
    both = ("turn", "place")
    found = {
        "turn_place_x": (both, seen.z.real),
        "turn_place_y": (both, seen.z.imag),
        "turn_place_vx": (both, seen.v.real),
        "turn_place_vy": (both, seen.v.imag),
        **_forces("turn_", "turn", seen),
    }
    if places.planes:
        found |= _unbalances("turn_", "turn", seen)
        left = sizes(seen.wanted + seen.held)
        found |= {
            "turn_plane_residual": (("turn", "plane"), left),
            "turn_unbalance": ("turn", sizes(seen.unbalance[:, 0])),
            "turn_residual_unbalance": ("turn", sizes(seen.left[:, 0])),
        }
    return found


def seen_at(states: Matrix, assembly: Assembly, gauges: Gauges) -> Seen:
    """What states say of places, planes and supports; the time stands first in each row."""
    from autobalancer.kernels.measures.seen import see

    desk = desk_for(gauges, states.shape[0])
    see(assembly.system, gauges, np.ascontiguousarray(states), 0, states.shape[0], 1, desk)
    return desk.seen


def at_the_end(time: float, speed: float, assembly: Assembly, places: Places, gauges: Gauges) -> dict[str, Any]:
    """What the machine would do at its last speed with its balls held, unless it is shaken; and how it sags at rest."""
    sag = {"rotor_sag": ("place", np.abs(places.sag))} if places.sag.any() else {}
    if gauges.scalars[HELD] == UNKNOWN or not abs(speed) < FASTEST:
        return sag
    vibration, force = without_balancing(assembly, places, gauges, time, speed)
    if places.rubber_rows.size and np.isnan(vibration).all():
        return sag  # its circles would be ellipses, for which the stiffness of rubber is not known
    return {**sag, "vibration_without_balls": ("place", vibration), "force_without_balls": ("support", force)}


def mass_attributes(places: Places) -> dict[str, float]:
    """Mass of all that turns, to which an unbalance is compared."""
    return {"turning_mass": turning_mass(places)}


def ball_states_of(states: Matrix, assembly: Assembly) -> Any:
    """States of resolved balls in their races, (T, n, ...)."""
    return ball_states(states, assembly.system, assembly.places.shape[2])


def _unbalances(prefix: str, dimension: str, seen: Seen) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, vector in (("unbalance", seen.wanted), ("balls", seen.held)):
        found[f"{prefix}plane_{name}"] = ((dimension, "plane"), sizes(vector))
        found[f"{prefix}plane_{name}_angle_in_rotor"] = ((dimension, "plane"), np.angle(vector))
    return found


def _forces(prefix: str, dimension: str, seen: Seen) -> dict[str, Any]:
    return {
        f"{prefix}support_force_x": ((dimension, "support"), seen.force.real),
        f"{prefix}support_force_y": ((dimension, "support"), seen.force.imag),
    }
