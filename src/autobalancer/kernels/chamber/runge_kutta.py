"""The classical Runge-Kutta method of fourth order with fixed steps, as in Pakuła (2021), appendix 1; for comparison."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import njit, types, void

from autobalancer.kernels.chamber.forces import forces
from autobalancer.kernels.chamber.layout import (
    DRIVEN,
    FORCE,
    INVERSE_INERTIA,
    INVERSE_MASS,
    MOMENT,
    NEW,
    OVERFLOW,
    POS,
    SPIN,
    STEP,
    STEPS_DONE,
    STORED,
    VEL,
    Q,
    V,
    matrix,
    short,
    vector,
    whole,
)
from autobalancer.kernels.chamber.pairs import follow
from autobalancer.kernels.chamber.samples import add_reactions, speed_at, step_done
from autobalancer.kernels.flags import COMPILED
from autobalancer.kernels.pointers import data

PER_BALL = 9


@njit(
    void(
        types.int64, types.int64, matrix, matrix, matrix, vector, matrix, short, short, types.int8[::1], matrix, short,
        short, matrix, whole, short, short, vector, matrix, matrix, matrix, whole, matrix, matrix, matrix, vector, vector,
        vector, vector, whole, matrix, types.float64[:, :, ::1], matrix, matrix,
    ),
    **COMPILED,
)  # fmt: skip
def runge_kutta(
    steps, every, balls, chambers, wall_springs, number, pair_stiffness, first, second, touching, springs, old_row,
    old_second, old_springs, cells, order, places, host, inertia, stiffness, damping, active, work, block, profile, power,
    before, ledger, greatest, counts, samples, ball_samples, ledgers, memory,
):  # fmt: skip
    """Like ``verlet``; ``memory`` (2, 9 n + 14) holds the state at the start of a step and the sum of its slopes."""
    h = number[STEP]
    n = balls.shape[0]
    body = PER_BALL * n
    driven = number[DRIVEN] != 0.0
    begin, total = memory[0], memory[1]
    kept = 0
    for _ in range(steps):
        now = counts[STEPS_DONE] * h
        fastest = 0.0
        for i in range(n):
            square = 0.0
            for j in range(PER_BALL):
                begin[PER_BALL * i + j] = balls[i, POS + j]
                total[PER_BALL * i + j] = 0.0
            for j in range(3):
                square += balls[i, VEL + j] ** 2
            fastest = max(fastest, square)
        for i in range(14):
            begin[body + i] = host[Q + i]
            total[body + i] = 0.0
        way = h * sqrt(fastest)
        follow(
            balls, number, first, second, touching, springs, old_row, old_second, old_springs, cells, order, places, counts,
            greatest, way, 3.0, way,
        )  # fmt: skip
        if counts[OVERFLOW] != 0:
            return
        for stage in range(4):
            ahead = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
            then = 0.0 if stage == 3 else (h if stage == 2 else 0.5 * h)
            weight = (h / 6.0) if stage in (0, 3) else (h / 3.0)
            prescribed = 0.0
            if not driven:
                host[V + 6], prescribed = speed_at(profile, now + ahead, counts)
            forces(
                balls, chambers, wall_springs, number, pair_stiffness, first, second, touching, springs, host, inertia,
                stiffness, damping, active, work, block, power, counts, greatest, prescribed,
            )  # fmt: skip
            for i in range(n):
                ball = data(balls[i])
                inverse, spun = ball[INVERSE_MASS], ball[INVERSE_INERTIA]
                o = PER_BALL * i
                for j in range(3):
                    speed = ball[VEL + j]
                    rate = inverse * ball[FORCE + j]
                    turn = spun * ball[MOMENT + j]
                    total[o + j] += weight * speed
                    total[o + 3 + j] += weight * rate
                    total[o + 6 + j] += weight * turn
                    ball[POS + j] = begin[o + j] + then * speed
                    ball[VEL + j] = begin[o + 3 + j] + then * rate
                    ball[SPIN + j] = begin[o + 6 + j] + then * turn
            for i in range(7):
                speed, rate = host[V + i], host[NEW + i]
                total[body + i] += weight * speed
                total[body + 7 + i] += weight * rate
                host[Q + i] = begin[body + i] + then * speed
                host[V + i] = begin[body + 7 + i] + then * rate
            for i in range(STORED):
                ledger[i] += weight * power[i]
            add_reactions(before, host, weight / h)
        for i in range(n):
            for j in range(PER_BALL):
                balls[i, POS + j] = begin[PER_BALL * i + j] + total[PER_BALL * i + j]
        for i in range(14):
            host[Q + i] = begin[body + i] + total[body + i]
        kept = step_done(
            every, balls, chambers, host, before, counts, greatest, power, ledger, samples, ball_samples, ledgers, kept
        )
