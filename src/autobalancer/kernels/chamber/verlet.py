"""Velocity Verlet: half a kick, drift, one evaluation with the velocity foreseen, half a kick.

Forces that depend on velocity are evaluated at v + h a of the step before, so that one evaluation a step keeps the second
order.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import njit, types, void

from autobalancer.kernels.chamber.contact import APART
from autobalancer.kernels.chamber.forces import forces
from autobalancer.kernels.chamber.layout import (
    ACC,
    BEGUN_BALL,
    BEGUN_WALL,
    CENTER,
    CHAMBER,
    CONSTRAINT,
    DRIVEN,
    FORCE,
    FORCE_SEEN,
    HOST,
    INERTIA,
    MASS,
    MOMENT,
    NEW,
    OVERFLOW,
    P1,
    PIECE,
    POS,
    SKIN,
    SPIN,
    STEP,
    STEPS_DONE,
    STORED,
    VEL,
    WAY,
    A,
    Q,
    V,
    matrix,
    short,
    vector,
    whole,
)
from autobalancer.kernels.chamber.pairs import rebuild
from autobalancer.kernels.flags import COMPILED
from autobalancer.kernels.pointers import data

REACTIONS = 12  # bearing forces and constraints, means since the last sample
SAMPLE = HOST + 20  # columns of a sample: host, means of reactions, counts, greatest force, energy in contacts


@njit(**APART)
def speed_at(profile, time, counts):
    """Speed and its rate at ``time``, straight between the rows (time, speed), constant outside."""
    last = profile.shape[0] - 1
    k = counts[PIECE]
    while k < last and time >= profile[k + 1, 0]:
        k += 1
    counts[PIECE] = k
    if k == last or time < profile[0, 0]:
        return profile[k, 1], 0.0
    rate = (profile[k + 1, 1] - profile[k, 1]) / (profile[k + 1, 0] - profile[k, 0])
    return profile[k, 1] + rate * (time - profile[k, 0]), rate


@njit(**APART)
def note_sample(balls, chambers, host, sums, counts, greatest, power, every, row, row_balls):
    """One sample: the body, means of reactions, counts; places of the balls in their chambers, velocities, spins."""
    for i in range(HOST):
        row[i] = host[i]
    for i in range(REACTIONS):
        row[HOST + i] = sums[i] / every
        sums[i] = 0.0
    row[HOST + 12], row[HOST + 13] = counts[BEGUN_BALL], counts[BEGUN_WALL]
    row[HOST + 14], row[HOST + 15] = greatest[FORCE_SEEN], power[STORED]
    counts[BEGUN_BALL] = counts[BEGUN_WALL] = 0
    greatest[FORCE_SEEN] = 0.0
    a, b, c = host[Q + 3], host[Q + 4], host[Q + 5]
    for i in range(balls.shape[0]):
        x, y, z = balls[i, POS] - host[Q], balls[i, POS + 1] - host[Q + 1], balls[i, POS + 2] - host[Q + 2]
        row_balls[i, 0] = x - (b * z - c * y) - chambers[int(balls[i, CHAMBER]), CENTER]
        row_balls[i, 1] = y - (c * x - a * z)
        row_balls[i, 2] = z - (a * y - b * x)
        for j in range(6):
            row_balls[i, 3 + j] = balls[i, VEL + j]


@njit(
    void(
        types.int64, types.int64, matrix, matrix, matrix, vector, matrix, short, short, types.int8[::1], matrix, short,
        short, matrix, whole, short, short, vector, matrix, matrix, matrix, whole, matrix, matrix, vector, vector, vector,
        vector, whole, matrix, types.float64[:, :, ::1], matrix,
    ),
    **COMPILED,
)  # fmt: skip
def verlet(
    steps, every, balls, chambers, wall_springs, number, pair_stiffness, first, second, touching, springs, old_row,
    old_second, old_springs, cells, order, places, host, inertia, stiffness, damping, active, work, profile, power, before,
    ledger, greatest, counts, samples, ball_samples, ledgers,
):  # fmt: skip
    """Advance by ``steps`` steps and keep a sample after each ``every`` of them.

    ``ledger`` gathers the powers over time; ``samples`` (., SAMPLE), ``ball_samples`` (., n, 9) and ``ledgers`` (., POWERS)
    take what is kept; ``before`` are the powers of the last evaluation, followed by the sums of the reactions.
    """
    h = number[STEP]
    n = balls.shape[0]
    driven = number[DRIVEN] != 0.0
    kept = 0
    for _ in range(steps):
        now = (counts[STEPS_DONE] + 1) * h
        prescribed = 0.0
        if not driven:
            speed, prescribed = speed_at(profile, now, counts)
        for i in range(7):
            half = host[V + i] + 0.5 * h * host[A + i]
            host[Q + i] += h * half
            host[V + i] = half + 0.5 * h * host[A + i]
        if not driven:
            host[V + 6] = speed
        fastest = 0.0
        for i in range(n):
            b = data(balls[i])
            square = 0.0
            for j in range(3):
                change = 0.5 * h * b[ACC + j]
                half = b[VEL + j] + change
                b[POS + j] += h * half
                square += half * half
                b[VEL + j] = half + change
                b[SPIN + j] += h * b[ACC + 3 + j]
            fastest = max(fastest, square)
        greatest[WAY] += h * sqrt(fastest)
        if 2.0 * greatest[WAY] > number[SKIN]:
            rebuild(
                balls, number, first, second, touching, springs, old_row, old_second, old_springs, cells, order, places,
                counts,
            )  # fmt: skip
            greatest[WAY] = 0.0
            if counts[OVERFLOW] != 0:
                return
        forces(
            balls, chambers, wall_springs, number, pair_stiffness, first, second, touching, springs, host, inertia,
            stiffness, damping, active, work, power, counts, greatest, prescribed,
        )  # fmt: skip
        for i in range(7):
            host[V + i] += 0.5 * h * (host[NEW + i] - host[A + i])
            host[A + i] = host[NEW + i]
        if not driven:
            host[V + 6] = speed
        for i in range(n):
            b = data(balls[i])
            inverse, spun = 1.0 / b[MASS], 1.0 / b[INERTIA]
            for j in range(3):
                new = inverse * b[FORCE + j]
                b[VEL + j] += 0.5 * h * (new - b[ACC + j])
                b[ACC + j] = new
                new = spun * b[MOMENT + j]
                b[SPIN + j] += 0.5 * h * (new - b[ACC + 3 + j])
                b[ACC + 3 + j] = new
        for i in range(STORED):
            ledger[i] += 0.5 * h * (before[i] + power[i])
            before[i] = power[i]
        for i in range(6):
            before[STORED + 1 + i] += host[P1 + i]
            before[STORED + 7 + i] += host[CONSTRAINT + i]
        counts[STEPS_DONE] += 1
        if counts[STEPS_DONE] % every == 0:
            note_sample(
                balls, chambers, host, before[STORED + 1 :], counts, greatest, power, float(every), samples[kept],
                ball_samples[kept],
            )  # fmt: skip
            for i in range(STORED):
                ledgers[kept, i] = ledger[i]
            kept += 1


@njit(
    void(
        matrix, matrix, matrix, vector, matrix, short, short, types.int8[::1], matrix, short, short, matrix, whole, short,
        short, vector, matrix, matrix, matrix, whole, matrix, matrix, vector, vector, vector, whole,
    ),
    **COMPILED,
)  # fmt: skip
def start(
    balls, chambers, wall_springs, number, pair_stiffness, first, second, touching, springs, old_row, old_second,
    old_springs, cells, order, places, host, inertia, stiffness, damping, active, work, profile, power, before, greatest,
    counts,
):  # fmt: skip
    """List the pairs and evaluate once at time 0, so that the first step has its rates."""
    prescribed = 0.0
    if number[DRIVEN] == 0.0:
        host[V + 6], prescribed = speed_at(profile, 0.0, counts)
    rebuild(
        balls, number, first, second, touching, springs, old_row, old_second, old_springs, cells, order, places, counts
    )
    greatest[WAY] = 0.0
    if counts[OVERFLOW] != 0:
        return
    for _ in range(2):  # the second time with the bearing forces of the first
        forces(
            balls, chambers, wall_springs, number, pair_stiffness, first, second, touching, springs, host, inertia,
            stiffness, damping, active, work, power, counts, greatest, prescribed,
        )  # fmt: skip
    for i in range(7):
        host[A + i] = host[NEW + i]
    for i in range(balls.shape[0]):
        for j in range(3):
            balls[i, ACC + j] = balls[i, FORCE + j] / balls[i, MASS]
            balls[i, ACC + 3 + j] = balls[i, MOMENT + j] / balls[i, INERTIA]
    for i in range(STORED):
        before[i] = power[i]
