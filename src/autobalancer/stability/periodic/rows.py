"""What is kept of one point of a branch."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalancer.stability.continuation.steady import Steady, centers_of, nearly_true_races, running_true
from autobalancer.stability.host.cycle import Cycle, Equations
from autobalancer.stability.host.planar import Floats
from autobalancer.stability.host.stations import Stations
from autobalancer.stability.periodic.orbits import Orbits
from autobalancer.stability.states.linear import kept
from autobalancer.stability.states.state import named_at_rest

ZERO = 1e-9  # growth rates up to this share of the speed count as zero
AROUND = np.pi * np.arange(180) / 180  # rotor angles at which extrema of a steady state are looked for
FINE = 16  # points per interval where extrema are looked for


@dataclass(frozen=True)
class Row:
    """A steady state or an orbit in SI; ``state`` is the state of all balls.

    Of a steady state on anisotropic supports its mean over half a turn of the rotor, of an orbit that at its begin.
    """

    share: float
    value: float
    speed: float
    name: str
    state: Floats
    stations: tuple[Floats, Floats]  # deflection of each, least and greatest
    deflection: tuple[float, float]  # of the station that is farthest from its place, least and greatest
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
    around = field.at(state, AROUND) if isinstance(field, Cycle) else state[None]
    values = problem.all_eigenvalues(u)
    freedom = running_true(field, state, problem.span.length)
    name = _name(field, state, problem.span.length)
    deciding = kept(values, freedom or 0)
    lead = deciding[np.argmax(deciding.real)]
    n = field.balls
    angles = around[:, field.rotor : field.rotor + n]
    size = deflections(field.host, around)
    unstable = int((deciding.real > ZERO * field.speed).sum())
    return Row(
        share=float(u[-1]),
        value=problem.span.value(float(u[-1])),
        speed=field.speed,
        name=name,
        state=state[: field.rotor + 2 * n],
        stations=(size.min(0), size.max(0)),
        deflection=(float(size.max(1).min()), float(size.max())),
        low=angles.min(0),
        high=angles.max(0),
        ball_speed=np.full(n, field.speed),
        growth=float(lead.real),
        unstable=unstable,
        period=math.nan if len(around) == 1 else math.pi / field.speed,
        frequency=abs(float(lead.imag)),
    )


def orbit_row(problem: Orbits, u: Floats) -> Row:
    """The row of a periodic orbit."""
    orbit = problem.orbit(u)
    n = len(orbit.winding)
    edges = problem.mesh.edges
    fine = np.append((edges[:-1, None] + np.diff(edges)[:, None] * np.arange(FINE) / FINE).ravel(), 1.0)
    states = problem.mesh.interpolated(orbit.states, fine)
    size = deflections(problem.span.whole(float(u[-1])).host, states)
    angles = states[:, problem.span.rotor : problem.span.rotor + n]
    turning = np.array(orbit.winding) != 0
    lead = orbit.multipliers[1]
    return Row(
        share=float(u[-1]),
        value=problem.span.value(float(u[-1])),
        speed=orbit.speed,
        name="stalled" if turning.all() else "partly stalled" if turning.any() else "swinging",
        state=orbit.states[0],
        stations=(size.min(0), size.max(0)),
        deflection=(float(size.max(1).min()), float(size.max())),
        low=np.where(turning, np.nan, angles.min(0)),
        high=np.where(turning, np.nan, angles.max(0)),
        ball_speed=orbit.ball_speed_in_space,
        growth=float(np.log(abs(lead)) / orbit.period) if lead else -math.inf,
        unstable=orbit.unstable,
        period=orbit.period,
        frequency=abs(float(np.angle(lead))) / orbit.period,
    )


def deflections(host: Stations, states: Floats) -> Floats:
    """Of the stations, (..., P) m."""
    pairs = host.model.pairs
    along = [states[..., part] @ host.rows.T for part in (slice(0, pairs), slice(pairs, 2 * pairs))]
    return np.asarray(np.hypot(*along))


def _name(field: Equations, state: Floats, length: float) -> str:
    host, first = field.host, field.rotor
    if host.forces is not None:
        return named_at_rest(host, field.speed, state[first : first + field.balls], 0).name
    center, true = centers_of(host, state[: first + 2 * field.balls]), nearly_true_races(field, state, length)
    stations = set(host.station.tolist())
    balanced = set(host.station[true].tolist())
    if balanced:
        return "balanced" if balanced == stations else "mixed"
    sides = (np.exp(-1j * state[first : first + host.moment.size]) * center).real > 0.0
    alike = all(side.all() or not side.any() for side in (sides[host.station == place] for place in stations))
    return "coincident" if alike else "in line"


def verdict(row: Row) -> str:
    """stable, marginal or unstable."""
    if row.unstable:
        return "unstable"
    return "marginal" if row.growth > -ZERO * row.speed else "stable"
