"""The full equations of balls on any isotropic rotor, linearized about a state of rest in the rotor.

In the frame that turns with the rotor, with complex coordinates Q = Q_x + i Q_y, rows B_p of the stations, s = m eps and
the acceleration A_p = B_p (Q'' + 2iW Q' - W^2 Q),

    M (Q'' + 2iW Q' - W^2 Q) + (C - iWG) (Q' + iW Q) + K Q + sum s B^T e^(i phi) i (phi'' + 2iW phi' - W^2 phi) = 0
    I phi'' + beta phi' + s Im[e^(-i phi) A_p] + s W^2 Re[e^(-i phi) (Z_p + E)] phi = 0

for small Q and phi; M has the balls' mass on it. What balls feel beyond the deflection of their race comes from the vector field.
"""

from __future__ import annotations

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.stability.host.stations import Complexes, Floats, Matrix, Stations
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.states.stations import StationState, state_vector

BALLS_ALONE, ROTOR_ALONE = 30.0, 3.0  # way of the balls over deflection of the rotor


def matrices(st: Stations, speed: float, state: StationState) -> tuple[Floats, Floats, Floats]:
    """Mass, damping and stiffness matrices for (Q_x, Q_y, phi_1 ... phi_n).

    Raises
    ------
    QuestionError
        On anisotropic supports: there the state is periodic and Floquet multipliers decide.
    """
    if not st.isotropic:
        raise QuestionError("linear stability: the supports are not isotropic; use Floquet multipliers")
    n, w, r = st.moment.size, speed, st.model.pairs
    mass, turning, stiffness = st.model.complex_matrices(w)
    m, c, k = (np.zeros((2 * r + n, 2 * r + n)) for _ in range(3))
    _fill(m, mass)
    _fill(c, turning + 2j * w * mass)
    _fill(k, stiffness + 1j * w * turning - w * w * mass)
    if n == 0:
        return m, c, k
    push = st.moment * np.exp(1j * state.angles)
    row = st.rows[st.station]  # (n, pairs)
    tangent, radial = _both(1j * push, row), _both(push, row)
    ball = slice(2 * r, None)
    m[: 2 * r, ball], m[ball, : 2 * r] = tangent.T, tangent
    c[: 2 * r, ball], c[ball, : 2 * r] = -2.0 * w * radial.T, 2.0 * w * radial
    k[: 2 * r, ball], k[ball, : 2 * r] = -w * w * tangent.T, -w * w * tangent
    center = state.whirl[st.station] + st.offset
    m[ball, ball], c[ball, ball] = np.diag(st.inertia), np.diag(st.drag)
    k[ball, ball] = np.diag(w * w * (push.conj() * center).real)
    return m, c, k


def modes(st: Stations, speed: float, state: StationState) -> tuple[Complexes, Complexes]:
    """Eigenvalues (1/s), the fastest growing first, and eigenvectors over (Q_x, Q_y, phi_1 ... phi_n)."""
    if st.plain:
        return eigensystem(*matrices(st, speed, state))
    values, vectors = np.linalg.eig(Field(st, speed).jacobian(state_vector(st, speed, state.angles)))
    order, half = np.argsort(-values.real, kind="stable"), 2 * st.model.pairs
    shown = np.r_[0:half, 2 * half : 2 * half + st.moment.size]
    return values[order], vectors[shown][:, order]


def motion_name(vector: Complexes, st: Stations, value: complex, speed: float) -> str:
    """What moves in an eigenvector (Q_x, Q_y, phi...): the rotor and how it whirls in space, the balls and how, or both.

    The way of the balls in the race is compared with the deflection of the station that moves most: above 30 the mode is named
    after the balls, below 3 after the rotor. A part e^(i w t) in the rotor is a whirl with W + w in space.
    """
    r = st.model.pairs
    x, y, balls = st.rows @ vector[:r], st.rows @ vector[r : 2 * r], vector[2 * r :]
    if balls.size == 0:
        x, y = vector[:r], vector[r : 2 * r]
    place = int(np.argmax(np.hypot(np.abs(x), np.abs(y))))
    rotor = float(np.hypot(abs(x[place]), abs(y[place])))
    way = float(np.sqrt((np.abs(balls * st.moment / st.ball_mass) ** 2).sum())) if balls.size else 0.0
    if way < ROTOR_ALONE * rotor or balls.size == 0:
        ahead = abs(x[place] + 1j * y[place]) >= abs(x[place] - 1j * y[place])
        frequency = speed + value.imag if ahead else speed - value.imag
        return f"rotor, {'forward' if frequency >= 0.0 else 'backward'} whirl"
    moving = "balls" if way > BALLS_ALONE * rotor else "balls and rotor"
    if balls.size < 2:
        return f"{moving}, oscillating"
    strength = [float(np.linalg.norm(balls[st.station == p])) for p in range(len(st.names))]
    total = float(np.linalg.norm(strength))
    for p, name in enumerate(st.names):
        if len(st.names) > 1 and strength[p] > 0.98 * total:
            moving = f"{moving} of {name}"
            balls = balls[st.station == p]
            break
    together = abs(balls.sum()) / np.abs(balls).sum()
    how = "together" if together > 0.8 else "against each other" if together < 0.2 else "unequally"
    return f"{moving}, {how}" if balls.size > 1 else f"{moving}, oscillating"


def _fill(block: Matrix, matrix: Complexes) -> None:
    """A complex matrix on Q_x + i Q_y into the corner of a real one on Q_x, Q_y."""
    r = matrix.shape[0]
    block[:r, :r] = block[r : 2 * r, r : 2 * r] = matrix.real
    block[r : 2 * r, :r] = matrix.imag
    block[:r, r : 2 * r] = -matrix.imag


def _both(vectors: Complexes, row: Matrix) -> Matrix:
    """Vectors at the stations of the balls as rows over (Q_x, Q_y), (n, 2 pairs)."""
    return np.concatenate([vectors.real[:, None] * row, vectors.imag[:, None] * row], axis=1)


def eigensystem(m: Floats, c: Floats, k: Floats) -> tuple[Complexes, Complexes]:
    """Eigenvalues (1/s), the fastest growing first, and eigenvectors (columns: displacements only)."""
    n = m.shape[0]
    first = np.zeros((2 * n, 2 * n))
    first[:n, n:] = np.eye(n)
    first[n:, :n], first[n:, n:] = -np.linalg.solve(m, k), -np.linalg.solve(m, c)
    values, vectors = np.linalg.eig(first)
    order = np.argsort(-values.real, kind="stable")
    return values[order], vectors[:n, order]


def kept(values: Complexes, freedom: int) -> Complexes:
    """The eigenvalues that decide: those without the ``freedom`` zeros of a continuum of states."""
    if freedom == 0:
        return values
    smallest = np.argsort(np.abs(values))[:freedom]
    return np.delete(values, smallest)


# When a state is stable.


MARGIN = 1e-9  # growth rates up to this share of the speed count as zero


def growth(values: Complexes, freedom: int) -> float:
    """Greatest real part that counts: without the zeros of a continuum, 1/s."""
    return float(kept(values, freedom).real.max())


def verdict(rate: float, speed: float) -> str:
    """stable, marginal or unstable."""
    if abs(rate) <= MARGIN * speed:
        return "marginal"
    return "unstable" if rate > 0.0 else "stable"
