"""Impacts of balls as a run goes: every contact that begins is noted with its speed, a step later than it began.

The stepper asks for a switch after every step; these look at the state in which the step began, which no retreat takes back.
"""

from __future__ import annotations

import math
from typing import Any

from autobalancer.kernels.balls.path import orbit
from autobalancer.kernels.balls.switches import adherence
from autobalancer.kernels.flags import ADDRESSED, INLINE, njit
from autobalancer.kernels.integrators.switching import DUE, pair_at
from autobalancer.kernels.pointers import behind, data
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.records.impacts import BALL, BEHIND, INNER, NEXT, SIDES
from autobalancer.kernels.records.resolved import BALL_STATES, BALL_VX, BALL_VY, BALL_X, BALL_Y
from autobalancer.kernels.system import BALLS, System, system_at

TINY = 1e-30  # m^2, as in resolved.py
SLOWEST = 1e-5  # m/s: balls that rest touch again and again by rounding


@njit(**ADDRESSED)
def impacts_of_guided(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch of guided balls that never stop."""
    if ask == DUE:
        note(time, parameters, pair, False)
    return 0.0


@njit(**ADDRESSED)
def impacts_and_adherence(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch of guided balls on real races."""
    if ask == DUE:
        note(time, parameters, pair, False)
    return adherence(ask, time, rates, parameters, pair)


@njit(**ADDRESSED)
def impacts_of_resolved(ask: int, time: float, rates: Any, parameters: Any, pair: Any) -> float:
    """The switch of resolved balls."""
    if ask == DUE:
        note(time, parameters, pair, True)
    return 0.0


@njit(**INLINE)
def note(time: float, parameters: Any, pair: Any, resolved: bool) -> None:
    """Note the contacts that have begun before the last step; rigid ones are noted where they strike."""
    p, (_, m) = behind(system_at(parameters)), behind(pair_at(pair))
    y = data(m.start)
    for k in range(p.touches.size):
        touch = p.touches[k]
        if resolved:
            depth, approach = _between_resolved(y, p, touch)
        else:
            contact = p.contacts[touch.one]
            if (contact.rigid if touch.kind == NEXT else contact.wall_rigid) != 0:
                continue
            depth, approach = _between_guided(y, p, touch)
        if depth <= 0.0:
            touch.known, touch.approach = 0, approach
            continue
        speed = max(touch.approach, approach)
        if touch.known == 0 and speed > SLOWEST:
            number = p.impact_count[0]
            if number < p.impacts.size:
                p.impacts[number].time, p.impacts[number].speed, p.impacts[number].touch = time, speed, k
            p.impact_count[0] = number + 1
        touch.known = 1


@njit(**INLINE)
def _between_guided(y: Any, p: System, touch: Any) -> tuple[float, float]:
    """By how much a ball overlaps what it may hit (rad), and the speed of approach (m/s)."""
    contact, i = p.contacts[touch.one], touch.one
    angle, rate = y[BALLS + i], y[BALLS + p.ball_count + i]
    if touch.kind == NEXT:
        j = touch.other
        ahead = y[BALLS + j] - angle + contact.wrap
        return contact.touch - ahead, contact.pace * (rate - y[BALLS + p.ball_count + j])
    if touch.kind == BEHIND:
        return contact.wall_low - angle, -contact.wall_pace * rate
    return angle - contact.wall_high, contact.wall_pace * rate


@njit(**INLINE)
def _between_resolved(y: Any, p: System, touch: Any) -> tuple[float, float]:
    """The same of a resolved ball, the overlap in m."""
    first = 2 + 2 * p.host.size + 2 * p.ball_count
    ball, own = p.free_balls[touch.one], first + touch.one * BALL_STATES
    x, z, vx, vz = y[own + BALL_X], y[own + BALL_Y], y[own + BALL_VX], y[own + BALL_VY]
    if touch.kind == BALL:
        its, other = first + touch.other * BALL_STATES, p.free_balls[touch.other]
        x, z, vx, vz = y[its + BALL_X] - x, y[its + BALL_Y] - z, y[its + BALL_VX] - vx, y[its + BALL_VY] - vz
        apart = math.sqrt(x * x + z * z + TINY)
        return ball.radius + other.radius - apart, -(vx * x + vz * z) / apart
    if touch.kind == SIDES:
        if ball.partition == NONE:
            return -1.0, 0.0
        part, angle = p.partitions[ball.partition], y[BALLS + touch.one]
        side, px, py = 1.0, part.behind_x, part.behind_y
        if angle > part.middle:
            side, px, py = -1.0, part.ahead_x, part.ahead_y
        if side * (x * py - z * px) <= 0.0:  # beyond the center of the race there is no partition
            return -1.0, 0.0
        return ball.radius - (x * px + z * py), -(vx * px + vz * py)
    away = math.sqrt(x * x + z * z + TINY)
    nx, ny = x / away, z / away
    depth, outward = away - orbit(p.waves, ball, ball.orbit, nx, ny)[0], (vx * x + vz * z) / away
    if touch.kind == INNER:
        return -depth - ball.gap, -outward
    return depth, outward
