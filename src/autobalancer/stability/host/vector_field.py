"""The equations of balls on any rotor at constant speed W as a smooth vector field in the frame of the rotor.

State: coordinates Q of the rotor (``pairs`` along X, as many along Y), V (their velocity in space along the axes of the
rotor), ball angles phi, ball speeds phi' in the rotor. With s = m eps, t and n the tangential and radial unit vectors at a
ball, B the row of its station, A = V' + iW V and c the center of its race in the rotor,

    M A + sum B^T s t phi'' = -K Q - (C - iWG) V + W^2 F + sum B^T s (W + phi')^2 n
    I phi'' + s t.(B A)     = -beta phi' + s W^2 Im[e^(-i phi) c]

M has the balls' mass on it, F are the unbalances and the eccentric masses of the balls. A planar rotor has one pair of
coordinates, one station and B = 1. Where x and y are not alike, M, C, G and K turn backward in these axes, by the rotor angle
theta, and come back after half a turn (:mod:`autobalancer.stability.host.vector_field`).

There is more on races that tilt (:mod:`autobalancer.stability.host.vector_field`) and with forces on the balls
(:mod:`autobalancer.stability.host.stations`). These are the compiled equations written so that they can be differentiated: both
sides as Taylor series along a direction give derivatives of any order from one linear solve each, exact to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache, cached_property, reduce
from typing import NamedTuple

import numpy as np

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.stability.host.stations import Numbers, Series, Stations, refuse_motion_along_the_axis


@dataclass(frozen=True)
class Field:
    """The vector field of a machine at a speed; the last axis of a state counts its 4 ``pairs`` + 2 n components.

    On anisotropic supports at the rotor angles ``theta`` (rad): one, or one for each entry of the last but one axis of a state.
    """

    host: Stations
    speed: float
    theta: float | Floats = 0.0

    count = 1  # of harmonics of a state, see :class:`~autobalancer.stability.host.vector_field.Cycle`

    @property
    def balls(self) -> int:
        """Number of balls n."""
        return self.host.moment.size

    @property
    def rotor(self) -> int:
        """Number of components of a state that belong to the rotor: Q and V."""
        return 4 * self.host.model.pairs

    @cached_property
    def rows(self) -> Matrix:
        """Deflection of each ball's station over the coordinates, (n, pairs)."""
        return np.asarray(self.host.rows[self.host.station])

    @cached_property
    def _matrices(self) -> tuple[Matrix, Matrix, Matrix, Floats]:
        """M, C - iWG, K over Q_x, Q_y, each also for every angle where x and y are not alike, and the load W^2 F."""
        model, load = self.host.model, self.speed**2 * self.host.fixed_load
        fixed = np.concatenate([load.real, load.imag])
        if model.isotropic:
            mass, turning, stiffness = (_real(m) for m in model.complex_matrices(self.speed))
            return mass, turning, stiffness, fixed
        refuse_motion_along_the_axis(model)
        n, both = 2 * model.pairs, np.arange(model.pairs)
        turned, angles = np.zeros((*np.shape(self.theta), n, n)), np.asarray(self.theta)[..., None]
        x, y = both, model.pairs + both
        turned[..., x, x] = turned[..., y, y] = np.cos(angles)
        turned[..., y, x], turned[..., x, y] = np.sin(angles), -np.sin(angles)
        turning = model.damping_at(self.speed) + self.speed * model.gyroscopic
        back = np.swapaxes(turned, -1, -2)
        mass, turning, stiffness = (
            back @ m[:n, :n] @ turned for m in (model.mass, turning, model.stiffness_at(self.speed))
        )
        return mass, turning, stiffness, fixed

    def __call__(self, states: Floats) -> Floats:
        """Time derivative of one state or of many."""
        return np.asarray(self.taylor(states, np.zeros_like(states), 0)[0], np.float64)

    def taylor(self, state: Numbers, direction: Numbers, order: int) -> list[Numbers]:
        """Coefficients of h^0, h^1 ... of the field at ``state + h direction``; the direction may be complex."""
        state = np.broadcast_to(state, direction.shape)
        matrices, right = self.series(state, direction, order)
        rates: list[Numbers] = []
        for k in range(order + 1):
            for j in range(1, k + 1):
                right[k] = right[k] - (matrices[j] @ rates[k - j][..., None])[..., 0]
            rates.append(np.linalg.solve(self.inertia(matrices[0]), right[k][..., None])[..., 0])
        return [self._assembled((state, direction)[k] if k < 2 else None, rates[k]) for k in range(order + 1)]

    def series(self, state: Numbers, direction: Numbers, order: int) -> tuple[list[Numbers], list[Numbers]]:
        """Coefficients of the varying part of the inertia and of the right-hand side over A and phi''."""
        p, n, speed, first = self.host, self.balls, self.speed, self.rotor
        half = first // 2
        _, damping, stiffness, fixed = self._matrices
        angle, turn = state[..., first : first + n], direction[..., first : first + n]
        rate, change = state[..., first + n :], direction[..., first + n :]
        # powers of the way along the direction: of the square of a ball's speed in space,
        square = [(speed + rate) ** 2, 2.0 * (speed + rate) * change, change**2]
        cosine, sine, matrices = [], [], []
        right: list[Numbers] = []
        # of cos and sin, whose derivatives repeat, and so of all that is a product of these
        for k in range(order + 1):
            factor = turn**k / math.factorial(k)
            cosine.append(np.cos(angle + 0.5 * np.pi * k) * factor)
            sine.append(np.sin(angle + 0.5 * np.pi * k) * factor)
            matrices.append(self._coupling(cosine[k], sine[k]))
            here = (state, direction)[k] if k < 2 else np.zeros_like(direction)
            load = -_product(stiffness, here[..., :half]) - _product(damping, here[..., half:first])
            if k == 0:
                load = load + fixed
            # centrifugal forces at the stations
            pull = [sum(square[j] * side[k - j] for j in range(min(k, 2) + 1)) for side in (cosine, sine)]
            load = load + np.concatenate([(p.moment * part) @ self.rows for part in pull], -1)
            # torques: drag, and what the eccentricity of the race does
            across = p.offset.imag * cosine[k] - p.offset.real * sine[k]
            torque = -p.drag * here[..., first + n :] + p.moment * speed**2 * across
            right.append(np.concatenate([load, torque], -1))
        # forces and tilt add to both
        if p.forces is not None:
            for total, more in zip(right, p.forces.series(angle, rate, turn, change, speed, order), strict=True):
                total[..., half:] += more
        if p.slopes is not None:
            self._tilt(state, direction, cosine, sine, matrices, right)
        return matrices, right

    def _tilt(
        self,
        state: Numbers,
        direction: Numbers,
        cosine: list[Numbers],
        sine: list[Numbers],
        matrices: list[Numbers],
        right: list[Numbers],
    ) -> None:
        """Add what balls on a race that tilts feel and do, see :mod:`autobalancer.stability.host.vector_field`."""
        p, n, first = self.host, self.balls, self.rotor
        assert p.slopes is not None
        order, pairs, slopes = len(right) - 1, first // 4, p.slopes[p.station]
        # everything as series in the way along the direction, so that products are those of series
        c, s = Series(cosine, order), Series(sine, order)

        def straight(part: slice, rows: Matrix | None = None) -> Series:
            both = [one[..., part] if rows is None else one[..., part] @ rows.T for one in (state, direction)]
            return Series(both, order)

        def quarter(number: int) -> Series:
            return straight(slice(number * pairs, (number + 1) * pairs), slopes)

        # where the balls are in the race, and how it tilts
        across, up = p.orbit * c + p.offset.real, p.orbit * s + p.offset.imag
        adds = tilted(
            Feels(
                p.ball_mass, across, up, -p.orbit * s, p.orbit * c, p.orbit * (up * c - across * s),
                straight(slice(first + n, None)), *(quarter(number) for number in range(4)),
            ),
            self.speed,
            p.weight,
        )  # fmt: skip
        x, y, ball = slice(0, pairs), slice(pairs, 2 * pairs), slice(2 * pairs, None)
        # into the matrix and the load, term by term
        for k in range(order + 1):
            matrix, load = matrices[k], right[k]
            for part, lean, moment in ((x, adds.lean_x, adds.moment_x), (y, adds.lean_y, adds.moment_y)):
                block = slopes.T * np.asarray(lean[k])[..., None, :]
                matrix[..., part, ball] += block
                matrix[..., ball, part] += np.swapaxes(block, -1, -2)
                load[..., part] += moment[k] @ slopes
            for one, other, entry in ((x, x, adds.xx), (x, y, adds.xy), (y, x, adds.xy), (y, y, adds.yy)):
                matrix[..., one, other] += (slopes.T * np.asarray(entry[k])[..., None, :]) @ slopes
            load[..., ball] += adds.torque[k]

    def at(self, state: Floats, theta: Floats) -> Floats:
        """A state, which is at rest, at any rotor angles: once."""
        return state[None]

    def around(self, state: Numbers) -> Numbers:
        """The state, which is alike at all angles."""
        return state

    def exponents(self, state: Floats, scale: Floats | float = 1.0) -> Complexes:
        """Growth rates, 1/s, greatest real part first, (size,); ``scale`` is the size of each component."""
        sizes = np.broadcast_to(scale, state.shape)
        values = np.linalg.eigvals(self.jacobian(state) * sizes / sizes[:, None])
        return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)

    def held(self, stiffness: Floats, damping: Floats) -> Floats:
        """As :meth:`Cycle.held`: the stiffness is constant."""
        return stiffness

    @property
    def field(self) -> Field:
        """Itself."""
        return self

    def accelerations(self, states: Floats, rates: Floats) -> Floats:
        """A, of the coordinates in space along the axes of the rotor; ``rates`` is the field there."""
        half = self.rotor // 2
        return np.asarray(rates[..., half : self.rotor] - self._turned(states[..., half : self.rotor]))

    def jacobian(self, states: Floats) -> Matrix:
        """Derivative of the field with respect to the state, (..., size, size)."""
        if not self.host.plain:  # balls feel more than the deflection of their race: one direction after the other
            directions = self.units(states)
            matrices, pushes = self.series(np.broadcast_to(states, directions.shape), directions, 1)
            inertia = self.inertia(matrices[0][0])
            rates = np.linalg.solve(inertia, pushes[0][0, ..., None])
            moved = pushes[1] - (matrices[1] @ rates)[..., 0]
            return self._slopes(np.linalg.solve(inertia, np.moveaxis(moved, 0, -1)))
        p, n, speed, first = self.host, self.balls, self.speed, self.rotor
        half, pairs = first // 2, first // 4
        _, damping, stiffness, _ = self._matrices
        angle, rate = states[..., first : first + n], states[..., first + n :]
        c, s = np.cos(angle), np.sin(angle)
        # accelerations there, which multiply the slopes of the inertia
        values = self(states)
        whole = self.accelerations(states, values)
        ax, ay = whole[..., :pairs] @ self.rows.T, whole[..., pairs:] @ self.rows.T
        spin = values[..., first + n :]
        # rows of the rotor: springs and dampers, then how the forces of the balls turn and grow
        right = np.zeros((*states.shape[:-1], half + n, first + 2 * n))
        ball = np.arange(n)
        right[..., :half, :half], right[..., :half, half:first] = -stiffness, -damping
        for part, tangent, radial in ((slice(0, pairs), -s, c), (slice(pairs, half), c, s)):
            push = (speed + rate) ** 2 * tangent + spin * radial  # s t phi'' turns with the ball
            right[..., part, first : first + n] = self._at_rows(p.moment * push)
            right[..., part, first + n :] = self._at_rows(2.0 * p.moment * (speed + rate) * radial)
        # rows of the balls: how the torque of the accelerated race turns, and drag
        along = p.offset.real * c + p.offset.imag * s
        right[..., half + ball, first + ball] = p.moment * (c * ax + s * ay - speed**2 * along)
        right[..., half + ball, first + n + ball] = -p.drag
        return self._slopes(np.linalg.solve(self.inertia(self._coupling(c, s)), right))

    @staticmethod
    def units(states: Floats) -> Floats:
        """Each component of a state as a direction, (size, ..., size)."""
        size = states.shape[-1]
        return np.broadcast_to(np.eye(size).reshape(size, *[1] * (states.ndim - 1), size), (size, *states.shape))

    def _slopes(self, slope: Numbers) -> Matrix:
        """The Jacobian with the derivatives of A and phi'' put in."""
        n, speed, first = self.balls, self.speed, self.rotor
        half, pairs = first // 2, first // 4
        ball = np.arange(n)
        whole = np.zeros((*slope.shape[:-2], first + 2 * n, first + 2 * n))
        whole[..., half:first, :], whole[..., first + n :, :] = slope[..., :half, :], slope[..., half:, :]
        whole[..., first + ball, first + n + ball] = 1.0
        one = np.arange(pairs)
        for begin in (0, half):  # V = Q' + iW Q and A = V' + iW V in the turning axes
            whole[..., begin + one, begin + pairs + one] += speed
            whole[..., begin + pairs + one, begin + one] -= speed
        both = np.arange(half)
        whole[..., both, half + both] = 1.0
        return whole

    def second(self, state: Floats, u: Numbers, v: Numbers) -> Numbers:
        """The symmetric bilinear form B(u, v) of the second derivatives."""
        plus, minus = (self.taylor(state, d, 2)[2] for d in (u + v, u - v))
        return np.asarray(0.5 * (plus - minus))

    def bent(self, state: Floats, u: Numbers) -> Numbers:
        """The matrix of B(u, .)."""
        each = np.eye(state.size, dtype=u.dtype)
        return self.second(state, np.broadcast_to(u, each.shape), each).T

    def third(self, state: Floats, u: Numbers, v: Numbers) -> Numbers:
        """The symmetric trilinear form C(u, u, v) of the third derivatives."""
        plus, minus, pure = (6.0 * self.taylor(state, d, 3)[3] for d in (u + v, u - v, v))
        return np.asarray((plus - minus - 2.0 * pure) / 6.0)

    def _at_rows(self, values: Numbers) -> Numbers:
        """Values of the balls on the coordinates of their stations, (..., pairs, n)."""
        return np.asarray(self.rows.T * values[..., None, :])

    def _coupling(self, cosine: Numbers, sine: Numbers) -> Numbers:
        """The part of the inertia that depends on the ball angles."""
        n, half = self.balls, self.rotor // 2
        m = np.zeros((*cosine.shape[:-1], half + n, half + n), cosine.dtype)
        for part, side in ((slice(0, half // 2), -sine), (slice(half // 2, half), cosine)):
            m[..., part, half:] = self._at_rows(self.host.moment * side)
        m[..., half:, :half] = np.swapaxes(m[..., :half, half:], -1, -2)
        return m

    @cached_property
    def _constant(self) -> Matrix:
        """The part of the inertia that does not."""
        half = self.rotor // 2
        mass = self._matrices[0]
        m = np.zeros((*mass.shape[:-2], half + self.balls, half + self.balls))
        m[..., :half, :half] = mass
        m[..., half:, half:] = np.diag(self.host.inertia)
        return m

    def inertia(self, coupling: Numbers) -> Numbers:
        """The whole inertia over A and phi''."""
        return np.asarray(coupling + self._constant)

    def _turned(self, pairs: Numbers) -> Numbers:
        """-iW times coordinates (X ..., Y ...)."""
        half = pairs.shape[-1] // 2
        return self.speed * np.concatenate([pairs[..., half:], -pairs[..., :half]], -1)

    def _assembled(self, here: Numbers | None, rates: Numbers) -> Numbers:
        """Q', V', phi', phi'' from A and phi''; ``here`` is the state of this order."""
        n, first = self.balls, self.rotor
        half = first // 2
        if here is None:
            here = np.zeros((*rates.shape[:-1], first + 2 * n))
        q, v = here[..., :half], here[..., half:first]
        return np.concatenate(
            [v + self._turned(q), rates[..., :half] + self._turned(v), here[..., first + n :], rates[..., half:]], -1
        )


def _product(matrix: Matrix, vectors: Numbers) -> Numbers:
    """A matrix, or one for every angle, times vectors."""
    return np.asarray(vectors @ matrix.T if matrix.ndim == 2 else (matrix @ vectors[..., None])[..., 0])


def _real(matrix: Complexes) -> Matrix:
    """A complex matrix on X + iY as a real one on X, Y."""
    return np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])


# What the tilt of a race adds to the equations of its balls, in the frame of the rotor.
#
# With the slope s of the race, its rate e in space, the ball at r = E + eps e^(i phi) from the center, u = t phi' +
# iW r, along t = dr/d phi, and the acceleration a of gravity along the axis, the kinetic energy of a ball grows by
# m/2 ((e.r)^2 + (r x u) (e x s)) and its potential by m a s.r; see :mod:`autobalancer.kernels.balls.guided`. So
#
#     moment on the station  -m (e'.r) r - 2 m (e.u) r - m a r + m/2 (r x u)' i s
#     torque on the ball     m (e.r) (e.t) + m W (r.t) (e x s) - m a s.t - m/2 (r x t) (e' x s)


class Feels(NamedTuple):
    """A ball and its race; every entry counts the balls last."""

    mass: Numbers  # effective
    across: Series  # r
    up: Series
    along_x: Series  # t
    along_y: Series
    bend: Series  # d(r x t)/d phi
    rate: Series  # phi'
    slope_x: Series  # s
    slope_y: Series
    rate_x: Series  # e
    rate_y: Series


class Adds(NamedTuple):
    """Inertia (lean: between slope and ball angle) and forces; moments have parts along x and y."""

    xx: Series
    xy: Series
    yy: Series
    lean_x: Series
    lean_y: Series
    moment_x: Series
    moment_y: Series
    torque: Series


def tilted(b: Feels, speed: float, weight: float) -> Adds:
    """What the tilt adds; ``weight`` is the acceleration of gravity along the axis."""
    m = b.mass
    spin = b.rate_x * b.slope_y - b.rate_y * b.slope_x  # e x s
    rise, arm = b.across * b.along_x + b.up * b.along_y, 0.5 * m * (b.across * b.along_y - b.up * b.along_x)
    moving_x, moving_y = b.along_x * b.rate - speed * b.up, b.along_y * b.rate + speed * b.across
    known = 2.0 * m * (b.rate_x * moving_x + b.rate_y * moving_y) + m * weight
    spun = 0.5 * m * (b.bend * b.rate * b.rate + 2.0 * speed * (rise * b.rate))
    torque = m * ((b.rate_x * b.across + b.rate_y * b.up) * (b.rate_x * b.along_x + b.rate_y * b.along_y))
    torque = torque + m * speed * (rise * spin) - m * weight * (b.slope_x * b.along_x + b.slope_y * b.along_y)
    return Adds(
        xx=m * (b.across * b.across),
        xy=m * (b.across * b.up),
        yy=m * (b.up * b.up),
        lean_x=arm * b.slope_y,
        lean_y=-arm * b.slope_x,
        moment_x=-known * b.across - spun * b.slope_y,
        moment_y=-known * b.up + spun * b.slope_x,
        torque=torque,
    )


# The equations where x and y are not alike: a steady state there repeats with every half turn of the rotor.
#
# In the frame of the rotor they are x' = f(x, theta) with theta = W t and the period pi. A state is a function
# x(theta) with that period, and
#
#     dx/dt + W dx/dtheta = f(x, theta)
#
# has no angle in it that is not a coordinate: steady states are at rest in it, and theories of states at rest serve as
# they stand: Newton's method, continuation, folds, Hopf points and their coefficients (Kuznetsov et al. 2005).
# x(theta) is counted in harmonics 1, sqrt(2) cos 2 theta, sqrt(2) sin 2 theta, ..., at as many angles of half a turn,
# so that the mean of x^2 is the sum of squares, and the first numbers of a state are its mean. Where the motion is
# smooth, some harmonics are exact to rounding.
#
# Growth rates are ln(multiplier) over the time of half a turn. Multipliers are those of the map over half a turn,
# which is integrated by the Gauss method of four stages (order eight). A growth rate plus 2iW is another name for the
# same motion.


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
        return np.asarray(_harmonics(self.count, theta) @ state.reshape(self.count, self.size))

    def harmonics(self, states: Numbers) -> Numbers:
        """The other way, (..., count * size)."""
        result = _waves(self.count).T @ states / self.count
        return np.asarray(result.reshape(*states.shape[:-2], self.count * self.size))

    def __call__(self, state: Floats) -> Floats:
        """Time derivative of a state."""
        moved = self.harmonics(self.field(self.around(state)))
        return np.asarray(moved - self.speed * (_slopes(self.count) @ state.reshape(self.count, -1)).ravel())

    def jacobian(self, state: Floats) -> Matrix:
        """Derivative with respect to the state."""
        spread = self._spread(self.field.jacobian(self.around(state)))
        count, size = self.count, self.size
        spread.reshape(count, size, count, size)[:, range(size), :, range(size)] -= self.speed * _slopes(count)
        return spread

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
        second = self.field.second(here, np.broadcast_to(way, each.shape), each.astype(way.dtype))
        return self._spread(np.moveaxis(second, 0, -1))

    def third(self, state: Floats, u: Numbers, v: Numbers) -> Numbers:
        """The symmetric trilinear form C(u, u, v) of the third derivatives."""
        return self.harmonics(self.field.third(self.around(state), self.around(u), self.around(v)))

    def held(self, stiffness: Floats, damping: Floats) -> Floats:
        """The constant r that holds d'' + c(theta) d' + r(theta) d = 0 (prime: by theta) at the same border, (n,).

        ``stiffness`` r and ``damping`` c at the angles, (count, n). The other harmonics of d are eliminated: what is left of
        its mean vanishes where d has the multiplier 1.
        """
        waves, slopes, result = _waves(self.count), _slopes(self.count), []
        for r, c in zip(stiffness.T, damping.T, strict=True):
            whole = waves.T @ (r[:, None] * waves + c[:, None] * (waves @ slopes)) / self.count + slopes @ slopes
            result.append(whole[0, 0] - whole[0, 1:] @ np.linalg.solve(whole[1:, 1:], whole[1:, 0]))
        return np.array(result)

    def half_turn(self, state: Floats) -> Matrix:
        """The map of small motions over half a turn from the angle zero on, in the frame of the rotor, (size, size)."""
        model = self.host.model
        stiffness = np.linalg.solve(model.mass, model.stiffness_at(self.speed))
        fastest = math.sqrt(float(np.abs(np.linalg.eigvals(stiffness)).max())) + self.speed  # seen from the rotor
        steps = steps_of(fastest, self.speed)
        width, half, n = math.pi / steps, self.rotor // 2, self.balls
        theta = (width * (np.arange(steps)[:, None] + gauss()[0])).ravel()
        rates = replace(self.field, theta=theta).jacobian(self.at(state, theta))
        # over Q and phi and their derivatives: V = Q' - turned Q
        position = np.r_[:half, self.rotor : self.rotor + n]
        velocity = np.r_[half : self.rotor, self.rotor + n : self.size]
        turned = np.zeros((half + n, half + n))
        turned[:half, :half] = rates[0, :half, :half]
        by_position, by_velocity = (rates[:, velocity][..., part] for part in (position, velocity))
        maps = step_maps(by_position - by_velocity @ turned, by_velocity + turned, width / self.speed)
        # and back
        whole, order = np.eye(self.size), np.concatenate([position, velocity])
        forth, back = np.eye(self.size), np.eye(self.size)
        forth[half + n :, : half + n], back[half + n :, : half + n] = -turned, turned
        whole[np.ix_(order, order)] = forth @ reduce(lambda before, one: one @ before, maps) @ back
        return whole

    def exponents(self, state: Floats, scale: Floats | float = 1.0) -> Complexes:
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
    result = np.linalg.solve(left, right.reshape(steps, 4 * size, 2 * size)).reshape(steps, 4, -1)
    maps = np.zeros((steps, 2 * size, 2 * size)) + np.eye(2 * size)
    maps[:, range(size), range(size, 2 * size)] += h
    maps[:, :size] += h * h * (weights @ inner @ result).reshape(steps, size, 2 * size)
    maps[:, size:] += h * (weights @ result).reshape(steps, size, 2 * size)
    return maps


@cache
def _waves(count: int) -> Matrix:
    """Harmonics, the columns, at the angles of half a turn."""
    return _harmonics(count, np.pi * np.arange(count) / count)


def _harmonics(count: int, theta: Floats) -> Matrix:
    harmonics = np.ones((theta.size, count))
    for k in range(1, count // 2 + 1):
        harmonics[:, 2 * k - 1], harmonics[:, 2 * k] = (
            math.sqrt(2.0) * np.cos(2 * k * theta),
            math.sqrt(2.0) * np.sin(2 * k * theta),
        )
    return harmonics


@cache
def _slopes(count: int) -> Matrix:
    """Derivative with respect to the angle, over the harmonics."""
    slopes = np.zeros((count, count))
    for k in range(1, count // 2 + 1):
        slopes[2 * k - 1, 2 * k], slopes[2 * k, 2 * k - 1] = 2.0 * k, -2.0 * k
    return slopes
