"""What stability needs of a machine at constant speed: its rotor, the stations of its balls, its unbalance.

A planar rotor is the limit of one station; as a :class:`Plane` it has closed forms, which are fast paths to the same answers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.assembly.contact import contact_rows
from autobalancer.assembly.drive_train import schedule_times, unbalance_factor, unbalance_vector
from autobalancer.assembly.guided_balls import ball_rows, force_rows, forces_in, has_forces, moving_rows
from autobalancer.assembly.reduced_rotor import axial_gravity
from autobalancer.assembly.rotors import lateral_model, planes_of, rows_matrix, unbalance_shape, with_ball_mass
from autobalancer.assembly.rotors.critical import critical_speeds, natural_frequencies
from autobalancer.assembly.rotors.equivalent_stiffness import HardPlace
from autobalancer.assembly.rotors.lateral_model import SAME, LateralModel
from autobalancer.assembly.rotors.rigid import Point
from autobalancer.assembly.system import steady, total_mass
from autobalancer.catalog.resolve import Ball, capability_of, planar_rotor, resolve
from autobalancer.errors import SIMULATE_OR_BASIN, QuestionError
from autobalancer.kernels.system import BALLS, System
from autobalancer.machine import Machine, PlanarRotor, Unbalance
from autobalancer.random_numbers import generator

# A planar machine as numbers.


SEARCHED = 40.0  # borders are sought up to so many times the critical speed
STAND_IN = (
    "or use the equivalent planar machine near one critical speed: equivalent_planar(machine), or "
    "'autobalancer equivalent-planar FILE --out planar.toml'"
)


@dataclass(frozen=True)
class Plane:
    """A planar machine at constant speed W without gravity, SI; mass includes the balls (effective)."""

    mass: float
    stiffness: tuple[float, float]
    damping: tuple[float, float]
    unbalance: complex  # in the rotor, kg m
    ball_mass: Floats  # (n,) effective
    moment: Floats  # (n,) effective mass x orbit radius
    inertia: Floats  # (n,) of the ball angle
    drag: Floats  # (n,)
    race: NDArray[np.int64]  # (n,) number of the ball's race, from 0
    offset: Complexes  # (n,) race center in the rotor
    capability: float = math.inf  # of balls side by side, kg m
    planar: ClassVar[bool] = True
    forces: ClassVar[None] = None  # with forces on its balls a planar machine is described as a station

    @property
    def isotropic(self) -> bool:
        """Whether x and y are alike."""
        return self.stiffness[0] == self.stiffness[1] and self.damping[0] == self.damping[1]

    @property
    def as_station(self) -> Stations:
        """The same as one station of a rotor."""
        return of_plane(self)

    @property
    def one_centric(self) -> bool:
        """Whether all balls run in one plane, around the axis."""
        return not np.any(self.offset)

    @property
    def knows_any_unbalance(self) -> bool:
        """Whether all borders but the exact one of a state are those of any unbalance."""
        return self.one_centric

    @property
    def greatest_resultant(self) -> float:
        """The greatest unbalance that balls side by side can balance, kg m."""
        return self.capability

    @property
    def station(self) -> NDArray[np.int64]:
        """All balls are at the only one, (n,)."""
        return np.zeros(self.moment.size, np.int64)

    @property
    def scale_speed(self) -> float:
        """The lower critical speed, rad/s."""
        return self.critical_speeds[0]

    @property
    def highest_searched(self) -> float:
        """Up to where borders are sought, rad/s."""
        return SEARCHED * self.critical_speeds[-1]

    @property
    def never_below(self) -> float:
        """A speed below which no balanced state is stable, rad/s."""
        return self.critical_speeds[0] if self.isotropic else 0.0

    @property
    def critical_speeds(self) -> tuple[float, ...]:
        """sqrt(k/M), rad/s, ascending."""
        return tuple(math.sqrt(k / self.mass) for k in sorted(set(self.stiffness)))

    def dynamic_stiffness(self, speed: float) -> complex:
        """Force over forward whirl, N/m; on orthotropic supports that of the forward component of the whirl."""
        x, y = (complex(k - self.mass * speed**2, b * speed) for k, b in zip(self.stiffness, self.damping, strict=True))
        if x == 0.0 or y == 0.0:
            return 0.0
        total = x + y
        if total == 0.0:
            return complex(math.inf)
        return 2.0 * x * y / total

    @property
    def fixed_load(self) -> complex:
        """Unbalance and the eccentric masses of the balls, kg m."""
        return self.unbalance + complex((self.ball_mass * self.offset).sum())


def refuse_forces(machine: Machine) -> None:
    """Refuse a machine with forces on its balls.

    Raises
    ------
    QuestionError
        If it has any.
    """
    items = [
        f"balancers[{b + 1}].races[{r + 1}].forces"
        for b, balancer in enumerate(machine.balancers)
        for r, race in enumerate(balancer.races)
        if race.forces
    ]
    if items:
        raise QuestionError(
            f"{items[0]}: this question does not know forces on the balls; simulate the machine instead, or ask without them"
        )


def plane(machine: Machine, unbalance: complex | float | None = None, *, with_forces: bool = False) -> Plane:
    """The plane of a machine; its unbalance is, unless given, the resultant at the end of all schedules.

    It knows nothing of forces on the balls; ``with_forces`` if the caller does.

    Raises
    ------
    QuestionError
        If gravity acts in the plane: then there is no steady state at rest in the rotor. If the rotor is not planar.
    """
    rotor = machine.rotor
    if not is_planar(machine):
        raise QuestionError(
            f"rotor: given one of kind {rotor.kind!r}; this analysis supports planar rotors only. For any rotor use "
            f"equilibria, eigenvalues, borders, stable_windows or border_curve; {STAND_IN}"
        )
    if machine.axis == "horizontal" and machine.gravity > 0.0:
        raise QuestionError(
            "steady states: gravity acts in the plane of this machine (horizontal axis); " + SIMULATE_OR_BASIN
        )
    if not with_forces:
        refuse_forces(machine)
    balls: tuple[Ball, ...] = resolve(machine)
    races = sorted({(ball.balancer, ball.race) for ball in balls})
    stiffness, damping = _planar_springs(machine, "steady states")
    return Plane(
        mass=total_mass(machine, balls),
        stiffness=stiffness,
        damping=damping,
        unbalance=unbalance_vector(machine, math.inf) if unbalance is None else complex(unbalance),
        ball_mass=np.array([ball.effective_mass for ball in balls]),
        moment=np.array([ball.moment for ball in balls]),
        inertia=np.array([ball.inertia for ball in balls]),
        drag=np.array([ball.drag for ball in balls]),
        race=np.array([races.index((ball.balancer, ball.race)) for ball in balls], np.int64),
        offset=np.array([ball.eccentricity for ball in balls], np.complex128),
        capability=capability_of(balls),
    )


def _planar_springs(machine: Machine, owner: str) -> tuple[tuple[float, float], tuple[float, float]]:
    """Stiffness and damping of a planar rotor along x and y in small motions about the place where it rests.

    Raises
    ------
    QuestionError
        If it rests in its bearing in a direction between x and y, which these two do not describe; ``owner`` is who asks.
    """
    springs = planar_rotor(machine)
    (kx, ky), hardening = springs.stiffness_xy, springs.hardening
    if hardening is not None:
        (xx, xy), (_, yy) = HardPlace("support", hardening, np.eye(2), 1, True).stiffness
        if abs(xy) > SAME * max(xx, yy):
            raise QuestionError(
                f"{owner}: the rotor rests beside the middle of its bearing between x and y, so that they are coupled; turn the "
                "axes until 'center' of its hardening is on one of them, or simulate it"
            )
        kx, ky = kx + float(xx), ky + float(yy)
    return (kx, ky), springs.damping_xy


# Forces on the balls that are leaves, as stability needs them: their torques, and the derivatives of these.
#
# The compiled forces are called as a run calls them. Derivatives along a direction come from values at seven places on
# it, some thousandths of a radian apart, exact for polynomials of degree six. The order of the balls around a race,
# which a force between neighbors needs, is that at the state in question.


APART, WIDER = 2e-3, 1e-2  # rad between two places: for first derivatives, and where higher ones are wanted
PLACES = np.arange(-3.0, 4.0)
WEIGHTS = np.linalg.inv(np.vander(PLACES, increasing=True))  # values at the places -> powers of the way between them
TURN = 2.0 * np.pi
TORQUE_ROUNDING = 1e-13  # torque over wall force and radius
SPEEDS = (1.0, 30.0, 1000.0)  # rad/s, at which it is tried whether forces push balls at all
PLACES_TRIED = 120  # at each of them
_TRIED: set[tuple[tuple[str, type], ...]] = set()  # classes of forces whose functions were tried already


@dataclass(frozen=True, eq=False)
class BallForces:
    """The forces of a machine; ``groups`` of coincident balls move as one."""

    machine: Machine
    balls: tuple[Ball, ...]
    pairs: bool  # whether any acts between balls: then equal balls are not free to change places
    groups: tuple[tuple[int, ...], ...] | None = None
    systems: dict[Any, System] = field(default_factory=dict, repr=False)  # for each order of the balls

    def merged(self, groups: tuple[tuple[int, ...], ...]) -> BallForces:
        """The same on groups of balls."""
        return replace(self, groups=groups)

    def torques(self, angles: Floats, rates: Floats, speed: float, order: Floats | None = None) -> Floats:
        """On each ball or group, (..., n) N m; balls have the order of the angles ``order``, else of the first ones."""
        shape, place = angles.shape, self._places
        angles, rates = (np.reshape(part, (-1, shape[-1]))[:, place] for part in (angles, rates))
        count = len(self.balls)
        system = self._system(angles[0] if order is None else np.reshape(order, -1)[place])
        result = _torques_and_wall_forces(system, angles, rates, speed)[:, :count]
        together = np.zeros((len(angles), shape[-1]))
        np.add.at(together.T, place, result.T)
        return together.reshape(shape)

    def series(
        self, angles: Numbers, rates: Numbers, turn: Numbers, change: Numbers, speed: float, order: int
    ) -> list[Numbers]:
        """Coefficients of h^0, h^1 ... at ``angles + h turn``, ``rates + h change``; the direction may be complex."""
        if not (np.iscomplexobj(turn) or np.iscomplexobj(change)):
            return self._along(angles, rates, turn, change, speed, order)
        a, b, c, d = turn.real, change.real, turn.imag, change.imag
        ways = ((a, b), (c, d), (a + c, b + d), (a - c, b - d))
        one, other, plus, minus = (self._along(angles, rates, x, y, speed, max(order, 3)) for x, y in ways)
        both, apart = ([0.5 * (a + sign * b) for a, b in zip(plus, minus, strict=True)] for sign in (1.0, -1.0))
        result = [
            one[0],
            one[1] + 1j * other[1],
            one[2] - other[2] + 1j * apart[2],
            2.0 * one[3] - both[3] + 1j * (apart[3] - 2.0 * other[3]),
        ]
        return result[: order + 1]

    def _along(
        self, angles: Floats, rates: Floats, turn: Floats, change: Floats, speed: float, order: int
    ) -> list[Numbers]:
        size = np.maximum(np.abs(turn).max(-1), np.abs(change).max(-1) / speed)[..., None]
        step = (APART if order < 2 else WIDER) / np.where(size > 0.0, size, 1.0)
        way = PLACES.reshape(-1, *[1] * np.ndim(turn)) * step
        first = np.reshape(angles, (-1, angles.shape[-1]))[0]
        values = self.torques(angles + way * turn, rates + way * change, speed, first)
        return [np.tensordot(WEIGHTS[k], values, 1) / step**k for k in range(order + 1)]

    @property
    def _places(self) -> np.ndarray[Any, Any]:
        """The group of each ball."""
        if self.groups is None:
            return np.arange(len(self.balls))
        place = np.zeros(len(self.balls), np.int64)
        for number, group in enumerate(self.groups):
            place[list(group)] = number
        return place

    def _system(self, angles: Floats) -> System:
        """The compiled forces with the balls in the order of these angles."""
        turns = np.floor(angles / TURN)
        key = (
            (tuple(np.argsort(angles - TURN * turns, kind="stable").tolist()), tuple(turns.tolist()))
            if self.pairs
            else ()
        )
        if key not in self.systems:
            count = len(self.balls)
            self.systems[key] = System(
                rotating=1, gravity_x=0.0, gravity_y=0.0, polar_inertia=1.0, ball_count=count, drive=steady(1.0, 0j),
                balls=ball_rows(self.balls), contacts=contact_rows(count), guided=moving_rows(self.balls),
                **force_rows(self.machine, self.balls, angles, tried=self.kinds not in _TRIED),
            )  # fmt: skip
        return self.systems[key]

    @property
    def kinds(self) -> tuple[tuple[str, type], ...]:
        """Class of each force, with its path; a parameter that varies changes their numbers only."""
        return tuple((path, type(force)) for path, force, _ in forces_in(self.machine, self.balls))

    def push(self) -> bool:
        """Whether they turn any ball, tried at many places; else a guided ball feels them in its wall only."""
        count, random = len(self.balls), generator(0)
        for speed in SPEEDS:
            angles, rates = (random.uniform(-size, size, (PLACES_TRIED, count)) for size in (np.pi, 1.0))
            for angle, rate in zip(angles, rates * speed, strict=True):
                result = _torques_and_wall_forces(self._system(angle), angle[None], rate[None], speed)[0]
                radius = np.array([ball.orbit_radius for ball in self.balls])
                if (np.abs(result[:count]) > TORQUE_ROUNDING * np.abs(result[count:]) * radius).any():
                    return True
        return False


def _torques_and_wall_forces(system: System, angles: Floats, rates: Floats, speed: float) -> Floats:
    from autobalancer.kernels.balls.ball_forces import force_torques

    count = system.ball_count
    states, forces = np.zeros((len(angles), BALLS + 2 * count)), np.zeros((len(angles), 2 * count))
    states[:, BALLS : BALLS + count], states[:, BALLS + count :] = angles, rates
    force_torques(system, states, speed, forces)
    return forces


def without_forces(machine: Machine) -> Machine:
    """The machine for theories that leave forces on the balls out."""
    balancers = tuple(
        balancer.model_copy(update={"races": tuple(race.model_copy(update={"forces": ()}) for race in balancer.races)})
        for balancer in machine.balancers
    )
    return machine.model_copy(update={"balancers": balancers})


def forces_on(machine: Machine) -> BallForces | None:
    """The forces of a machine that push balls along their races; ``None`` if it has none."""
    if not has_forces(machine):
        return None
    balls = resolve(machine)
    ball_forces = BallForces(machine, balls, any(force.pairs for _, force, _ in forces_in(machine, balls)))
    pushing = ball_forces.push()
    _TRIED.add(ball_forces.kinds)
    return ball_forces if pushing else None


ALONG = 1e-9  # share of the greatest entry of a matrix that moves nothing
ROUNDING = 4.0 * float(np.finfo(float).eps)  # of a sum of terms that cancel, over the terms


@dataclass(frozen=True)
class Stations:
    """A machine at constant speed W without gravity across its axis, SI; P stations carry n balls.

    The planar machine is the limit of one station and one pair of coordinates;
    :class:`~autobalancer.stability.host.stations.Plane` is the same for it, and faster.
    """

    model: LateralModel  # with the effective mass of the balls in their planes
    names: tuple[str, ...]  # (P,)
    rows: Matrix  # (P, pairs) deflections of the stations
    load: Complexes  # (pairs,) of all unbalances in the rotor
    unbalance: complex  # resultant of the point unbalances, kg m
    ball_mass: Floats  # (n,) effective
    moment: Floats  # (n,) effective mass x orbit radius
    inertia: Floats  # (n,) of the ball angle
    drag: Floats  # (n,)
    station: NDArray[np.int64]  # (n,) number of the ball's station, from 0
    race: NDArray[np.int64]  # (n,) number of its race, from 0
    offset: Complexes  # (n,) race center in the rotor
    capability: Floats  # (P,) of balls side by side, kg m
    slopes: Matrix | None = None  # (P, pairs) of the stations, where balls feel the tilt of their race
    weight: float = 0.0  # acceleration of gravity along the axis, felt where races tilt
    forces: BallForces | None = None  # that are leaves: springs, magnets, ...
    planar: bool = False  # whether the rotor is a planar one, whose deflection is that of its only station

    @property
    def isotropic(self) -> bool:
        """Whether x and y are alike."""
        return self.model.isotropic

    @cached_property
    def balanced(self) -> dict[float, Any]:
        """The balanced states by speed, as far as they were sought: several questions ask at the same speeds."""
        return {}

    @cached_property
    def critical_speeds(self) -> tuple[float, ...]:
        """Undamped, rad/s, ascending: those an unbalance excites; may be empty."""
        return critical_speeds(self.model)

    @cached_property
    def scale_speed(self) -> float:
        """A speed of the size of the machine's own, rad/s: the lowest critical speed, or frequency at rest."""
        return self.critical_speeds[0] if self.critical_speeds else float(natural_frequencies(self.model)[0])

    @property
    def highest_searched(self) -> float:
        """Up to where borders are sought, rad/s; not beyond the tables of the supports."""
        return float(min(SEARCHED * self.scale_speed, self.model.top_speed))

    @property
    def never_below(self) -> float:
        """A speed below which no balanced state is stable, rad/s: none is known without looking."""
        return 0.0

    @property
    def damping(self) -> tuple[float, ...]:
        """The greatest damping of the rotor: zero if it has none."""
        return (float(np.abs(self.model.damping).max()),)

    @property
    def orbit(self) -> Floats:
        """Orbit radius of each ball, (n,) m."""
        return np.asarray(self.moment / self.ball_mass)

    @property
    def as_station(self) -> Stations:
        """Itself; a plane becomes one."""
        return self

    @property
    def one_centric(self) -> bool:
        """Whether all balls run in one plane, around the axis."""
        return len(self.names) == 1 and not np.any(self.offset)

    @property
    def knows_any_unbalance(self) -> bool:
        """Whether all borders but the exact one of a state are those of any unbalance."""
        return self.isotropic and self.one_centric

    @property
    def greatest_resultant(self) -> float:
        """The greatest unbalance that balls side by side can balance, kg m: no single number where planes share it."""
        return math.inf

    @property
    def plain(self) -> bool:
        """Whether balls feel the deflection of their race and nothing else."""
        return self.slopes is None and self.forces is None

    def plain_at(self, speed: float) -> Stations:
        """The machine whose balls feel the deflection of their race and, at rest, their weight on it.

        On a leaning race gravity a along the axis acts as if the ball ran in the plane z - a/W^2. What is left of the tilt is
        of the second order in the slope, and nothing where the axis does not lean.
        """
        bare = self if self.forces is None else replace(self, forces=None)
        if self.slopes is None:
            return bare
        return replace(bare, rows=self.rows - self.weight / speed**2 * self.slopes, slopes=None)

    @property
    def fixed_load(self) -> Complexes:
        """Unbalances and the eccentric masses of the balls, (pairs,)."""
        eccentric = np.zeros(len(self.names), np.complex128)
        np.add.at(eccentric, self.station, self.ball_mass * self.offset)
        return self.load + self.rows.T @ eccentric

    def moments(self, angles: Floats) -> Complexes:
        """Resultant m eps e^(i phi) of the balls of each station, (P,) kg m."""
        result = np.zeros(len(self.names), np.complex128)
        np.add.at(result, self.station, self.moment * np.exp(1j * angles))
        return result

    def compliance(self, speed: float) -> Complexes:
        """Forward synchronous whirl of the coordinates for loads that turn with the rotor, (pairs, pairs).

        On anisotropic supports the forward component of the whirl.

        Raises
        ------
        QuestionError
            At a critical speed of an undamped rotor, as near to it as floating point tells.
        """
        n, model = self.model.pairs, self.model
        if self.isotropic:
            mass, turning, stiffness = model.complex_matrices(speed)
            return _inverse(stiffness, 1j * speed * turning, speed**2 * mass, speed)
        result = self.whole_compliance(speed)
        xx, xy, yx, yy = result[:n, :n], result[:n, n : 2 * n], result[n : 2 * n, :n], result[n : 2 * n, n : 2 * n]
        return np.asarray(0.5 * (xx + yy + 1j * (yx - xy)))

    def whole_compliance(self, speed: float) -> Complexes:
        """Complex amplitudes of all coordinates for forces e^(i W t), (N, N)."""
        model = self.model
        turning = model.damping_at(speed) + speed * model.gyroscopic
        return _inverse(model.stiffness_at(speed), 1j * speed * turning, speed**2 * model.mass, speed)

    def coordinates(self, speed: float, angles: Floats) -> Complexes:
        """Forward whirl of the coordinates, seen in the rotor, with the balls at rest at these angles, (pairs,)."""
        flat = self.plain_at(speed)
        result = np.asarray(
            speed**2 * (self.compliance(speed) @ (flat.fixed_load + flat.rows.T @ flat.moments(angles)))
        )
        if self.slopes is None:
            return result
        # the shorter reach of a ball on a leaning race, a moment -m W^2 (s.r) r, is no linear map of complex coordinates
        slopes, pairs = self.slopes[self.station], self.model.pairs
        place = self.offset + self.orbit * np.exp(1j * angles)
        lean = np.concatenate([slopes * place.real[:, None], slopes * place.imag[:, None]], 1)  # s.r of each ball
        back = lean.T * (self.ball_mass * speed**2)
        answer = self.compliance(speed)
        whole = np.block([[answer.real, -answer.imag], [answer.imag, answer.real]])
        both = np.linalg.solve(np.eye(2 * pairs) + whole @ back @ lean, np.concatenate([result.real, result.imag]))
        return np.asarray(both[:pairs] + 1j * both[pairs:])


