"""Which balls may touch: a list of near pairs with a margin, rebuilt when a ball may have crossed it.

What all balls turn and move together does not count, so that balls at rest in the rotor keep their list.

Up to a hundred balls every pair is looked at; beyond, balls are sorted into cells as wide as the margin reaches, which costs
time in proportion to their number.
"""

from __future__ import annotations

from math import sqrt

from numba import float64, types, void

from autobalancer.kernels.chamber.chamber_contact import cross, dot, minus, put, three
from autobalancer.kernels.chamber.chamber_forces import forces
from autobalancer.kernels.chamber.chamber_records import (
    CHAMBER,
    COORDINATES,
    LOST_BALLS,
    MOTION,
    SAMPLE,
    SAMPLES,
    THETA,
    TOO_DENSE,
    TURN_X,
    TURN_Y,
    TURN_Z,
    Chamber,
    Samples,
)
from autobalancer.kernels.compiler.flags import APART, COMPILED, MERGED, njit
from autobalancer.kernels.compiler.numba_struct import row

# mypy: disable-error-code="no-untyped-def"


DIRECT = 100
FAR = 1e6  # m
ENOUGH = 0.8  # of the margin: when less is left, looking again and again would take longer than a new list


@njit(**MERGED)
def _note(chamber, i, j):
    if j < i:
        i, j = j, i
    one, two = row(chamber.balls, i), row(chamber.balls, j)
    if one.chamber != two.chamber:
        return
    line = minus(three(two.position), three(one.position))
    along, over = 0.0, -chamber.run.margin
    if chamber.contact.cylinders != 0:  # the tilt of the rotor is small against the margin
        along, over = line[0], abs(line[0]) - one.half_length - two.half_length
    square = dot(line, line) - along * along
    both = one.radius + two.radius
    reach = both + chamber.run.margin
    if square >= reach * reach or over >= chamber.run.margin:
        return
    pairs, search, progress = chamber.pairs, chamber.scratch.search, chamber.progress
    k = progress.pairs
    if k >= pairs.first.shape[0]:
        progress.trouble = TOO_DENSE
        return
    pairs.first[k], pairs.second[k] = i, j
    pairs.touching[k] = 1 if square < both * both and over < 0.0 else 0
    pairs.stretch[k, 0] = pairs.stretch[k, 1] = pairs.stretch[k, 2] = 0.0
    for o in range(search.old_row[i], search.old_row[i + 1]):
        if search.old_second[o] == j:
            _copy(search.old_stretch, o, pairs.stretch, k)
            break
    progress.pairs = k + 1


@njit(**MERGED)
def _copy(source, i, target, j):
    target[j, 0], target[j, 1], target[j, 2] = source[i, 0], source[i, 1], source[i, 2]


@njit(**APART)
def rebuild(chamber):
    """List the pairs nearer than the margin, in an order that depends on nothing but the positions.

    Springs of pairs that stay are kept.
    """
    n = chamber.balls.shape[0]
    # where all balls were when pairs were listed, to know when the list grows old
    for i in range(n):
        put(chamber.pairs.listed[i], minus(three(row(chamber.balls, i).position), three(chamber.body.place)))
    _remember(chamber)
    chamber.progress.pairs = 0
    chamber.progress.rebuilds += 1
    # few balls: all pairs are tried
    if n <= DIRECT:
        for i in range(n):
            for j in range(i + 1, n):
                _note(chamber, i, j)
        return
    _note_by_cells(chamber)


@njit(**MERGED)
def _remember(chamber):
    """Sort the pairs of before by their first ball, so that they are found again."""
    pairs, search, used = chamber.pairs, chamber.scratch.search, chamber.progress.pairs
    n, first = chamber.balls.shape[0], pairs.first
    # sorting by counting: how many pairs each ball leads, then where its own begin
    for i in range(n + 1):
        search.old_row[i] = 0
    for k in range(used):
        search.old_row[first[k] + 1] += 1
    for i in range(n):
        search.old_row[i + 1] += search.old_row[i]
        search.places[i] = search.old_row[i]
    # each pair to its place, with the stretch of its friction springs
    for k in range(used):
        o = search.places[first[k]]
        search.places[first[k]] = o + 1
        search.old_second[o] = pairs.second[k]
        _copy(pairs.stretch, k, search.old_stretch, o)


