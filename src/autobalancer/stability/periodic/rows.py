"""What is kept of one point of a branch."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalancer.stability.continuation.steady import Steady, running_true
from autobalancer.stability.host.planar import Floats, Plane
from autobalancer.stability.periodic.orbits import Orbits
from autobalancer.stability.states.linear import kept

ZERO = 1e-9  # growth rates up to this share of the speed count as zero
FINE = 16  # points per interval where extrema are looked for


@dataclass(frozen=True)
class Row:
    """A steady state or an orbit in SI; ``state`` is the state of all balls (of an orbit at its begin)."""

    share: float
    value: float
    speed: float
    name: str
    state: Floats
    deflection: tuple[float, float]
    low: Floats  # ball angles
    high: Floats
    ball_speed: Floats  # mean, in space
    growth: float
    unstable: int
    period: float
    frequency: float  # of the leading eigenvalue or multiplier


def steady_row(problem: Steady, u: Floats) -> Row:
    """The row of a steady state."""
    field, state = problem.span.whole(float(u[-1])), problem.state(u)
    values = problem.all_eigenvalues(u)
    freedom = running_true(field.plane, state, problem.span.length)
    name = _name(field.plane, state, freedom is not None)
    deciding = kept(values, freedom or 0)
    lead = deciding[np.argmax(deciding.real)]
    n = field.balls
    angles = state[4 : 4 + n]
    size = float(np.hypot(state[0], state[1]))
    unstable = int((deciding.real > ZERO * field.speed).sum())
    return Row(
        share=float(u[-1]),
        value=problem.span.value(float(u[-1])),
        speed=field.speed,
        name=name,
        state=state,
        deflection=(size, size),
        low=angles,
        high=angles,
        ball_speed=np.full(n, field.speed),
        growth=float(lead.real),
        unstable=unstable,
        period=math.nan,
        frequency=abs(float(lead.imag)),
    )


def orbit_row(problem: Orbits, u: Floats) -> Row:
    """The row of a periodic orbit."""
    orbit = problem.orbit(u)
    n = len(orbit.winding)
    edges = problem.mesh.edges
    fine = np.append((edges[:-1, None] + np.diff(edges)[:, None] * np.arange(FINE) / FINE).ravel(), 1.0)
    states = problem.mesh.interpolated(orbit.states, fine)
    size = np.hypot(states[:, 0], states[:, 1])
    angles = states[:, 4 : 4 + n]
    turning = np.array(orbit.winding) != 0
    lead = orbit.multipliers[1]
    return Row(
        share=float(u[-1]),
        value=problem.span.value(float(u[-1])),
        speed=orbit.speed,
        name="stalled" if turning.any() else "swinging",
        state=orbit.states[0],
        deflection=(float(size.min()), float(size.max())),
        low=np.where(turning, np.nan, angles.min(0)),
        high=np.where(turning, np.nan, angles.max(0)),
        ball_speed=orbit.ball_speed_in_space,
        growth=float(np.log(abs(lead)) / orbit.period) if lead else -math.inf,
        unstable=orbit.unstable,
        period=orbit.period,
        frequency=abs(float(np.angle(lead))) / orbit.period,
    )


def _name(p: Plane, state: Floats, true: bool) -> str:
    center = complex(state[0], state[1]) + p.offset
    sides = (np.exp(-1j * state[4 : 4 + p.moment.size]) * center).real > 0.0
    return "balanced" if true else "coincident" if sides.all() or not sides.any() else "in line"


def verdict(row: Row) -> str:
    """stable, marginal or unstable."""
    if row.unstable:
        return "unstable"
    return "marginal" if row.growth > -ZERO * row.speed else "stable"