def _inverse(stiffness: Any, turning: Any, inertia: Any, speed: float) -> Complexes:
    """Inverse of stiffness + turning - inertia, refused where these cancel to the last digits that numbers have."""
    dynamic = stiffness + turning - inertia
    size = np.sqrt(np.abs(np.diag(stiffness)) + np.abs(np.diag(turning)) + np.abs(np.diag(inertia)))
    try:
        result = np.linalg.inv(dynamic / np.outer(size, size))
    except np.linalg.LinAlgError:
        result = np.full_like(dynamic, np.inf)
    if not np.abs(result).max() * ROUNDING < 1.0:
        raise QuestionError(
            f"speed: {speed:.6g} rad/s is a critical speed of an undamped rotor, where its deflection is not determined"
        )
    return np.asarray(result / np.outer(size, size), np.complex128)


def stations(machine: Machine, unbalance: complex | float | None = None, *, largest: bool = False) -> Stations:
    """The stations of a machine.

    Parameters
    ----------
    machine
        Any machine without gravity across its axis.
    unbalance
        Size (kg m, its direction is kept) or vector of the machine's unbalance, which must then be a single one.
    largest
        Take the unbalances at the time at which they are largest, else those after all schedules.

    Raises
    ------
    QuestionError
        If gravity acts across the axis, ``unbalance`` is given and the machine has not just one, or of
        :func:`refuse_motion_along_the_axis`.
    """
    if machine.axis == "horizontal" and machine.gravity > 0.0:
        raise QuestionError(
            "steady states: gravity acts across the axis of this machine (horizontal axis); " + SIMULATE_OR_BASIN
        )
    # the rotor with the mass of its balls in their planes
    bare = lateral_model(machine)
    model = with_ball_mass(machine, bare)
    tilting, forces = machine.tilting_races == "full", forces_on(machine)
    if not model.isotropic and (tilting or forces is not None):
        refuse_motion_along_the_axis(model)
    # the balls by station and by race
    balls = resolve(machine)
    planes = planes_of(machine, bare)
    races = sorted({(ball.balancer, ball.race) for ball in balls})
    load, resultant = load_of(machine, bare, largest)
    if unbalance is not None:
        load, resultant = load_of_size(machine, bare, unbalance)
    return Stations(
        model=model,
        names=planes.names,
        rows=rows_matrix(list(planes.rows)).reshape(len(planes.rows), model.pairs),
        load=load,
        unbalance=resultant,
        ball_mass=np.array([ball.effective_mass for ball in balls]),
        moment=np.array([ball.moment for ball in balls]),
        inertia=np.array([ball.inertia for ball in balls]),
        drag=np.array([ball.drag for ball in balls]),
        station=np.array([planes.of_balancer[ball.balancer] for ball in balls], np.int64),
        race=np.array([races.index((ball.balancer, ball.race)) for ball in balls], np.int64),
        offset=np.array([ball.eccentricity for ball in balls], np.complex128),
        capability=np.array(
            [
                capability_of(ball for ball in balls if planes.of_balancer[ball.balancer] == number)
                for number in range(len(planes.rows))
            ],
            np.float64,
        ),
        slopes=np.array([rows.slope for rows in planes.rows]).reshape(len(planes.rows), model.pairs)
        if tilting
        else None,
        weight=axial_gravity(machine) if tilting else 0.0,
        forces=forces,
    )


