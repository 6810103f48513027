"""Floquet multipliers of balls on any rotor: its equations linearized about a periodic state and taken around a turn.

What balls feel beyond the deflection of their race comes from the vector field over half a turn.

The variational equations are linear with coefficients that repeat, mirrored, after half a turn. They are integrated by
the Gauss method of four stages (order eight) in equal steps, all steps at once; multipliers of the whole turn are the
squares of those of the mirrored half.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.patience import still_time
from autobalancer.stability.host.cycle import gauss, step_maps, steps_of
from autobalancer.stability.host.planar import Complexes, Floats, Matrix
from autobalancer.stability.host.stations import Stations
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


# Periodic steady states where x and y are not alike: the balls swing in the rotor with twice its speed.
#
# After half a turn the machine is its own mirror image, so that ball angles phi(theta) have even harmonics only and
# motions of the rotor odd ones. The rotor is linear and answers harmonic by harmonic; what is left is the torque on
# each ball,
#
#     I phi'' + beta phi' + s Im[e^(-i psi) A_p] - s W^2 Im[e^(-i phi) E] = 0,    psi = theta + phi,
#     forces s ((W + phi')^2 - i phi'') e^(i psi) at the stations,
#
# demanded at equidistant rotor angles of half a turn and solved by Newton's method. The number of angles is doubled
# until the highest harmonics vanish, so that the state is exact to rounding.
#
# Mean angle and swing of a ball are kept apart: where an unbalance is small, the torque that counts is far below the
# rounding of I phi'' if phi'' is taken of the angle as a whole.


FIRST, MOST = 16, 128  # angles in half a turn
TAIL = 1e-11  # rad: higher harmonics below it have vanished
NEWTON_STEPS = 40


@dataclass(frozen=True)
class Swing:
    """A steady state that repeats after half a turn, turned by half a turn."""

    angles: Matrix  # (n, m) ball angles in the rotor at rotor angles pi j / m
    acceleration: Complexes  # (P, m) of the stations in space, m/s^2
    speed: float

    def at(self, turn: Floats) -> tuple[Floats, Floats, Floats, Complexes]:
        """Angles, their first and second time derivatives (n, k) and accelerations (P, k) at rotor angles."""
        m = self.angles.shape[1]
        even = np.fft.fft(self.angles, axis=1) / m
        k = np.fft.fftfreq(m, 1.0 / m)
        k[m // 2] = 0.0  # the highest harmonic has vanished
        even[:, m // 2] = 0.0
        back = np.exp(2j * np.outer(k, turn))
        rate = 2j * k * self.speed
        phi, first, second = ((even * rate**order @ back).real for order in range(3))
        grid = np.pi * np.arange(m) / m
        odd = np.fft.fft(self.acceleration * np.exp(-1j * grid), axis=1) / m
        return phi, first, second, np.asarray((odd @ back) * np.exp(1j * turn))


def swing_of(st: Stations, speed: float, guess: StationState) -> Swing:
    """Refine a state of the averaged torque to the periodic state of the full equations.

    Raises
    ------
    QuestionError
        If Newton's method finds no such state near the guess.
    """
    m = FIRST
    mean, swing = guess.angles[:, None].copy(), np.zeros((guess.angles.size, m))
    while True:
        still_time()
        balance = _Balance(st, speed, m)
        mean, swing = balance.solved(mean, swing)
        harmonics = np.abs(np.fft.fft(swing, axis=1)) / m
        tail = float(harmonics[:, m // 2 - 1 : m // 2 + 2].max(initial=0.0))
        if tail < TAIL:
            return Swing(mean + swing, balance.acceleration(mean, swing), speed)
        if m == MOST:
            raise QuestionError(
                f"steady state: the balls do not swing smoothly at {speed:.6g} rad/s (harmonic {m}: {tail:.2g} rad)"
            )
        padded = np.fft.fft(swing, axis=1) * 2.0
        spread = np.zeros((swing.shape[0], 2 * m), np.complex128)
        spread[:, : m // 2], spread[:, -(m // 2) + 1 :] = padded[:, : m // 2], padded[:, m // 2 + 1 :]
        swing, m = np.fft.ifft(spread, axis=1).real, 2 * m


class _Balance:
    """The torques on the balls at m rotor angles."""

    def __init__(self, st: Stations, speed: float, m: int) -> None:
        self.st, self.speed, self.m = st, speed, m
        grid = _grid(m)
        self.turn, self.waves = grid.turn, grid.waves
        self.first, self.second, self.squares = speed * grid.first, speed**2 * grid.second, speed**2 * grid.squares
        model, places = st.model, len(st.names)
        pushed, n = model.both(st.rows), model.pairs
        force = np.zeros(model.size, np.complex128)
        force[:n], force[n : 2 * n] = st.fixed_load, -1j * st.fixed_load
        sigma = 1j * speed * grid.odd[:, None, None]
        held, damping = model.stiffness_at(speed), model.damping_at(speed) + speed * model.gyroscopic
        loads = np.column_stack([pushed.T, force])
        found = pushed @ np.linalg.solve(held + sigma * damping + sigma**2 * model.mass, loads) * sigma**2
        size = 2 * places * m
        answer = (found[:, :, :-1].reshape(grid.odd.size, -1).T @ grid.times).real.reshape(2 * places, 2 * places, m, m)
        self.answer = answer.swapaxes(1, 2).reshape(size, size)
        self.alone = np.real(speed**2 * found[0, :, -1:] * np.exp(1j * self.turn))  # (2 P, m)

    def solved(self, mean: Matrix, swing: Matrix) -> tuple[Matrix, Matrix]:
        """Mean angles (n, 1) and swings (n, m) of the balls at which all torques vanish."""
        st, size = self.st, self.m * self.st.moment.size
        unit = self._unit()
        miss = self._torques(mean, swing)
        for _ in range(NEWTON_STEPS):
            if np.abs(miss / unit).max(initial=0.0) < 1e-15:
                break
            slope = self._slopes(mean, swing)
            step = self._step(miss / unit, slope / np.repeat(unit, self.m)[:, None], unit)
            largest = float(np.abs(step).max())
            step *= min(1.0, 0.4 / max(largest, 1e-300))
            shift = step.mean(axis=1, keepdims=True)
            mean, swing = mean + shift, swing + (step - shift)
            miss = self._torques(mean, swing)
            if largest < 1e-13 * max(float(np.abs(swing).max()), 1e-3):
                break
        error = float(np.abs(miss / unit).max(initial=0.0))
        if not error < 1e-9 or size == 0:
            raise QuestionError(
                f"steady state: no periodic state is found near the averaged one at {self.speed:.6g} rad/s "
                f"(torque {error:.2g} of its size, {len(st.names)} stations)"
            )
        return mean, swing

    def _step(self, miss: Matrix, slope: Matrix, unit: Floats) -> Matrix:
        """Newton's step, wave by wave in units of the inertia of the balls, which grows with the square of the wave."""
        n, m = miss.shape
        size = 1.0 / np.sqrt(1.0 + self.st.inertia[:, None] / unit * np.maximum(self.squares, 0.0))  # (n, m)
        blocks = self.waves.T @ slope.reshape(n, m, n, m).swapaxes(1, 2) @ self.waves  # (n, n, m, m)
        scaled = (blocks.swapaxes(1, 2) * size[:, :, None, None] * size).reshape(n * m, n * m)
        found = np.linalg.lstsq(scaled, -((miss @ self.waves) * size).ravel(), rcond=1e-9)[0]
        return np.asarray((found.reshape(n, m) * size) @ self.waves.T)

    def acceleration(self, mean: Matrix, swing: Matrix) -> Complexes:
        """Of the stations in space, (P, m)."""
        force, _ = self._forces(mean, swing)
        places = len(self.st.names)
        total = np.zeros((places, self.m), np.complex128)
        np.add.at(total, self.st.station, force)
        parts = np.concatenate([total.real, total.imag]).ravel()
        found = (self.answer @ parts).reshape(2 * places, self.m) + self.alone
        return np.asarray(found[:places] + 1j * found[places:])

    def _unit(self) -> Floats:
        """Size of the torque on each ball, (n, 1)."""
        st, w = self.st, self.speed
        own = np.abs(st.offset).max() + np.abs(self.alone).max() / w**2
        reach = np.abs(self.answer).sum(axis=1).max() * st.moment.sum()
        return np.asarray(st.moment * w**2 * (own + reach))[:, None]

    def _forces(self, mean: Matrix, swing: Matrix) -> tuple[Complexes, tuple[Complexes, Complexes, Complexes]]:
        """Force of each ball on its station (n, m), and its derivatives by phi, phi', phi''."""
        w, s = self.speed, self.st.moment[:, None]
        rate, change = swing @ self.first.T, swing @ self.second.T
        ahead = s * np.exp(1j * (self.turn + (mean + swing)))
        pull = (w + rate) ** 2 - 1j * change
        return pull * ahead, (1j * pull * ahead, 2.0 * (w + rate) * ahead, -1j * ahead)

    def _torques(self, mean: Matrix, swing: Matrix) -> Matrix:
        """On each ball, (n, m) N m."""
        st, w = self.st, self.speed
        s, angles = st.moment[:, None], mean + swing
        back = np.exp(-1j * (self.turn + angles))
        center = np.exp(-1j * angles) * st.offset[:, None]
        rate, change = swing @ self.first.T, swing @ self.second.T
        inertia, drag = st.inertia[:, None], st.drag[:, None]
        a = self.acceleration(mean, swing)[st.station]
        return np.asarray(inertia * change + drag * rate + s * (back * a).imag - s * w * w * center.imag)

    def _slopes(self, mean: Matrix, swing: Matrix) -> Matrix:
        """Of the torques over the swings, (n m, n m)."""
        st, m, w = self.st, self.m, self.speed
        n, places = st.moment.size, len(st.names)
        s, angles = st.moment[:, None], mean + swing
        back = np.exp(-1j * (self.turn + angles))
        center = np.exp(-1j * angles) * st.offset[:, None]
        a = self.acceleration(mean, swing)[st.station]
        own = s * (w * w * center.real - (back * a).real)
        _, (by_angle, by_rate, by_change) = self._forces(mean, swing)
        slope = np.zeros((n, m, n, m))
        for i in range(n):
            push = np.diag(by_angle[i]) + by_rate[i][:, None] * self.first + by_change[i][:, None] * self.second
            parts = np.zeros((2 * places, m, m))
            parts[st.station[i]], parts[places + st.station[i]] = push.real, push.imag
            moved = (self.answer @ parts.reshape(-1, m)).reshape(2 * places, m, m)
            seen = moved[:places] + 1j * moved[places:]
            slope[:, :, i] += (st.moment[:, None, None] * back[:, :, None] * seen[st.station]).imag
            slope[i, :, i] += st.inertia[i] * self.second + st.drag[i] * self.first + np.diag(own[i])
        return slope.reshape(n * m, n * m)


