"""Forces on balls that are leaves: springs, magnets, ..., called by their address.

They depend on where the ball is in its race, how it moves there and the speed of the rotor. The race gets the opposite force
at the place of the ball: a guided ball feels F.tau along its path, and F.n presses it on the wall; of a resolved one F is one
more of its forces.
"""

from __future__ import annotations

import math
from typing import Any

from numba import float64, void

from autobalancer.kernels.balls.guided import orbit
from autobalancer.kernels.compiler.callbacks import call_energy, call_force, call_pair, call_pair_energy
from autobalancer.kernels.compiler.flags import APART, COMPILED, INLINE, njit
from autobalancer.kernels.compiler.numba_struct import data, deref
from autobalancer.kernels.records import BALL_STATES, BALL_VX, BALL_VY, BALL_X, BALL_Y, NONE
from autobalancer.kernels.system import (
    BALLS,
    SPEED,
    Floats,
    Matrix,
    System,
    matrix_type,
    system_at,
    system_type,
    vector_type,
)
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**INLINE)
def push_guided(y: Any, p: System, speed: float) -> None:
    """Add to what each guided ball touches the torque of its forces, and what they press it on the wall."""
    if p.forces.shape[0] > 0:
        put_guided(y, p, speed)
    for f in range(p.forces.shape[0]):
        force = p.forces[f]
        fx, fy, its_x, its_y = _force_at(y, p, f)
        _add(p, force.ball, y, fx, fy)
        if force.other != NONE:
            _add(p, force.other, y, its_x, its_y)


@njit(**APART)
def push_planar(y: Any, system: Any, speed: float) -> None:
    """The same for the fast path of planar rotors, apart from it: else what it reads would be read there in any case."""
    push_guided(y, deref(system_at(system)), speed)


@njit(**INLINE)
def put_guided(y: Any, p: System, speed: float) -> None:
    """Where the guided balls are."""
    for b in range(p.ball_count):
        ball, place, rate = p.balls[b], p.places[b], y[BALLS + p.ball_count + b]
        s, c = sine_cosine(y[BALLS + b])
        radius, first, _ = orbit(p.waves, ball, ball.orbit, c, s)
        place.x, place.y, place.speed = radius * c, radius * s, speed
        place.vx, place.vy = (first * c - radius * s) * rate, (first * s + radius * c) * rate


@njit(**INLINE)
def put_resolved(y: Any, p: System, speed: float) -> None:
    """Where the resolved balls are."""
    for b in range(p.ball_count):
        own, place = 2 + 2 * p.host.size + 2 * p.ball_count + b * BALL_STATES, p.places[b]
        place.x, place.y, place.speed = y[own + BALL_X], y[own + BALL_Y], speed
        place.vx, place.vy = y[own + BALL_VX], y[own + BALL_VY]


@njit(**INLINE)
def push_resolved(y: Any, p: System, speed: float) -> None:
    """Add its forces to what each resolved ball feels."""
    if p.forces.shape[0] > 0:
        put_resolved(y, p, speed)
    for f in range(p.forces.shape[0]):
        force = p.forces[f]
        fx, fy, its_x, its_y = _force_at(y, p, f)
        p.free[force.ball].force_x += fx
        p.free[force.ball].force_y += fy
        if force.other != NONE:
            p.free[force.other].force_x += its_x
            p.free[force.other].force_y += its_y


@njit(**INLINE)
def _force_at(y: Any, p: System, f: int) -> tuple[float, float, float, float]:
    """The force on its ball and on the other one, whose places are known."""
    force = p.forces[f]
    place = p.places[force.ball]
    if force.other == NONE:
        fx, fy = call_force(force.address, place, p.force_numbers, force.first)
        its_x, its_y = 0.0, 0.0
    else:
        next = _next(y, p, force, place)
        fx, fy, its_x, its_y = call_pair(force.address, place, next, p.force_numbers, force.first)
    if not math.isfinite(fx + fy + its_x + its_y) and math.isfinite(place.x + place.y + place.vx + place.vy):
        force.wrong, force.wrong_x, force.wrong_y, force.wrong_vx = 1, place.x, place.y, place.vx
        force.wrong_vy, force.wrong_speed = place.vy, place.speed
    return fx, fy, its_x, its_y


@njit(**INLINE)
def _next(y: Any, p: System, force: Any, place: Any) -> Any:
    """The place of the other ball of a pair; both know by how much they are ahead of each other."""
    next = p.places[force.other]
    next.ahead = y[BALLS + force.other] - y[BALLS + force.ball] + force.wrap
    place.ahead = -next.ahead
    return next


@njit(**INLINE)
def _add(p: System, b: int, y: Any, fx: float, fy: float) -> None:
    """Put a force on guided ball b: its torque F.tau, and F.n outward."""
    ball, moving, place = p.balls[b], p.guided[b], p.places[b]
    away = math.sqrt(place.x * place.x + place.y * place.y)
    c, s = place.x / away, place.y / away
    radius, first, _ = orbit(p.waves, ball, ball.orbit, c, s)
    tx, ty = first * c - radius * s, first * s + radius * c
    moving.contact += fx * tx + fy * ty
    moving.outward += (fx * ty - fy * tx) / math.sqrt(radius * radius + first * first)


@njit(**INLINE)
def energy_of(y: Any, p: System) -> float:
    """Energy of all forces that have one, J; the places of the balls are known."""
    total = 0.0
    for f in range(p.forces.shape[0]):
        force = p.forces[f]
        if force.energy == 0:
            continue
        place = p.places[force.ball]
        if force.other == NONE:
            total += call_energy(force.energy, place, p.force_numbers, force.first)
        else:
            next = _next(y, p, force, place)
            total += call_pair_energy(force.energy, place, next, p.force_numbers, force.first)
    return total


# Energy of the forces on balls at states that were saved.


@njit(void(system_type, matrix_type, vector_type), **COMPILED)
def force_energies(p: System, states: Matrix, out: Floats) -> None:
    """Write the energy of all forces that have one into ``out`` (times,), J."""
    for i in range(states.shape[0]):
        y = data(states[i])
        if p.free_balls.shape[0] > 0:
            put_resolved(y, p, states[i, SPEED])
        else:
            put_guided(y, p, states[i, SPEED])
        out[i] = energy_of(y, p)


# Torques of forces that are leaves on guided balls, at many places; for questions of stability.


@njit(void(system_type, matrix_type, float64, matrix_type), **COMPILED)
def force_torques(p: System, states: Matrix, speed: float, out: Matrix) -> None:
    """Write torques (N m), then wall forces (N), of each ball into ``out`` (k, 2 n) at states (k, 6 + 2 n) of the balls."""
    for k in range(states.shape[0]):
        for b in range(p.ball_count):
            p.guided[b].contact, p.guided[b].outward = 0.0, 0.0
        push_guided(data(states[k]), p, speed)
        for b in range(p.ball_count):
            out[k, b], out[k, p.ball_count + b] = p.guided[b].contact, p.guided[b].outward
