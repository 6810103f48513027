"""What a run says of places: planes of balancers, stations and supports, in the coordinates of its state."""

from __future__ import annotations

import cmath
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from autobalancer.assembly.guided import ball_inertia
from autobalancer.assembly.reduced_rotor import spatial_parts
from autobalancer.assembly.rotors import (
    LateralModel,
    lateral_model,
    places_key,
    reference,
    rotor_key,
    spring_model,
    station_rows,
    with_ball_mass,
)
from autobalancer.assembly.rotors.equivalent_stiffness import mounts
from autobalancer.assembly.rotors.grounds import Ground, carried, grounds, large_motions, sag
from autobalancer.assembly.rotors.hardening import hard_places
from autobalancer.assembly.rotors.lateral_model import Complexes, Floats, Matrix
from autobalancer.assembly.rotors.planes import Planes, planes_of
from autobalancer.assembly.rotors.reduction import Reduction, circular
from autobalancer.assembly.system import Assembly, assemble, assemble_general, total_mass
from autobalancer.cache import remembered
from autobalancer.catalog.resolve import Ball, capability_of, resolve, settled
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, X, Y
from autobalancer.machine import Machine, MultibodyRotor, PlanarRotor, Unbalance

SAME = 1e-12  # rows that differ less are those of one place


@dataclass(frozen=True)
class Places:
    """Over R coordinates of the state; every row is a pair along x and y."""

    planes: tuple[str, ...]  # (P,)
    plane_of_ball: tuple[int, ...]  # (n,) from 0
    names: tuple[str, ...]  # (L,) planes, then stations and supports where none of those before is
    kinds: tuple[str, ...]  # (L,) plane, reference, station or support
    rows: Matrix  # (L, 2, R) deflections
    supports: tuple[str, ...]  # (S,)
    sag: Complexes  # (L,) of the rotor without balls under its weight, x + i y in m; deflections count from there
    weight: Matrix  # (S, 2) of the rotor without balls, N
    speeds: Floats  # (k,) of the tables
    stiffness: Matrix  # (k, S, 2, R) rows of the forces on the supports
    damping: Matrix  # (k, S, 2, R)
    run_stiffness: Matrix  # (k, S, 2, R) the same in a run, without the elements of rubber ...
    run_damping: Matrix  # (k, S, 2, R)
    rubber_rows: Matrix  # (S, 2, 2 M) ... which give forces for those of all M pieces of rubber
    hard_rows: Matrix  # (S, 2, 2 H) the same for the forces of all H bearings that become stiffer
    machine: Machine
    model: LateralModel  # with the mass of the balls
    basis: Matrix  # (N, R)
    capability: Floats  # (P,) of the balls, kg m
    centers: Complexes  # (R,) load of the balls spread evenly over their races
    center_loads: Complexes  # (pairs,) the same over the coordinates of the model along x


class _Seen(NamedTuple):
    """What of the places depends on the rotor and the coordinates of a run only; see :class:`Places`."""

    planes: Planes
    names: tuple[str, ...]
    kinds: tuple[str, ...]
    rows: Matrix
    supports: tuple[str, ...]
    sag: Complexes
    weight: Matrix
    stiffness: Matrix
    damping: Matrix
    run_stiffness: Matrix
    run_damping: Matrix
    rubber_rows: Matrix
    hard_rows: Matrix


