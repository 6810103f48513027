"""The full equations linearized about a state of rest in the rotor, isotropic machines.

In the frame that turns with the rotor, with Z = X + iY and s = m eps (derived from Spannan 2021, 4.14-4.17):

    M (Z'' + 2iW Z' - W^2 Z) + b (Z' + iW Z) + k Z + sum s e^(i phi) i (phi'' + 2iW phi' - W^2 phi) = 0
    I phi'' + beta phi' + s Im[e^(-i phi) (Z'' + 2iW Z' - W^2 Z)] + s W^2 Re[e^(-i phi) c] phi = 0

for small Z and phi about the state with ball angles phi and race-center vector c.
"""

from __future__ import annotations

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.stability.host.planar import Complexes, Floats, Plane
from autobalancer.stability.states.planar import Equilibrium


def matrices(p: Plane, speed: float, state: Equilibrium) -> tuple[Floats, Floats, Floats]:
    """Mass, damping (with gyroscopic terms) and stiffness matrices for (X, Y, phi_1 ... phi_n).

    Raises
    ------
    QuestionError
        On orthotropic supports: there the state is periodic and Floquet multipliers decide.
    """
    if not p.isotropic:
        raise QuestionError("linear stability: the supports are not isotropic; use Floquet multipliers")
    n = p.moment.size
    m, c, k = (np.zeros((2 + n, 2 + n)) for _ in range(3))
    b, w = p.damping[0], speed
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])  # i
    m[:2, :2] = p.mass * np.eye(2)
    c[:2, :2] = b * np.eye(2) + 2.0 * p.mass * w * turn
    k[:2, :2] = (p.stiffness[0] - p.mass * w * w) * np.eye(2) + b * w * turn
    for i in range(n):
        cos, sin = np.cos(state.angles[i]), np.sin(state.angles[i])
        radial, tangent = p.moment[i] * np.array([cos, sin]), p.moment[i] * np.array([-sin, cos])
        row = 2 + i
        m[:2, row] = m[row, :2] = tangent
        c[:2, row] = -2.0 * w * radial
        k[:2, row] = -w * w * tangent
        # Im[e^(-i phi) (.)] is the component along the tangent
        c[row, :2] = 2.0 * w * tangent @ turn
        k[row, :2] = -w * w * tangent
        m[row, row], c[row, row] = p.inertia[i], p.drag[i]
        center = state.whirl + p.offset[i]
        k[row, row] = w * w * (radial @ [center.real, center.imag])
    return m, c, k


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


BALLS_ALONE, ROTOR_ALONE = 30.0, 3.0  # way of the balls over deflection of the rotor


def motion_name(vector: Complexes, p: Plane, value: complex, speed: float) -> str:
    """What moves in an eigenvector (X, Y, phi...): the rotor and how it whirls in space, the balls and how, or both.

    The way of the balls in the race is compared with the deflection of the rotor: above 30 the mode is named after the
    balls, below 3 after the rotor. A part e^(i w t) in the rotor is a whirl with W + w in space.
    """
    x, y, balls = vector[0], vector[1], vector[2:]
    rotor = float(np.hypot(abs(x), abs(y)))
    way = float(np.sqrt((np.abs(balls * p.moment / p.ball_mass) ** 2).sum())) if balls.size else 0.0
    if way < ROTOR_ALONE * rotor or balls.size == 0:
        frequency = speed + value.imag if abs(x + 1j * y) >= abs(x - 1j * y) else speed - value.imag
        return f"rotor, {'forward' if frequency >= 0.0 else 'backward'} whirl"
    moving = "balls" if way > BALLS_ALONE * rotor else "balls and rotor"
    if balls.size < 2:
        return f"{moving}, oscillating"
    together = abs(balls.sum()) / np.abs(balls).sum()
    how = "together" if together > 0.8 else "against each other" if together < 0.2 else "unequally"
    return f"{moving}, {how}"
