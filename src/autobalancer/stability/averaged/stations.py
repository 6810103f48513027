"""The averaged equations of balls on any rotor, linearized about a state of rest in the rotor.

Coordinates x = Re[a_x e^(i W t)], y = Im[a_y e^(i W t)] with slow a, as are the ball angles. With a = (a_x, a_y, others), rows
B_p of the stations over x, R = (B, B, 0), s = m eps, D = K + iW (C + WG) - W^2 M and F the load R^T U of unbalances and balls,
averaging over a turn to first order in damping, balls and slow rates leaves

    (2iW M + WG) a' = W^2 F + 2W sum s R^T e^(i phi) phi' - D a
    beta phi' = s W Im[e^(-i phi) (W (Z_p + E) - i Z_p')],    Z = R a / 2

where rows and columns of y in M, C, G and K are multiplied by i and -i. Balls feel the forward whirl Z only, the backward part
has no mean. One pair of coordinates gives :mod:`autobalancer.stability.averaged.equations`, Spannan (2021), (4.24)-(4.29).
Where x and y are alike balls move the forward whirl a_x = a_y = Z of the coordinates only, and the equations are those of Z.

The gyroscopic part of the first factor is not small and stays: with it an undamped mode that whirls forward at
v goes through its resonance as i (v - W), exact at W = v. The inertia of the ball angle is left out, and so is all that balls
feel beyond the deflection of their race.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.stability.host.planar import Complexes, Floats, Matrix
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.states.linear import kept
from autobalancer.stability.states.state import StationState

LOST = 1e-7  # singular value, over the greatest, of ball motions that move nothing


class Whirl(NamedTuple):
    """What balls move at k speeds: h complex coordinates a, of which the share Z = ``felt`` R a is felt."""

    slow: Complexes  # (k, h, h) before a'
    held: Complexes  # D, (k, h, h)
    rows: Matrix  # R, (P, h)
    felt: float
    mass: Floats  # (h,)


def whirl_of(st: Stations, speeds: Floats) -> Whirl:
    """The matrices of the rotor at speeds (k,)."""
    w, model, n = speeds[:, None, None], st.model, st.model.pairs
    damping, stiffness = model.damping, model.stiffness
    if model.speeds.size > 1:
        damping, stiffness = (np.array([at(one) for one in speeds]) for at in (model.damping_at, model.stiffness_at))
    slow = np.asarray(2j * w * model.mass + w * model.gyroscopic, np.complex128)
    moving = damping + w * model.gyroscopic
    held = np.asarray(stiffness - w * w * model.mass + 1j * w * moving, np.complex128)
    mass = np.diag(model.mass)
    if st.isotropic:
        slow, held = (matrix[:, :n, :n] + 1j * matrix[:, n : 2 * n, :n] for matrix in (slow, held))
        return Whirl(slow, held, st.rows, 1.0, mass[:n])
    quarter = np.ones(model.size, np.complex128)
    quarter[n : 2 * n] = 1j
    seen = np.outer(quarter, quarter.conj())
    rows = np.concatenate([st.rows, st.rows, np.zeros((len(st.names), model.size - 2 * n))], 1)
    return Whirl(np.asarray(seen * slow), np.asarray(seen * held), rows, 0.5, mass)


def averaged_station_matrices(st: Stations, speed: float, state: StationState) -> tuple[Floats, Floats]:
    """A and B of A x' + B x = 0 for x = (Re a, Im a, phi_1 ... phi_n), real."""
    center = (state.whirl[st.station] + st.offset)[None]
    speeds = np.array([speed])
    a, b = _matrices(st, speeds, state.angles[None], center, whirl_of(st, speeds))
    return a[0], b[0]


