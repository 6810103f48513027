"""The rigid rotor that tilts, with balls in any planes, once more: nothing eliminated, complex, plain numpy.

Coordinates in space: deflection x of the mass center and slope a of the axis, both complex, and ball angles phi in the
rotor. With z_p = x + z a at the plane of a ball and psi = W t + phi, per unit of what moves:

    m x''                = sum F                      F on the rotor, by supports, unbalance and balls
    J_t a'' - i J_p W a' = sum z F + tilt moments
    ball:  F = -m_b (z_p + eps e^(i psi))'',   (1 + j) m_b eps^2 phi'' + beta phi' = -m_b eps Im[e^(-i psi) z_p'']
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Tilting:
    """Numbers; supports are (position, k_x, k_y, c_x, c_y), balls (position, mass, orbit, inertia, drag)."""

    mass: float
    transverse: float
    polar: float
    supports: tuple[tuple[float, float, float, float, float], ...]
    unbalance: complex  # in the rotor, at the mass center, kg m
    couple: complex  # kg m^2
    balls: tuple[tuple[float, float, float, float, float], ...]
    speed: float

    def rates(self, time: float, y: np.ndarray) -> np.ndarray:
        """Derivative of (x, a real and imaginary parts, phi, and their velocities) in axes at rest."""
        n, w = len(self.balls), self.speed
        half = 4 + n
        x, a = y[0] + 1j * y[1], y[2] + 1j * y[3]
        vx, va = y[half] + 1j * y[half + 1], y[half + 2] + 1j * y[half + 3]
        phi, rate = y[4:half], y[half + 4 :]
        turn = np.exp(1j * w * time)
        force = self.unbalance * w**2 * turn
        moment = self.couple * w**2 * turn + 1j * self.polar * w * va
        for z, kx, ky, cx, cy in self.supports:
            place, fast = x + z * a, vx + z * va
            push = -(kx * place.real + cx * fast.real) - 1j * (ky * place.imag + cy * fast.imag)
            force, moment = force + push, moment + z * push
        matrix, right = np.zeros((half, half)), np.zeros(half)
        matrix[0, 0] = matrix[1, 1] = self.mass
        matrix[2, 2] = matrix[3, 3] = self.transverse
        for i, (z, m, eps, inertia, drag) in enumerate(self.balls):
            ahead = turn * np.exp(1j * phi[i])
            pull = m * eps * (w + rate[i]) ** 2 * ahead  # what -m eps (e^(i psi))'' has without phi''
            force, moment = force + pull, moment + z * pull
            side = np.array([-ahead.imag, ahead.real]) * m * eps  # m eps i e^(i psi)
            for row, lever in ((0, 1.0), (2, z)):
                matrix[row : row + 2, 0:2] += lever * m * np.eye(2)
                matrix[row : row + 2, 2:4] += lever * z * m * np.eye(2)
                matrix[row : row + 2, 4 + i] += lever * side
                matrix[4 + i, row : row + 2] += lever * side
            matrix[4 + i, 4 + i], right[4 + i] = inertia, -drag * rate[i]
        right[:4] = force.real, force.imag, moment.real, moment.imag
        return np.concatenate([y[half:], np.linalg.solve(matrix, right)])

    def rotating(self, y: np.ndarray) -> np.ndarray:
        """The same seen from the rotor, where nothing depends on the time; velocities in space, along its axes."""
        n, w = len(self.balls), self.speed
        half = 4 + n
        found = self.rates(0.0, y)
        turn = np.array([[0.0, w], [-w, 0.0]])
        for start in (0, 2, half, half + 2):
            found[start : start + 2] += turn @ y[start : start + 2]
        return found

    def resting(self, x: complex, a: complex, angles: np.ndarray) -> np.ndarray:
        """A state of rest in the rotor."""
        v, u = 1j * self.speed * x, 1j * self.speed * a
        return np.array(
            [x.real, x.imag, a.real, a.imag, *angles, v.real, v.imag, u.real, u.imag, *np.zeros(len(angles))]
        )

    def jacobian(self, y: np.ndarray) -> np.ndarray:
        """Of the field seen from the rotor, by differences of fourth order."""
        scale = np.concatenate(
            [np.full(4, 1e-4), np.ones(len(self.balls)), np.full(4, 1e-2), np.full(len(self.balls), 10.0)]
        )
        columns = []
        for i, size in enumerate(scale):
            step = np.zeros(y.size)
            step[i] = 3e-3 * size
            near = self.rotating(y + step) - self.rotating(y - step)
            far = self.rotating(y + 2.0 * step) - self.rotating(y - 2.0 * step)
            columns.append((8.0 * near - far) / (12.0 * step[i]))
        return np.array(columns).T