def refuse_motion_along_the_axis(model: LateralModel) -> None:
    """Refuse a rotor that forces across its axis also move along or about it: the vector field has no such coordinates.

    Raises
    ------
    QuestionError
        If it does.
    """
    lateral = 2 * model.pairs
    for matrix in (model.mass, model.gyroscopic, *model.damping, *model.stiffness):
        if np.abs(matrix[:lateral, lateral:]).max(initial=0.0) > ALONG * np.abs(matrix).max():
            raise QuestionError(
                "rotor: forces across its axis also move it along or about the axis. On supports that differ along x and y, "
                'branches, tilting_races = "full" and forces on the balls are then not known here; simulate the machine, or '
                "ask about balls that feel the deflection of their race only"
            )


def station_form(machine: Machine, unbalance: complex | float | None = None) -> Stations:
    """The stations of any machine; a planar one is a single station, and may have any unbalance."""
    return in_plane(machine, unbalance) if is_planar(machine) else stations(machine, unbalance)


def is_planar(machine: Machine) -> bool:
    """Whether the rotor is a planar one."""
    return isinstance(machine.rotor, PlanarRotor)


def in_plane(machine: Machine, unbalance: complex | float | None = None) -> Stations:
    """A planar machine as one station, with the forces on its balls.

    Raises
    ------
    QuestionError
        As of :func:`~autobalancer.stability.host.stations.plane`.
    """
    return replace(of_plane(plane(machine, unbalance, with_forces=True)), forces=forces_on(machine))