@njit(**APART)
def _note_by_cells(chamber):
    balls, search = chamber.balls, chamber.scratch.search
    cells, order, places = search.cells, search.order, search.places
    n = balls.shape[0]
    # cells as wide as the largest pair with its margin, fewer where balls are far apart
    low0 = low1 = low2 = 1e300
    high0 = high1 = high2 = -1e300
    radius = away = 0.0
    for i in range(n):
        x, y, z = three(row(balls, i).position)
        away += abs(x) + abs(y) + abs(z)
        low0, low1, low2 = min(low0, x), min(low1, y), min(low2, z)
        high0, high1, high2 = max(high0, x), max(high1, y), max(high2, z)
        radius = max(radius, row(balls, i).radius, row(balls, i).half_length)
    if not away < FAR * n:  # there are no cells for balls that left all bounds, or whose places are no numbers
        chamber.progress.trouble = LOST_BALLS
        return
    size = 2.0 * radius + chamber.run.margin
    room = cells.shape[0] - 2
    while True:
        c0, c1, c2 = int((high0 - low0) / size) + 1, int((high1 - low1) / size) + 1, int((high2 - low2) / size) + 1
        if float(c0) * float(c1) * float(c2) <= room:
            break
        size *= 1.3
    total = c0 * c1 * c2
    # sort by counting: balls of a cell stand side by side in ``order``
    for c in range(total + 2):
        cells[c] = 0
    for i in range(n):
        x, y, z = three(row(balls, i).position)
        a, b, c = int((x - low0) / size), int((y - low1) / size), int((z - low2) / size)
        places[i] = (a * c1 + b) * c2 + c
        cells[places[i] + 2] += 1
    for c in range(total):
        cells[c + 2] += cells[c + 1]
    for i in range(n):
        o = cells[places[i] + 1]
        cells[places[i] + 1] = o + 1
        order[o] = i
    # each ball with those after it in its cell and the neighbors; a line of three cells is one range
    for i in range(n):
        place = places[i]
        a, rest = place // (c1 * c2), place % (c1 * c2)
        b, c = rest // c2, rest % c2
        for da in range(max(a - 1, 0), min(a + 2, c0)):
            for db in range(max(b - 1, 0), min(b + 2, c1)):
                line = (da * c1 + db) * c2
                for o in range(cells[line + max(c - 1, 0)], cells[line + min(c + 1, c2 - 1) + 1]):
                    j = order[o]
                    if j > i:
                        _note(chamber, i, j)


@njit(**APART)
def follow(chamber, way, times, ahead):
    """Add to the way of the fastest ball, and list the pairs again when ``times`` as much is more than the margin.

    ``ahead`` is the part of ``way`` that is still to be gone.
    """
    margin, progress = chamber.run.margin, chamber.progress
    progress.way += way
    if times * progress.way <= margin:
        return
    progress.way = moved(chamber) + ahead
    if times * progress.way > ENOUGH * margin:
        rebuild(chamber)
        progress.way = ahead


@njit(**APART)
def moved(chamber):
    """The farthest that a ball is from where it was listed, after the turn of all balls about the rotor that fits best."""
    balls, listed, middle = chamber.balls, chamber.pairs.listed, three(chamber.body.place)
    # the turn about the axis that fits best, so that balls which only ride along count as at rest
    along = across = 0.0
    for i in range(balls.shape[0]):
        _, y, z = minus(three(row(balls, i).position), middle)
        along += listed[i, 1] * y + listed[i, 2] * z
        across += listed[i, 1] * z - listed[i, 2] * y
    size = sqrt(along * along + across * across)
    c, s = (along / size, across / size) if size > 0.0 else (1.0, 0.0)
    # what is left of each way when this turn is taken out
    most = 0.0
    for i in range(balls.shape[0]):
        u, v = listed[i, 1], listed[i, 2]
        way = minus(minus(three(row(balls, i).position), middle), (listed[i, 0], c * u - s * v, s * u + c * v))
        most = max(most, dot(way, way))
    return sqrt(most)