def places_of(machine: Machine, assembly: Assembly) -> Places:
    """The places of an assembled machine."""
    bare = spring_model(machine)
    model = with_ball_mass(machine, lateral_model(machine))
    basis = assembly.reduction.basis if assembly.reduction is not None else np.eye(model.size)
    seen = _seen(machine, bare, assembly.reduction)
    planes = seen.planes
    centers = sum(
        (
            np.asarray(moment * planes.rows[planes.of_balancer[number]].deflection, np.complex128)
            for number, moment in center_moments(machine, assembly.balls).items()
        ),
        np.zeros(model.pairs, np.complex128),
    )
    plane = tuple(planes.of_balancer[ball.balancer] for ball in assembly.balls)
    of_plane = [[b for b, p in zip(assembly.balls, plane, strict=True) if p == i] for i in range(len(planes.names))]
    return Places(
        planes=planes.names,
        plane_of_ball=plane,
        speeds=bare.speeds,
        machine=machine,
        model=model,
        basis=basis,
        capability=np.array([capability_of(balls) for balls in of_plane], np.float64),
        centers=basis.T @ circular(model, centers),
        center_loads=centers,
        **{name: getattr(seen, name) for name in _Seen._fields[1:]},
    )


@remembered(8, by=lambda machine, bare, small: (*places_key(machine), *rotor_key(machine), bare, small and small.basis))
def _seen(machine: Machine, bare: LateralModel, small: Reduction | None) -> _Seen:
    basis = np.eye(bare.size) if small is None else small.basis
    planes, stations = planes_of(machine, bare), station_rows(machine, bare)
    result = grounds(machine, bare)
    rows = {name: bare.both(row.deflection[None]) for name, row in zip(planes.names, planes.rows, strict=True)}
    if not rows:
        first, place = reference(machine, bare)
        rows[first] = bare.both(place.deflection[None])
    kinds = ["plane"] * len(planes.names) or ["reference"]
    others = [("station", name, bare.both(row.deflection[None])) for name, row in stations.items()]
    for kind, name, row in [*others, *(("support", ground.name, ground.row) for ground in result)]:
        if not any(np.abs(row - other).max() <= SAME for other in rows.values()):
            rows[name if name not in rows else f"{kind} {name}"] = row
            kinds.append(kind)
    pull = float(machine.gravity) if machine.axis == "horizontal" else 0.0
    rest = sag(bare, pull)
    rubber = mounts(machine, bare)
    runs = [large_motions(machine, bare, ground, rubber) for ground in result]

    def over_speeds(matrices: Iterable[Matrix]) -> Matrix:
        shape = (len(result), bare.speeds.size, 2, basis.shape[1])
        return np.array([matrix @ basis for matrix in matrices]).reshape(shape).swapaxes(0, 1)

    return _Seen(
        planes=planes,
        names=tuple(rows),
        kinds=tuple(kinds),
        rows=np.array([row @ basis for row in rows.values()]),
        supports=tuple(ground.name for ground in result),
        sag=np.array([row @ rest @ (1.0, 1j) for row in rows.values()]),
        weight=_weights(bare, result, pull),
        stiffness=over_speeds(ground.stiffness for ground in result),
        damping=over_speeds(ground.damping for ground in result),
        run_stiffness=over_speeds(run[0] for run in runs),
        run_damping=over_speeds(run[1] for run in runs),
        rubber_rows=np.array([run[2] for run in runs]).reshape(len(result), 2, 2 * len(rubber)),
        hard_rows=carried(bare, result, hard_places(machine, bare)),
    )


def _weights(model: LateralModel, grounds: tuple[Ground, ...], gravity: float) -> Matrix:
    """Force of the rotor's weight without balls on each support, (S, 2) N; ``gravity`` acts along -y."""
    rest = sag(model, gravity)
    return np.array([ground.stiffness[0] @ rest for ground in grounds]).reshape(len(grounds), 2)


def turning_mass(places: Places) -> float:
    """Mass of all that turns, balls included, kg."""
    rotor = places.machine.rotor
    if isinstance(rotor, MultibodyRotor):
        return places.model.total_mass - sum(float(body.mass) for body in rotor.bodies if not body.rotating)
    return places.model.total_mass


def coordinates(states: Matrix, assembly: Assembly) -> tuple[Matrix, Matrix]:
    """Coordinates of the rotor in space and their velocities, (T, R) each."""
    q, v = in_frame(states, assembly)
    if assembly.system.rotating:
        q, v = _turned(q, states[:, THETA]), _turned(v, states[:, THETA])
    return q, v


