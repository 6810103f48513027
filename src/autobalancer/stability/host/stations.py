"""What stability needs of a machine whose rotor tilts or bends: its matrices, the stations of its balls, its unbalance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.assembly.host import axial_gravity
from autobalancer.assembly.rotors import LateralModel, lateral_model, rows_matrix, with_ball_mass
from autobalancer.assembly.rotors.critical import critical_speeds, natural_frequencies
from autobalancer.assembly.rotors.planes import planes_of
from autobalancer.assembly.rotors.rigid import Point
from autobalancer.catalog.race_capability import capability_of
from autobalancer.catalog.resolve import resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.stability.host.forces import BallForces, forces_on
from autobalancer.stability.host.loads import load_of, load_of_size
from autobalancer.stability.host.planar import Complexes, Floats, Matrix, Plane, plane

ALONG = 1e-9  # share of the greatest entry of a matrix that moves nothing
ROUNDING = 4.0 * float(np.finfo(float).eps)  # of a sum of terms that cancel, over the terms


@dataclass(frozen=True)
class Stations:
    """A machine at constant speed W without gravity across its axis, SI; P stations carry n balls.

    The planar machine is the limit of one station and one pair of coordinates;
    :class:`~autobalancer.stability.host.planar.Plane` is the same for it, and faster.
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

    @property
    def isotropic(self) -> bool:
        """Whether x and y are alike."""
        return self.model.isotropic

    @cached_property
    def critical_speeds(self) -> tuple[float, ...]:
        """Undamped, rad/s, ascending: those an unbalance excites; may be empty."""
        return critical_speeds(self.model)

    @cached_property
    def scale_speed(self) -> float:
        """A speed of the size of the machine's own, rad/s: the lowest critical speed, or frequency at rest."""
        return self.critical_speeds[0] if self.critical_speeds else float(natural_frequencies(self.model)[0])

    @property
    def orbit(self) -> Floats:
        """Orbit radius of each ball, (n,) m."""
        return np.asarray(self.moment / self.ball_mass)

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
        found = np.zeros(len(self.names), np.complex128)
        np.add.at(found, self.station, self.moment * np.exp(1j * angles))
        return found

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
        found = self.whole_compliance(speed)
        xx, xy, yx, yy = found[:n, :n], found[:n, n : 2 * n], found[n : 2 * n, :n], found[n : 2 * n, n : 2 * n]
        return np.asarray(0.5 * (xx + yy + 1j * (yx - xy)))

    def whole_compliance(self, speed: float) -> Complexes:
        """Complex amplitudes of all coordinates for forces e^(i W t), (N, N)."""
        model = self.model
        turning = model.damping_at(speed) + speed * model.gyroscopic
        return _inverse(model.stiffness_at(speed), 1j * speed * turning, speed**2 * model.mass, speed)

    def coordinates(self, speed: float, angles: Floats) -> Complexes:
        """Forward whirl of the coordinates, seen in the rotor, with the balls at rest at these angles, (pairs,)."""
        flat = self.plain_at(speed)
        found = np.asarray(speed**2 * (self.compliance(speed) @ (flat.fixed_load + flat.rows.T @ flat.moments(angles))))
        if self.slopes is None:
            return found
        # the shorter reach of a ball on a leaning race, a moment -m W^2 (s.r) r, is no linear map of complex coordinates
        slopes, pairs = self.slopes[self.station], self.model.pairs
        place = self.offset + self.orbit * np.exp(1j * angles)
        lean = np.concatenate([slopes * place.real[:, None], slopes * place.imag[:, None]], 1)  # s.r of each ball
        back = lean.T * (self.ball_mass * speed**2)
        answer = self.compliance(speed)
        whole = np.block([[answer.real, -answer.imag], [answer.imag, answer.real]])
        both = np.linalg.solve(np.eye(2 * pairs) + whole @ back @ lean, np.concatenate([found.real, found.imag]))
        return np.asarray(both[:pairs] + 1j * both[pairs:])


def _inverse(stiffness: Any, turning: Any, inertia: Any, speed: float) -> Complexes:
    """Inverse of stiffness + turning - inertia, refused where these cancel to the last digits that numbers have."""
    dynamic = stiffness + turning - inertia
    size = np.sqrt(np.abs(np.diag(stiffness)) + np.abs(np.diag(turning)) + np.abs(np.diag(inertia)))
    try:
        found = np.linalg.inv(dynamic / np.outer(size, size))
    except np.linalg.LinAlgError:
        found = np.full_like(dynamic, np.inf)
    if not np.abs(found).max() * ROUNDING < 1.0:
        raise QuestionError(
            f"speed: {speed:.6g} rad/s is a critical speed of an undamped rotor, where its deflection is not determined"
        )
    return np.asarray(found / np.outer(size, size), np.complex128)


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
            "steady states: gravity acts across the axis of this machine (horizontal axis); simulate it instead, "
            "or ask basin with random starts"
        )
    bare = lateral_model(machine)
    model = with_ball_mass(machine, bare)
    tilting, forces = machine.tilting_races == "full", forces_on(machine)
    if not model.isotropic and (tilting or forces is not None):
        refuse_motion_along_the_axis(model)
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


def in_plane(machine: Machine, unbalance: complex | float | None = None) -> Stations:
    """A planar machine as one station, with the forces on its balls.

    Raises
    ------
    QuestionError
        As of :func:`~autobalancer.stability.host.planar.plane`.
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
        capability=np.array([p.capability]),
    )
