"""What a march keeps: the prescribed speed of an instant, the ledger of a step, samples."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from numba import njit

from autobalancer.kernels.chamber.contact import APART, TOUCH
from autobalancer.kernels.chamber.layout import (
    BEGUN_BALL,
    BEGUN_WALL,
    CENTER,
    CHAMBER,
    CONSTRAINT,
    FORCE_SEEN,
    HOST,
    P1,
    P_CONTACT,
    P_FRICTION,
    PIECE,
    POS,
    STEPS_DONE,
    STORED,
    VEL,
    Q,
)

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


@njit(**TOUCH)
def add_reactions(before, host, weight):
    """``before`` has the powers of the last evaluation, followed by the sums of the reactions."""
    for i in range(6):
        before[STORED + 1 + i] += weight * host[P1 + i]
        before[STORED + 7 + i] += weight * host[CONSTRAINT + i]


@njit(**TOUCH)
def book(ledger, before, power, h, jolt):
    """Add the powers of a step to ``ledger``; ``jolt`` is the sum of the changes of all accelerations squared times mass.

    Losses of impacts and friction are those at foreseen velocities less h^2/4 of the jolt, each by its part: with F = m a,
    F_n (v_n - v*_n) = h/2 m a_n (a_n - a_n-1), in the sum over all steps h/4 m (a_n - a_n-1)^2 and what is left of the ends.
    """
    parts = abs(power[P_CONTACT]) + power[P_FRICTION]
    over = 0.25 * h * h * jolt / parts if parts > 0.0 else 0.0
    for i in range(STORED):
        ledger[i] += 0.5 * h * (before[i] + power[i])
        before[i] = power[i]
    for i in (P_CONTACT, P_FRICTION):
        ledger[i] -= over * abs(power[i])


@njit(**TOUCH)
def step_done(
    every, balls, chambers, host, before, counts, greatest, power, ledger, samples, ball_samples, ledgers, kept
):
    """Count a step and keep a sample if one is due; answers how many are kept now."""
    counts[STEPS_DONE] += 1
    if counts[STEPS_DONE] % every != 0:
        return kept
    note_sample(
        balls, chambers, host, before[STORED + 1 :], counts, greatest, power, float(every), samples[kept],
        ball_samples[kept],
    )  # fmt: skip
    for i in range(STORED):
        ledgers[kept, i] = ledger[i]
    return kept + 1
