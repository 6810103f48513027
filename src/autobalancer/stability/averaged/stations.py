"""The averaged equations of balls on any isotropic rotor, linearized about a state of rest in the rotor.

The forward whirl of all coordinates is Z e^(i W t) with a slow Z, as are the ball angles. With rows B_p of the stations,
s = m eps, D = K + iW (C - iWG) - W^2 M and F the load of unbalances and balls, averaging to first order in damping, balls
and slow rates leaves

    (2iW M - iWG) Z' = W^2 F + 2W sum s B^T e^(i phi) phi' - D Z
    beta phi' = s W Im[e^(-i phi) (W (B_p Z + E) - i B_p Z')]

which for one pair of coordinates are the equations of :mod:`autobalancer.stability.averaged.equations`, Spannan (2021),
(4.24)-(4.29). The gyroscopic part of the first factor is not small and stays: with it an undamped mode that whirls forward at
v goes through its resonance as i (v - W), exact at W = v. The inertia of the ball angle is left out.
"""

from __future__ import annotations

import numpy as np

from autobalancer.stability.averaged.equations import refuse_without_drag, slow_eigenvalues
from autobalancer.stability.host.planar import Complexes, Floats, Matrix
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.states.linear import kept
from autobalancer.stability.states.state import StationState

LOST = 1e-7  # singular value, over the greatest, of ball motions that move nothing


def averaged_station_matrices(st: Stations, speed: float, state: StationState) -> tuple[Floats, Floats]:
    """A and B of A x' + B x = 0 for x = (Z_x, Z_y, phi_1 ... phi_n), real."""
    w, r = speed, st.model.pairs
    mass, turning, stiffness = st.model.complex_matrices(w)
    gyroscopic = st.model.gyroscopic[:r, :r] + 1j * st.model.gyroscopic[r : 2 * r, :r]
    push = st.rows[st.station].T * (st.moment * np.exp(1j * state.angles))  # (pairs, n)
    size = 2 * r + st.moment.size
    a, b = np.zeros((size, size)), np.zeros((size, size))
    host, ball = slice(0, 2 * r), slice(2 * r, None)
    a[host, host] = _real(2j * w * mass + w * gyroscopic)
    b[host, host] = _real(stiffness + 1j * w * turning - w * w * mass)
    a[host, ball], b[host, ball] = -2.0 * w * _parts(push), -w * w * _parts(1j * push)
    # Re[e^(-i phi) z] and Im[e^(-i phi) z] of a complex z as rows over its real and imaginary part
    a[ball, host], b[ball, host] = w * _parts(push).T, -w * w * _parts(1j * push).T
    a[ball, ball] = np.diag(st.drag)
    center = state.whirl[st.station] + st.offset
    b[ball, ball] = np.diag(w * w * (st.moment * np.exp(-1j * state.angles) * center).real)
    return a, b


def averaged_station_eigenvalues(st: Stations, speed: float, state: StationState) -> Complexes:
    """Eigenvalues, 1/s, the fastest growing first.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    refuse_without_drag(st.drag)
    a, b = averaged_station_matrices(st, speed, state)
    heavy = np.sqrt(np.diag(st.model.mass)[: st.model.pairs] * speed)
    unit = 1.0 / np.concatenate([heavy, heavy, np.sqrt(st.drag)])
    return slow_eigenvalues(a * np.outer(unit, unit), b * np.outer(unit, unit))


def averaged_station_growth(st: Stations, speed: float, state: StationState) -> float:
    """Greatest real part that counts of a balanced state, 1/s: without the zeros of balls that may be moved for nothing."""
    weight = np.sqrt(np.diag(st.model.mass)[: st.model.pairs])
    push = st.rows[st.station].T * (st.moment * np.exp(1j * state.angles)) / weight[:, None]
    reach = np.linalg.svd(_parts(push), compute_uv=False)
    lost = st.moment.size - int(np.sum(reach > LOST * reach[0]))
    return float(kept(averaged_station_eigenvalues(st, speed, state), lost).real.max())


def _real(matrix: Complexes) -> Matrix:
    return np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])


def _parts(columns: Complexes) -> Matrix:
    return np.vstack([columns.real, columns.imag])
