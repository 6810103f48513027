"""What a run says of places: planes of balancers, stations and supports, in the coordinates of its state."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from autobalancer.arrays import Complexes
from autobalancer.assembly.contact import Tables, is_rigid, law_numbers, least_rebound, parallel, restitution
from autobalancer.assembly.drive_train import unbalance_factor
from autobalancer.assembly.guided_balls import ball_inertia
from autobalancer.assembly.reduced_rotor import has_hardening, spatial_parts
from autobalancer.assembly.rotors import (
    Planes,
    lateral_model,
    places_key,
    planes_of,
    reference,
    rotor_key,
    spring_model,
    station_rows,
    unbalance_shape,
    with_ball_mass,
)
from autobalancer.assembly.rotors.ellipses import steadily
from autobalancer.assembly.rotors.equivalent_stiffness import hard_places, mounts, softened
from autobalancer.assembly.rotors.grounds import Ground, carried, grounds, large_motions, sag
from autobalancer.assembly.rotors.lateral_model import LateralModel
from autobalancer.assembly.rotors.reduction import Reduction, circular
from autobalancer.assembly.system import Assembly, assemble, assemble_general, total_mass
from autobalancer.cache import remembered
from autobalancer.catalog.product_tables import RING, TURNED, TURNED_ECCENTRICITY, ring_eccentricity
from autobalancer.catalog.resolve import Ball, capability_of, resolve, settled
from autobalancer.errors import QuestionError
from autobalancer.kernels import records
from autobalancer.kernels.measures.record_series import BALL, PLACE
from autobalancer.kernels.measures.thresholds import ITERATED, LINEAR, UNKNOWN
from autobalancer.kernels.measures.workspace import SCALARS, MeasureInputs, Observables, Workspace
from autobalancer.kernels.records import MEETING
from autobalancer.kernels.system import BALLS, SPEED, THETA, VX, VY, Floats, Matrix, Rows, X, Y
from autobalancer.laws.impacts import LEAST, rebound
from autobalancer.machine import Machine, MultibodyRotor, PlanarRotor, Race, Unbalance
from autobalancer.machine.rebound import Rebound
from autobalancer.results.display_units import length_text, moment_text

# Contacts whose impacts a run notes, and what an impact in each of them means.


ROOM = 20_000  # impacts between two looks at them


@dataclass(frozen=True)
class Touch:
    """A contact: numbers of both balls from 0, the second -1 at a partition and -2 at a wall; reduced mass, kg."""

    kind: int
    one: int
    other: int
    mass: float
    restitution: float
    rebound: Rebound | None
    slowest: float  # m/s: no slower impact rebounds, because of the fluid
    least: float = LEAST  # restitution that counts for less; 0 of rigid contacts


def with_touches(machine: Machine, assembly: Assembly) -> tuple[Assembly, tuple[Touch, ...]]:
    """The assembly with room for the impacts of all contacts of its balls, and these contacts."""
    touches = touches_of(machine, assembly)
    if not touches:
        return assembly, ()
    rows = records.TOUCH.rows(len(touches))
    for row, touch in zip(rows, touches, strict=True):
        row.kind, row.one, row.other, row.known = touch.kind, touch.one, touch.other, -1
    room = {"touches": rows, "impacts": records.IMPACT.rows(ROOM), "impact_count": np.zeros(1, np.int64)}
    return replace(assembly, system=assembly.system._replace(**room)), touches


def touches_of(machine: Machine, assembly: Assembly) -> tuple[Touch, ...]:
    """All contacts of the balls of a machine."""
    return tuple(_resolved(machine, assembly) if assembly.resolved else _guided(machine, assembly))


def _guided(machine: Machine, assembly: Assembly) -> list[Touch]:
    touches = []
    for i, (ball, contact) in enumerate(zip(assembly.balls, assembly.system.contacts, strict=True)):
        race = _race(machine, ball)
        least = 0.0 if is_rigid(race) else LEAST
        if contact.hard > 0.0 or contact.rigid > 0:
            j = int(contact.next)
            other = assembly.balls[j]
            mass = parallel(ball.inertia, other.inertia) / contact.pace**2
            touches.append(Touch(records.NEXT, i, j, mass, *_meeting(race, ball, other), least=least))
        if contact.wall_hard > 0.0 or contact.wall_rigid > 0:
            mass = ball.inertia / contact.wall_pace**2
            touches += [
                Touch(kind, i, -1, mass, *_meeting(race, ball), least=least) for kind in (records.BEHIND, records.AHEAD)
            ]
    return touches


def _resolved(machine: Machine, assembly: Assembly) -> list[Touch]:
    touches = []
    for i, (ball, free) in enumerate(zip(assembly.balls, assembly.system.free_balls, strict=True)):
        race, mass = _race(machine, ball), float(free.mass + free.extra)
        law = race.resolved
        assert law is not None
        damped = free.wall_damping / (2.0 * math.sqrt(free.wall_stiffness * mass))  # with 'damping', of a linear spring
        told = float(law.restitution) if law.restitution is not None else rebound(damped)
        touches.append(Touch(records.WALL, i, -2, mass, told, law.rebound, least_rebound(law.rebound, ball)))
        if np.isfinite(free.gap):
            touches.append(replace(touches[-1], kind=records.INNER))
        if race.partitions is not None:
            touches.append(Touch(records.SIDES, i, -1, mass, *_meeting(race, ball)))
        for j in range(i + 1, len(assembly.balls)):
            other, its = assembly.balls[j], assembly.system.free_balls[j]
            if free.race >= 0 and free.race == its.race:
                reduced = parallel(mass, float(its.mass + its.extra))
                touches.append(Touch(records.OTHER_BALL, i, j, reduced, *_meeting(race, ball, other)))
    return touches


def _race(machine: Machine, ball: Ball) -> Race:
    return machine.balancers[ball.balancer].races[ball.race]


def _meeting(race: Race, ball: Ball, other: Ball | None = None) -> tuple[float, Rebound | None, float]:
    falls = race.contact.rebound if race.contact is not None else None
    return restitution(race), falls, least_rebound(falls, ball, other)


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


class _RotorPlaces(NamedTuple):
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
    seen = _rotor_places(machine, bare, assembly.reduction)
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
        **{name: getattr(seen, name) for name in _RotorPlaces._fields[1:]},
    )


@remembered(8, by=lambda machine, bare, small: (*places_key(machine), *rotor_key(machine), bare, small and small.basis))
def _rotor_places(machine: Machine, bare: LateralModel, small: Reduction | None) -> _RotorPlaces:
    # places at which the rotor is seen: planes of balancers, named stations, supports, each once
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
    # the rest position, and what rubber and hardening bearings do around it
    pull = float(machine.gravity) if machine.axis == "horizontal" else 0.0
    rest = sag(bare, pull)
    rubber = mounts(machine, bare)
    runs = [large_motions(machine, bare, ground, rubber) for ground in result]

    def over_speeds(matrices: Iterable[Matrix]) -> Matrix:
        shape = (len(result), bare.speeds.size, 2, basis.shape[1])
        return np.array([matrix @ basis for matrix in matrices]).reshape(shape).swapaxes(0, 1)

    return _RotorPlaces(
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


def assemble_locked(machine: Machine, rotating: bool | None = None) -> Assembly:
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


# What unbalance does at the planes and places of a machine at a steady speed.


def plane_unbalances(assembly: Assembly, gauges: MeasureInputs, time: float, speed: float) -> Complexes:
    """The unbalance that the balls of each plane have to balance so that all planes rest, kg m in the rotor, (P,).

    It is what the unbalances do at the planes at this speed, put into these planes; on a planar rotor their sum. nan at
    a critical speed of an undamped rotor.
    """
    from autobalancer.kernels.measures import observables

    plane_unbalances = np.zeros(gauges.capability.size, np.complex128)
    observables.plane_unbalances(assembly.system, gauges, time, speed, desk_for(gauges, 0), plane_unbalances)
    return plane_unbalances


def off_center_unbalances(places: Places, speed: float) -> Complexes:
    """Residual unbalance of each plane for each meter by which the race of a plane is off the axis, kg, (P, P).

    Balls that rest in the rotor hold the centers of their races at rest, so the axis of the rotor is as far off the axis of
    rotation as the race is off the axis: of a planar rotor the residual is (M - (k + i b w)/w^2) E in the rotor. nan where
    the races cannot all be at rest, as in more than two planes of a rigid rotor, or without speed.
    """
    count = len(places.planes)
    if not speed:
        return np.full((count, count), np.nan + 0j)
    circles = (
        places.rows[:count, 0] - 1j * places.rows[:count, 1]
    ).T  # force of a unit vector that turns with the rotor
    dynamic = _dynamic_stiffness(places, np.array([float(speed)]))[0]
    try:
        moved = 0.5 * circles.conj().T @ np.linalg.solve(dynamic, circles)
        scale = np.abs(moved).max(initial=0.0)
        if np.linalg.matrix_rank(moved, tol=1e-9 * scale) < count:
            raise np.linalg.LinAlgError
        return np.asarray(-np.linalg.inv(moved) / speed**2, np.complex128)
    except np.linalg.LinAlgError:
        return np.full((count, count), np.nan + 0j)


def without_balancing(
    assembly: Assembly, places: Places, gauges: MeasureInputs, time: float, speed: float
) -> tuple[Floats, Floats]:
    """Greatest vibration of each place, (L,) m, and greatest vibrating force on each support, (S,) N, without balancing.

    The balls are spread evenly over their races and held; the speed is steady, and nothing shakes the machine from outside.
    nan at a critical speed of an undamped rotor, and on softening rubber whose steady motion is not known.
    """
    if places.rubber_rows.size:
        return _on_rubber(places, time, speed)
    from autobalancer.kernels.measures import observables

    vibration, force = np.zeros(len(places.names)), np.zeros(len(places.supports))
    observables.observe_locked_balls(assembly.system, gauges, time, speed, desk_for(gauges, 0), vibration, force)
    return vibration, force


def _on_rubber(places: Places, time: float, speed: float) -> tuple[Floats, Floats]:
    """The same on rubber that is as soft as its own deflection makes it."""
    machine, bare = places.machine, lateral_model(places.machine)
    soft = softened(machine, bare, places.model)
    assert soft is not None
    load = sum(
        (
            unbalance_factor(part, float(time)) * unbalance_shape(machine, bare, number)
            for number, part in enumerate(machine.unbalances)
        ),
        places.center_loads,
    )
    try:
        result = steadily(soft, np.array([float(speed)]), load, "vibration without balls")
    except QuestionError:
        return np.full(len(places.names), np.nan), np.full(len(places.supports), np.nan)
    moved = np.linalg.lstsq(places.basis, result.motion[0], rcond=None)[0]
    force = places.rubber_rows @ result.pushes[0].ravel()
    for i, share in enumerate(table_shares(places.speeds, np.array([float(speed)]))):
        force = force + share * (places.run_stiffness[i] + 1j * speed * places.run_damping[i]) @ moved
    return _semi_major(np.asarray(places.rows @ moved, np.complex128)), _semi_major(force)


def _semi_major(pairs: Complexes) -> Floats:
    """Greatest length of Re((x, y) e^(i theta)), of complex (..., 2)."""
    x, y = pairs[..., 0], pairs[..., 1]
    return np.asarray(0.5 * (np.abs(x + 1j * y) + np.abs(x - 1j * y)), np.float64)


def _dynamic_stiffness(places: Places, speed: Floats) -> Complexes:
    """K + i w (C + w G) - w^2 M over the coordinates, with the balls on the rotor, (T, R, R)."""
    model, basis = places.model, places.basis
    w = speed[:, None, None]
    total = 1j * w**2 * (basis.T @ model.gyroscopic @ basis) - w**2 * (basis.T @ model.mass @ basis)
    for i, share in enumerate(table_shares(model.speeds, speed)):
        small = basis.T @ model.stiffness[i] @ basis + 1j * w * (basis.T @ model.damping[i] @ basis)
        total = total + share[:, None, None] * small
    return np.asarray(total, np.complex128)


# What a race off the axis leaves, however well its balls balance: they bring the center of the race to rest, not the
# axis.
#
# Spannan (2021), section 4.2.4: on isotropic supports the axis then whirls at the eccentricity. Where the machine has
# none, a typical one is taken.


@dataclass(frozen=True)
class OffCenterPlane:
    """A plane of balancers: eccentricity of its races (the greatest, or a typical one) and vibration of the axis, m.

    ``residual`` (kg m) is the unbalance that stays in this plane while all races are at rest: of given eccentricities
    what they leave, of typical ones the most, over their directions; nan where the races cannot all be at rest. ``source``
    says where a typical eccentricity comes from.
    """

    name: str
    given: bool
    eccentricity: float
    residual: float
    source: str = ""


@dataclass(frozen=True)
class OffCenter:
    """The planes of a machine at a steady speed (rad/s)."""

    speed: float
    planes: tuple[OffCenterPlane, ...]

    @property
    def greatest(self) -> float:
        """The greatest eccentricity, m."""
        return max((plane.eccentricity for plane in self.planes), default=0.0)

    @property
    def given(self) -> bool:
        """Whether the machine gives the eccentricity of some race in each plane."""
        return all(plane.given for plane in self.planes)

    @property
    def sentence(self) -> str:
        """All that in words; empty for races that are said to be centered."""
        planes = [plane for plane in self.planes if plane.eccentricity > 0.0]
        if not planes:
            return ""
        unknown = not all(plane.given for plane in planes)
        several = len(self.planes) > 1
        parts = [
            f"{length_text(plane.eccentricity)}{f' at {plane.name}' if several else ''} "
            f"{'leaves' if plane.given else 'would leave'} a vibration of {length_text(plane.eccentricity)}"
            + (
                f" and {'up to ' * (several and unknown)}{moment_text(plane.residual)} of unbalance"
                if np.isfinite(plane.residual)
                else ""
            )
            for plane in planes
        ]
        sources = " or ".join(dict.fromkeys(plane.source for plane in planes if not plane.given))
        begin = f"not given{' everywhere' * any(p.given for p in planes)}; typical is {sources}: " if unknown else ""
        return begin + "; ".join(parts) + ", with the balls in their best places"


def off_center(places: Places, balls: tuple[Ball, ...], speed: float) -> OffCenter | None:
    """The eccentricities of a machine and what they leave at a speed (rad/s); None without balls."""
    if not balls:
        return None
    given, greatest, fixed, sources = zip(
        *(_plane([ball for ball, p in zip(balls, places.plane_of_ball, strict=True) if p == i], places)
          for i in range(len(places.planes))),
        strict=True,
    )  # fmt: skip
    effect = off_center_unbalances(places, speed)
    known = np.array(given, bool)
    left = np.abs(effect[:, known] @ np.array(fixed)[known]) + np.abs(effect[:, ~known]) @ np.array(greatest)[~known]
    return OffCenter(
        float(speed),
        tuple(
            OffCenterPlane(name, bool(one), float(offset), float(residual), source)
            for name, one, offset, residual, source in zip(places.planes, given, greatest, left, sources, strict=True)
        ),
    )


def _plane(balls: list[Ball], places: Places) -> tuple[bool, float, complex, str]:
    """Whether an eccentricity is given, the greatest one or a typical one, the given one with its direction, m, and a source."""
    races = [places.machine.balancers[ball.balancer].races[ball.race] for ball in balls]
    if any("eccentricity" in race.model_fields_set for race in races):
        offset = max((ball.eccentricity for ball in balls), key=abs)
        return True, abs(offset), offset, ""
    if any(race.bearing is None for race in races):
        return False, TURNED_ECCENTRICITY, 0j, TURNED
    size = max((2.0 * ball.orbit_radius + ball.diameter for ball in balls), default=0.0)
    return False, ring_eccentricity(size), 0j, RING


# The numbers that measures need of a machine, and room for them, as kernels/measures/workspace.py names them.


MOST = 200_000  # impacts that are kept


def gauges_of(
    assembly: Assembly, places: Places, jumps: Sequence[float] = (), touches: Sequence[Touch] = (), *, centered: bool
) -> MeasureInputs:
    """The numbers of an assembled machine; ``centered`` says that nothing can deflect its rotor for good."""
    # contacts whose impacts count, and single numbers that decide what is measured
    basis, model, balls = places.basis, places.model, assembly.balls
    meetings, rebounds = meetings_of(touches)
    scalars = np.zeros(SCALARS)
    scalars[:] = (
        centered,
        assembly.resolved,
        _held(places.machine, places, bool(balls)),
        isinstance(places.machine.rotor, PlanarRotor),
    )
    return MeasureInputs(
        scalars=scalars,
        rows=_flat(places.rows),
        speeds=np.array(places.speeds, np.float64),
        stiffness=_by_speed(places.run_stiffness),
        damping=_by_speed(places.run_damping),
        weight=np.array(places.weight, np.float64).ravel(),
        rubber=_flat(places.rubber_rows),
        hard=_flat(places.hard_rows),
        ball_mass=np.array([ball.effective_mass for ball in balls], np.float64),
        ball_moment=np.array([ball.moment for ball in balls], np.float64),
        ball_centers=np.array([[b.eccentricity.real, b.eccentricity.imag] for b in balls], np.float64).reshape(-1, 2),
        ball_planes=np.array(places.plane_of_ball, np.int64),
        capability=np.array(places.capability, np.float64),
        mass=np.ascontiguousarray(basis.T @ model.mass @ basis, np.float64),
        gyroscopic=np.ascontiguousarray(basis.T @ model.gyroscopic @ basis, np.float64),
        model_speeds=np.array(model.speeds, np.float64),
        model_damping=np.array([basis.T @ damping @ basis for damping in model.damping], np.float64),
        model_stiffness=np.array([basis.T @ stiffness @ basis for stiffness in model.stiffness], np.float64),
        held_stiffness=_by_speed(places.stiffness),
        held_damping=_by_speed(places.damping),
        held_loads=np.stack([places.centers.real, places.centers.imag]),
        jumps=np.array(jumps, np.float64),
        meetings=meetings,
        rebounds=rebounds,
        whirls=assembly.whirls,
    )


def desk_for(gauges: MeasureInputs, states: int, bins: int = 0, hits: int = 0) -> Workspace:
    """Room for runs of machines with arrays of the same size: states of places, bins of an envelope, impacts."""
    size, balls, planes = gauges.rows.shape[0], gauges.ball_mass.size, gauges.capability.size
    places, supports = gauges.rows.shape[1] // 2, gauges.weight.size // 2
    most, columns = max(places, supports, 1), 1 + 2 * (1 + balls)

    def complexes(*shape: int) -> Any:
        return np.zeros(shape, np.complex128)

    def seen(count: int) -> Any:
        return complexes(states, count)

    return Workspace(
        Observables(
            seen(places), seen(places), seen(supports), seen(planes), seen(planes), seen(1), seen(1),
            np.zeros((states, balls)),
        ),
        np.zeros(size), np.zeros(size), np.zeros(2 * most), np.zeros(states),
        np.zeros(bins), np.zeros(bins), np.zeros(bins), np.zeros(bins), np.zeros((bins, balls)), np.zeros((bins, balls)),
        np.zeros((4 + len(BALL), balls)),
        np.zeros((2 + len(PLACE), most)),
        complexes(max(states, columns, planes), columns + most + planes + 1),
        complexes(max(size, columns, planes), max(size + planes + 1, columns + most, planes + 2)),
        complexes(most),
        np.zeros((4, hits)),
        np.zeros(1, np.int64),
    )  # fmt: skip


def meetings_of(touches: Sequence[Touch]) -> tuple[Rows, Floats]:
    """What an impact means in each contact, and the laws of restitution of those where that depends on the speed."""
    rows, laws = MEETING.rows(len(touches)), Tables(law_numbers)
    for row, touch in zip(rows, touches, strict=True):
        row.mass, row.restitution, row.least = touch.mass, touch.restitution, touch.least
        row.law = laws.first(touch.rebound, touch.restitution, touch.slowest)
    return rows, laws.numbers


def _held(machine: Machine, places: Places, balls: bool) -> int:
    if not balls or machine.excitations or has_hardening(machine):
        return UNKNOWN
    return ITERATED if places.rubber_rows.size else LINEAR


def _flat(rows: Matrix) -> Matrix:
    """Rows of pairs (L, 2, R) coordinate by coordinate, (R, 2 L)."""
    return np.ascontiguousarray(rows.reshape(2 * rows.shape[0], rows.shape[2]).T, np.float64)


def _by_speed(rows: Matrix) -> Matrix:
    """The same of rows for each speed, (k, S, 2, R) to (k, R, 2 S)."""
    return np.ascontiguousarray(
        rows.reshape(rows.shape[0], 2 * rows.shape[1], rows.shape[3]).swapaxes(1, 2), np.float64
    )