def averaged_station_eigenvalues(st: Stations, speed: float, state: StationState) -> Complexes:
    """Eigenvalues, 1/s, the fastest growing first.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    center = state.whirl[st.station] + st.offset
    values = eigenvalues_at(st, np.array([speed]), state.angles[None], center[None])[0]
    return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)


def eigenvalues_at(st: Stations, speeds: Floats, angles: Matrix, centers: Complexes) -> Complexes:
    """Eigenvalues at k speeds for ball angles and race centers in the rotor, both (k, n); (k, size), 1/s.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    refuse_without_drag(st.drag)
    whirl = whirl_of(st, speeds)
    a, b = _matrices(st, speeds, angles, centers, whirl)
    heavy = np.sqrt(whirl.mass * float(speeds.mean()))
    unit = 1.0 / np.concatenate([heavy, heavy, np.sqrt(st.drag)])
    scale = np.outer(unit, unit)
    return np.asarray(np.linalg.eigvals(-np.linalg.solve(a * scale, b * scale)), np.complex128)


def averaged_station_growth(st: Stations, speed: float, state: StationState) -> float:
    """Greatest real part that counts, 1/s: of a balanced state without the zeros of balls that may be moved for nothing."""
    return float(kept(averaged_station_eigenvalues(st, speed, state), _neutral(st, state)).real.max())


def averaged_station_growths(st: Stations, speeds: Floats, state: StationState) -> Floats:
    """The same at many speeds, (k,), of a state whose angles and deflections are alike at all of them."""
    k, center = speeds.size, state.whirl[st.station] + st.offset
    values = eigenvalues_at(st, speeds, np.tile(state.angles, (k, 1)), np.tile(center, (k, 1)))
    order = np.argsort(np.abs(values), axis=1)[:, _neutral(st, state) :]
    return np.asarray(np.take_along_axis(values.real, order, axis=1).max(axis=1))


def refuse_without_drag(drag: Floats) -> None:
    """Refuse balls without drag: the averaged equations, which leave out their inertia, say nothing about them.

    Raises
    ------
    QuestionError
        If there is one.
    """
    if not (drag > 0.0).all():
        raise QuestionError("averaged theory: a ball without drag has no averaged equation of motion; give it some")


def _matrices(st: Stations, speeds: Floats, angles: Matrix, centers: Complexes, whirl: Whirl) -> tuple[Matrix, Matrix]:
    """A and B at k speeds, each (k, size, size)."""
    n, h, w, felt = st.moment.size, whirl.held.shape[1], speeds[:, None, None], whirl.felt
    push = whirl.rows[st.station].T * (st.moment * np.exp(1j * angles))[:, None]  # (k, h, n)
    a, b = (np.zeros((speeds.size, 2 * h + n, 2 * h + n)) for _ in range(2))
    host, ball, each = slice(0, 2 * h), slice(2 * h, None), 2 * h + np.arange(n)
    a[:, host, host] = _real(whirl.slow)
    b[:, host, host] = _real(whirl.held)
    along, across = _parts(push), _parts(1j * push)
    a[:, host, ball], b[:, host, ball] = -2.0 * w * along, -w * w * across
    # Re[e^(-i phi) z] and Im[e^(-i phi) z] of a complex z as rows over its real and imaginary part
    a[:, ball, host] = felt * w * along.swapaxes(1, 2)
    b[:, ball, host] = -felt * w * w * across.swapaxes(1, 2)
    a[:, each, each] = st.drag
    b[:, each, each] = speeds[:, None] ** 2 * (st.moment * np.exp(-1j * angles) * centers).real
    return a, b


def _neutral(st: Stations, state: StationState) -> int:
    """Dimension of the small ball motions that leave a balanced rotor balanced."""
    if state.name != "balanced":
        return 0
    weight = np.sqrt(np.diag(st.model.mass)[: st.model.pairs])
    push = st.rows[st.station].T * (st.moment * np.exp(1j * state.angles)) / weight[:, None]
    reach = np.linalg.svd(np.vstack([push.real, push.imag]), compute_uv=False)
    return st.moment.size - int(np.sum(reach > LOST * reach[0]))


def _real(matrices: Complexes) -> Matrix:
    return np.block([[matrices.real, -matrices.imag], [matrices.imag, matrices.real]])


def _parts(columns: Complexes) -> Matrix:
    return np.concatenate([columns.real, columns.imag], axis=1)