# What a march keeps: the prescribed speed of an instant, the account of a step, samples.


# mypy: disable-error-code="no-untyped-def"


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
    # the body as it is
    body, since = chamber.body, chamber.since
    middle = three(body.place)
    turn = body.place[TURN_X], body.place[TURN_Y], body.place[TURN_Z]
    sample.rotor_angle, sample.speed = body.place[THETA], body.rate[THETA]
    put(sample.body_position, middle)
    put(sample.body_rotation, turn)
    for i in range(THETA):
        sample.body_rate[i] = body.rate[i]
    # reactions as means since the last sample; the sums begin anew
    for i in range(3):
        sample.bearing_force[0, i], sample.bearing_force[1, i] = since.bearing_1[i] / every, since.bearing_2[i] / every
        sample.constraint_force[i] = since.constraint[i] / every
        sample.constraint_moment[i] = since.constraint[3 + i] / every
        since.bearing_1[i] = since.bearing_2[i] = since.constraint[i] = since.constraint[3 + i] = 0.0
    # counts and greatest values since the last sample, which begin anew too
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
    # balls in their chamber: place against the middle of the rotor, its tilt taken out to first order
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


# The classical Runge-Kutta method of fourth order with fixed steps, as in Pakuła (2021), appendix 1; for comparison.


# mypy: disable-error-code="no-untyped-def"


@njit(**MERGED)
def _begin_balls(balls, begun, gone):
    """Keep the state at the start of the step; answers the square of the greatest velocity."""
    fastest = 0.0
    for i in range(balls.shape[0]):
        ball, old, total = row(balls, i), row(begun, i), row(gone, i)
        square = 0.0
        for j in range(3):
            old.position[j], old.velocity[j], old.spin[j] = ball.position[j], ball.velocity[j], ball.spin[j]
            total.position[j] = total.velocity[j] = total.spin[j] = 0.0
            square += ball.velocity[j] ** 2
        fastest = max(fastest, square)
    return fastest


@njit(**MERGED)
def _begin_body(body, old, total):
    for i in range(COORDINATES):
        old.place[i], old.rate[i] = body.place[i], body.rate[i]
        total.place[i] = total.rate[i] = 0.0


@njit(**MERGED)
def _go_balls(balls, begun, gone, then, weight):
    """Add the slopes of a stage with their weight, and go along them for the time ``then`` from the start."""
    for i in range(balls.shape[0]):
        ball, old, total = row(balls, i), row(begun, i), row(gone, i)
        for j in range(3):
            speed = ball.velocity[j]
            rate = ball.inverse_mass * ball.force[j]
            turn = ball.inverse_inertia * ball.moment[j]
            total.position[j] += weight * speed
            total.velocity[j] += weight * rate
            total.spin[j] += weight * turn
            ball.position[j] = old.position[j] + then * speed
            ball.velocity[j] = old.velocity[j] + then * rate
            ball.spin[j] = old.spin[j] + then * turn


@njit(**MERGED)
def _go_body(body, old, total, then, weight):
    for i in range(COORDINATES):
        speed, rate = body.rate[i], body.new_acceleration[i]
        total.place[i] += weight * speed
        total.rate[i] += weight * rate
        body.place[i] = old.place[i] + then * speed
        body.rate[i] = old.rate[i] + then * rate