def of_plane(p: Plane) -> Stations:
    """A planar machine as one station of a rotor with one pair of coordinates."""
    model = LateralModel(
        mass=p.mass * np.eye(2),
        gyroscopic=np.zeros((2, 2)),
        speeds=np.zeros(1),
        damping=np.diag(p.damping)[None],
        stiffness=np.diag(p.stiffness)[None],
        pairs=1,
        coordinates=("x", "y"),
        axis=Point(),
        polar_inertia=None,
        total_mass=p.mass,
    )
    return Stations(
        model=model,
        names=("plane",),
        rows=np.ones((1, 1)),
        load=np.array([p.unbalance], np.complex128),
        unbalance=p.unbalance,
        ball_mass=p.ball_mass,
        moment=p.moment,
        inertia=p.inertia,
        drag=p.drag,
        station=np.zeros(p.moment.size, np.int64),
        race=p.race,
        offset=p.offset,
        capability=np.array([min(p.capability, float(p.moment.sum()))]),
        planar=True,
    )


# Loads of the unbalances of a machine on the coordinates of its rotor.


def load_of(machine: Machine, model: LateralModel, largest: bool) -> tuple[Complexes, complex]:
    """Load and resultant after all schedules, or at the time at which the load is largest."""
    if not largest:
        return _load_at(machine, model, np.inf, False)
    inverse = np.linalg.inv(model.mass[: model.pairs, : model.pairs])
    result = loads_at_corners(machine, model)
    return max(result, key=lambda one: float(np.real(one[0].conj() @ inverse @ one[0])))