def accelerations(states: Matrix, rates: Matrix, assembly: Assembly) -> Matrix:
    """Accelerations of the coordinates in space, (T, R); ``rates`` are the time derivatives of the states."""
    v, change = in_frame(states, assembly)[1], in_frame(rates, assembly)[1]
    if not assembly.system.rotating:
        return change
    quarter = np.stack([-v[:, 1::2], v[:, 0::2]], axis=2).reshape(v.shape)  # the axes turn with the rotor
    return _turned(change + states[:, SPEED, None] * quarter, states[:, THETA])


def deflections(places: Places, q: Matrix) -> Complexes:
    """x + i y of each place for coordinates or their velocities, (T, L)."""
    both = q @ places.rows.reshape(-1, q.shape[1]).T
    return np.asarray(both[:, 0::2] + 1j * both[:, 1::2])


def in_frame(states: Matrix, assembly: Assembly) -> tuple[Matrix, Matrix]:
    """Coordinates of the rotor and their velocities in space, (T, R) each, in the axes of the frame."""
    rest, size = BALLS + 2 * len(assembly.balls), assembly.places.shape[2] if assembly.general else 2
    q = np.column_stack([states[:, [X, Y]], states[:, rest : rest + size - 2]])
    return q, np.column_stack([states[:, [VX, VY]], states[:, rest + size - 2 : rest + 2 * size - 4]])


def _turned(pairs: Matrix, angle: Floats) -> Matrix:
    z = (pairs[:, 0::2] + 1j * pairs[:, 1::2]) * np.exp(1j * angle)[:, None]
    return np.stack([z.real, z.imag], axis=2).reshape(pairs.shape)


def table_shares(speeds: Floats, speed: Floats) -> list[Floats]:
    """Weight of each speed of the tables at these speeds: linear in between."""
    if speeds.size == 1:
        return [np.ones_like(speed)]
    return [np.interp(np.abs(speed), speeds, row) for row in np.eye(speeds.size)]


# The same machine without balancing: its balls are spread evenly over their races and held.
#
# Their mass stays on the rotor, so that critical speeds are those of the machine with balls. Their forces cancel but
# for those of races that are not centered.


def assemble_held(machine: Machine, rotating: bool | None = None) -> Assembly:
    """A machine with its balls held, ready to integrate.

    Raises
    ------
    MachineError
        As :func:`autobalancer.assembly.system.assemble`.
    """
    balls = resolve(machine)
    centers = tuple(
        Unbalance(moment=abs(moment), angle=cmath.phase(moment), station=machine.balancers[number].station)
        for number, moment in center_moments(machine, balls).items()
    )
    unbalances = (*machine.unbalances, *centers)
    machine = settled(machine)
    bare = machine.model_copy(update={"balancers": (), "unbalances": unbalances, "tilting_races": "deflection"})
    if isinstance(machine.rotor, PlanarRotor) and not machine.excitations:
        loaded = machine.rotor.model_copy(update={"mass": total_mass(machine, balls)})
        held = assemble(bare.model_copy(update={"rotor": loaded}), rotating=rotating)
    else:
        parts = spatial_parts(machine.model_copy(update={"unbalances": unbalances}), balls, held=True)
        held = assemble_general(bare, (), seed=0, rotating=rotating, contact=False, lags={}, parts=parts)
    inertia = held.system.polar_inertia + sum(ball_inertia(ball) for ball in balls)
    return Assembly(**{**vars(held), "system": held.system._replace(polar_inertia=inertia)})


def center_moments(machine: Machine, balls: tuple[Ball, ...]) -> dict[int, complex]:
    """Unbalance of the balls of each balancer (by its number from 0) when they are spread evenly, kg m, if there is one."""
    moments = dict.fromkeys(range(len(machine.balancers)), 0j)
    for ball in balls:
        moments[ball.balancer] += ball.effective_mass * ball.eccentricity
    return {number: moment for number, moment in moments.items() if moment != 0.0}
