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
    """What balls move: h complex coordinates a, of which the share Z = ``felt`` R a is felt."""

    slow: Complexes  # (h, h) before a'
    held: Complexes  # D, (h, h)
    rows: Matrix  # R, (P, h)
    felt: float
    mass: Floats  # (h,)


def whirl_of(st: Stations, speed: float) -> Whirl:
    """The matrices of the rotor at a speed."""
    w, model, n = speed, st.model, st.model.pairs
    if st.isotropic:
        mass, turning, stiffness = model.complex_matrices(w)
        gyroscopic = model.gyroscopic[:n, :n] + 1j * model.gyroscopic[n : 2 * n, :n]
        slow, held = 2j * w * mass + w * gyroscopic, stiffness + 1j * w * turning - w * w * mass
        return Whirl(slow, held, st.rows, 1.0, np.diag(model.mass)[:n])
    quarter = np.ones(model.size, np.complex128)
    quarter[n : 2 * n] = 1j
    seen = np.outer(quarter, quarter.conj())
    moving = model.damping_at(w) + w * model.gyroscopic
    slow = seen * (2j * w * model.mass + w * model.gyroscopic)
    held = seen * (model.stiffness_at(w) + 1j * w * moving - w * w * model.mass)
    rows = np.concatenate([st.rows, st.rows, np.zeros((len(st.names), model.size - 2 * n))], 1)
    return Whirl(slow, held, rows, 0.5, np.diag(model.mass))


def averaged_station_matrices(st: Stations, speed: float, state: StationState) -> tuple[Floats, Floats]:
    """A and B of A x' + B x = 0 for x = (Re a, Im a, phi_1 ... phi_n), real."""
    return _matrices(st, speed, state, whirl_of(st, speed))


def averaged_station_eigenvalues(st: Stations, speed: float, state: StationState) -> Complexes:
    """Eigenvalues, 1/s, the fastest growing first.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    refuse_without_drag(st.drag)
    whirl = whirl_of(st, speed)
    a, b = _matrices(st, speed, state, whirl)
    heavy = np.sqrt(whirl.mass * speed)
    unit = 1.0 / np.concatenate([heavy, heavy, np.sqrt(st.drag)])
    scale = np.outer(unit, unit)
    values = np.linalg.eigvals(-np.linalg.solve(a * scale, b * scale))
    return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)


def averaged_station_growth(st: Stations, speed: float, state: StationState) -> float:
    """Greatest real part that counts, 1/s: of a balanced state without the zeros of balls that may be moved for nothing."""
    return float(kept(averaged_station_eigenvalues(st, speed, state), _neutral(st, state)).real.max())


def refuse_without_drag(drag: Floats) -> None:
    """Refuse balls without drag: the averaged equations, which leave out their inertia, say nothing about them.

    Raises
    ------
    QuestionError
        If there is one.
    """
    if not (drag > 0.0).all():
        raise QuestionError("averaged theory: a ball without drag has no averaged equation of motion; give it some")


def _matrices(st: Stations, speed: float, state: StationState, whirl: Whirl) -> tuple[Floats, Floats]:
    w, h = speed, whirl.held.shape[0]
    push = whirl.rows[st.station].T * (st.moment * np.exp(1j * state.angles))  # (h, n)
    size = 2 * h + st.moment.size
    a, b = np.zeros((size, size)), np.zeros((size, size))
    host, ball = slice(0, 2 * h), slice(2 * h, None)
    a[host, host], b[host, host] = _real(whirl.slow), _real(whirl.held)
    a[host, ball], b[host, ball] = -2.0 * w * _parts(push), -w * w * _parts(1j * push)
    # Re[e^(-i phi) z] and Im[e^(-i phi) z] of a complex z as rows over its real and imaginary part
    a[ball, host], b[ball, host] = whirl.felt * w * _parts(push).T, -whirl.felt * w * w * _parts(1j * push).T
    a[ball, ball] = np.diag(st.drag)
    center = state.whirl[st.station] + st.offset
    b[ball, ball] = np.diag(w * w * (st.moment * np.exp(-1j * state.angles) * center).real)
    return a, b


def _neutral(st: Stations, state: StationState) -> int:
    """Dimension of the small ball motions that leave a balanced rotor balanced."""
    if state.name != "balanced":
        return 0
    weight = np.sqrt(np.diag(st.model.mass)[: st.model.pairs])
    push = st.rows[st.station].T * (st.moment * np.exp(1j * state.angles)) / weight[:, None]
    reach = np.linalg.svd(_parts(push), compute_uv=False)
    return st.moment.size - int(np.sum(reach > LOST * reach[0]))


def _real(matrix: Complexes) -> Matrix:
    return np.block([[matrix.real, -matrix.imag], [matrix.imag, matrix.real]])


def _parts(columns: Complexes) -> Matrix:
    return np.vstack([columns.real, columns.imag])
