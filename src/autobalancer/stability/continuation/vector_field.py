"""The equations of an isotropic machine at constant speed W as a smooth vector field in the frame of the rotor.

State X, Y, VX, VY (velocity in space along the axes of the rotor), ball angles phi, ball speeds phi' in the rotor. With
s = m eps, t and n the tangential and radial unit vectors at a ball, A the acceleration of the race center:

    M A + sum s t phi'' = -k z - b v + W^2 (U + sum m E) + sum s (W + phi')^2 n
    I phi'' + s t.A     = -beta phi' + s W^2 E sin(gamma - phi)

This is the compiled kernel :func:`autobalancer.kernels.guided_balls.planar` written so that it can be differentiated: both
sides as Taylor series along a direction give derivatives of any order from one linear solve each, exact to rounding.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.stability.host.planar import Floats, Matrix, Plane

Numbers = NDArray[Any]  # real or complex


@dataclass(frozen=True)
class Field:
    """The vector field of a plane at a speed; the last axis of a state counts its 4 + 2 n components."""

    plane: Plane
    speed: float

    @property
    def balls(self) -> int:
        """Number of balls n."""
        return self.plane.moment.size

    def __call__(self, states: Floats) -> Floats:
        """Time derivative of one state or of many."""
        return np.asarray(self.taylor(states, np.zeros_like(states), 0)[0], np.float64)

    def taylor(self, state: Numbers, direction: Numbers, order: int) -> list[Numbers]:
        """Coefficients of h^0, h^1 ... of the field at ``state + h direction``; the direction may be complex."""
        p, n, speed = self.plane, self.balls, self.speed
        state = np.broadcast_to(state, direction.shape)
        angle, turn = state[..., 4 : 4 + n], direction[..., 4 : 4 + n]
        rate, change = state[..., 4 + n :], direction[..., 4 + n :]
        square = [(speed + rate) ** 2, 2.0 * (speed + rate) * change, change**2]
        cosine, sine, matrices = [], [], []
        rates: list[Numbers] = []
        for k in range(order + 1):
            factor = turn**k / math.factorial(k)
            cosine.append(np.cos(angle + 0.5 * np.pi * k) * factor)
            sine.append(np.sin(angle + 0.5 * np.pi * k) * factor)
            matrices.append(self._coupling(cosine[k], sine[k]))
            here = (state, direction)[k] if k < 2 else np.zeros_like(direction)
            z, v, ball = here[..., :2], here[..., 2:4], here[..., 4 + n :]
            load = -p.stiffness[0] * z - p.damping[0] * v
            if k == 0:
                load = load + speed**2 * np.array([p.fixed_load.real, p.fixed_load.imag])
            pull = [sum(square[j] * side[k - j] for j in range(min(k, 2) + 1)) for side in (cosine, sine)]
            load = load + np.stack([(p.moment * part).sum(-1) for part in pull], -1)
            across = p.offset.imag * cosine[k] - p.offset.real * sine[k]
            right = np.concatenate([load, -p.drag * ball + p.moment * speed**2 * across], -1)
            for j in range(1, k + 1):
                right = right - (matrices[j] @ rates[k - j][..., None])[..., 0]
            rates.append(np.linalg.solve(self._inertia(matrices[0]), right[..., None])[..., 0])
        return [self._assembled((state, direction)[k] if k < 2 else None, rates[k]) for k in range(order + 1)]

    def jacobian(self, states: Floats) -> Matrix:
        """Derivative of the field with respect to the state, (..., 4 + 2 n, 4 + 2 n)."""
        p, n, speed = self.plane, self.balls, self.speed
        angle, rate = states[..., 4 : 4 + n], states[..., 4 + n :]
        c, s = np.cos(angle), np.sin(angle)
        m = self._coupling(c, s)
        acceleration = self(states)
        ax = acceleration[..., 2:3] - speed * states[..., 3:4]
        ay = acceleration[..., 3:4] + speed * states[..., 2:3]
        spin = acceleration[..., 4 + n :]
        right = np.zeros((*states.shape[:-1], 2 + n, 4 + 2 * n))
        ball = np.arange(n)
        for row in range(2):
            right[..., row, row], right[..., row, 2 + row] = -p.stiffness[0], -p.damping[0]
        tangent, radial = (-s, c), (c, s)
        for row in range(2):
            push = (speed + rate) ** 2 * tangent[row] + spin * radial[row]  # s t phi'' turns with the ball
            right[..., row, 4 : 4 + n] = p.moment * push
            right[..., row, 4 + n :] = 2.0 * p.moment * (speed + rate) * radial[row]
        along = p.offset.real * c + p.offset.imag * s
        right[..., 2 + ball, 4 + ball] = p.moment * (c * ax + s * ay - speed**2 * along)
        right[..., 2 + ball, 4 + n + ball] = -p.drag
        slope = np.linalg.solve(self._inertia(m), right)
        whole = np.zeros((*states.shape[:-1], 4 + 2 * n, 4 + 2 * n))
        whole[..., 2:4, :], whole[..., 4 + n :, :] = slope[..., :2, :], slope[..., 2:, :]
        whole[..., 4 + ball, 4 + n + ball] = 1.0
        for first in (0, 2):  # v = z' + i W z and A = v' + i W v in the turning axes
            whole[..., first, first + 1] += speed
            whole[..., first + 1, first] -= speed
        whole[..., 0, 2] = whole[..., 1, 3] = 1.0
        return whole

    def second(self, state: Floats, u: Numbers, v: Numbers) -> Numbers:
        """The symmetric bilinear form B(u, v) of the second derivatives."""
        plus, minus = (self.taylor(state, d, 2)[2] for d in (u + v, u - v))
        return np.asarray(0.5 * (plus - minus))

    def third(self, state: Floats, u: Numbers, v: Numbers) -> Numbers:
        """The symmetric trilinear form C(u, u, v) of the third derivatives."""
        plus, minus, pure = (6.0 * self.taylor(state, d, 3)[3] for d in (u + v, u - v, v))
        return np.asarray((plus - minus - 2.0 * pure) / 6.0)

    def _coupling(self, cosine: Numbers, sine: Numbers) -> Numbers:
        """The part of the inertia that depends on the ball angles."""
        n = self.balls
        m = np.zeros((*cosine.shape[:-1], 2 + n, 2 + n), cosine.dtype)
        for row, part in ((0, -sine), (1, cosine)):
            m[..., row, 2:] = m[..., 2:, row] = self.plane.moment * part
        return m

    def _inertia(self, coupling: Numbers) -> Numbers:
        p = self.plane
        return np.asarray(coupling + np.diag(np.concatenate([[p.mass, p.mass], p.inertia])))

    def _assembled(self, here: Numbers | None, rates: Numbers) -> Numbers:
        """z', v', phi', phi'' from A and phi''; ``here`` is the state of this order."""
        n = self.balls
        if here is None:
            here = np.zeros((*rates.shape[:-1], 4 + 2 * n))
        z, v, turn = here[..., :2], here[..., 2:4], self.speed * np.array([[0.0, 1.0], [-1.0, 0.0]])
        return np.concatenate([v + z @ turn.T, rates[..., :2] + v @ turn.T, here[..., 4 + n :], rates[..., 2:]], -1)
