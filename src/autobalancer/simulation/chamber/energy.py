"""Energy of balls, body and rotor in sampled states."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.assembly.chamber import ChamberNumbers
from autobalancer.kernels.chamber import layout as at
from autobalancer.machine.chamber import ChamberMachine

Array = Any


def energies(p: ChamberNumbers, hosts: Array, balls: Array) -> tuple[Array, Array]:
    """Kinetic and potential energy without that in contacts, (times,) each, of samples as ``verlet`` keeps them, J."""
    number = p.number
    q, v = hosts[:, at.Q : at.Q + 6], hosts[:, at.V : at.V + 6]
    theta, w = hosts[:, at.Q + 6], hosts[:, at.V + 6]
    c, s = np.cos(theta), np.sin(theta)
    along, up = number[at.U_C] * c - number[at.U_S] * s, number[at.U_C] * s + number[at.U_S] * c
    couple_c = number[at.COUPLE_C] * c - number[at.COUPLE_S] * s
    couple_s = number[at.COUPLE_C] * s + number[at.COUPLE_S] * c
    kinetic = 0.5 * np.einsum("ti,ij,tj->t", v, p.inertia, v) + 0.5 * number[at.POLAR] * w**2
    kinetic += v[:, 0] * (v[:, 4] * up - v[:, 5] * along + w * (q[:, 4] * along + q[:, 5] * up))
    kinetic += w * (along * v[:, 2] - up * v[:, 1] - couple_c * v[:, 4] - couple_s * v[:, 5])
    mass, inertia = p.balls[:, at.MASS], p.balls[:, at.INERTIA]
    kinetic += 0.5 * np.einsum("i,tij->t", mass, balls[:, :, 3:6] ** 2)
    kinetic += 0.5 * np.einsum("i,tij->t", inertia, balls[:, :, 6:9] ** 2)
    gravity = number[[at.GRAVITY_X, at.GRAVITY_Y, at.GRAVITY_Z]]
    potential = 0.5 * np.einsum("ti,ij,tj->t", q, p.stiffness, q)
    potential -= gravity[1] * along + gravity[2] * up + gravity[0] * (q[:, 4] * up - q[:, 5] * along)
    potential -= np.einsum("i,tij,j->t", mass, places(p, hosts, balls), gravity)
    return kinetic, potential


def places(p: ChamberNumbers, hosts: Array, balls: Array) -> Array:
    """Places of the balls in space, (times, n, 3), m."""
    q = hosts[:, at.Q : at.Q + 6]
    turn = np.tile(np.eye(3), (len(hosts), 1, 1))
    a, b, c = q[:, 3], q[:, 4], q[:, 5]
    turn[:, 0, 1], turn[:, 0, 2], turn[:, 1, 0] = c, -b, -c
    turn[:, 1, 2], turn[:, 2, 0], turn[:, 2, 1] = a, b, -a
    own = balls[:, :, :3].copy()
    own[:, :, 0] += p.chambers[p.balls[:, at.CHAMBER].astype(int), at.CENTER]
    return np.linalg.solve(turn[:, None], own[..., None])[..., 0] + q[:, None, :3]


def total_energy(machine: ChamberMachine, p: ChamberNumbers) -> float:
    """Energy of the state as it is, with that in contacts, J."""
    from autobalancer.kernels.chamber.samples import SAMPLE, note_sample

    row, balls = np.zeros((1, SAMPLE)), np.zeros((1, p.balls.shape[0], 9))
    note_sample(
        p.balls, p.chambers, p.host, np.zeros(12), p.counts.copy(), p.greatest.copy(), p.power, 1.0, row[0], balls[0]
    )
    kinetic, potential = energies(p, row, balls)
    return float(kinetic[0] + potential[0] + p.power[at.STORED])
