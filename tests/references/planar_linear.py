"""The full equations linearized about a state of rest in the rotor, isotropic machines.

In the frame that turns with the rotor, with Z = X + iY and s = m eps (derived from Spannan 2021, 4.14-4.17):

    M (Z'' + 2iW Z' - W^2 Z) + b (Z' + iW Z) + k Z + sum s e^(i phi) i (phi'' + 2iW phi' - W^2 phi) = 0
    I phi'' + beta phi' + s Im[e^(-i phi) (Z'' + 2iW Z' - W^2 Z)] + s W^2 Re[e^(-i phi) c] phi = 0

for small Z and phi about the state with ball angles phi and race-center vector c.
"""

from __future__ import annotations

import numpy as np
from tests.references.planar_states import Equilibrium

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.stability.host.stations import Plane


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