@njit(**MERGED)
def _end(chamber):
    """The state at the end of the step."""
    scratch, body = chamber.scratch, chamber.body
    for i in range(chamber.balls.shape[0]):
        ball, old, total = row(chamber.balls, i), row(scratch.begun, i), row(scratch.gone, i)
        for j in range(3):
            ball.position[j] = old.position[j] + total.position[j]
            ball.velocity[j] = old.velocity[j] + total.velocity[j]
            ball.spin[j] = old.spin[j] + total.spin[j]
    for i in range(COORDINATES):
        body.place[i] = scratch.body_begun.place[i] + scratch.body_gone.place[i]
        body.rate[i] = scratch.body_begun.rate[i] + scratch.body_gone.rate[i]


@njit(void(CHAMBER, SAMPLES), **COMPILED)
def runge_kutta(chamber, samples):
    """Like ``verlet``, with four evaluations a step."""
    h = chamber.run.step
    body, progress, scratch = chamber.body, chamber.progress, chamber.scratch
    driven = chamber.machine.driven != 0
    kept = 0
    for _ in range(samples.rows.shape[0] * samples.every):
        now = progress.steps * h
        # the state at the begin; pairs are listed again if balls may go too far in this step
        way = h * sqrt(_begin_balls(chamber.balls, scratch.begun, scratch.gone))
        _begin_body(body, scratch.body_begun, scratch.body_gone)
        follow(chamber, way, 3.0, way)
        if progress.trouble != 0:
            return
        # four slopes at t, t + h/2, t + h/2, t + h with the weights 1, 2, 2, 1 over 6
        for stage in range(4):
            ahead = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
            then = 0.0 if stage == 3 else (h if stage == 2 else 0.5 * h)
            weight = (h / 6.0) if stage in (0, 3) else (h / 3.0)
            # a speed that is prescribed is put in at every stage
            prescribed = 0.0
            if not driven:
                body.rate[THETA], prescribed = speed_at(chamber, now + ahead)
            forces(chamber, prescribed)
            _go_balls(chamber.balls, scratch.begun, scratch.gone, then, weight)
            _go_body(body, scratch.body_begun, scratch.body_gone, then, weight)
            # energy goes by the same weights, so the balance is as exact as the motion
            add_work(chamber.account, chamber.power, weight)
            add_reactions(chamber.since, body, weight / h)
        _end(chamber)
        kept = step_done(chamber, samples, kept)


# Velocity Verlet: half a kick, drift, one evaluation with the velocity foreseen, half a kick.
#
# Forces that depend on velocity are evaluated at v + h a of the step before, so that one evaluation a step keeps the
# second order. The step itself does the work of a force at the velocity it ends with, which is h/2 times the change of
# a off the one foreseen: where forces change at every step, as in a jammed ring of balls, this adds up.


# mypy: disable-error-code="no-untyped-def"


@njit(**MERGED)
def _drift_body(body, h):
    """To the end of the step, with the velocity foreseen there."""
    for i in range(COORDINATES):
        half = body.rate[i] + 0.5 * h * body.acceleration[i]
        body.place[i] += h * half
        body.rate[i] = half + 0.5 * h * body.acceleration[i]


@njit(**MERGED)
def _drift_balls(balls, h):
    """The same for the balls; answers the square of the greatest velocity."""
    fastest = 0.0
    for i in range(balls.shape[0]):
        ball = row(balls, i)
        square = 0.0
        for j in range(3):
            change = 0.5 * h * ball.acceleration[j]
            half = ball.velocity[j] + change
            ball.position[j] += h * half
            square += half * half
            ball.velocity[j] = half + change
            ball.spin[j] += h * ball.spin_rate[j]
        fastest = max(fastest, square)
    return fastest


@njit(**MERGED)
def _kick_body(machine, body, h):
    """Correct the velocity foreseen; answers the jolt of body and rotor."""
    old, new, inertia = body.acceleration, body.new_acceleration, machine.inertia
    jolt = machine.polar_inertia * (new[THETA] - old[THETA]) ** 2
    for i in range(THETA):
        for j in range(THETA):
            jolt += (new[i] - old[i]) * inertia[i, j] * (new[j] - old[j])
    for i in range(COORDINATES):
        body.rate[i] += 0.5 * h * (new[i] - old[i])
        old[i] = new[i]
    return jolt


