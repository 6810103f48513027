"""Velocity Verlet: half a kick, drift, one evaluation with the velocity foreseen, half a kick.

Forces that depend on velocity are evaluated at v + h a of the step before, so that one evaluation a step keeps the second
order. The step itself does the work of a force at the velocity it ends with, which is h/2 times the change of a off the one
foreseen: where forces change at every step, as in a jammed ring of balls, this adds up.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import njit, types, void

from autobalancer.kernels.chamber.forces import forces
from autobalancer.kernels.chamber.layout import (
    ACC,
    DRIVEN,
    FORCE,
    INERTIA,
    INVERSE_INERTIA,
    INVERSE_MASS,
    MASS,
    MOMENT,
    NEW,
    OVERFLOW,
    POLAR,
    POS,
    SPIN,
    SPIN_ACC,
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
from autobalancer.kernels.chamber.pairs import follow, rebuild
from autobalancer.kernels.chamber.samples import add_reactions, book, speed_at, step_done
from autobalancer.kernels.flags import COMPILED
from autobalancer.kernels.pointers import data


@njit(
    void(
        types.int64, types.int64, matrix, matrix, matrix, vector, matrix, short, short, types.int8[::1], matrix, short,
        short, matrix, whole, short, short, vector, matrix, matrix, matrix, whole, matrix, matrix, matrix, vector, vector,
        vector, vector, whole, matrix, types.float64[:, :, ::1], matrix,
    ),
    **COMPILED,
)  # fmt: skip
def verlet(
    steps, every, balls, chambers, wall_springs, number, pair_stiffness, first, second, touching, springs, old_row,
    old_second, old_springs, cells, order, places, host, inertia, stiffness, damping, active, work, block, profile, power,
    before, ledger, greatest, counts, samples, ball_samples, ledgers,
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
                b[SPIN + j] += h * b[SPIN_ACC + j]
            fastest = max(fastest, square)
        follow(
            balls, number, first, second, touching, springs, old_row, old_second, old_springs, cells, order, places, counts,
            greatest, h * sqrt(fastest), 2.0, 0.0,
        )  # fmt: skip
        if counts[OVERFLOW] != 0:
            return
        forces(
            balls, chambers, wall_springs, number, pair_stiffness, first, second, touching, springs, host, inertia,
            stiffness, damping, active, work, block, power, counts, greatest, prescribed,
        )  # fmt: skip
        jolt = number[POLAR] * (host[NEW + 6] - host[A + 6]) ** 2
        for i in range(6):
            for j in range(6):
                jolt += (host[NEW + i] - host[A + i]) * inertia[i, j] * (host[NEW + j] - host[A + j])
        for i in range(7):
            host[V + i] += 0.5 * h * (host[NEW + i] - host[A + i])
            host[A + i] = host[NEW + i]
        if not driven:
            host[V + 6] = speed
        for i in range(n):
            b = data(balls[i])
            inverse, spun = b[INVERSE_MASS], b[INVERSE_INERTIA]
            for j in range(3):
                new = inverse * b[FORCE + j]
                change = new - b[ACC + j]
                jolt += b[MASS] * change * change
                b[VEL + j] += 0.5 * h * change
                b[ACC + j] = new
                new = spun * b[MOMENT + j]
                change = new - b[SPIN_ACC + j]
                jolt += b[INERTIA] * change * change
                b[SPIN + j] += 0.5 * h * change
                b[SPIN_ACC + j] = new
        book(ledger, before, power, h, jolt)
        add_reactions(before, host, 1.0)
        kept = step_done(
            every, balls, chambers, host, before, counts, greatest, power, ledger, samples, ball_samples, ledgers, kept
        )


@njit(
    void(
        matrix, matrix, matrix, vector, matrix, short, short, types.int8[::1], matrix, short, short, matrix, whole, short,
        short, vector, matrix, matrix, matrix, whole, matrix, matrix, matrix, vector, vector, vector, whole,
    ),
    **COMPILED,
)  # fmt: skip
def start(
    balls, chambers, wall_springs, number, pair_stiffness, first, second, touching, springs, old_row, old_second,
    old_springs, cells, order, places, host, inertia, stiffness, damping, active, work, block, profile, power, before,
    greatest, counts,
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
            stiffness, damping, active, work, block, power, counts, greatest, prescribed,
        )  # fmt: skip
    for i in range(7):
        host[A + i] = host[NEW + i]
    for i in range(balls.shape[0]):
        for j in range(3):
            balls[i, ACC + j] = balls[i, INVERSE_MASS] * balls[i, FORCE + j]
            balls[i, SPIN_ACC + j] = balls[i, INVERSE_INERTIA] * balls[i, MOMENT + j]
    for i in range(STORED):
        before[i] = power[i]
