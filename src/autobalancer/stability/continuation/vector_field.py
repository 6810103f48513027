"""The equations of balls on any isotropic rotor at constant speed W as a smooth vector field in the frame of the rotor.

State: coordinates Q of the rotor (``pairs`` along X, as many along Y), V (their velocity in space along the axes of the
rotor), ball angles phi, ball speeds phi' in the rotor. With s = m eps, t and n the tangential and radial unit vectors at a
ball, B the row of its station, A = V' + iW V and c the center of its race in the rotor,

    M A + sum B^T s t phi'' = -K Q - (C - iWG) V + W^2 F + sum B^T s (W + phi')^2 n
    I phi'' + s t.(B A)     = -beta phi' + s W^2 Im[e^(-i phi) c]

M has the balls' mass on it, F are the unbalances and the eccentric masses of the balls. A planar rotor has one pair of
coordinates, one station and B = 1. These are the compiled equations written so that they can be differentiated: both sides as
Taylor series along a direction give derivatives of any order from one linear solve each, exact to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.stability.host.planar import Complexes, Floats, Matrix
from autobalancer.stability.host.stations import Stations

Numbers = NDArray[Any]  # real or complex


@dataclass(frozen=True)
class Field:
    """The vector field of a machine at a speed; the last axis of a state counts its 4 ``pairs`` + 2 n components."""

    host: Stations
    speed: float

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
        """M, C - iWG, K over Q_x, Q_y, and the load W^2 F."""
        load = self.speed**2 * self.host.fixed_load
        mass, turning, stiffness = (_real(m) for m in self.host.model.complex_matrices(self.speed))
        return mass, turning, stiffness, np.concatenate([load.real, load.imag])

    def __call__(self, states: Floats) -> Floats:
        """Time derivative of one state or of many."""
        return np.asarray(self.taylor(states, np.zeros_like(states), 0)[0], np.float64)

    def taylor(self, state: Numbers, direction: Numbers, order: int) -> list[Numbers]:
        """Coefficients of h^0, h^1 ... of the field at ``state + h direction``; the direction may be complex."""
        p, n, speed, first = self.host, self.balls, self.speed, self.rotor
        half = first // 2
        _, damping, stiffness, fixed = self._matrices
        state = np.broadcast_to(state, direction.shape)
        angle, turn = state[..., first : first + n], direction[..., first : first + n]
        rate, change = state[..., first + n :], direction[..., first + n :]
        square = [(speed + rate) ** 2, 2.0 * (speed + rate) * change, change**2]
        cosine, sine, matrices = [], [], []
        rates: list[Numbers] = []
        for k in range(order + 1):
            factor = turn**k / math.factorial(k)
            cosine.append(np.cos(angle + 0.5 * np.pi * k) * factor)
            sine.append(np.sin(angle + 0.5 * np.pi * k) * factor)
            matrices.append(self._coupling(cosine[k], sine[k]))
            here = (state, direction)[k] if k < 2 else np.zeros_like(direction)
            load = -here[..., :half] @ stiffness.T - here[..., half:first] @ damping.T
            if k == 0:
                load = load + fixed
            pull = [sum(square[j] * side[k - j] for j in range(min(k, 2) + 1)) for side in (cosine, sine)]
            load = load + np.concatenate([(p.moment * part) @ self.rows for part in pull], -1)
            across = p.offset.imag * cosine[k] - p.offset.real * sine[k]
            right = np.concatenate([load, -p.drag * here[..., first + n :] + p.moment * speed**2 * across], -1)
            for j in range(1, k + 1):
                right = right - (matrices[j] @ rates[k - j][..., None])[..., 0]
            rates.append(np.linalg.solve(self._inertia(matrices[0]), right[..., None])[..., 0])
        return [self._assembled((state, direction)[k] if k < 2 else None, rates[k]) for k in range(order + 1)]

    def accelerations(self, states: Floats, rates: Floats) -> tuple[Floats, Floats]:
        """Of each ball's station in space, along the axes of the rotor, (..., n); ``rates`` is the field there."""
        half = self.rotor // 2
        whole = rates[..., half : self.rotor] - self._turned(states[..., half : self.rotor])
        pairs = half // 2
        return whole[..., :pairs] @ self.rows.T, whole[..., pairs:] @ self.rows.T

    def jacobian(self, states: Floats) -> Matrix:
        """Derivative of the field with respect to the state, (..., size, size)."""
        p, n, speed, first = self.host, self.balls, self.speed, self.rotor
        half, pairs = first // 2, first // 4
        _, damping, stiffness, _ = self._matrices
        angle, rate = states[..., first : first + n], states[..., first + n :]
        c, s = np.cos(angle), np.sin(angle)
        values = self(states)
        ax, ay = self.accelerations(states, values)
        spin = values[..., first + n :]
        right = np.zeros((*states.shape[:-1], half + n, first + 2 * n))
        ball = np.arange(n)
        right[..., :half, :half], right[..., :half, half:first] = -stiffness, -damping
        for part, tangent, radial in ((slice(0, pairs), -s, c), (slice(pairs, half), c, s)):
            push = (speed + rate) ** 2 * tangent + spin * radial  # s t phi'' turns with the ball
            right[..., part, first : first + n] = self._at_rows(p.moment * push)
            right[..., part, first + n :] = self._at_rows(2.0 * p.moment * (speed + rate) * radial)
        along = p.offset.real * c + p.offset.imag * s
        right[..., half + ball, first + ball] = p.moment * (c * ax + s * ay - speed**2 * along)
        right[..., half + ball, first + n + ball] = -p.drag
        slope = np.linalg.solve(self._inertia(self._coupling(c, s)), right)
        whole = np.zeros((*states.shape[:-1], first + 2 * n, first + 2 * n))
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
        m = np.zeros((half + self.balls, half + self.balls))
        m[:half, :half] = self._matrices[0]
        m[half:, half:] = np.diag(self.host.inertia)
        return m

    def _inertia(self, coupling: Numbers) -> Numbers:
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


def _real(matrix: Complexes) -> Matrix:
    """A complex matrix on X + iY as a real one on X, Y."""
    return np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])
