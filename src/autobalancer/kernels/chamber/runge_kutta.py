"""The classical Runge-Kutta method of fourth order with fixed steps, as in Pakuła (2021), appendix 1; for comparison."""

# mypy: disable-error-code="no-untyped-def"
from __future__ import annotations

from math import sqrt

from numba import void

from autobalancer.kernels.chamber.chamber import CHAMBER, SAMPLES
from autobalancer.kernels.chamber.forces import forces
from autobalancer.kernels.chamber.pairs import follow
from autobalancer.kernels.chamber.records import COORDINATES, THETA
from autobalancer.kernels.chamber.samples import add_reactions, add_work, speed_at, step_done
from autobalancer.kernels.flags import COMPILED, MERGED, njit
from autobalancer.kernels.pointers import row


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
        way = h * sqrt(_begin_balls(chamber.balls, scratch.begun, scratch.gone))
        _begin_body(body, scratch.body_begun, scratch.body_gone)
        follow(chamber, way, 3.0, way)
        if progress.trouble != 0:
            return
        for stage in range(4):
            ahead = 0.0 if stage == 0 else (h if stage == 3 else 0.5 * h)
            then = 0.0 if stage == 3 else (h if stage == 2 else 0.5 * h)
            weight = (h / 6.0) if stage in (0, 3) else (h / 3.0)
            prescribed = 0.0
            if not driven:
                body.rate[THETA], prescribed = speed_at(chamber, now + ahead)
            forces(chamber, prescribed)
            _go_balls(chamber.balls, scratch.begun, scratch.gone, then, weight)
            _go_body(body, scratch.body_begun, scratch.body_gone, then, weight)
            add_work(chamber.account, chamber.power, weight)
            add_reactions(chamber.since, body, weight / h)
        _end(chamber)
        kept = step_done(chamber, samples, kept)
