"""What a march keeps: the prescribed speed of an instant, the account of a step, samples."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import types, void

from autobalancer.kernels.chamber.chamber import CHAMBER
from autobalancer.kernels.chamber.records import MOTION, SAMPLE, THETA, TURN_X, TURN_Y, TURN_Z
from autobalancer.kernels.chamber.vectors import cross, minus, put, three
from autobalancer.kernels.flags import APART, COMPILED, MERGED, njit
from autobalancer.kernels.pointers import row


@njit(**APART)
def speed_at(chamber, time):
    """Speed and its rate at ``time``, straight between the corners of the profile, constant outside."""
    profile, progress = chamber.profile, chamber.progress
    last = profile.shape[0] - 1
    k = progress.piece
    while k < last and time >= profile[k + 1].time:
        k += 1
    progress.piece = k
    here = profile[k]
    if k == last or time < profile[0].time:
        return here.speed, 0.0
    rate = (profile[k + 1].speed - here.speed) / (profile[k + 1].time - here.time)
    return here.speed + rate * (time - here.time), rate


@njit(**MERGED)
def _copy_account(account, sample):
    sample.work_motor, sample.loss_contact, sample.loss_friction = (
        account.work_motor, account.loss_contact, account.loss_friction,
    )  # fmt: skip
    sample.loss_rolling, sample.loss_supports = account.loss_rolling, account.loss_supports
    sample.loss_bearings, sample.loss_drag = account.loss_bearings, account.loss_drag


@njit(**APART)
def _greatest_tilting(balls):
    """Greatest moment that would tilt a cylinder over what its contacts could bear; both begin anew."""
    most = 0.0
    for i in range(balls.shape[0]):
        ball = row(balls, i)
        moment = sqrt(ball.tilting[0] ** 2 + ball.tilting[1] ** 2)
        if ball.holding > 0.0:
            most = max(most, moment / ball.holding)
        ball.tilting[0] = ball.tilting[1] = ball.holding = 0.0
    return most


@njit(void(CHAMBER, types.float64, SAMPLE.row_type, MOTION.rows_type()), **COMPILED)
def note_sample(chamber, every, sample, balls):
    """One sample: the body, means of reactions, counts; places of the balls in their chambers, velocities, spins."""
    body, since = chamber.body, chamber.since
    middle = three(body.place)
    turn = body.place[TURN_X], body.place[TURN_Y], body.place[TURN_Z]
    sample.rotor_angle, sample.speed = body.place[THETA], body.rate[THETA]
    put(sample.body_position, middle)
    put(sample.body_rotation, turn)
    for i in range(THETA):
        sample.body_rate[i] = body.rate[i]
    for i in range(3):
        sample.bearing_force[0, i], sample.bearing_force[1, i] = since.bearing_1[i] / every, since.bearing_2[i] / every
        sample.constraint_force[i] = since.constraint[i] / every
        sample.constraint_moment[i] = since.constraint[3 + i] / every
        since.bearing_1[i] = since.bearing_2[i] = since.constraint[i] = since.constraint[3 + i] = 0.0
    sample.motor_torque, sample.energy_contact = body.torque, chamber.power.stored
    sample.contacts_ball, sample.contacts_wall = since.contacts_ball, since.contacts_wall
    sample.greatest_contact_force = since.greatest_force
    sample.impact_speeds, sample.impact_energies = since.impact_speeds, since.impact_energies
    since.contacts_ball = since.contacts_wall = 0
    since.impact_speeds = since.impact_energies = 0.0
    since.greatest_force = 0.0
    _copy_account(chamber.account, sample)
    if chamber.contact.cylinders != 0:
        sample.tilting = _greatest_tilting(chamber.balls)
    for i in range(chamber.balls.shape[0]):
        ball, kept = row(chamber.balls, i), row(balls, i)
        arm = minus(three(ball.position), middle)
        place = minus(arm, cross(turn, arm))
        put(kept.position, (place[0] - chamber.rooms[ball.chamber].center, place[1], place[2]))
        put(kept.velocity, three(ball.velocity))
        put(kept.spin, three(ball.spin))


@njit(**MERGED)
def add_reactions(since, body, weight):
    """Add the reactions of an evaluation to the sums since the last sample."""
    for i in range(3):
        since.bearing_1[i] += weight * body.bearing_1[i]
        since.bearing_2[i] += weight * body.bearing_2[i]
    for i in range(6):
        since.constraint[i] += weight * body.constraint[i]


@njit(**MERGED)
def add_work(account, power, time):
    """Add ``power`` over ``time``."""
    account.work_motor += time * power.motor
    account.loss_contact += time * power.contact
    account.loss_friction += time * power.friction
    account.loss_rolling += time * power.rolling
    account.loss_supports += time * power.supports
    account.loss_bearings += time * power.bearings
    account.loss_drag += time * power.drag


@njit(**MERGED)
def add_step(account, before, power, h):
    """Add the work of a step from its powers ``before`` and after it."""
    account.work_motor += 0.5 * h * (before.motor + power.motor)
    account.loss_contact += 0.5 * h * (before.contact + power.contact)
    account.loss_friction += 0.5 * h * (before.friction + power.friction)
    account.loss_rolling += 0.5 * h * (before.rolling + power.rolling)
    account.loss_supports += 0.5 * h * (before.supports + power.supports)
    account.loss_bearings += 0.5 * h * (before.bearings + power.bearings)
    account.loss_drag += 0.5 * h * (before.drag + power.drag)


@njit(**MERGED)
def keep_power(before, power):
    """What is now is what was before the next step."""
    before.motor, before.contact, before.friction, before.rolling = (
        power.motor, power.contact, power.friction, power.rolling,
    )  # fmt: skip
    before.supports, before.bearings, before.drag = power.supports, power.bearings, power.drag


@njit(**MERGED)
def book(chamber, jolt):
    """Add the powers of a step to the account; ``jolt`` is the sum of the changes of all accelerations squared times mass.

    Losses of impacts and friction are those at foreseen velocities less h^2/4 of the jolt, each by its part: with F = m a,
    F_n (v_n - v*_n) = h/2 m a_n (a_n - a_n-1), in the sum over all steps h/4 m (a_n - a_n-1)^2 and what is left of the ends.
    """
    account, power, h = chamber.account, chamber.power, chamber.run.step
    parts = abs(power.contact) + power.friction
    over = 0.25 * h * h * jolt / parts if parts > 0.0 else 0.0
    add_step(account, chamber.before, power, h)
    keep_power(chamber.before, power)
    account.loss_contact -= over * abs(power.contact)
    account.loss_friction -= over * abs(power.friction)


@njit(**MERGED)
def step_done(chamber, samples, kept):
    """Count a step and keep a sample if one is due; answers how many are kept now."""
    progress = chamber.progress
    progress.steps += 1
    if progress.steps % samples.every != 0:
        return kept
    note_sample(chamber, float(samples.every), samples.rows[kept], samples.balls[kept])
    return kept + 1