def loads_at_corners(machine: Machine, model: LateralModel) -> list[tuple[Complexes, complex]]:
    """Load and resultant just before and after each time of all schedules; between two of them both change linearly."""
    return [_load_at(machine, model, time, before) for time in schedule_times(machine) for before in (False, True)]


def _load_at(machine: Machine, model: LateralModel, time: float, before: bool) -> tuple[Complexes, complex]:
    load = np.zeros(model.pairs, np.complex128)
    for number, part in enumerate(machine.unbalances):
        load += unbalance_factor(part, time, before=before) * unbalance_shape(machine, model, number)
    return load, unbalance_vector(machine, time, before=before)


def vector_of(unbalance: complex | float) -> complex:
    """An unbalance that is given, a vector or a mere size, kg m."""
    value = complex(unbalance)
    if not np.isfinite(value) or (not isinstance(unbalance, complex) and value.real < 0.0):
        raise QuestionError(f"unbalance: given {unbalance!r}; must be a size not below zero, in kg m, or a vector")
    return value


def load_of_size(machine: Machine, model: LateralModel, unbalance: complex | float) -> tuple[Complexes, complex]:
    """Load and resultant with another size or vector of the only unbalance, kg m."""
    if len(machine.unbalances) != 1 or machine.unbalances[0].is_couple:
        raise QuestionError(
            f"unbalance: the machine has {len(machine.unbalances)} unbalances along its axis; change the one you mean in "
            "the machine, such as 'unbalances[1].moment'"
        )
    value, part = vector_of(unbalance), machine.unbalances[0]
    direction = complex(np.exp(1j * float(part.angle)))
    if isinstance(unbalance, complex):
        value = value / direction
    one = machine.model_copy(update={"unbalances": (Unbalance(moment=1.0, angle=part.angle, station=part.station),)})
    return np.asarray(value * unbalance_shape(one, model, 0)), value * direction


