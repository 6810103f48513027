"""Floquet multipliers of balls on any rotor: its equations linearized about a periodic state and taken around a turn.

What balls feel beyond the deflection of their race comes from the vector field over half a turn.

The variational equations are linear with coefficients that repeat, mirrored, after half a turn. They are integrated by
the Gauss method of four stages (order eight) in equal steps, all steps at once; multipliers of the whole turn are the
squares of those of the mirrored half.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.stability.host.cycle import gauss, step_maps, steps_of
from autobalancer.stability.host.planar import Complexes, Floats, Matrix
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.states.harmonic_balance import Swing, swing_of
from autobalancer.stability.states.state import StationState
from autobalancer.stability.states.swinging import swinging


def exponents_of(st: Stations, speed: float, guess: StationState) -> Complexes:
    """ln(multiplier) over the time of a turn, 1/s, the fastest growing first, as many as :func:`counted`.

    Raises
    ------
    QuestionError
        If there is no periodic state near the guess.
    """
    if not st.plain:
        cycle, state = swinging(st, speed, guess.angles, guess.freedom)
        return cycle.exponents(state)
    half = half_turn(st, swing_of(st, speed, guess))
    multipliers = np.linalg.eigvals(half) ** 2
    values = np.log(multipliers) * speed / (2.0 * math.pi)
    return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)


def counted(st: Stations) -> int:
    """Number of exponents: two for each ball and coordinate, of those along and about the axis where they are known."""
    return 2 * (st.moment.size + (st.model.size if st.plain else 2 * st.model.pairs))


def in_mean(st: Stations, speed: float, guess: StationState) -> StationState:
    """Mean ball angles and forward whirl of the periodic state near a state of the mean torque; the same if there is none.

    States that rest stay as they are, and so do those of balls that feel the deflection of their race only.
    """
    if st.isotropic or st.plain:
        return guess
    try:
        cycle, state = swinging(st, speed, guess.angles, guess.freedom)
    except QuestionError:
        return guess
    mean, half, n = state[: cycle.size], cycle.rotor // 2, cycle.balls
    coordinates = mean[: half // 2] + 1j * mean[half // 2 : half]
    whirl = np.asarray(st.rows @ coordinates, np.complex128)
    return replace(guess, angles=mean[cycle.rotor : cycle.rotor + n], whirl=whirl)


def half_turn(st: Stations, swing: Swing) -> Matrix:
    """Small motions (q, phi, q', phi') half a turn later, seen from axes turned by half a turn."""
    model, n = st.model, st.moment.size
    fastest = math.sqrt(
        float(np.abs(np.linalg.eigvals(np.linalg.solve(model.mass, model.stiffness_at(swing.speed)))).max())
    )
    steps = steps_of(fastest, swing.speed)
    nodes, _, _ = gauss()
    width = math.pi / steps
    turn = width * (np.arange(steps)[:, None] + nodes)
    held, slowed = _accelerations(st, swing, turn.ravel())
    maps = step_maps(held, slowed, width / swing.speed)
    whole = maps[0]
    for one in maps[1:]:
        whole = one @ whole
    mirror = np.tile(np.concatenate([np.full(model.size, -1.0), np.ones(n)]), 2)
    return np.asarray(mirror[:, None] * whole)


def _accelerations(st: Stations, swing: Swing, turn: Floats) -> tuple[Matrix, Matrix]:
    """x'' = held x + slowed x' at rotor angles, x = (q, phi); each (k, N + n, N + n)."""
    model, n, w = st.model, st.moment.size, swing.speed
    size, both = model.size, model.both(st.rows)
    places, count = len(st.names), turn.size
    angle, rate, change, acceleration = swing.at(turn)
    ahead = st.moment[:, None] * np.exp(1j * (turn + angle))  # (n, k)
    row_x, row_y = both[st.station], both[places + st.station]  # (n, N)

    def along(vector: Complexes) -> Matrix:
        """Forces of the balls on the coordinates, (k, N, n)."""
        return np.asarray(np.einsum("nk,na->kan", vector.real, row_x) + np.einsum("nk,na->kan", vector.imag, row_y))

    mass = np.zeros((count, size + n, size + n))
    mass[:, :size, :size] = model.mass
    mass[:, :size, size:] = along(1j * ahead)
    mass[:, size:, :size] = mass[:, :size, size:].transpose(0, 2, 1)
    mass[:, range(size, size + n), range(size, size + n)] = st.inertia
    right = np.zeros((count, size + n, 2 * (size + n)))
    right[:, :size, :size] = -model.stiffness_at(w)
    right[:, :size, size : size + n] = along((1j * (w + rate) ** 2 + change) * ahead)
    right[:, :size, size + n : 2 * size + n] = -(model.damping_at(w) + w * model.gyroscopic)
    right[:, :size, 2 * size + n :] = along(2.0 * (w + rate) * ahead)
    ball = np.arange(n)
    seen = (ahead.conj() * acceleration[st.station]).real
    center = st.moment[:, None] * w * w * (np.exp(-1j * angle) * st.offset[:, None]).real
    right[:, size + ball, size + ball] = (seen - center).T
    right[:, size + ball, 2 * size + n + ball] = -st.drag
    found = np.linalg.solve(mass, right)
    return np.asarray(found[:, :, : size + n]), np.asarray(found[:, :, size + n :])
