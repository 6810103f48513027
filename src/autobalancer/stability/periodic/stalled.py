"""The stalled-ball (Sommerfeld) solutions: balls that hang at a resonance while the rotor runs faster.

Ryzhik et al. (2001). In the frame of the rotor each is a periodic orbit on which the balls lose one revolution per period. It
is far from every state of rest. It begins from the torque balance of :mod:`autobalancer.stability.stall.states`: balls that
circle at a steady speed v, and a rotor that whirls with them at v and with its unbalance at W.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from autobalancer.catalog.resolve import Ball
from autobalancer.stability.continuation.follow import NoConvergence, at_parameter
from autobalancer.stability.continuation.steady import Range
from autobalancer.stability.continuation.symmetry import Groups
from autobalancer.stability.host.cycle import Equations
from autobalancer.stability.host.planar import Floats, Matrix
from autobalancer.stability.periodic.collocation import Mesh
from autobalancer.stability.periodic.orbits import Orbits
from autobalancer.stability.stall.groups import Loads, StalledGroup
from autobalancer.stability.stall.ranges import stable
from autobalancer.stability.stall.states import Balance
from autobalancer.stability.stall.whirling import Whirling


def stalled_orbits(span: Range, groups: Groups, share: float, intervals: int) -> Iterator[tuple[Orbits, Floats]]:
    """Problem and orbit for each resonance at which all balls can hang together at a share of the range."""
    field = span.field(share, groups)
    if (field.host.drag <= 0.0).any():
        return
    mesh = Mesh(np.linspace(0.0, 1.0, intervals + 1))
    rotor = Whirling(field.host)
    balance = Balance(rotor, Loads(tuple(_group(field, number) for number in range(len(groups)))))
    (found,) = stable(balance, balance.found(np.array([field.speed])))
    for whirl, phases, hanging in zip(found.whirl.tolist(), found.phases, balance.resonant(found), strict=True):
        if not hanging:
            continue
        period = 2.0 * math.pi / (field.speed - whirl)
        states = _guess(field, whirl, phases, mesh.nodes) / span.scale(len(groups))
        problem = Orbits(span, groups, (-1,) * len(groups), mesh, period, states)
        try:
            u = at_parameter(problem, np.append(states.ravel(), [0.0, share]), share)
        except (NoConvergence, np.linalg.LinAlgError):
            continue
        if 0.5 < problem.period(u) / period < 2.0:
            yield problem, u


def _group(field: Equations, number: int) -> StalledGroup:
    """One of the merged balls."""
    p, i = field.host, number
    orbit = float(p.moment[i] / p.ball_mass[i])
    spin = float(p.inertia[i] / (p.moment[i] * orbit)) - 1.0
    ball = Ball(0, 0, float(p.ball_mass[i]), 0.0, 0.0, 0.0, orbit, spin, 0.0, float(p.drag[i]), 0j, None, 0.0)
    return StalledGroup(int(p.station[i]), 1, ball, 0.0)


def _guess(field: Equations, whirl: float, phases: Floats, times: Floats) -> Matrix:
    """States over one period (unit time) with the balls at these angles at time zero, circling steadily."""
    p, speed = field.host, field.speed
    back = np.exp(-2j * np.pi * times)[:, None]  # what turns with the balls, in the frame of the rotor
    mass, turning, stiffness = p.model.complex_matrices(speed)
    dynamic = stiffness + 1j * whirl * turning - whirl**2 * mass
    driven = whirl**2 * np.linalg.solve(dynamic, p.rows.T @ p.moments(phases))
    still = speed**2 * (p.compliance(speed) @ p.fixed_load)
    q = still + driven * back
    v = 1j * speed * still + 1j * whirl * driven * back
    angles = phases - 2.0 * np.pi * times[:, None]
    rates = np.full((times.size, phases.size), whirl - speed)
    return np.hstack([q.real, q.imag, v.real, v.imag, angles, rates])
