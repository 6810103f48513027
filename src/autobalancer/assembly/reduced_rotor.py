"""A rotor with stations in reduced coordinates."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.assembly.drive_train import corners, unbalance_factor
from autobalancer.assembly.rotors import (
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
from autobalancer.assembly.rotors.critical import forward_whirls, natural_frequencies
from autobalancer.assembly.rotors.equivalent_stiffness import (
    HardPlace,
    Mount,
    central_force,
    hard_places,
    hardenings,
    mounts,
    sliding_model,
)
from autobalancer.assembly.rotors.lateral_model import LateralModel, Rows
from autobalancer.assembly.rotors.reduction import Reducer, Reduction, circular
from autobalancer.cache import remembered
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels.compiler.simd import LANES
from autobalancer.kernels.records import ELASTOPLASTIC, ELEMENT, ENDOCHRONIC, HARDENING, MAXWELL, RUBBER_MOUNT
from autobalancer.kernels.system import BALLS, SPEED, VX, VY, Bearings, Host, Work, X, Y
from autobalancer.kernels.system import Rubber as RubberRows
from autobalancer.machine import (
    AsynchronousDrive,
    ConstantTorque,
    Hardening,
    Hill,
    Machine,
    MultibodyRotor,
    PlanarRotor,
    PointJoint,
    PrescribedSpeed,
    Rubber,
    TargetTorque,
    TorqueTable,
)


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
    gyroscopic_shares: tuple[float, ...]  # of each of them
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
        model.isotropic and all(spring.isotropic(model.pairs) for spring in springs), name, front, rows, named, everything,
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
    # the rotor on its supports; does the drive go beyond their tables?
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
    # critical speeds with the balls, and up to where the reduced rotor must hold
    critical, shares = forward_whirls(loaded)
    still = critical or tuple(natural_frequencies(loaded).tolist())
    if top is None:
        top = min(2.0 * still[min(2, len(still) - 1)] if still else 1000.0, model.top_speed)
    # a basis of few coordinates that carries the motion at all places
    loads = [unbalance_shape(machine, model, number) for number in range(len(machine.unbalances))]
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
        gyroscopic_shares=shares,
        frequency=max(still, default=1.0),
    )


def _shapes(model: LateralModel, basis: Matrix, loads: list[Complexes]) -> Complexes:
    shapes = np.array([basis.T @ circular(model, load) for load in loads], np.complex128)
    return shapes.reshape(len(loads), basis.shape[1])


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
    return [half[None] for m in found for row in m.rows for half in (row[:pairs], row[pairs : 2 * pairs]) if half.any()]


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


def turned(pairs: Floats, angle: float) -> Floats:
    """Coordinates in pairs (x, y) turned by an angle."""
    z = (pairs[0::2] + 1j * pairs[1::2]) * complex(math.cos(angle), math.sin(angle))
    return np.column_stack([z.real, z.imag]).ravel()


# A rotor with stations as the numbers of kernels/host/linear.py.


def host_of(machine: Machine, parts: Parts, starts: Floats) -> tuple[Host, Work]:
    """The rotor of a machine, and room for its work; ``starts`` are those of the segments of its drive."""
    width, count = padded_size(parts.size), parts.places.shape[0]
    each = 4 if machine.tilting_races == "full" else 2
    inverse, matrices = _matrices(parts.sliding, parts.reduction.basis, parts.mass, parts.places, parts.slopes, each)
    host = Host(
        size=parts.size,
        width=width,
        stations=count,
        axial_gravity=axial_gravity(machine),
        loads=loads_of(machine, parts, inverse, starts, width),
        **matrices,
    )
    return host, _work(width, count * each, each)


@remembered(8)
def _matrices(
    model: LateralModel, basis: Matrix, mass: Matrix, places: Matrix, slopes: Matrix, each: int
) -> tuple[Matrix, dict[str, Matrix]]:
    """The inverse of the mass, and the matrices of a rotor with ``each`` rows at a station."""
    size, width = mass.shape[0], padded_size(mass.shape[0])
    inverse: Matrix = np.asarray(np.linalg.inv(mass), np.float64)
    stations = zip(places, slopes, strict=True)
    rows = np.concatenate([np.zeros((0, size)), *(np.concatenate(both[: each // 2]) for both in stations)])
    gyroscopic = basis.T @ model.gyroscopic @ basis

    def columns(matrix: Matrix) -> Matrix:
        return _wide(matrix.T, (width, width))  # row j is column j of the matrix

    return inverse, {
        "speeds": np.array(model.speeds, np.float64),
        "gyroscopic": columns(inverse @ gyroscopic),
        "damping": np.array([columns(inverse @ (basis.T @ c @ basis)) for c in model.damping]),
        "stiffness": np.array([columns(inverse @ (basis.T @ k @ basis)) for k in model.stiffness]),
        "spin": columns(0.5 * gyroscopic),
        "rows": _wide(rows, (places.shape[0] * each, width)),
        "reach": _wide(rows @ inverse, (places.shape[0] * each, width)),
        "mobility": np.ascontiguousarray(rows @ inverse @ rows.T),
    }


def _work(width: int, rows: int, each: int) -> Work:
    q, v, f, g, own = (np.zeros(width) for _ in range(5))
    one, two, push, arm, turn = (np.zeros(rows) for _ in range(5))
    return Work(q, v, f, g, own, np.zeros((rows, rows)), one, two, push, arm, turn, np.zeros((rows, each)))


def _wide(matrix: Matrix, shape: tuple[int, int]) -> Matrix:
    """With zeros around."""
    wide = np.zeros(shape)
    wide[: matrix.shape[0], : matrix.shape[1]] = matrix
    return wide


def axial_gravity(machine: Machine) -> float:
    """Acceleration along +z of a machine with a vertical axis; z points up unless its rotor says the contrary."""
    if machine.axis == "horizontal":
        return 0.0
    return float(machine.gravity) if getattr(machine.rotor, "up", None) == "-z" else -float(machine.gravity)


def loads_of(machine: Machine, parts: Parts, inverse: Matrix, starts: Floats, width: int) -> Matrix:
    """Of each segment of time: M^-1 u and u, real and imaginary parts, then the rates of these four; (segments, 8, W)."""
    loads = np.zeros((starts.size, 8, width))
    for number, start in enumerate(starts):
        now, rate = np.zeros((2, parts.size), np.complex128)
        for shape, unbalance in zip(parts.shapes, machine.unbalances, strict=True):
            factor = unbalance_factor(unbalance, float(start))
            now = now + factor * shape
            if number + 1 < starts.size:
                late = unbalance_factor(unbalance, float(starts[number + 1]), before=True)
                rate = rate + (late - factor) / (starts[number + 1] - start) * shape
        # the kernel takes Re(u e^(i theta)) as real part times cosine less imaginary part times sine
        vectors = [
            part for load in (now, rate) for vector in (inverse @ load, load) for part in (vector.real, vector.imag)
        ]
        loads[number, :, : parts.size] = vectors
    return loads


def padded_size(size: int) -> int:
    """Coordinates in whole lanes."""
    return size + (-size % LANES)


# Rubber that softens with the amplitude as the numbers of kernels/host/external_forces.py, and its forces at the start.


LAWS = {"elastoplastic": ELASTOPLASTIC, "endochronic": ENDOCHRONIC}


def rubbers(machine: Machine) -> Iterator[tuple[str, Rubber]]:
    """Every piece of rubber of a machine with its name for people, in the order of the file."""
    rotor = machine.rotor
    if isinstance(rotor, PlanarRotor):
        if rotor.rubber is not None:
            yield "support", rotor.rubber
    elif isinstance(rotor, MultibodyRotor):
        for number, joint in enumerate(rotor.joints, 1):
            if isinstance(joint, PointJoint):
                yield from ((f"joint {number}, {rubber.name}", rubber.rubber) for rubber in joint.rubbers())
    else:
        for number, support in enumerate(rotor.supports, 1):
            if support.rubber is not None:
                yield f"support {number}", support.rubber


def has_rubber(machine: Machine) -> bool:
    """Whether any of it softens with the amplitude."""
    return any(True for _ in rubbers(machine))


def element_count(parts: Parts) -> int:
    """Elements of all rubber; each has two states."""
    return sum(len(_elements(mount.rubber)) for mount in parts.mounts)


def rubber_rows(parts: Parts, first_state: int) -> RubberRows:
    """All rubber of a rotor; the forces of its elements begin at ``first_state``."""
    width, count = padded_size(parts.size), len(parts.mounts)
    rubber_rows, elements = RUBBER_MOUNT.rows(count), ELEMENT.rows(element_count(parts))
    rows, number = np.zeros((2 * count, width)), 0
    for i, mount in enumerate(parts.mounts):
        rows[2 * i : 2 * i + 2, : parts.size] = mount.rows @ parts.reduction.basis
        its = _elements(mount.rubber)
        rubber_rows[i].first, rubber_rows[i].elements = number, len(its)
        for law, stiffness, give in its:
            one = elements[number]
            one.law, one.state, one.stiffness, one.give = law, first_state + 2 * number, stiffness, give
            number += 1
    reach = np.zeros_like(rows)
    reach[:, : parts.size] = rows[:, : parts.size] @ np.linalg.inv(parts.mass)
    return RubberRows(rubber_rows, elements, rows, reach)


def pulled_forces(parts: Parts, place: Floats) -> Floats:
    """Forces of all elements when the rotor was pulled straight and slowly from rest to the coordinates r, (2 elements,)."""
    pulled_forces = []
    for mount in parts.mounts:
        stretch = mount.rows @ parts.reduction.basis @ place
        size = float(np.hypot(*stretch))
        for law, stiffness, give in _elements(mount.rubber):
            share = 0.0
            if size > 0.0 and law != MAXWELL:  # a Maxwell element has relaxed
                limit = slipping_force(law, stiffness, give)
                ratio = stiffness * size / limit
                share = limit * (math.tanh(ratio) if law == ELASTOPLASTIC else -math.expm1(-ratio)) / size
            pulled_forces.append(share * stretch)
    return np.concatenate(pulled_forces) if pulled_forces else np.zeros(0)


def force_scales(parts: Parts, length: float) -> Floats:
    """Sizes of the forces of all elements in motions of a length (m), for tolerances, (2 elements,)."""
    sizes = [
        min(stiffness * length, slipping_force(law, stiffness, give))
        for mount in parts.mounts
        for law, stiffness, give in _elements(mount.rubber)
    ]
    return np.repeat(np.array(sizes, np.float64), 2)


def slipping_force(law: int, stiffness: float, give: float) -> float:
    """The force at which an element slides, N; infinite of one that relaxes."""
    if law == MAXWELL:
        return math.inf
    return math.sqrt(stiffness / give) if law == ELASTOPLASTIC else stiffness / give


def _elements(rubber: Rubber) -> list[tuple[int, float, float]]:
    """Law, stiffness and give of each element, as in :data:`autobalancer.kernels.records.ELEMENT`."""
    elements = []
    if rubber.friction is not None:
        law = LAWS[rubber.friction.law]
        for a, k in zip(rubber.friction.breakaway_amplitude, rubber.friction.stiffness, strict=True):
            elements.append((law, float(k), 1.0 / (k * a * a) if law == ELASTOPLASTIC else 1.0 / a))
    if rubber.maxwell is not None:
        pairs = zip(rubber.maxwell.stiffness, rubber.maxwell.relaxation_time, strict=True)
        elements += [(MAXWELL, float(k), 1.0 / tau) for k, tau in pairs]
    return elements


# Bearings that become stiffer as they deflect, as the numbers of kernels/host/external_forces.py, and their forces in a run.


def bearings_of(parts: Parts) -> Bearings:
    """All of them, over the coordinates of a run."""
    width, count = padded_size(parts.size), len(parts.hard)
    springs, rows = HARDENING.rows(count), np.zeros((2 * count, width))
    pieces = [np.zeros((0, 5))]
    for i, (spring, place) in enumerate(zip(springs, parts.hard, strict=True)):
        rows[2 * i : 2 * i + 2, : parts.size] = place.rows @ parts.reduction.basis
        law = central_force(place.hardening)
        spring.cubic, spring.contact, spring.clearance = law.cubic, law.contact, law.clearance
        spring.center_x, spring.center_y = place.hardening.center
        spring.rest_x, spring.rest_y = hardening_force(place.hardening, np.zeros((1, 2)))[0]
        spring.first, spring.pieces = sum(map(len, pieces)), len(law.pieces)
        pieces.append(law.pieces)
    reach = np.zeros_like(rows)
    reach[:, : parts.size] = rows[:, : parts.size] @ np.linalg.inv(parts.mass)
    return Bearings(springs, rows, reach, np.vstack(pieces))


def hardening_force(hardening: Hardening, moved: Matrix) -> Matrix:
    """Force of the rotor on the bearing at deflections (T, 2) from where it rests, that at rest included; (T, 2) N."""
    way = moved - np.array(hardening.center, float)
    distance = np.hypot(way[:, 0], way[:, 1])
    size = central_force(hardening).force(distance)
    return np.asarray(way * (size / np.where(distance > 0.0, distance, 1.0))[:, None])


def has_hardening(machine: Machine) -> bool:
    """Whether any bearing of a machine becomes stiffer as it deflects."""
    return any(True for _ in hardenings(machine))
