"""The plane or the stations of a machine at its largest unbalance, and what may be wrong with them."""

from __future__ import annotations

import math

import numpy as np

from autobalancer.assembly.forces.rows import has_forces
from autobalancer.assembly.profile import largest_unbalance
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.results.number_text import moment_text
from autobalancer.stability.host.planar import Plane, plane
from autobalancer.stability.host.reduction import reduced
from autobalancer.stability.host.stations import Stations, in_plane, stations
from autobalancer.stability.states.stations import required

Described = Plane | Stations


SEARCHED = 40.0  # the exact border is sought up to so many times the critical speed


def described(machine: Machine, unbalance: complex | float | None, highest: float | None = None) -> Described:
    """The numbers of any machine with an unbalance, see :func:`plane_of`; for speeds up to ``highest``, rad/s."""
    if isinstance(machine.rotor, PlanarRotor):
        vector = _vector(machine, unbalance)
        return in_plane(machine, vector) if has_forces(machine) else plane(machine, vector)
    st = stations(machine, unbalance, largest=True)
    return reduced(st, max(highest_searched(st), highest or 0.0))


def highest_searched(p: Described) -> float:
    """Up to where the exact border is sought, rad/s; not beyond the tables of the supports."""
    if isinstance(p, Stations):
        return float(min(SEARCHED * p.scale_speed, p.model.top_speed))
    return SEARCHED * math.sqrt(max(p.stiffness) / p.mass)


def plane_of(machine: Machine, unbalance: complex | float | None) -> Plane:
    """The plane with an unbalance; a mere size keeps the direction of the machine's largest one, the default."""
    return plane(machine, _vector(machine, unbalance))


def _vector(machine: Machine, unbalance: complex | float | None) -> complex:
    largest = largest_unbalance(machine)
    if unbalance is None:
        return largest
    value = complex(unbalance)
    if not (math.isfinite(value.real) and math.isfinite(value.imag)) or (
        not isinstance(unbalance, complex) and value.real < 0.0
    ):
        raise QuestionError(f"unbalance: given {unbalance!r}; must be a size not below zero, in kg m, or a vector")
    return value if isinstance(unbalance, complex) or largest == 0.0 else value * largest / abs(largest)


def lower_critical_speed(p: Described) -> float:
    """The lowest critical speed, rad/s: sqrt(k/M) of the softer direction; of a rotor without any its lowest frequency."""
    return p.scale_speed if isinstance(p, Stations) else math.sqrt(min(p.stiffness) / p.mass)


def why_no_state(p: Described) -> str:
    """Why a machine has no balanced state at any speed that was tried."""
    if isinstance(p, Stations) and p.forces is not None:
        return "no state was found in which the balls, with the forces on them, make the deflection smaller"
    if isinstance(p, Stations):
        return _why_no_rest(p)
    need, points = abs(p.unbalance), float(p.moment.sum())
    have = min(points, p.capability)
    if p.moment.size == 1:
        return "no balanced state: one ball alone balances only an unbalance of exactly its own moment"
    if np.any(p.offset != 0.0):
        return "no balanced state: the balls cannot make up for unbalance and eccentricity of the race"
    if need > have:
        return f"no balanced state: the balls can balance {moment_text(have, 4)} at most, the unbalance is {moment_text(need, 4)}"
    least = 2.0 * float(p.moment.max()) - points
    if need < least:
        sizes = f"{moment_text(least, 4)}, the unbalance is {moment_text(need, 4)}"
        return f"no balanced state: unequal balls always add up to {sizes}"
    return "no balanced state was found"


def _why_no_rest(st: Stations) -> str:
    """The same for several stations, from what they need well above the lowest critical speed."""
    if np.any(st.offset != 0.0):
        return "no balanced state: the balls cannot make up for unbalance and eccentricity of the races"
    speed = min(3.0 * st.scale_speed, st.model.top_speed)
    parts = []
    for place, (name, need) in enumerate(zip(st.names, np.abs(required(st, speed)).tolist(), strict=True)):
        have = float(st.capability[place])
        if need > have or int((st.station == place).sum()) == 1:
            parts.append(
                f"at {name!r} {moment_text(need, 4)} are needed at {speed:.4g} rad/s, the balls have {moment_text(have, 4)}"
            )
    return f"no balanced state: {'; '.join(parts)}" if parts else "no balanced state was found"


def service_speed(st: Stations, highest: float | None) -> float:
    """The speed for which a machine is judged, rad/s: the highest prescribed one, else three times the lowest critical one."""
    return min(3.0 * st.scale_speed if highest is None or highest <= 0.0 else highest, st.model.top_speed)