@njit(**MERGED)
def _kick_balls(balls, h, jolt):
    """Correct the velocities foreseen; answers the jolt with that of the balls."""
    for i in range(balls.shape[0]):
        ball = row(balls, i)
        inverse, spun = ball.inverse_mass, ball.inverse_inertia
        moved = turned = 0.0  # sums of their own: the processor would wait for one sum over all balls
        for j in range(3):
            new = inverse * ball.force[j]
            change = new - ball.acceleration[j]
            moved += change * change
            ball.velocity[j] += 0.5 * h * change
            ball.acceleration[j] = new
            new = spun * ball.moment[j]
            change = new - ball.spin_rate[j]
            turned += change * change
            ball.spin[j] += 0.5 * h * change
            ball.spin_rate[j] = new
        jolt += ball.mass * moved + ball.inertia * turned
    return jolt


@njit(**MERGED)
def _fade(balls, fading):
    """Slow all balls down by the factor ``fading``."""
    for i in range(balls.shape[0]):
        ball = row(balls, i)
        for j in range(3):
            ball.velocity[j] *= fading


@njit(**APART)
def _begin(chamber):
    """List the pairs and evaluate once at time 0, so that the first step has its rates."""
    body, progress = chamber.body, chamber.progress
    prescribed = 0.0
    if chamber.machine.driven == 0:
        body.rate[THETA], prescribed = speed_at(chamber, 0.0)
    rebuild(chamber)
    progress.way = 0.0
    if progress.trouble != 0:
        return
    for _ in range(2):  # the second time with the bearing forces of the first
        forces(chamber, prescribed)
    for i in range(COORDINATES):
        body.acceleration[i] = body.new_acceleration[i]
    for i in range(chamber.balls.shape[0]):
        ball = row(chamber.balls, i)
        for j in range(3):
            ball.acceleration[j] = ball.inverse_mass * ball.force[j]
            ball.spin_rate[j] = ball.inverse_inertia * ball.moment[j]
    keep_power(chamber.before, chamber.power)


@njit(void(CHAMBER, SAMPLES, float64), **COMPILED)
def verlet(chamber, samples, fading):
    """Advance until there is a sample in every row of ``samples``; with no row, make the chamber ready for its first step.

    After every sample the velocities of the balls are multiplied by ``fading``. All of it is one compiled function, because
    each takes half a minute to compile.
    """
    if samples.rows.shape[0] == 0:
        _begin(chamber)
        return
    h = chamber.run.step
    body, progress = chamber.body, chamber.progress
    driven = chamber.machine.driven != 0
    kept = 0
    for _ in range(samples.rows.shape[0] * samples.every):
        # drift to the end of the step with the velocities foreseen there
        speed = prescribed = 0.0
        if not driven:
            speed, prescribed = speed_at(chamber, (progress.steps + 1) * h)
        _drift_body(body, h)
        if not driven:
            body.rate[THETA] = speed
        fastest = _drift_balls(chamber.balls, h)
        # pairs are listed again when the fastest ball has gone half the margin
        follow(chamber, h * sqrt(fastest), 2.0, 0.0)
        if progress.trouble != 0:
            return
        # one evaluation, then the velocities foreseen are corrected by half the change of the accelerations
        forces(chamber, prescribed)
        jolt = _kick_body(chamber.machine, body, h)
        if not driven:
            body.rate[THETA] = speed
        jolt = _kick_balls(chamber.balls, h, jolt)
        # account of energy, reactions, and a sample if one is due
        book(chamber, jolt)
        add_reactions(chamber.since, body, 1.0)
        before = kept
        kept = step_done(chamber, samples, kept)
        if kept > before and fading != 1.0:
            _fade(chamber.balls, fading)


def start(chamber: Chamber) -> None:
    """List the pairs and evaluate once at time 0, so that the first step has its rates."""
    verlet(chamber, Samples(1, SAMPLE.rows(0), MOTION.rows(0, chamber.balls.shape[0])), 1.0)
