"""Balls as an element of a rotor that something else moves, such as another program.

With the accelerations a = (A of all rows of the stations, w') the element is two linear forms,

    F = force - mass a,    phi'' = push - lean a,

F the forces on the rows of the stations and, last, the torque on the rotor. Rows of a station: deflection along x and y;
where balls move with the tilt of their race, the slopes dx/dz and dy/dz too, and F has their moments. All is in axes at rest,
F contains the weight of the balls, ``mass`` their mass. It is symmetric where balls do not rub.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import float64, types, void

from autobalancer.kernels.balls.ball_forces import push_guided
from autobalancer.kernels.balls.guided import touch
from autobalancer.kernels.balls.on_stations import gather
from autobalancer.kernels.compiler.flags import COMPILED, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data
from autobalancer.kernels.host.linear import Motion, solve_two
from autobalancer.kernels.system import BALLS, Floats, Matrix, System, matrix_type, system_type, tuple_type, vector_type
from autobalancer.kernels.trigonometry import sine_cosine


@njit(
    void(
        float64, vector_type, vector_type, vector_type, system_type,
        vector_type, matrix_type, vector_type, matrix_type,
    ),
    **COMPILED,
)  # fmt: skip
def element(
    time: float,
    shaft: Floats,
    rotor: Floats,
    balls: Floats,
    system: System,
    force: Floats,
    mass: Matrix,
    push: Floats,
    lean: Matrix,
) -> None:
    """Both forms at an instant, written into the last four.

    Parameters
    ----------
    time
        s; only what is tabled over time needs it.
    shaft
        (2 R,) the R rows of all stations, then their rates.
    rotor
        (2,) angle and speed.
    balls
        (2 n,) angles in the rotor, then their speeds there.
    system
        The balls, on a rotor whose coordinates are these rows, and whose speed is free; ``rigid.middle`` has room for a state.
    force, mass
        (R + 1,), (R + 1, R + 1).
    push, lean
        (n,), (n, R + 1).
    """
    p, work = system, system.work
    count, rows, each = p.ball_count, p.host.size, p.work.inert.shape[1]
    q, v, y = data(work.q), data(work.v), data(p.rigid.middle)
    # the motion as the balls look for it, and room for what they give
    for i in range(rows):
        q[i], v[i] = shaft[i], shaft[rows + i]
        work.push[i], work.arm[i], work.turn[i] = 0.0, 0.0, 0.0
        for j in range(each):
            work.inert[i, j] = 0.0
    for i in range(2 * count):
        y[BALLS + i] = balls[i]
    sine, cosine = sine_cosine(rotor[0])
    motion = Motion(rotor[1], 0.0, sine, cosine, p.gravity_x, p.gravity_y, 0.0)
    touch(y, p)
    push_guided(y, p, motion.speed)
    torque, inertia = 0.0, 0.0
    for b in range(count):
        its_torque, its_inertia = gather(time, y, p, motion, b, (each, True, False))
        torque += its_torque
        inertia += its_inertia
    # forces: the stations do not feel each other but by the rotor
    mass[:, :] = 0.0
    for i in range(rows):
        first = (i // each) * each
        force[i], mass[i, rows], mass[rows, i] = work.push[i], work.arm[i], work.turn[i]
        for j in range(each):
            mass[i, first + j] = work.inert[i, j]
    force[rows], mass[rows, rows] = torque, inertia
    # balls: their rows as they were solved
    lean[:, :] = 0.0
    for b in range(count):
        moving, at = p.guided[b], p.balls[b].station * each
        push[b], lean[b, rows] = moving.push, moving.twist
        lean[b, at], lean[b, at + 1] = moving.lean_x, moving.lean_y
        if each == 4:
            lean[b, at + 2], lean[b, at + 3] = moving.lean_u, moving.lean_v


# A rotor of given matrices with the element, by the method of Newmark (1959) with constant mean acceleration.
#
# With c = C + w G, k = K + w' D and the predictions q*, v* of a step h, Z a = f - c v* - k q* + B^T F, Z = M + h/2 c + h^2/4 k,
# so that the rows of the stations have A = A0 + H F with H = B Z^-1 B^T. F and the balls, which go by the same rule, are
# found together, a guess of phi'' after the other. All matrices are kept by columns.


AGREED, GUESSES = 1e-9, 20  # change of phi'' over its size with which a guess is taken, and of a step; how many guesses


class Rotor(NamedTuple):
    """N coordinates, R rows of the stations; C and K at T speeds and linear between them."""

    mass: Matrix  # (N, N) M
    gyroscopic: Matrix  # (N, N) G of speed one
    turning: Matrix  # (N, N) D: stiffness over the angular acceleration
    rows: Matrix  # (R, N) B
    speeds: Floats  # (T,)
    damping: Any  # (T, N, N)
    stiffness: Any  # (T, N, N)


class Room(NamedTuple):
    """Work space, and the motion as it goes on."""

    left: Matrix  # (N, N) Z^T, then its factors
    damping: Matrix  # (N, N) C + w G
    stiffness: Matrix  # (N, N) K + w' D
    reached: Matrix  # (R, N) Z^-1 B^T by its columns
    mobility: Matrix  # (R, R) H
    q: Floats  # (N,)
    v: Floats  # (N,)
    a: Floats  # (N,)
    rates: Matrix  # (3, n) phi'' a step before, at the last one, and as it is guessed
    shaft: Floats  # (2 R,) motion of the rows
    near: Floats  # (2 R,) the same as predicted
    now: Floats  # (2 n,) balls
    small: Matrix  # (R, R) 1 + H S
    free: Floats  # (R,) A0
    one: Floats  # (R,) A
    two: Floats  # (R,) F
    spare: Floats  # (R,)
    force: Floats  # the forms of the element
    added: Matrix
    push: Floats
    lean: Matrix


def room_for(size: int, rows: int, count: int) -> Room:
    """Room for N coordinates, R rows and n balls, at rest."""
    shapes: tuple[tuple[int, ...], ...] = (
        ((size, size),) * 3 + ((rows, size), (rows, rows)) + ((size,),) * 3 + ((3, count),)
    )
    shapes += ((2 * rows,), (2 * rows,), (2 * count,), (rows, rows)) + ((rows,),) * 4
    return Room(*map(np.zeros, (*shapes, (rows + 1,), (rows + 1, rows + 1), (count,), (count, rows + 1))))


cube_type = types.Array(float64, 3, "C")
rotor_type = tuple_type(Rotor, damping=cube_type, stiffness=cube_type)
room_type = tuple_type(Room)


@njit(**INLINE)
def _subtract(out: Any, columns: Any, factors: Any) -> None:
    """A matrix times a vector, taken off."""
    for j in range(columns.shape[0]):
        factor = factors[j]
        for i in range(columns.shape[1]):
            out[i] -= factor * columns[j, i]


@njit(**INLINE)
def _factorize(p: Rotor, w: Room, step: float, speed: float, acceleration: float) -> None:
    """Matrices at a speed, factors of Z, and what forces on the stations do."""
    size, last, below, share = p.mass.shape[0], p.speeds.size - 1, 0, 0.0
    if last > 0:
        amount = min(max(abs(speed), p.speeds[0]), p.speeds[last])
        while below < last - 1 and p.speeds[below + 1] < amount:
            below += 1
        share = (amount - p.speeds[below]) / (p.speeds[below + 1] - p.speeds[below])
    above = min(below + 1, last)
    for j in range(size):
        for i in range(size):
            c = (1.0 - share) * p.damping[below, j, i] + share * p.damping[above, j, i] + speed * p.gyroscopic[j, i]
            k = (1.0 - share) * p.stiffness[below, j, i] + share * p.stiffness[above, j, i]
            k += acceleration * p.turning[j, i]
            w.damping[j, i], w.stiffness[j, i] = c, k
            w.left[j, i] = p.mass[j, i] + 0.5 * step * c + 0.25 * step * step * k
    for k in range(size):  # its symmetric part is positive definite, so no row is exchanged
        for i in range(k + 1, size):
            factor = w.left[i, k] / w.left[k, k]
            w.left[i, k] = factor
            for j in range(k + 1, size):
                w.left[i, j] -= factor * w.left[k, j]
    for r in range(p.rows.shape[0]):
        for i in range(size):
            w.reached[r, i] = p.rows[r, i]
        _solve(w.left, w.reached[r])
        for other in range(p.rows.shape[0]):
            w.mobility[other, r] = _along(p.rows[other], w.reached[r])


@njit(**INLINE)
def _along(row: Any, x: Any) -> float:
    """What a row of a station is of a motion."""
    total = 0.0
    for i in range(x.size):
        total += row[i] * x[i]
    return total


@njit(**INLINE)
def _solve(left: Any, x: Any) -> None:
    """Z x = b in place, with Z^T = left."""
    size = x.size
    for j in range(size):
        factor = x[j] / left[j, j]
        x[j] = factor
        for i in range(j + 1, size):
            x[i] -= left[j, i] * factor
    for j in range(size - 1, 0, -1):
        factor = x[j]
        for i in range(j):
            x[i] -= left[j, i] * factor


@njit(**INLINE)
def _couple(w: Room, acceleration: float) -> None:
    """Accelerations of the rows and forces of the element on them, from what it does now."""
    size = w.one.size
    for i in range(size):
        w.two[i] = w.force[i] - w.added[i, size] * acceleration
    for i in range(size):
        w.one[i] = w.free[i]
        for j in range(size):
            w.small[i, j] = 1.0 if i == j else 0.0
        for k in range(size):
            w.one[i] += w.mobility[i, k] * w.two[k]
            for j in range(size):
                w.small[i, j] += w.mobility[i, k] * w.added[k, j]
    solve_two(data(w.small), data(w.one), data(w.spare), size)
    for i in range(size):
        for j in range(size):
            w.two[i] -= w.added[i, j] * w.one[j]


@njit(**INLINE)
def _guess(
    p: Rotor, w: Room, system: System, balls: Floats, step: float, time: float, turn: Floats, count: int
) -> float:
    """One guess of all that is unknown at the end of a step; by how much phi'' changed, over its size."""
    rows, most, change = w.one.size, 1.0, 0.0
    for b in range(count):
        rate = 0.5 * (w.rates[1, b] + w.rates[2, b])
        w.now[count + b] = balls[count + b] + step * rate
        w.now[b] = balls[b] + step * (balls[count + b] + 0.5 * step * rate)
    for i in range(rows):
        w.shaft[i] = w.near[i] + 0.25 * step * step * w.one[i]
        w.shaft[rows + i] = w.near[rows + i] + 0.5 * step * w.one[i]
    element(time, w.shaft, turn, w.now, system, w.force, w.added, w.push, w.lean)
    _couple(w, turn[2])
    for b in range(count):
        rate = w.push[b] - w.lean[b, rows] * turn[2] - _along(w.lean[b], w.one)
        most, change = max(most, abs(rate)), max(change, abs(rate - w.rates[2, b]))
        w.rates[2, b] = rate
    return change / most


@njit(
    types.boolean(vector_type, matrix_type, matrix_type, rotor_type, room_type, system_type, matrix_type, matrix_type),
    **COMPILED,
)
def march(
    times: Floats, turns: Matrix, forces: Matrix, p: Rotor, w: Room, system: System, motion: Matrix, balls: Matrix
) -> bool:
    """Move rotor and balls from step to step; whether they agreed in all of them.

    Parameters
    ----------
    times
        (K,) of the steps.
    turns
        (K, 3) angle, speed and acceleration of the rotor there.
    forces
        (K, N) from outside.
    p, w, system
        The rotor, its motion at the start with room to work, and the system of the element.
    motion, balls
        (K, N), (K, 2 n): q and the balls; of the latter the first row is where they start.
    """
    count, rows, last = balls.shape[1] // 2, p.rows.shape[0], 0.0
    for s in range(times.size):  # the first step is none: it finds the accelerations at the start
        before = max(s - 1, 0)
        step = times[s] - times[before]
        if abs(step - last) <= AGREED * last:  # times are rounded
            step = last
        if s == 0 or step != last or turns[s, 1] != turns[before, 1] or turns[s, 2] != turns[before, 2]:
            _factorize(p, w, step, turns[s, 1], turns[s, 2])
            last = step
        # what is known of the motion at the end, and of the accelerations
        for i in range(w.q.size):
            w.q[i] += step * (w.v[i] + 0.25 * step * w.a[i])
            w.v[i] += 0.5 * step * w.a[i]
            w.a[i] = forces[s, i]
        _subtract(w.a, w.damping, w.v)
        _subtract(w.a, w.stiffness, w.q)
        _solve(w.left, w.a)
        for i in range(rows):
            w.near[i], w.near[rows + i], w.free[i] = (
                _along(p.rows[i], w.q),
                _along(p.rows[i], w.v),
                _along(p.rows[i], w.a),
            )
            w.one[i] = w.free[i]
        for b in range(count):
            w.rates[2, b] = 2.0 * w.rates[1, b] - w.rates[0, b]
        guesses = 0
        while _guess(p, w, system, balls[before], step, times[s], turns[s], count) > AGREED:
            guesses += 1
            if guesses == GUESSES:
                return False
        # the forces move the rotor
        for i in range(w.q.size):
            for r in range(rows):
                w.a[i] += w.two[r] * w.reached[r, i]
            w.q[i] += 0.25 * step * step * w.a[i]
            w.v[i] += 0.5 * step * w.a[i]
            motion[s, i] = w.q[i]
        for b in range(count):
            w.rates[0, b] = w.rates[1, b] if s > 0 else w.rates[2, b]
            w.rates[1, b] = w.rates[2, b]
            balls[s, b], balls[s, count + b] = w.now[b], w.now[count + b]
    return True
