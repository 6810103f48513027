"""Balls coupled to a rotor of which only the receptance at the race is known, linearized about the balanced state.

With H(sigma) = sum r/(sigma - p), the receptance for forward rotating quantities, sum r = 0, and the acceleration A of
the race, in the frame that turns with the rotor at speed W (one complex q for each pole):

    q' = (p - iW) q + r f,   A = sum p^2 q + (sum r p) f,   f = -m A - i sum s e^(i phi) (phi'' + 2iW phi' - W^2 phi)
    I phi'' + beta phi' + s Im[e^(-i phi) A] = 0,   s = m_b eps

m is the mass of the balls if H was measured without them, else 0. The eigenvalues are the roots of det(1 - T(s)) = 0,

    T = 1/2 [a_0 G+, a_2 G-; a_-2 G+, a_0 G-],   G+ = (s + iW)^4 H(s + iW),   G- = conj(G+(conj s)),
    a_n = sum s_j^2 e^(i n phi_j) / P_j(s),   P = I s^2 + beta s,   1/H with balls = 1/H + m sigma^2.

Derived for this project; for equal balls it is (P - cN G+/2)(P - cN G-/2) = c^2 |S2|^2 G+ G-/4. For the planar rotor it
is :mod:`autobalancer.stability.states.linear`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from autobalancer.measurement.loop.balls import RaceBalls
from autobalancer.rotordynamics.receptance.pole_model import PoleModel

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


def loop_eigenvalues(
    model: PoleModel, balls: RaceBalls, angles: Floats, speed: float, *, gain: float = 1.0, phase: float = 0.0
) -> Complexes:
    """Eigenvalues of the closed loop, 1/s, the fastest growing first, without the zeros of freely movable balls.

    ``gain`` and ``phase`` (rad) change G+ to gain e^(i phase) G+: how wrong the receptance may be.
    """
    p, r, n, balls_n = model.poles, model.residues, model.poles.size, balls.count
    direct = complex((r * p).sum())
    ahead = balls.moment * np.exp(1j * angles)
    seen = gain * np.exp(1j * phase) * balls.moment * np.exp(-1j * angles)
    # columns: Re q, Im q, phi, phi'; rows of the equations for f (two) and phi''
    size = 2 * n + 2 * balls_n
    free = np.zeros(size, np.complex128)
    free[:n], free[n : 2 * n] = p**2, 1j * p**2
    load = -model.added_mass * free
    load[2 * n : 2 * n + balls_n] += 1j * speed**2 * ahead
    load[2 * n + balls_n :] += 2.0 * speed * ahead
    left = np.zeros((2 + balls_n, 2 + balls_n))
    right = np.zeros((2 + balls_n, size))
    factor = 1.0 + model.added_mass * direct
    left[:2, :2] = [[factor.real, -factor.imag], [factor.imag, factor.real]]
    left[0, 2:], left[1, 2:] = (1j * ahead).real, (1j * ahead).imag
    left[2:, 0], left[2:, 1] = (seen * direct).imag, (1j * seen * direct).imag
    left[2:, 2:] = np.diag(balls.inertia)
    right[0], right[1] = load.real, load.imag
    right[2:] = -(seen[:, None] * free).imag
    right[2:, 2 * n + balls_n :] -= np.diag(balls.drag)
    answer = np.linalg.solve(left, right)
    matrix = np.zeros((size, size))
    turned = p - 1j * speed
    matrix[:n, :n] = matrix[n : 2 * n, n : 2 * n] = np.diag(turned.real)
    matrix[:n, n : 2 * n], matrix[n : 2 * n, :n] = np.diag(-turned.imag), np.diag(turned.imag)
    matrix[:n] += np.outer(r.real, answer[0]) - np.outer(r.imag, answer[1])
    matrix[n : 2 * n] += np.outer(r.imag, answer[0]) + np.outer(r.real, answer[1])
    matrix[2 * n : 2 * n + balls_n, 2 * n + balls_n :] = np.eye(balls_n)
    matrix[2 * n + balls_n :] = answer[2:]
    values = np.linalg.eigvals(matrix)
    values = np.delete(values, np.argsort(np.abs(values))[: neutral_count(angles)])
    return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)


def neutral_count(angles: Floats) -> int:
    """Zeros among the eigenvalues: n - 2, or n - 1 for balls in line."""
    if angles.size < 2:
        return 0
    reach = np.linalg.svd(np.vstack([np.cos(angles), np.sin(angles)]), compute_uv=False)
    return int(angles.size - 2 + (reach[1] < 1e-7 * reach[0]))


def loop_matrix(model: PoleModel, balls: RaceBalls, angles: Floats, speed: float, s: Complexes) -> Complexes:
    """T(s), shape (..., 2, 2), at complex frequencies seen in the rotor."""
    ball = balls.inertia * s[..., None] ** 2 + balls.drag * s[..., None]
    a_0, a_2, a_back = ((balls.moment**2 * np.exp(1j * k * angles) / ball).sum(axis=-1) for k in (0, 2, -2))
    forward = _fourth(model, s + 1j * speed)
    backward = np.conj(_fourth(model, np.conj(s) + 1j * speed))
    rows = [[a_0 * forward, a_2 * backward], [a_back * forward, a_0 * backward]]
    return np.asarray(0.5 * np.moveaxis(np.array(rows), (0, 1), (-2, -1)), np.complex128)


def _fourth(model: PoleModel, sigma: Complexes) -> Complexes:
    return np.asarray(sigma**4 * model.receptance(sigma), np.complex128)
