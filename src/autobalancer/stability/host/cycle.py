"""The equations where x and y are not alike: a steady state there repeats with every half turn of the rotor.

In the frame of the rotor they are x' = f(x, theta) with theta = W t and the period pi. A state is a function x(theta) with
that period, and

    dx/dt + W dx/dtheta = f(x, theta)

has no angle in it that is not a coordinate: steady states are at rest in it, and theories of states at rest serve as they stand:
Newton's method, continuation, folds, Hopf points and their coefficients (Kuznetsov et al. 2005). x(theta) is counted in
harmonics 1, sqrt(2) cos 2 theta, sqrt(2) sin 2 theta, ..., at as many angles of half a turn, so that the mean of x^2 is the sum
of squares, and the first numbers of a state are its mean. Where the motion is smooth, some harmonics are exact to rounding.

Growth rates are ln(multiplier) over the time of half a turn. Multipliers are those of the map over half a turn, which is
integrated by the Gauss method of four stages (order eight). A growth rate plus 2iW is another name for the same motion.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

from autobalancer.stability.host.planar import Complexes, Floats, Matrix
from autobalancer.stability.host.series import Numbers
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.host.vector_field import Field

STEPS, MOST = 24, 96  # in half a turn, at least and at most
PER_PERIOD = 12  # steps in a period of the fastest motion of the rotor


@dataclass(frozen=True)
class Cycle:
    """The vector field of states that are functions of the rotor angle, (count * size,): harmonic after harmonic.

    ``count`` is odd: the mean, then cosine and sine of each harmonic.
    """

    host: Stations
    speed: float
    count: int

    @cached_property
    def field(self) -> Field:
        """The vector field at the angles."""
        return Field(self.host, self.speed, np.pi * np.arange(self.count) / self.count)

    @property
    def balls(self) -> int:
        """Number of balls n."""
        return self.field.balls

    @property
    def rotor(self) -> int:
        """Number of components in front of the ball angles."""
        return self.field.rotor

    @property
    def size(self) -> int:
        """Number of components at one angle."""
        return self.rotor + 2 * self.balls

    def around(self, state: Numbers) -> Numbers:
        """States at the angles, (..., count, size)."""
        return np.asarray(_waves(self.count) @ state.reshape(*state.shape[:-1], self.count, self.size))

    def at(self, state: Floats, theta: Floats) -> Floats:
        """A state at any rotor angles, (k, size)."""
        return np.asarray(_waves(self.count, theta) @ state.reshape(self.count, self.size))

    def harmonics(self, states: Numbers) -> Numbers:
        """The other way, (..., count * size)."""
        found = _waves(self.count).T @ states / self.count
        return np.asarray(found.reshape(*states.shape[:-2], self.count * self.size))

    def __call__(self, state: Floats) -> Floats:
        """Time derivative of a state."""
        moved = self.harmonics(self.field(self.around(state)))
        return np.asarray(moved - self.speed * (_slopes(self.count) @ state.reshape(self.count, -1)).ravel())

    def jacobian(self, state: Floats) -> Matrix:
        """Derivative with respect to the state."""
        found = self._spread(self.field.jacobian(self.around(state)))
        count, size = self.count, self.size
        found.reshape(count, size, count, size)[:, range(size), :, range(size)] -= self.speed * _slopes(count)
        return found

    def _spread(self, blocks: Numbers) -> Numbers:
        """Matrices at the angles, (count, size, size), as one matrix over the harmonics."""
        waves, count = _waves(self.count), self.count
        mixed = np.einsum("ja,jb->abj", waves, waves).reshape(count * count, count) / count
        both = (mixed @ blocks.reshape(count, -1)).reshape(count, count, self.size, self.size)
        return np.asarray(both.transpose(0, 2, 1, 3).reshape(count * self.size, count * self.size))

    def second(self, state: Floats, u: Numbers, v: Numbers) -> Numbers:
        """The symmetric bilinear form B(u, v) of the second derivatives."""
        return self.harmonics(self.field.second(self.around(state), self.around(u), self.around(v)))

    def bent(self, state: Floats, u: Numbers) -> Numbers:
        """The matrix of B(u, .)."""
        here, way = self.around(state), self.around(u)
        each = self.field.units(here)
        found = self.field.second(here, np.broadcast_to(way, each.shape), each.astype(way.dtype))
        return self._spread(np.moveaxis(found, 0, -1))

    def third(self, state: Floats, u: Numbers, v: Numbers) -> Numbers:
        """The symmetric trilinear form C(u, u, v) of the third derivatives."""
        return self.harmonics(self.field.third(self.around(state), self.around(u), self.around(v)))

    def held(self, stiffness: Floats, damping: Floats) -> Floats:
        """The constant r that holds d'' + c(theta) d' + r(theta) d = 0 (prime: by theta) at the same border, (n,).

        ``stiffness`` r and ``damping`` c at the angles, (count, n). The other harmonics of d are eliminated: what is left of
        its mean vanishes where d has the multiplier 1.
        """
        waves, slopes, found = _waves(self.count), _slopes(self.count), []
        for r, c in zip(stiffness.T, damping.T, strict=True):
            whole = waves.T @ (r[:, None] * waves + c[:, None] * (waves @ slopes)) / self.count + slopes @ slopes
            found.append(whole[0, 0] - whole[0, 1:] @ np.linalg.solve(whole[1:, 1:], whole[1:, 0]))
        return np.array(found)

    def half_turn(self, state: Floats) -> Matrix:
        """The map of small motions over half a turn from the angle zero on, in the frame of the rotor, (size, size)."""
        model = self.host.model
        stiffness = np.linalg.solve(model.mass, model.stiffness_at(self.speed))
        fastest = math.sqrt(float(np.abs(np.linalg.eigvals(stiffness)).max())) + self.speed  # seen from the rotor
        steps = steps_of(fastest, self.speed)
        nodes, weights, inner = gauss()
        width = math.pi / steps
        theta = (width * (np.arange(steps)[:, None] + nodes)).ravel()
        rates = replace(self.field, theta=theta).jacobian(self.at(state, theta)).reshape(steps, 4, self.size, self.size)
        size, h = self.size, width / self.speed
        left = np.eye(4 * size) - h * np.einsum("ij,sikl->sikjl", inner, rates).reshape(steps, 4 * size, 4 * size)
        stages = np.linalg.solve(left, rates.reshape(steps, 4 * size, size)).reshape(steps, 4, size, size)
        maps = np.eye(size) + h * np.einsum("i,sikl->skl", weights, stages)
        whole = np.eye(size)
        for one in maps:
            whole = one @ whole
        return whole

    def exponents(self, state: Floats) -> Complexes:
        """Growth rates, 1/s, greatest real part first, (size,)."""
        multipliers = np.linalg.eigvals(self.half_turn(state)).astype(np.complex128)
        multipliers[multipliers == 0.0] = np.finfo(float).tiny  # what dies out within half a turn
        values = np.log(multipliers) * self.speed / math.pi
        return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)


Equations = Field | Cycle  # a rotor by its supports: isotropic, or not


def steps_of(fastest: float, speed: float) -> int:
    """Number of steps in half a turn for a rotor whose fastest motion has this frequency, rad/s.

    Motions that are too fast for the greatest number still decay or grow by the method as they do, only at another rate; those up
    to some times the speed, which decide, do not notice.
    """
    return min(max(STEPS, math.ceil(PER_PERIOD * fastest / (2.0 * speed))), MOST)


@cache
def gauss() -> tuple[Floats, Floats, Matrix]:
    """Nodes and weights in the unit interval, and integrals of the Lagrange polynomials from 0 to each node."""
    nodes, weights = np.polynomial.legendre.leggauss(4)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    powers, order = np.vander(nodes, increasing=True), np.arange(1, 5)
    return nodes, weights, np.asarray((nodes[:, None] ** order / order) @ np.linalg.inv(powers))


def step_maps(held: Matrix, slowed: Matrix, h: float) -> Matrix:
    """Maps of (x, x') over steps of a width h where x'' = held x + slowed x' at the nodes, (4 s, d, d) each; (s, 2 d, 2 d).

    Gauss' method of four stages, solved for accelerations only, which positions and speeds follow from.
    """
    nodes, weights, inner = gauss()
    size, steps = held.shape[-1], len(held) // 4
    held, slowed = held.reshape(steps, 4, 1, size, size), slowed.reshape(steps, 4, 1, size, size)
    left = -(h * h) * (inner @ inner)[:, :, None, None] * held - h * inner[:, :, None, None] * slowed  # (s, 4, 4, d, d)
    left = left.swapaxes(2, 3).reshape(steps, 4 * size, 4 * size)
    left[:, range(4 * size), range(4 * size)] += 1.0
    right = np.concatenate([held, slowed + h * nodes[:, None, None, None] * held], axis=-1)
    found = np.linalg.solve(left, right.reshape(steps, 4 * size, 2 * size)).reshape(steps, 4, -1)
    maps = np.zeros((steps, 2 * size, 2 * size)) + np.eye(2 * size)
    maps[:, range(size), range(size, 2 * size)] += h
    maps[:, :size] += h * h * (weights @ inner @ found).reshape(steps, size, 2 * size)
    maps[:, size:] += h * (weights @ found).reshape(steps, size, 2 * size)
    return maps


def _waves(count: int, theta: Floats | None = None) -> Matrix:
    """Harmonics, the columns, at the angles of half a turn or at others."""
    return _at_own(count) if theta is None else _harmonics(count, theta)


@cache
def _at_own(count: int) -> Matrix:
    return _harmonics(count, np.pi * np.arange(count) / count)


def _harmonics(count: int, theta: Floats) -> Matrix:
    found = np.ones((theta.size, count))
    for k in range(1, count // 2 + 1):
        found[:, 2 * k - 1], found[:, 2 * k] = (
            math.sqrt(2.0) * np.cos(2 * k * theta),
            math.sqrt(2.0) * np.sin(2 * k * theta),
        )
    return found


@cache
def _slopes(count: int) -> Matrix:
    """Derivative with respect to the angle, over the harmonics."""
    found = np.zeros((count, count))
    for k in range(1, count // 2 + 1):
        found[2 * k - 1, 2 * k], found[2 * k, 2 * k - 1] = 2.0 * k, -2.0 * k
    return found
