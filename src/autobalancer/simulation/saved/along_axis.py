"""What a result says of the axis: names of balancers, places along it, and couple unbalance."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.assembly.places import Places
from autobalancer.assembly.profile import unbalance_factor
from autobalancer.assembly.rotors import couple_vector
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.system import Floats
from autobalancer.machine import Machine, PlanarRotor


def axis_coordinates(places: Places, assembly: Assembly) -> dict[str, Any]:
    """Names of the balancers of the balls, and where planes and stations are along the axis, m."""
    machine, balls = places.machine, assembly.balls
    found: dict[str, Any] = {}
    if balls:
        names = balancer_names(machine)
        found["balancer_name"] = ("ball", np.array([names[ball.balancer] for ball in balls], dtype=object))
    if isinstance(machine.rotor, PlanarRotor):
        return found
    if places.planes:
        first: dict[int, float | str | None] = {}
        for ball, plane in zip(balls, places.plane_of_ball, strict=True):
            first.setdefault(plane, machine.balancers[ball.balancer].station)
        where = [_position(machine, first.get(plane)) for plane in range(len(places.planes))]
        found["plane_position"] = ("plane", np.array(where, np.float64))
    if machine.stations:
        found["station_position"] = ("station", np.array([float(s.position) for s in machine.stations], np.float64))
    return found


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