class _Grid(NamedTuple):
    """m equidistant angles of half a turn, and what belongs to them at any speed."""

    turn: Floats  # (m,)
    odd: Floats  # harmonics of the rotor, (m/2,)
    times: Complexes  # (m/2, m m): of each harmonic, from a force at one angle to the motion at another
    first: Matrix  # derivatives at speed 1, (m, m)
    second: Matrix
    squares: Floats  # of the harmonics of the balls, (m,), and their waves as columns
    waves: Matrix


@cache
def _grid(m: int) -> _Grid:
    turn, odd = np.pi * np.arange(m) / m, np.arange(1.0, m, 2.0)
    k = np.fft.fftfreq(m, 1.0 / m)
    wave = np.exp(2j * np.outer(turn, k))
    second = ((wave * (2j * k) ** 2) @ wave.conj().T).real / m
    k[m // 2] = 0.0  # the first derivative of the highest harmonic is not seen at these angles
    first = ((wave * (2j * k)) @ wave.conj().T).real / m
    out = np.exp(1j * np.outer(odd, turn))
    times = np.asarray(out[:, :, None] * out.conj()[:, None, :] * (2.0 / m), np.complex128).reshape(odd.size, m * m)
    squares, waves = np.linalg.eigh(-second)
    return _Grid(turn, odd, times, first, second, squares, waves)
