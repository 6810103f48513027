"""The full equations of balls on any isotropic rotor, linearized about a state of rest in the rotor.

In the frame that turns with the rotor, with complex coordinates Q = Q_x + i Q_y, rows B_p of the stations, s = m eps and
the acceleration A_p = B_p (Q'' + 2iW Q' - W^2 Q),

    M (Q'' + 2iW Q' - W^2 Q) + (C - iWG) (Q' + iW Q) + K Q + sum s B^T e^(i phi) i (phi'' + 2iW phi' - W^2 phi) = 0
    I phi'' + beta phi' + s Im[e^(-i phi) A_p] + s W^2 Re[e^(-i phi) (Z_p + E)] phi = 0

for small Q and phi; M has the balls' mass on it. What balls feel beyond the deflection of their race comes from the vector field.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.errors import QuestionError
from autobalancer.progress import check_deadline
from autobalancer.stability.host.stations import Plane, Stations
from autobalancer.stability.host.vector_field import Cycle, Field, gauss, step_maps, steps_of
from autobalancer.stability.states.rest_states import StationState, state_vector

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
    # the rotor in axes that turn with it
    mass, turning, stiffness = st.model.complex_matrices(w)
    m, c, k = (np.zeros((2 * r + n, 2 * r + n)) for _ in range(3))
    _fill(m, mass)
    _fill(c, turning + 2j * w * mass)
    _fill(k, stiffness + 1j * w * turning - w * w * mass)
    if n == 0:
        return m, c, k
    # balls: they shake the rotor across and along, and the whirl of their race holds them
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


def deciding_eigenvalues(values: Complexes, freedom: int) -> Complexes:
    """The eigenvalues that decide: those without the ``freedom`` zeros of a continuum of states."""
    if freedom == 0:
        return values
    smallest = np.argsort(np.abs(values))[:freedom]
    return np.delete(values, smallest)


# When a state is stable.


MARGIN = 1e-9  # growth rates up to this share of the speed count as zero


def growth(values: Complexes, freedom: int) -> float:
    """Greatest real part that counts: without the zeros of a continuum, 1/s."""
    return float(deciding_eigenvalues(values, freedom).real.max())


def verdict(rate: float, speed: float) -> str:
    """stable, marginal or unstable."""
    if abs(rate) <= MARGIN * speed:
        return "marginal"
    return "unstable" if rate > 0.0 else "stable"


# Floquet multipliers of balls on any rotor: its equations linearized about a periodic state and taken around a turn.
#
# What balls feel beyond the deflection of their race comes from the vector field over half a turn.
#
# The variational equations are linear with coefficients that repeat, mirrored, after half a turn. They are integrated
# by the Gauss method of four stages (order eight) in equal steps, all steps at once; multipliers of the whole turn are
# the squares of those of the mirrored half.


def exponents_of(st: Stations, speed: float, guess: StationState) -> Complexes:
    """ln(multiplier) over the time of a turn, 1/s, the fastest growing first.

    Two for each ball and coordinate, of those along and about the axis where they are known.

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
    # ball moments in space, and their forces on all coordinates
    ahead = st.moment[:, None] * np.exp(1j * (turn + angle))  # (n, k)
    row_x, row_y = both[st.station], both[places + st.station]  # (n, N)

    def along(vector: Complexes) -> Matrix:
        """Forces of the balls on the coordinates, (k, N, n)."""
        return np.asarray(np.einsum("nk,na->kan", vector.real, row_x) + np.einsum("nk,na->kan", vector.imag, row_y))

    # mass with the balls' coupling, symmetric
    mass = np.zeros((count, size + n, size + n))
    mass[:, :size, :size] = model.mass
    mass[:, :size, size:] = along(1j * ahead)
    mass[:, size:, :size] = mass[:, :size, size:].transpose(0, 2, 1)
    mass[:, range(size, size + n), range(size, size + n)] = st.inertia
    # rows of the rotor, then of the balls, whose stiffness follows from the acceleration of their race
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
    accelerations = np.linalg.solve(mass, right)
    return np.asarray(accelerations[:, :, : size + n]), np.asarray(accelerations[:, :, size + n :])


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
        check_deadline()
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
        result = pushed @ np.linalg.solve(held + sigma * damping + sigma**2 * model.mass, loads) * sigma**2
        size = 2 * places * m
        answer = (result[:, :, :-1].reshape(grid.odd.size, -1).T @ grid.times).real.reshape(
            2 * places, 2 * places, m, m
        )
        self.answer = answer.swapaxes(1, 2).reshape(size, size)
        self.alone = np.real(speed**2 * result[0, :, -1:] * np.exp(1j * self.turn))  # (2 P, m)

    def solved(self, mean: Matrix, swing: Matrix) -> tuple[Matrix, Matrix]:
        """Mean angles (n, 1) and swings (n, m) of the balls at which all torques vanish."""
        st, w, size = self.st, self.speed, self.m * self.st.moment.size
        # size of the torque on each ball, (n, 1)
        own = np.abs(st.offset).max() + np.abs(self.alone).max() / w**2
        reach = np.abs(self.answer).sum(axis=1).max() * st.moment.sum()
        unit = np.asarray(st.moment * w**2 * (own + reach))[:, None]
        miss = self._torques(mean, swing)
        for _ in range(NEWTON_STEPS):
            if np.abs(miss / unit).max(initial=0.0) < 1e-15:
                break
            # Newton's method; no ball goes farther than 0.4 rad at once
            slope = self._slopes(mean, swing)
            step = self._step(miss / unit, slope / np.repeat(unit, self.m)[:, None], unit)
            largest = float(np.abs(step).max())
            step *= min(1.0, 0.4 / max(largest, 1e-300))
            shift = step.mean(axis=1, keepdims=True)
            mean, swing = mean + shift, swing + (step - shift)
            miss = self._torques(mean, swing)
            if largest < 1e-13 * max(float(np.abs(swing).max()), 1e-3):
                break
        # an answer that is none is refused
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
        step = np.linalg.lstsq(scaled, -((miss @ self.waves) * size).ravel(), rcond=1e-9)[0]
        return np.asarray((step.reshape(n, m) * size) @ self.waves.T)

    def acceleration(self, mean: Matrix, swing: Matrix) -> Complexes:
        """Of the stations in space, (P, m)."""
        force, _ = self._forces(mean, swing)
        places = len(self.st.names)
        total = np.zeros((places, self.m), np.complex128)
        np.add.at(total, self.st.station, force)
        parts = np.concatenate([total.real, total.imag]).ravel()
        result = (self.answer @ parts).reshape(2 * places, self.m) + self.alone
        return np.asarray(result[:places] + 1j * result[places:])

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


