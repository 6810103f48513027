"""Rotor models as matrices; :func:`lateral_model` and :func:`rows_at` are the ways in."""

from __future__ import annotations

import cmath
from dataclasses import dataclass, replace
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import numpy as np

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.assembly.drive_train import unbalance_factor
from autobalancer.assembly.rotors.equivalent_stiffness import hard_places
from autobalancer.assembly.rotors.lateral_model import LateralModel, Rows, matrices
from autobalancer.cache import remembered
from autobalancer.catalog.resolve import planar_rotor, resolve
from autobalancer.errors import MachineError
from autobalancer.machine import Machine, PlanarRotor, RigidRotor, Unbalance


def rotor_key(machine: Machine) -> tuple[Any, ...]:
    """All that the matrices of a rotor without balls depend on."""
    rotor = machine.rotor
    loose = isinstance(rotor, PlanarRotor) and not rotor.settled  # springs that follow from a critical speed with balls
    return rotor, machine.gravity, machine.axis, machine.balancers if loose else None


def places_key(machine: Machine) -> tuple[Any, ...]:
    """All that its places depend on besides."""
    return machine.stations, tuple((balancer.station, balancer.name) for balancer in machine.balancers)


def _with_balls_key(machine: Machine, model: LateralModel) -> tuple[Any, ...]:
    balls = tuple((ball.balancer, ball.effective_mass) for ball in resolve(machine))
    return model, *places_key(machine), balls


@remembered(8, by=rotor_key)
def lateral_model(machine: Machine) -> LateralModel:
    """The matrices of a machine's rotor without balls, in small motions about the place where it rests.

    Raises
    ------
    MachineError
        If the rotor is not possible as described: disconnected, without mass, a place that does not exist.
    """
    # the rotor with the stiffness that its bearings add where it rests
    model = spring_model(machine)
    more = np.zeros_like(model.mass)
    for place in hard_places(machine, model):
        more += place.rows.T @ place.stiffness @ place.rows
    return replace(model, stiffness=model.stiffness + more) if more.any() else model


@remembered(8, by=rotor_key)
def spring_model(machine: Machine) -> LateralModel:
    """The same without what its bearings become stiffer by, which a run adds as a force."""
    rotor = planar_rotor(machine) if isinstance(machine.rotor, PlanarRotor) else machine.rotor
    return matrices(rotor, float(machine.gravity) if machine.axis == "vertical" else 0.0)


def rows_at(machine: Machine, model: LateralModel, place: float | str | None, *path: str | int) -> Rows:
    """The rows of a place: a position, the name of a station, or ``None``; ``path`` names the key in errors."""
    body = None
    if isinstance(place, str):
        items = [i for i, station in enumerate(machine.stations) if station.name == place]
        if not items:
            known = ", ".join(repr(station.name) for station in machine.stations) or "none"
            raise MachineError.of("Machine", [(path, f"no station is named {place!r}; there is {known}")])
        station = machine.stations[items[0]]
        place, body, path = float(station.position), station.body, ("stations", items[0])
    try:
        return model.axis.rows(place, body)
    except ValueError as reason:
        raise MachineError.of("Machine", [(path, str(reason))]) from None


def station_rows(machine: Machine, model: LateralModel) -> dict[str, Rows]:
    """Rows of all named stations."""
    return {station.name: rows_at(machine, model, station.name) for station in machine.stations}


def balancer_rows(machine: Machine, model: LateralModel) -> list[Rows]:
    """Rows of each balancer's plane, in order."""
    return [rows_at(machine, model, b.station, "balancers", i, "station") for i, b in enumerate(machine.balancers)]


def reference(machine: Machine, model: LateralModel) -> tuple[str, Rows]:
    """The place whose deflection is *the* deflection of the machine, and its name.

    It is the plane of the first balancer, else the first station, else the only disk or body, else the middle of the rotor.
    """
    if machine.balancers:
        first = machine.balancers[0]
        name = first.station if isinstance(first.station, str) else first.name or "balancer 1"
        return name, balancer_rows(machine, model)[0]
    if machine.stations:
        return machine.stations[0].name, rows_at(machine, model, machine.stations[0].name)
    if len(getattr(machine.rotor, "disks", ())) > 1:  # none of them is the one
        line = model.axis.line()
        middle = 0.5 * (line[0][0] + line[-1][0])
        return "middle of the rotor", min(line, key=lambda place: abs(place[0] - middle))[1]
    return "rotor", rows_at(machine, model, None, "balancers")


