"""A rotor with stations in reduced coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from autobalancer.assembly.profile import corners
from autobalancer.assembly.rotors import (
    LateralModel,
    balancer_rows,
    lateral_model,
    places_key,
    reference,
    rotor_key,
    rows_matrix,
    spring_model,
    station_rows,
    unbalance_shape,
    with_ball_mass,
)
from autobalancer.assembly.rotors.critical import critical_speeds, natural_frequencies
from autobalancer.assembly.rotors.hardening import HardPlace, hard_places
from autobalancer.assembly.rotors.model import Complexes, Floats, Matrix, Rows
from autobalancer.assembly.rotors.mounts import Mount, mounts, sliding_model
from autobalancer.assembly.rotors.reduction import Reducer, Reduction, circular
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels.system import BALLS, SPEED, VX, VY, X, Y
from autobalancer.machine import (
    AsynchronousDrive,
    ConstantTorque,
    Hill,
    Machine,
    PrescribedSpeed,
    TargetTorque,
    TorqueTable,
)
from autobalancer.remembered import remembered


@dataclass(frozen=True)
class Parts:
    """A rotor in reduced coordinates r, q = basis r; the first two are the deflection at the reference place."""

    model: LateralModel
    sliding: LateralModel  # the model without the elements of rubber that softens with the amplitude
    mounts: tuple[Mount, ...]  # this rubber
    hard: tuple[
        HardPlace, ...
    ]  # bearings that become stiffer as they deflect, whose force is in none of both but at rest
    reduction: Reduction
    isotropic: bool
    places: Matrix  # (P, 2, R) deflection rows of the balancers
    slopes: Matrix  # (P, 2, R)
    mass: Matrix  # (R, R)
    shapes: Complexes  # (unbalances, R) load of each unbalance at factor one: forces w^2 Re(shape e^(i theta))
    reference: str
    stations: dict[str, Matrix]
    critical_speeds: tuple[float, ...]
    frequency: float  # of the machine, for tolerances

    @property
    def size(self) -> int:
        """Number of coordinates R."""
        return int(self.mass.shape[0])

    def small(self, matrix: Matrix) -> Matrix:
        """A matrix over q as one over r."""
        basis = self.reduction.basis
        return np.asarray(basis.T @ matrix @ basis)

    def length(self, balls: tuple[Ball, ...]) -> float:
        """Deflection of the free rotor under unbalance and balls, for tolerances."""
        loads = np.abs(np.linalg.solve(self.mass, self.shapes.T)[:2]).sum(axis=1).max() if self.shapes.size else 0.0
        mobile = float(np.linalg.inv(self.mass)[0, 0])
        eccentric = max((abs(ball.eccentricity) for ball in balls), default=0.0)
        return float(loads) + mobile * sum(ball.moment for ball in balls) + eccentric


class Frame(NamedTuple):
    """A rotor without balls and unbalances, and what is seen of it."""

    model: LateralModel
    sliding: LateralModel
    rubber: tuple[Mount, ...]
    hard: tuple[HardPlace, ...]
    alike: bool  # whether x and y are
    reference: str
    front: Rows
    rows: list[Rows]  # of the balancers
    named: dict[str, Rows]  # of the stations
    everything: Matrix  # all of them along x, (P, pairs)


class Small(NamedTuple):
    """The same in reduced coordinates, see :class:`Parts`."""

    places: Matrix
    slopes: Matrix
    mass: Matrix
    stations: dict[str, Matrix]


@remembered(8, by=lambda machine: (*rotor_key(machine), *places_key(machine)))
def _frame(machine: Machine) -> Frame:
    model = lateral_model(machine)
    rubber, hard = mounts(machine, model), hard_places(machine, model)
    name, front = reference(machine, model)
    rows, named = balancer_rows(machine, model), station_rows(machine, model)
    springs: tuple[Mount | HardPlace, ...] = (*rubber, *hard)
    everything = np.vstack([rows_matrix([front, *rows, *named.values()]), *_seen(springs, model.pairs)])
    return Frame(
        model, sliding_model(machine, spring_model(machine), rubber), rubber, hard,
        model.isotropic and all(one.isotropic(model.pairs) for one in springs), name, front, rows, named, everything,
    )  # fmt: skip


@remembered(8)
def _reducer(frame: Frame, model: LateralModel, top: float, wanted: int | None) -> Reducer:
    return Reducer(model, frame.front, frame.everything, top, wanted, isotropic=frame.alike)


@remembered(8)
def _small(frame: Frame, model: LateralModel, basis: Matrix) -> Small:
    def seen(row: Floats) -> Matrix:
        return np.asarray(model.both(row[None]) @ basis)

    count, size = len(frame.rows), basis.shape[1]
    return Small(
        places=np.array([seen(row.deflection) for row in frame.rows]).reshape(count, 2, size),
        slopes=np.array([seen(row.slope) for row in frame.rows]).reshape(count, 2, size),
        mass=basis.T @ model.mass @ basis,
        stations={key: seen(row.deflection) for key, row in frame.named.items()},
    )


@remembered(8)
def _sliding(sliding: LateralModel, mass: Matrix) -> LateralModel:
    return replace(sliding, mass=mass)


def spatial_parts(machine: Machine, balls: tuple[Ball, ...], held: bool = False) -> Parts:
    """Build, reduce and place everything but the time; if ``held`` the mass of the balls belongs to the rotor."""
    frame = _frame(machine)
    model = frame.model
    top = top_speed(machine)
    if top is not None and top > model.top_speed * (1.0 + 1e-12):
        raise MachineError(
            f"rotor: its tables over the speed end at {model.top_speed:.6g} rad/s, but the drive goes up to {top:.6g} rad/s; "
            "extend the tables"
        )
    loaded = with_ball_mass(machine, model)
    model = loaded if held else model
    critical = critical_speeds(loaded)
    still = critical or tuple(natural_frequencies(loaded).tolist())
    if top is None:
        top = min(2.0 * still[min(2, len(still) - 1)] if still else 1000.0, model.top_speed)
    loads = _loads(machine, model)
    reducer = _reducer(frame, model, max(top, 1.0), getattr(machine.rotor, "modes", None))
    reduction = reducer.carrying(sum(loads, np.zeros(model.pairs, np.complex128)))
    small = _small(frame, model, reduction.basis)
    return Parts(
        model=model,
        sliding=_sliding(frame.sliding, model.mass),
        mounts=frame.rubber,
        hard=frame.hard,
        reduction=reduction,
        isotropic=frame.alike,
        places=small.places,
        slopes=small.slopes,
        mass=small.mass,
        shapes=_shapes(model, reduction.basis, loads),
        reference=frame.reference,
        stations=small.stations,
        critical_speeds=critical,
        frequency=max(still, default=1.0),
    )


def _loads(machine: Machine, model: LateralModel) -> list[Complexes]:
    return [unbalance_shape(machine, model, number) for number in range(len(machine.unbalances))]


def _shapes(model: LateralModel, basis: Matrix, loads: list[Complexes]) -> Complexes:
    found = np.array([basis.T @ circular(model, load) for load in loads], np.complex128)
    return found.reshape(len(loads), basis.shape[1])


def length_scale(machine: Machine, parts: Parts, balls: tuple[Ball, ...]) -> float:
    """Size of the deflections of a run, m."""
    return max(parts.length(balls), abs(complex(*machine.start.deflection)), 1e-9)


def spatial_scales(parts: Parts, length: float, balls: int, size: int) -> tuple[Floats, Floats]:
    """Size of each of the ``size`` components of a state, and 1 where the tolerance grows with the component."""
    scale, growing = np.ones(size), np.zeros(size)
    where, fast = coordinate_places(parts.size, balls)
    scale[where], scale[fast] = length, length * parts.frequency
    growing[where] = growing[fast] = 1.0
    rest, own = BALLS + 2 * balls, 2 + 2 * parts.size + 2 * balls
    scale[SPEED] = scale[BALLS + balls : rest] = scale[own:] = parts.frequency
    return scale, growing


def coordinate_places(size: int, balls: int) -> tuple[list[int], list[int]]:
    """Where the coordinates of a rotor and their velocities are in a state."""
    rest = BALLS + 2 * balls
    return [X, Y, *range(rest, rest + size - 2)], [VX, VY, *range(rest + size - 2, rest + 2 * size - 4)]


def _seen(found: tuple[Mount | HardPlace, ...], pairs: int) -> list[Matrix]:
    """Rows over the coordinates along x of the places of rubber and bearings, which modes must move well too."""
    return [half[None] for m in found for one in m.rows for half in (one[:pairs], one[pairs : 2 * pairs]) if half.any()]


def top_speed(machine: Machine) -> float | None:
    """The greatest speed that the drive asks for, rad/s; None if it does not say."""
    drive = machine.drive
    if isinstance(drive, PrescribedSpeed):
        if isinstance(drive.profile, Hill):
            return max(abs(float(drive.profile.start)), abs(float(drive.profile.end)))
        return max(abs(speed) for _, speed in corners(drive.profile))
    if isinstance(drive, TorqueTable):
        return max(abs(float(speed)) for speed in drive.speed)
    if isinstance(drive, AsynchronousDrive):
        return abs(float(drive.synchronous_speed))
    damping = float(drive.damping)
    if isinstance(drive, ConstantTorque):
        return abs(float(drive.torque)) / damping if damping > 0.0 else None
    assert isinstance(drive, TargetTorque)
    gain = float(drive.gain)
    profile = drive.profile
    ends = [float(profile.start), float(profile.end)] if isinstance(profile, Hill) else [w for _, w in corners(profile)]
    return gain * max(map(abs, ends)) / damping if damping > 0.0 else None


def pulled(parts: Parts, x: float, y: float) -> Floats:
    """Coordinates r of the rotor pulled at its reference place to (x, y) by a static force there."""
    if x == 0.0 and y == 0.0:
        return np.zeros(parts.size)
    shape = np.linalg.solve(parts.small(parts.model.stiffness_at(0.0)), np.eye(parts.size)[:, :2])
    return np.asarray(shape @ np.linalg.solve(shape[:2], [x, y]))


def struck(parts: Parts, x: float, y: float) -> Floats:
    """Velocities of r of the rotor struck at its reference place, which moves at (x, y) afterwards."""
    shape = np.linalg.inv(parts.mass)[:, :2]
    return np.asarray(shape @ np.linalg.solve(shape[:2], [x, y]))


def turned(pairs: Floats, angle: float) -> Floats:
    """Coordinates in pairs (x, y) turned by an angle."""
    z = (pairs[0::2] + 1j * pairs[1::2]) * complex(math.cos(angle), math.sin(angle))
    return np.column_stack([z.real, z.imag]).ravel()