# The steady state of all equations where x and y are not alike, in harmonics of twice the speed, from ball angles near
# it.
#
# Newton's method for :class:`~autobalancer.stability.host.vector_field.Cycle`, with as many harmonics as the state needs. It
# starts with balls at rest, and the rotor as it follows them.


COUNTS = (9, 17, 33, 65)  # numbers of harmonics that are tried
CORRECTIONS = 40
CLOSE, NEAR = 1e-13, 1e-9  # rad: last correction, and one below which it may be rounding
LARGEST = 0.3  # rad: of one correction
SLACK = 1e-9  # singular value, over the greatest, that counts as none along a continuum of states


def swinging(st: Stations, speed: float, angles: Floats, freedom: int = 0) -> tuple[Cycle, Floats]:
    """The equations and the state near ball angles (n,); of a continuum of ``freedom`` dimensions the nearest member.

    Raises
    ------
    QuestionError
        If Newton's method finds no such state, or the balls do not swing smoothly.
    """
    start = np.asarray(angles, np.float64)
    for count in COUNTS:
        cycle = Cycle(st, speed, count)
        state = settled_on(cycle, start, freedom)
        start = state.reshape(count, -1)[:, cycle.rotor : cycle.rotor + cycle.balls]
        if tail(cycle, state) < TAIL:
            return cycle, state
    raise QuestionError(
        f"steady state: the balls do not swing smoothly at {speed:.6g} rad/s (harmonic {COUNTS[-1] - 1})"
    )


def settled_on(cycle: Cycle, angles: Floats, freedom: int = 0) -> Floats:
    """The state near ball angles, their mean (n,) or harmonic after harmonic (k, n), with as many harmonics as the cycle has.

    Raises
    ------
    QuestionError
        If Newton's method finds no such state.
    """
    start = np.atleast_2d(angles)
    parts = np.zeros((cycle.count, cycle.size))
    parts[: len(start), cycle.rotor : cycle.rotor + cycle.balls] = start
    state, scale, last = parts.ravel(), sizes(cycle), math.inf
    # the rotor as it follows the balls, then Newton's method for all
    follows = np.tile(np.arange(cycle.size) < cycle.rotor, cycle.count)
    slope, miss = cycle.jacobian(state), cycle(state)
    state[follows] -= np.linalg.solve(slope[np.ix_(follows, follows)], miss[follows])
    for _ in range(CORRECTIONS):
        slope, miss = cycle.jacobian(state) * scale / scale[:, None], -cycle(state) / scale
        step = np.linalg.lstsq(slope, miss, rcond=SLACK)[0] if freedom else np.linalg.solve(slope, miss)
        turned = np.abs(step.reshape(cycle.count, -1)[:, cycle.rotor : cycle.rotor + cycle.balls])
        length = float(turned.max(initial=0.0))
        state = state + scale * step * min(1.0, LARGEST / max(length, 1e-300))
        if length < CLOSE or 0.5 * last < length < NEAR:
            return state
        last = length
    raise QuestionError(f"steady state: no periodic state is found near these ball angles at {cycle.speed:.6g} rad/s")


