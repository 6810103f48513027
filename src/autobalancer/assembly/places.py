"""What a run says of places: planes of balancers, stations and supports, in the coordinates of its state."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.profile import unbalance_factor
from autobalancer.assembly.rotors import LateralModel, lateral_model, station_rows, unbalance_shape, with_ball_mass
from autobalancer.assembly.rotors.grounds import grounds, weights
from autobalancer.assembly.rotors.model import Complexes, Floats, Matrix
from autobalancer.assembly.rotors.planes import least_moments, planes_of
from autobalancer.assembly.rotors.reduction import circular
from autobalancer.assembly.system import Assembly
from autobalancer.catalog.race_capability import capability_of
from autobalancer.kernels.system import BALLS, THETA, VX, VY, X, Y
from autobalancer.machine import Machine, PlanarRotor

AT_ONCE = 1_000_000  # entries of the dynamic stiffnesses that are solved together


@dataclass(frozen=True)
class Places:
    """Over R coordinates of the state; every row is a pair along x and y."""

    planes: tuple[str, ...]  # (P,)
    plane_of_ball: tuple[int, ...]  # (n,) from 0
    names: tuple[str, ...]  # (L,) planes, then the stations that are not among them, else the reference
    rows: Matrix  # (L, 2, R) deflections
    supports: tuple[str, ...]  # (S,)
    weight: Matrix  # (S, 2) of the rotor without balls, N
    speeds: Floats  # (k,) of the tables
    stiffness: Matrix  # (k, S, 2, R) rows of the forces on the supports
    damping: Matrix  # (k, S, 2, R)
    machine: Machine
    model: LateralModel  # with the mass of the balls
    basis: Matrix  # (N, R)
    capability: Floats  # (P,) of the balls, kg m


def places_of(machine: Machine, assembly: Assembly) -> Places:
    """The places of an assembled machine."""
    bare = lateral_model(machine)
    model = with_ball_mass(machine, bare)
    basis = assembly.reduction.basis if assembly.reduction is not None else np.eye(model.size)
    planes, stations = planes_of(machine, bare), station_rows(machine, bare)
    named = dict(zip(planes.names, planes.rows, strict=True))
    for name, row in stations.items():
        if not any(np.array_equal(row.deflection, other.deflection) for other in named.values()):
            named[name if name not in named else f"station {name}"] = row
    if named:
        rows = np.array([bare.both(row.deflection[None]) @ basis for row in named.values()])
    else:
        rows = np.eye(basis.shape[1])[None, :2]  # the reference place, which leads the state
    found = grounds(machine, bare)
    pull = float(machine.gravity) if machine.axis == "horizontal" else 0.0
    plane = tuple(planes.of_balancer[ball.balancer] for ball in assembly.balls)
    of_plane = [[b for b, p in zip(assembly.balls, plane, strict=True) if p == i] for i in range(len(planes.names))]
    shape = (len(found), bare.speeds.size, 2, basis.shape[1])
    return Places(
        planes=planes.names,
        plane_of_ball=plane,
        names=tuple(named) or (assembly.reference or "rotor",),
        rows=rows,
        supports=tuple(ground.name for ground in found),
        weight=weights(bare, found, pull),
        speeds=bare.speeds,
        stiffness=np.array([ground.stiffness @ basis for ground in found]).reshape(shape).swapaxes(0, 1),
        damping=np.array([ground.damping @ basis for ground in found]).reshape(shape).swapaxes(0, 1),
        machine=machine,
        model=model,
        basis=basis,
        capability=np.array([capability_of(balls) for balls in of_plane], np.float64),
    )


def coordinates(states: Matrix, assembly: Assembly) -> tuple[Matrix, Matrix]:
    """Coordinates of the rotor in space and their velocities, (T, R) each."""
    rest, size = BALLS + 2 * len(assembly.balls), assembly.places.shape[2] if assembly.general else 2
    q = np.column_stack([states[:, [X, Y]], states[:, rest : rest + size - 2]])
    v = np.column_stack([states[:, [VX, VY]], states[:, rest + size - 2 : rest + 2 * size - 4]])
    if assembly.system.rotating:
        q, v = _turned(q, states[:, THETA]), _turned(v, states[:, THETA])
    return q, v


def deflections(places: Places, q: Matrix) -> Complexes:
    """x + i y of each place for coordinates or their velocities, (T, L)."""
    both = q @ places.rows.reshape(-1, q.shape[1]).T
    return np.asarray(both[:, 0::2] + 1j * both[:, 1::2])


def support_forces(places: Places, speed: Floats, q: Matrix, v: Matrix) -> Complexes:
    """Force of the rotor on each support, its weight included, x + i y in N, (T, S)."""
    total = np.zeros((q.shape[0], len(places.supports), 2))
    for i, share in enumerate(_shares(places.speeds, speed)):
        if share.any():
            now = np.einsum("sdr,tr->tsd", places.stiffness[i], q) + np.einsum("sdr,tr->tsd", places.damping[i], v)
            total += share[:, None, None] * now
    total += places.weight
    return np.asarray(total[..., 0] + 1j * total[..., 1])


def plane_unbalances(places: Places, time: Floats, speed: Floats) -> Complexes:
    """The unbalance that the balls of each plane have to balance so that all planes rest, kg m in the rotor, (T, P).

    It is what the unbalances do at the planes at this speed, put into these planes; on a planar rotor their sum. nan at
    a critical speed of an undamped rotor.
    """
    loads = _loads(places, time)
    if isinstance(places.machine.rotor, PlanarRotor):
        return np.repeat(loads[:, :1], len(places.planes), axis=1)
    rows = places.rows[: len(places.planes)]
    found = np.empty((time.size, len(places.planes)), np.complex128)
    step = max(1, AT_ONCE // places.basis.shape[1] ** 2)
    for first in range(0, time.size, step):
        part = slice(first, first + step)
        dynamic = _dynamic_stiffness(places, speed[part])
        circles = rows[:, 0] - 1j * rows[:, 1]  # force of a unit vector that turns with the rotor
        forces = np.concatenate([np.tile(circles.T, (dynamic.shape[0], 1, 1)), loads[part, :, None]], axis=2)
        try:
            moved = 0.5 * circles.conj() @ np.linalg.solve(dynamic, forces)
            found[part] = least_moments(moved[:, :, :-1], moved[:, :, -1], places.capability)
        except np.linalg.LinAlgError:
            found[part] = np.nan
    return found


def _turned(pairs: Matrix, angle: Floats) -> Matrix:
    z = (pairs[:, 0::2] + 1j * pairs[:, 1::2]) * np.exp(1j * angle)[:, None]
    return np.stack([z.real, z.imag], axis=2).reshape(pairs.shape)


def _shares(speeds: Floats, speed: Floats) -> list[Floats]:
    """Weight of each speed of the tables at these speeds: linear in between."""
    if speeds.size == 1:
        return [np.ones_like(speed)]
    return [np.interp(np.abs(speed), speeds, row) for row in np.eye(speeds.size)]


def _loads(places: Places, time: Floats) -> Complexes:
    """Loads of all unbalances: forces are w^2 Re(load e^(i theta)), (T, R)."""
    total = np.zeros((time.size, places.basis.shape[1]), np.complex128)
    for number, part in enumerate(places.machine.unbalances):
        shape = places.basis.T @ circular(places.model, unbalance_shape(places.machine, places.model, number))
        fixed = part.schedule is None
        factor = np.ones(time.size) if fixed else np.array([unbalance_factor(part, float(t)) for t in time])
        total += factor[:, None] * shape
    return total


def _dynamic_stiffness(places: Places, speed: Floats) -> Complexes:
    """K + i w (C + w G) - w^2 M over the coordinates, with the balls on the rotor, (T, R, R)."""
    model, basis = places.model, places.basis
    w = speed[:, None, None]
    total = 1j * w**2 * (basis.T @ model.gyroscopic @ basis) - w**2 * (basis.T @ model.mass @ basis)
    for i, share in enumerate(_shares(model.speeds, speed)):
        small = basis.T @ model.stiffness[i] @ basis + 1j * w * (basis.T @ model.damping[i] @ basis)
        total = total + share[:, None, None] * small
    return np.asarray(total, np.complex128)
