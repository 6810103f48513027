"""Velocity Verlet: half a kick, drift, one evaluation with the velocity foreseen, half a kick.

Forces that depend on velocity are evaluated at v + h a of the step before, so that one evaluation a step keeps the second
order. The step itself does the work of a force at the velocity it ends with, which is h/2 times the change of a off the one
foreseen: where forces change at every step, as in a jammed ring of balls, this adds up.
"""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import float64, void

from autobalancer.kernels.chamber.chamber import CHAMBER, SAMPLES, Chamber, Samples
from autobalancer.kernels.chamber.forces import forces
from autobalancer.kernels.chamber.pairs import follow, rebuild
from autobalancer.kernels.chamber.records import COORDINATES, MOTION, SAMPLE, THETA
from autobalancer.kernels.chamber.samples import add_reactions, book, keep_power, speed_at, step_done
from autobalancer.kernels.flags import APART, COMPILED, MERGED, njit
from autobalancer.kernels.pointers import row


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
        speed = prescribed = 0.0
        if not driven:
            speed, prescribed = speed_at(chamber, (progress.steps + 1) * h)
        _drift_body(body, h)
        if not driven:
            body.rate[THETA] = speed
        fastest = _drift_balls(chamber.balls, h)
        follow(chamber, h * sqrt(fastest), 2.0, 0.0)
        if progress.trouble != 0:
            return
        forces(chamber, prescribed)
        jolt = _kick_body(chamber.machine, body, h)
        if not driven:
            body.rate[THETA] = speed
        jolt = _kick_balls(chamber.balls, h, jolt)
        book(chamber, jolt)
        add_reactions(chamber.since, body, 1.0)
        before = kept
        kept = step_done(chamber, samples, kept)
        if kept > before and fading != 1.0:
            _fade(chamber.balls, fading)


def start(chamber: Chamber) -> None:
    """List the pairs and evaluate once at time 0, so that the first step has its rates."""
    verlet(chamber, Samples(1, SAMPLE.rows(0), MOTION.rows(0, chamber.balls.shape[0])), 1.0)
