"""Energy of balls, body and rotor in sampled states."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.kernels.chamber.chamber import Chamber
from autobalancer.kernels.fields import Rows
from autobalancer.simulation.chamber.sampling import sample_now

Array = Any


def energies(chamber: Chamber, samples: Rows, balls: Rows) -> tuple[Array, Array]:
    """Kinetic and potential energy without that in contacts, (times,) each, of samples as ``verlet`` keeps them, J."""
    p = chamber.machine
    q, v = np.hstack([samples.body_position, samples.body_rotation]), samples.body_rate
    theta, w = samples.rotor_angle, samples.speed
    along, up = _turned(p.unbalance, theta)
    couple_c, couple_s = _turned(p.couple, theta)
    kinetic = 0.5 * np.einsum("ti,ij,tj->t", v, p.inertia, v) + 0.5 * p.polar_inertia * w**2
    kinetic += v[:, 0] * (v[:, 4] * up - v[:, 5] * along + w * (q[:, 4] * along + q[:, 5] * up))
    kinetic += w * (along * v[:, 2] - up * v[:, 1] - couple_c * v[:, 4] - couple_s * v[:, 5])
    mass, inertia, gravity = chamber.balls.mass, chamber.balls.inertia, p.gravity
    kinetic += 0.5 * np.einsum("i,tij->t", mass, balls.velocity**2)
    kinetic += 0.5 * np.einsum("i,tij->t", inertia, balls.spin**2)
    potential = 0.5 * np.einsum("ti,ij,tj->t", q, p.stiffness, q)
    potential -= gravity[1] * along + gravity[2] * up + gravity[0] * (q[:, 4] * up - q[:, 5] * along)
    potential -= np.einsum("i,tij,j->t", mass, places(chamber, samples, balls), gravity)
    return kinetic, potential


def _turned(vector: Array, theta: Array) -> tuple[Array, Array]:
    c, s = np.cos(theta), np.sin(theta)
    return vector[0] * c - vector[1] * s, vector[0] * s + vector[1] * c


def places(chamber: Chamber, samples: Rows, balls: Rows) -> Array:
    """Places of the balls in space, (times, n, 3), m."""
    turn = np.tile(np.eye(3), (len(samples), 1, 1))
    a, b, c = samples.body_rotation.T
    turn[:, 0, 1], turn[:, 0, 2], turn[:, 1, 0] = c, -b, -c
    turn[:, 1, 2], turn[:, 2, 0], turn[:, 2, 1] = a, b, -a
    own = balls.position.copy()
    own[:, :, 0] += chamber.rooms.center[chamber.balls.chamber]
    return np.linalg.solve(turn[:, None], own[..., None])[..., 0] + samples.body_position[:, None]


def total_energy(chamber: Chamber) -> float:
    """Energy of the state as it is, with that in contacts, J."""
    samples = sample_now(chamber)
    kinetic, potential = energies(chamber, samples.rows, samples.balls)
    return float(kinetic[0] + potential[0] + chamber.power.stored)