# Power series of a few terms, so that equations with products can be differentiated as they stand.


Numbers = NDArray[Any]  # real or complex


class Series:
    """Coefficients of h^0, h^1 ...: arrays that broadcast. Missing ones are zero; products are cut after ``order``."""

    __array_ufunc__ = None  # arrays leave products with a series to the series

    def __init__(self, parts: list[Any], order: int) -> None:
        self.parts, self.order = parts[: order + 1], order

    def __getitem__(self, power: int) -> Any:
        return self.parts[power] if power < len(self.parts) else 0.0

    def __neg__(self) -> Series:
        return Series([-part for part in self.parts], self.order)

    def __add__(self, other: Series | Numbers | float) -> Series:
        if not isinstance(other, Series):
            return Series([self[0] + other, *self.parts[1:]], self.order)
        most = max(len(self.parts), len(other.parts))
        return Series([self[k] + other[k] for k in range(most)], self.order)

    def __sub__(self, other: Series | Numbers | float) -> Series:
        return self + -other

    def __mul__(self, other: Series | Numbers | float) -> Series:
        if not isinstance(other, Series):
            return Series([part * other for part in self.parts], self.order)
        most = min(len(self.parts) + len(other.parts) - 1, self.order + 1)
        return Series([self._product(other, k) for k in range(most)], self.order)

    def _product(self, other: Series, power: int) -> Any:
        first, last = max(power - len(other.parts) + 1, 0), min(power, len(self.parts) - 1)
        return sum(self.parts[j] * other.parts[power - j] for j in range(first, last + 1))

    __rmul__ = __mul__


# The damping of the whirl at a critical speed, and of all free motions of the rotor.


def damping_ratio(model: LateralModel, speed: float) -> float:
    """Of the free whirl that turns with the rotor at a critical speed."""
    values = free_eigenvalues(model, speed)
    own = values[np.argmin(np.abs(values - 1j * speed))]
    return float(-own.real / abs(own))


def free_eigenvalues(model: LateralModel, speed: float) -> NDArray[np.complex128]:
    """Eigenvalues of the rotor at a speed, 1/s, with the mass of the balls on it."""
    mass: NDArray[Any]
    stiffness: NDArray[Any]
    turning: NDArray[Any]
    if model.isotropic:
        mass, turning, stiffness = model.complex_matrices(speed)
    else:
        mass, stiffness = model.mass, model.stiffness_at(speed)
        turning = model.damping_at(speed) + speed * model.gyroscopic
    n = mass.shape[0]
    first = np.block(
        [
            [np.zeros((n, n)), np.eye(n)],
            [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, turning)],
        ]
    )
    return np.asarray(np.linalg.eigvals(first), np.complex128)