def tail(cycle: Cycle, state: Floats) -> float:
    """Size of the highest harmonic, over the sizes of the components."""
    return float(np.abs((state / sizes(cycle)).reshape(cycle.count, -1)[-2:]).max())


def sizes(cycle: Cycle) -> Floats:
    """Of the components of a state: deflections by the moment of unbalance and balls, angles of one radian."""
    host, n = cycle.host, cycle.balls
    length = (abs(host.unbalance) + float(host.moment.sum())) / host.model.total_mass or 1.0
    repeat = np.repeat([length, length * cycle.speed, 1.0, cycle.speed], [cycle.rotor // 2, cycle.rotor // 2, n, n])
    return np.asarray(np.tile(repeat, cycle.count), np.float64)


# Growth rates of balanced planar rotors on orthotropic supports, at many speeds at once.
#
# Where races are on the axis a balanced rotor rests and its balls stand still, so that nothing but the supports
# repeats with every half turn of the rotor. In its frame, with the means k, b of stiffness and damping and half the
# differences D, d (y less x), the equations are those of :mod:`autobalancer.stability.states.linearized` for k and b, and
# on the rotor acts
#
#     e^(-2 i theta) [D conj Q + d (conj Q' - i W conj Q)].
#
# The map over half a turn is integrated by the Gauss method of four stages (order eight) in equal steps, at all speeds
# together.


LEAST, UNIT = 16, 8  # steps in half a turn: at least, and in multiples of
PER_PERIOD = 12  # steps in a period of the fastest motion of the rotor, seen from the rotor
AT_ONCE = 30_000  # numbers in memory: more do not fit the cache of a processor

SIDES = np.array(
    [[[1.0, 0.0], [0.0, -1.0]], [[0.0, -1.0], [-1.0, 0.0]]]
)  # of cos 2 theta, sin 2 theta: e^(-2 i theta) conj Q
ACROSS = np.array([[[0.0, 1.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, -1.0]]])  # times i


def growth_rates(p: Plane, speeds: Floats, angles: Matrix, neutral: NDArray[np.int64]) -> Floats:
    """Greatest real part at each speed, 1/s, of balanced states whose rotor rests.

    Parameters
    ----------
    p
        A planar rotor with races on the axis.
    speeds
        rad/s, (k,).
    angles
        Of the balls in the rotor, rad, (k, n).
    neutral
        How many roots are zero and do not count, (k,).
    """
    fastest = np.sqrt(max(p.stiffness) / p.mass) / speeds + 1.0  # in units of the speed
    steps = UNIT * np.ceil(np.maximum(LEAST, 0.5 * PER_PERIOD * fastest) / UNIT).astype(int)
    rates = np.empty(speeds.size)
    for count in np.unique(steps):
        places = np.flatnonzero(steps == count)
        width = max(1, AT_ONCE // (int(count) * (4 * (2 + p.moment.size)) ** 2))
        for part in np.split(places, range(width, places.size, width)):
            check_deadline()
            half = half_turns(p, speeds[part], angles[part], int(count))
            with np.errstate(divide="ignore"):  # a motion that dies out at once
                values = np.log(np.linalg.eigvals(half).astype(np.complex128))
            deciding = np.take_along_axis(values.real, np.argsort(np.abs(values), axis=1), axis=1)
            deciding[np.arange(half.shape[1]) < neutral[part, None]] = -np.inf
            rates[part] = deciding.max(axis=1) * speeds[part] / np.pi
    return rates


def half_turns(p: Plane, speeds: Floats, angles: Matrix, steps: int) -> Matrix:
    """Maps of small motions (X, Y, phi, X', Y', phi') over half a turn, in the frame of the rotor, (k, 4 + 2n, 4 + 2n).

    Stages are solved for accelerations only, which positions and speeds follow from.
    """
    nodes, weights, inner = gauss()
    k, size, h = speeds.size, 2 + p.moment.size, (np.pi / steps / speeds)[:, None, None, None]
    # accelerations over angle: constant and with cos and sin of twice the angle
    held, slowed = _accelerations_over_half_turn(p, speeds, angles)
    theta = np.pi / steps * (np.arange(steps)[:, None] + nodes)
    waves = np.stack([np.ones_like(theta), np.cos(2.0 * theta), np.sin(2.0 * theta)], axis=-1)  # (steps, 4, 3)
    # Gauss' method of four stages: the matrix of one step for all steps and speeds at once
    parts = np.concatenate(
        [(inner @ inner)[:, :, None] * waves[:, :, None], inner[:, :, None] * waves[:, :, None]], axis=-1
    )
    blocks = parts.reshape(-1, 6) @ np.concatenate([-h * h * held, -h * slowed], axis=1).reshape(k, 6, -1)
    # stages for every unit start
    left = blocks.reshape(k, steps, 4, 4, size, size).swapaxes(3, 4).reshape(k, steps, 4 * size, 4 * size)
    left[:, :, range(4 * size), range(4 * size)] += 1.0
    at_start = (waves.reshape(-1, 3) @ one.reshape(k, 3, -1) for one in (held, slowed))
    held, slowed = (one.reshape(k, steps, 4, size, size) for one in at_start)
    right = np.concatenate([held, slowed + h[..., None] * nodes[:, None, None] * held], axis=-1)
    result = np.linalg.solve(left, right.reshape(k, steps, 4 * size, 2 * size)).reshape(k, steps, 4, 2 * size * size)
    # the map of each step, then their product in pairs
    maps = np.zeros((k, steps, 2 * size, 2 * size)) + np.eye(2 * size)
    maps[:, :, range(size), range(size, 2 * size)] = h[..., 0]
    maps[:, :, :size] += h * h * (weights @ inner @ result).reshape(k, steps, size, 2 * size)
    maps[:, :, size:] += h * (weights @ result).reshape(k, steps, size, 2 * size)
    while maps.shape[1] > 1:
        odd = maps[:, -1:] if maps.shape[1] % 2 else maps[:, :0]
        maps = np.concatenate([maps[:, 1::2] @ maps[:, : maps.shape[1] // 2 * 2 : 2], odd], axis=1)
    return np.asarray(maps[:, 0])


def _accelerations_over_half_turn(p: Plane, speeds: Floats, angles: Matrix) -> Matrix:
    """Of positions and of speeds: constant, with cos 2 theta and with sin 2 theta, (2, k, 3, 2 + n, 2 + n)."""
    k, n = angles.shape
    size, w = 2 + n, speeds[:, None, None]
    (kx, ky), (bx, by) = p.stiffness, p.damping
    # means of x and y, and half their differences, which turn with twice the speed
    stiffness, damping, uneven, drift = 0.5 * (kx + ky), 0.5 * (bx + by), 0.5 * (ky - kx), 0.5 * (by - bx)
    turned = np.array([[0.0, -1.0], [1.0, 0.0]])
    radial = np.stack([p.moment * np.cos(angles), p.moment * np.sin(angles)], axis=1)  # (k, 2, n)
    tangent = turned @ radial
    # mass with the balls' coupling
    mass = np.zeros((k, size, size))
    mass[:, :2, :2], mass[:, 2:, 2:] = p.mass * np.eye(2), np.diag(p.inertia)
    mass[:, :2, 2:], mass[:, 2:, :2] = tangent, tangent.transpose(0, 2, 1)
    force = np.zeros((k, size, 2 * size, 3))  # constant, with cos 2 theta, with sin 2 theta
    held, slowed = force[:, :, :size], force[:, :, size:]
    # the constant part is that of isotropic supports
    held[:, :2, :2, 0] = -(stiffness - p.mass * w * w) * np.eye(2) - w * damping * turned
    held[:, :2, 2:, 0], held[:, 2:, :2, 0] = w * w * tangent, w * w * tangent.transpose(0, 2, 1)
    slowed[:, :2, :2, 0] = -damping * np.eye(2) - 2.0 * w * p.mass * turned
    slowed[:, :2, 2:, 0], slowed[:, 2:, :2, 0] = 2.0 * w * radial, -2.0 * w * radial.transpose(0, 2, 1)
    slowed[:, 2:, 2:, 0] = -np.diag(p.drag)
    # what differs between x and y
    for wave, (side, across) in enumerate(zip(SIDES, ACROSS, strict=True), 1):
        held[:, :2, :2, wave] = uneven * side - w * drift * across
        slowed[:, :2, :2, wave] = drift * side
    moved = np.linalg.solve(mass, force.reshape(k, size, -1)).reshape(k, size, 2, size, 3)
    return np.asarray(moved.transpose(2, 0, 4, 1, 3))