def unbalance_shape(machine: Machine, model: LateralModel, number: int) -> Complexes:
    """The load of one unbalance at factor one, (pairs,) complex in the rotor: forces are w^2 Re, Im (load e^(i theta))."""
    unbalance: Unbalance = machine.unbalances[number]
    rows = rows_at(machine, model, unbalance.station, "unbalances", number, "station")
    vector, shape = unbalance.vector, rows.deflection
    if unbalance.is_couple:
        vector, shape = couple_vector(machine, number), rows.slope
    return np.asarray(vector * shape, np.complex128)


def couple_vector(machine: Machine, number: int) -> complex:
    """The couple, or (J_t - J_p) chi, of one unbalance at factor one, kg m^2, in the rotor; 0 of a point unbalance."""
    unbalance = machine.unbalances[number]
    size = float(unbalance.couple or 0.0)
    if unbalance.misalignment is not None:
        rotor = machine.rotor
        assert isinstance(rotor, RigidRotor)
        size = float(unbalance.misalignment) * float(rotor.transverse_inertia - rotor.polar_inertia)
    return cmath.rect(size, unbalance.angle)


def unbalance_load(machine: Machine, model: LateralModel, time: float = np.inf) -> Complexes:
    """The resultant load of all unbalances at a time, by default after all schedules; (pairs,)."""
    total = np.zeros(model.pairs, np.complex128)
    for number, unbalance in enumerate(machine.unbalances):
        total += unbalance_factor(unbalance, time) * unbalance_shape(machine, model, number)
    return total


@remembered(8, by=_with_balls_key)
def with_ball_mass(machine: Machine, model: LateralModel) -> LateralModel:
    """The model with the (effective) masses of all balls fixed to the axis in the planes of their balancers."""
    mass, total = model.mass.copy(), model.total_mass
    both = [model.both(row.deflection[None]) for row in balancer_rows(machine, model)]
    for ball in resolve(machine):
        mass += ball.effective_mass * both[ball.balancer].T @ both[ball.balancer]
        total += ball.effective_mass
    return replace(model, mass=mass, total_mass=total)


def rows_matrix(rows: list[Rows]) -> Matrix:
    """Deflection rows one above the other, (P, pairs)."""
    return np.array([row.deflection for row in rows]).reshape(len(rows), -1 if rows else 0)


# The planes of the balancers: where they are, what they are called, and what their balls have to balance.


@dataclass(frozen=True)
class Planes:
    """Balancers at the same place of the axis share a plane."""

    names: tuple[str, ...]  # (P,)
    rows: tuple[Rows, ...]  # (P,)
    of_balancer: tuple[int, ...]  # plane of each balancer, from 0


def planes_of(machine: Machine, model: LateralModel) -> Planes:
    """The planes of a machine, named by their station, else by their first balancer, else by its number."""
    names: list[str] = []
    rows: list[Rows] = []
    place: list[int] = []
    for number, (balancer, row) in enumerate(zip(machine.balancers, balancer_rows(machine, model), strict=True), 1):
        same = [i for i, other in enumerate(rows) if np.array_equal(other.deflection, row.deflection)]
        if not same:
            rows.append(row)
            name = balancer.station if isinstance(balancer.station, str) else balancer.name or f"plane {number}"
            names.append(name if name not in names else f"{name} ({number})")
        place.append(same[0] if same else len(rows) - 1)
    if isinstance(machine.rotor, PlanarRotor):
        names = ["rotor"] * len(names)
    return Planes(tuple(names), tuple(rows), tuple(place))


def least_moments(host: Complexes, wanted: Complexes, capability: Floats) -> Complexes:
    """Moments s with ``host`` s = ``wanted``, (..., P); of many, those that take the least share of the capabilities.

    ``host`` is (..., Q, P) and ``wanted`` (..., Q).
    """
    share = np.asarray(capability, np.float64)
    share = np.where(share > 0.0, share, 1e-6 * share.max(initial=0.0) or 1.0)  # a full race can balance nothing
    inverse = np.linalg.pinv(host * share, rcond=1e-11)
    return np.asarray(share * (inverse @ wanted[..., None])[..., 0], np.complex128)


for _file in iter_modules(__path__):  # a kind of rotor registers its matrices when its file is imported
    import_module(f"{__name__}.{_file.name}")
