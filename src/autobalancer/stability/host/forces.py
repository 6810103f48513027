"""Forces on the balls that are leaves, as stability needs them: their torques, and the derivatives of these.

The compiled forces are called as a run calls them. Derivatives along a direction come from values at seven places on it, some
thousandths of a radian apart, exact for polynomials of degree six. The order of the balls around a race, which a force between
neighbors needs, is that at the state in question.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from autobalancer.assembly.contact.meetings import contact_rows
from autobalancer.assembly.drive import steady
from autobalancer.assembly.forces.rows import force_rows, forces_in, has_forces
from autobalancer.assembly.guided import ball_rows, moving_rows
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.kernels.system import BALLS, System
from autobalancer.machine import Machine
from autobalancer.random_numbers import generator
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.host.series import Numbers

APART, WIDER = 2e-3, 1e-2  # rad between two places: for first derivatives, and where higher ones are wanted
PLACES = np.arange(-3.0, 4.0)
WEIGHTS = np.linalg.inv(np.vander(PLACES, increasing=True))  # values at the places -> powers of the way between them
TURN = 2.0 * np.pi
ROUNDING = 1e-13  # torque over wall force and radius
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
        found = _torques_and_wall_forces(system, angles, rates, speed)[:, :count]
        together = np.zeros((len(angles), shape[-1]))
        np.add.at(together.T, place, found.T)
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
        found = [
            one[0],
            one[1] + 1j * other[1],
            one[2] - other[2] + 1j * apart[2],
            2.0 * one[3] - both[3] + 1j * (apart[3] - 2.0 * other[3]),
        ]
        return found[: order + 1]

    def _along(
        self, angles: Floats, rates: Floats, turn: Floats, change: Floats, speed: float, order: int
    ) -> list[Numbers]:
        size = np.maximum(np.abs(turn).max(-1), np.abs(change).max(-1) / speed)[..., None]
        step = (APART if order < 2 else WIDER) / np.where(size > 0.0, size, 1.0)
        way = PLACES.reshape(-1, *[1] * np.ndim(turn)) * step
        values = self.torques(angles + way * turn, rates + way * change, speed, _first(angles))
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
            for one, rate in zip(angles, rates * speed, strict=True):
                found = _torques_and_wall_forces(self._system(one), one[None], rate[None], speed)[0]
                radius = np.array([ball.orbit_radius for ball in self.balls])
                if (np.abs(found[:count]) > ROUNDING * np.abs(found[count:]) * radius).any():
                    return True
        return False


def _torques_and_wall_forces(system: System, angles: Floats, rates: Floats, speed: float) -> Floats:
    from autobalancer.kernels.balls.force_torques import force_torques

    count = system.ball_count
    states, found = np.zeros((len(angles), BALLS + 2 * count)), np.zeros((len(angles), 2 * count))
    states[:, BALLS : BALLS + count], states[:, BALLS + count :] = angles, rates
    force_torques(system, states, speed, found)
    return found


def _first(angles: Floats) -> Floats:
    return np.asarray(np.reshape(angles, (-1, angles.shape[-1]))[0])


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
    found = BallForces(machine, balls, any(force.pairs for _, force, _ in forces_in(machine, balls)))
    pushing = found.push()
    _TRIED.add(found.kinds)
    return found if pushing else None
