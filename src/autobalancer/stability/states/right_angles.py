"""Equal balls with S2 = sum e^(2 i phi) = 0, such as two at right angles: exact stability on orthotropic supports in closed form.

With u = sum s i e^(i phi) dphi, U = u e^(i W t) in space and the deflection z = x + iy the balls of a balanced planar rotor obey

    I u'' + beta u' + (N s^2/2) e^(-i W t) z'' = 0    for S2 = 0,    M z'' + b z' + k z + U'' = 0 in x and y each.

So they act like a ring that is alike in all directions. Seen in space all coefficients are constant whatever the supports are:
no Floquet theory is needed. With D = M t^2 + b t + k of x and y and A = I t^2 + beta t - I W^2 the exponents t are the roots of

    D_x D_y [A^2 + W^2 (2 I t + beta)^2] - (N s^2/2) t^4 (D_x + D_y) A + (N s^2/2)^2 t^8 = 0,

a real polynomial of degree eight. Seen from the rotor they are t - iW. On isotropic supports it is the product of two factors, of
which the explicit border of balls at right angles follows.
"""

from __future__ import annotations

import numpy as np

from autobalancer.stability.host.planar import Complexes, Floats, Plane


def exponents(p: Plane, speeds: Floats) -> Complexes:
    """The eight exponents in space, 1/s, of equal balls with S2 = 0 in races on the axis, (k, 8)."""
    k, own = speeds.size, np.eye(2)
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])
    w, inertia, drag = speeds[:, None, None], float(p.inertia[0]), float(p.drag[0])
    coupling = 0.5 * float((p.moment**2).sum())
    mass, damping, stiffness = np.zeros((4, 4)), np.zeros((k, 4, 4)), np.zeros((k, 4, 4))
    mass[:2, :2], mass[2:, 2:] = p.mass * own, inertia * own
    mass[:2, 2:], mass[2:, :2] = own, coupling * own
    damping[:, :2, :2], stiffness[:, :2, :2] = np.diag(p.damping), np.diag(p.stiffness)
    damping[:, 2:, 2:] = drag * own - 2.0 * w * inertia * turned
    stiffness[:, 2:, 2:] = -w * w * inertia * own - w * drag * turned
    first = np.zeros((k, 8, 8))
    first[:, :4, 4:] = np.eye(4)
    first[:, 4:, :4], first[:, 4:, 4:] = -np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)
    unit = np.tile([1.0, 1.0, p.moment[0], p.moment[0]], 2)  # of U a moment
    return np.asarray(np.linalg.eigvals(first * unit / unit[:, None]), np.complex128)


def growth_rates(p: Plane, speeds: Floats) -> Floats:
    """Greatest real part at each speed, 1/s."""
    return np.asarray(exponents(p, speeds).real.max(axis=1))
