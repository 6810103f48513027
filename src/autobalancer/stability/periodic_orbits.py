"""Periodic orbits in the frame of the rotor as points of a curve: balls that swing, and balls that stall.

A ball may turn by whole revolutions in a period (``winding``): balls that hang at the critical speed while the rotor runs on
fall behind by one revolution per period. Where groups of equal balls coincide they move as one; their falling apart is seen
by the multipliers of all balls.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Self

import numpy as np

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.stability.bifurcations import Loop, NoConvergence, Point, Special, Steps, follow, locate
from autobalancer.stability.host.vector_field import Equations
from autobalancer.stability.states.linearized import deciding_eigenvalues
from autobalancer.stability.states.rest_states import state_at_rest
from autobalancer.stability.steady_curves import (
    Groups,
    Range,
    Steady,
    centers_of,
    expanded,
    nearly_true_races,
    running_true,
)

FIRST_AMPLITUDE = 0.03  # of the ball angle, rad


@dataclass(frozen=True)
class Orbit:
    """One periodic orbit, SI: nodes of all balls, times over one period."""

    times: Floats
    states: Matrix
    period: float
    winding: tuple[int, ...]  # revolutions of each ball in the rotor in one period
    multipliers: Complexes  # of all balls, the trivial one first, then by amount
    own: Complexes  # those of the merged balls alone, likewise
    speed: float

    @property
    def unstable(self) -> int:
        """How many multipliers are outside the unit circle; none of a stable one."""
        return int((np.abs(self.multipliers[1:]) > 1.0 + 1e-7).sum())

    @property
    def apart(self) -> Complexes:
        """Multipliers of groups that fall apart: those of all balls less those of the merged ones."""
        left = self.multipliers
        for value in self.own:
            left = np.delete(left, np.argmin(np.abs(left - value)))
        return left

    @property
    def ball_speed_in_space(self) -> Floats:
        """Mean over a period, rad/s."""
        return np.asarray(self.speed + 2.0 * math.pi * np.array(self.winding) / self.period)


class Orbits:
    """Unknowns: scaled states at all nodes, logarithm of the period in units of ``unit``, share of the parameter's range."""

    def __init__(
        self, span: Range, groups: Groups, winding: tuple[int, ...], mesh: Mesh, unit: float, reference: Matrix
    ) -> None:
        self.span, self.groups, self.winding, self.mesh, self.unit = span, groups, winding, mesh, unit
        self.scale = span.scale(len(groups))
        self.size = self.scale.size
        self.reference = reference  # (N m + 1, d) scaled states: the phase stays as near as possible to theirs
        widths = np.diff(mesh.nodes)
        share = 0.5 * (np.append(widths, 0.0) + np.append(0.0, widths))
        self.weight = np.concatenate([np.repeat(share, self.size), [1.0, 1.0]])
        self.jump = np.zeros(self.size)
        self.jump[self.balls] = 2.0 * math.pi * np.array(winding)

    @property
    def balls(self) -> slice:
        """Where the angles of the merged balls are in a state."""
        return slice(self.span.rotor, self.span.rotor + len(self.groups))

    def states(self, u: Floats) -> Matrix:
        """Scaled states at the nodes."""
        return u[:-2].reshape(-1, self.size)

    def period(self, u: Floats) -> float:
        """Seconds."""
        return self.unit * float(np.exp(u[-2]))

    def _field(self, u: Floats, at: Floats) -> tuple[Equations, Floats]:
        """The field of the merged balls, and its values (scaled, over the unit period) at scaled states."""
        field = self.span.field(float(u[-1]), self.groups)
        return field, field(at * self.scale) * self.period(u) / self.scale

    def residual(self, u: Floats) -> Floats:
        states = self.states(u)
        defect = self.mesh.slopes_at_gauss(states) - self._field(u, self.mesh.at_gauss(states))[1]
        ends = states[-1] - states[0] - self.jump
        phase = self._phase()
        off = float((phase * states).sum()) - float((phase * self.reference).sum())
        return np.concatenate([defect.ravel(), ends, [off]])

    def _phase(self) -> Matrix:
        """Row of the phase condition: integral of x . reference' (Doedel 1981), from the Gauss points to the nodes."""
        weighted = self.mesh.slopes_at_gauss(self.reference) * self.mesh.weights()[:, :, None]
        pieces = np.einsum("kj,nkd->njd", basis()[0], weighted)
        nodes = np.zeros((self.mesh.count * DEGREE + 1, self.size))
        for j in range(DEGREE + 1):
            nodes[j : j + self.mesh.count * DEGREE : DEGREE] += pieces[:, j]
        return nodes

    def solve(self, u: Floats, row: Floats, right: Floats, last: float) -> Floats:
        states, d = self.states(u), self.size
        at = self.mesh.at_gauss(states)
        field, rates = self._field(u, at)
        jacobians = field.jacobian(at * self.scale) * (self.period(u) * self.scale / self.scale[:, None])
        shares, weights = self.span.offsets(float(u[-1]))
        slope = sum(w * self._field(np.append(u[:-1], s), at)[1] for s, w in zip(shares, weights, strict=True))
        extra = -np.stack([rates, np.asarray(slope)], -1)
        count = rates.size
        inside = condensed(self.mesh, jacobians, extra, right[:count].reshape(rates.shape))
        rows = np.zeros((d + 2, d + 3))
        rows[:d] = inside[-1] - inside[0]
        rows[d] = np.einsum("nd,ndc->c", self._phase(), inside)
        rows[d + 1] = np.einsum("nd,ndc->c", row[:-2].reshape(-1, d), inside)
        rows[d + 1, d : d + 2] += row[-2:]
        sums = np.concatenate([right[count:], [last]]) - rows[:, -1]
        small = np.linalg.solve(rows[:, :-1], sums)
        return np.append((inside @ np.append(small, 1.0)).ravel(), small[d:])

    def renewed(self, u: Floats, tangent: Floats) -> tuple[Self, Floats, Floats]:
        """The next step: phase as now, mesh adapted to the orbit."""
        states, mesh = self.states(u), self.mesh.adapted(self.states(u))
        nodes = mesh.nodes
        moved, way = (self.mesh.interpolated(x, nodes) for x in (states, self.states(tangent)))
        new = type(self)(self.span, self.groups, self.winding, mesh, self.unit, moved)
        return new, np.append(moved.ravel(), u[-2:]), np.append(way.ravel(), tangent[-2:])

    def orbit(self, u: Floats) -> Orbit:
        """The orbit with the multipliers of all balls."""
        states = self.states(u) * self.scale
        field = self.span.whole(float(u[-1]))
        values = own = self._multipliers(self.span.field(float(u[-1]), self.groups), states, u)
        if field.balls > len(self.groups):
            states = expanded(states, self.groups, self.span.rotor)
            values = self._multipliers(field, states, u)
        winding = np.zeros(field.balls, np.int64)
        for group, turns in zip(self.groups, self.winding, strict=True):
            winding[list(group)] = turns
        return Orbit(self.mesh.nodes, states, self.period(u), tuple(winding.tolist()), values, own, field.speed)

    def _multipliers(self, field: Equations, states: Matrix, u: Floats) -> Complexes:
        """Eigenvalues of the monodromy matrix, the one nearest to 1 first, then by amount."""
        at, scale = self.mesh.at_gauss(states), self.span.scale(field.balls)
        jacobians = field.jacobian(at) * (self.period(u) * scale / scale[:, None])
        n, m, d = at.shape
        nodes = condensed(self.mesh, jacobians, np.zeros((n, m, d, 0)), np.zeros((n, m, d)))
        values = np.linalg.eigvals(nodes[-1, :, :d]).astype(np.complex128)
        trivial = int(np.argmin(np.abs(values - 1.0)))
        others = np.delete(values, trivial)
        return np.concatenate([values[trivial : trivial + 1], others[np.argsort(-np.abs(others))]])


# Orthogonal collocation on a mesh over one period (de Boor and Swartz 1973; Doedel et al. 1991).
#
# On each of N intervals the orbit is a polynomial of degree m that satisfies the equations at the m Gauss points. The
# linear systems are condensed: inside an interval all is expressed by its first node, so that a small system for the
# first node of the orbit is left, and the product of the interval matrices is the monodromy matrix.


DEGREE = 4


@cache
def basis() -> tuple[Matrix, Matrix, Floats, Matrix]:
    """Values and derivatives of the Lagrange basis at the Gauss points, Gauss weights, highest derivative; unit interval."""
    nodes = np.linspace(0.0, 1.0, DEGREE + 1)
    gauss, weights = np.polynomial.legendre.leggauss(DEGREE)
    gauss, weights = 0.5 * (gauss + 1.0), 0.5 * weights
    powers = np.vander(nodes, increasing=True)
    coefficients = np.linalg.inv(powers)  # row k: factor of x^k for each node
    values = np.vander(gauss, DEGREE + 1, increasing=True) @ coefficients
    order = np.arange(DEGREE + 1)
    slopes = np.where(order > 0, order * gauss[:, None] ** np.maximum(order - 1, 0), 0.0) @ coefficients
    return np.asarray(values), np.asarray(slopes), np.asarray(weights, np.float64), np.asarray(coefficients, np.float64)


@dataclass(frozen=True)
class Mesh:
    """Edges of the intervals over the unit period, (N + 1,)."""

    edges: Floats

    @property
    def count(self) -> int:
        """Number of intervals."""
        return self.edges.size - 1

    @property
    def nodes(self) -> Floats:
        """Times of all nodes, (N m + 1,)."""
        steps = np.diff(self.edges)[:, None] * np.arange(DEGREE) / DEGREE
        return np.append((self.edges[:-1, None] + steps).ravel(), 1.0)

    def pieces(self, states: Matrix) -> Any:
        """Nodes by interval, (N, m + 1, d), from (N m + 1, d)."""
        index = np.arange(self.count)[:, None] * DEGREE + np.arange(DEGREE + 1)
        return states[index]

    def at_gauss(self, states: Matrix) -> Any:
        """States at the Gauss points, (N, m, d)."""
        return basis()[0] @ self.pieces(states)

    def slopes_at_gauss(self, states: Matrix) -> Any:
        """Derivatives over the unit period at the Gauss points, (N, m, d)."""
        return basis()[1] @ self.pieces(states) / np.diff(self.edges)[:, None, None]

    def weights(self) -> Matrix:
        """Gauss weights of the whole period, (N, m)."""
        return np.asarray(np.diff(self.edges)[:, None] * basis()[2])

    def interpolated(self, states: Matrix, times: Floats) -> Matrix:
        """The orbit at any times of the unit period."""
        place = np.clip(np.searchsorted(self.edges, times, side="right") - 1, 0, self.count - 1)
        x = (times - self.edges[place]) / np.diff(self.edges)[place]
        rows = np.vander(x, DEGREE + 1, increasing=True) @ basis()[3]
        return np.asarray(np.einsum("tj,tjd->td", rows, self.pieces(states)[place]))

    def adapted(self, states: Matrix) -> Mesh:
        """A mesh on which the estimated error is even: de Boor's rule with the derivative of order m + 1."""
        widths = np.diff(self.edges)
        highest = np.einsum("j,njd->nd", basis()[3][-1], self.pieces(states)) / widths[:, None] ** DEGREE
        apart = 0.5 * (widths + np.roll(widths, -1))
        jumps = np.linalg.norm(np.roll(highest, -1, axis=0) - highest, axis=1) / apart
        density = (0.5 * (jumps + np.roll(jumps, 1))) ** (1.0 / (DEGREE + 1))
        density = density + 0.1 * density.mean() + 1e-300
        total = np.concatenate([[0.0], np.cumsum(density * widths)])
        edges = np.interp(np.linspace(0.0, total[-1], self.count + 1), total, self.edges)
        edges[0], edges[-1] = 0.0, 1.0
        return Mesh(edges)


def condensed(mesh: Mesh, jacobians: Any, extra: Any, right: Any) -> Any:
    """Solve sum_j slopes x_j / h - A sum_j values x_j + extra . y = right inside all intervals.

    All nodes as the result @ (first node, extra unknowns, 1), (N m + 1, d, d + e + 1).

    ``jacobians`` (N, m, d, d), ``extra`` (N, m, d, e), ``right`` (N, m, d).
    """
    values, slopes, _, _ = basis()
    n, m, d, _ = jacobians.shape
    e = extra.shape[-1]
    widths = np.diff(mesh.edges)
    blocks = np.einsum("kj,ab,n->nkajb", slopes, np.eye(d), 1.0 / widths) - np.einsum(
        "kj,nkab->nkajb", values, jacobians
    )
    inner = blocks[:, :, :, 1:, :].reshape(n, m * d, m * d)
    side = np.concatenate([-blocks[:, :, :, 0, :], -extra, right[..., None]], -1).reshape(n, m * d, d + e + 1)
    local = np.linalg.solve(inner, side).reshape(n, m, d, d + e + 1)
    nodes = np.zeros((n * m + 1, d, d + e + 1))
    nodes[0, :, :d] = np.eye(d)
    for i in range(n):
        first = nodes[i * m]
        piece = local[i, :, :, :d] @ first
        piece[:, :, d:] += local[i, :, :, d:]
        nodes[i * m + 1 : (i + 1) * m + 1] = piece
    return nodes


# What is kept of one point of a branch.


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

    @property
    def verdict(self) -> str:
        """stable, marginal or unstable."""
        return "unstable" if self.unstable else "marginal" if self.growth > -ZERO * self.speed else "stable"


def steady_row(problem: Steady, u: Floats) -> Row:
    """The row of a steady state."""
    field, state = problem.span.whole(float(u[-1])), problem.state(u)
    # states of a turn, on anisotropic supports where the rotor's orbit is an ellipse
    around = field.at(state, AROUND)
    values = problem.all_eigenvalues(u)
    freedom = running_true(field, state, problem.span.length)
    name = _name(field, state, problem.span.length)
    # eigenvalues that decide: without those that a continuum of states makes zero
    deciding = deciding_eigenvalues(values, freedom or 0)
    lead = deciding[np.argmax(deciding.real)]
    n = field.balls
    angles = around[:, field.rotor : field.rotor + n]
    unstable = int((deciding.real > ZERO * field.speed).sum())
    return Row(
        **_place(problem.span, u, around),
        speed=field.speed,
        name=name,
        state=state[: field.rotor + 2 * n],
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
    # the orbit on a fine mesh, for its least and greatest values
    edges = problem.mesh.edges
    fine = np.append((edges[:-1, None] + np.diff(edges)[:, None] * np.arange(FINE) / FINE).ravel(), 1.0)
    states = problem.mesh.interpolated(orbit.states, fine)
    angles = states[:, problem.span.rotor : problem.span.rotor + n]
    # balls that turn round and round have no least angle
    turning = np.array(orbit.winding) != 0
    lead = orbit.multipliers[1]
    return Row(
        **_place(problem.span, u, states),
        speed=orbit.speed,
        name="stalled" if turning.all() else "partly stalled" if turning.any() else "swinging",
        state=orbit.states[0],
        low=np.where(turning, np.nan, angles.min(0)),
        high=np.where(turning, np.nan, angles.max(0)),
        ball_speed=orbit.ball_speed_in_space,
        growth=float(np.log(abs(lead)) / orbit.period) if lead else -math.inf,
        unstable=orbit.unstable,
        period=orbit.period,
        frequency=abs(float(np.angle(lead))) / orbit.period,
    )


def _place(span: Range, u: Floats, states: Floats) -> dict[str, Any]:
    """Where a row is along the parameter, and the deflections in its states."""
    host, share = span.whole(float(u[-1])).host, float(u[-1])
    pairs = host.model.pairs
    size = np.hypot(*(states[:, part] @ host.rows.T for part in (slice(0, pairs), slice(pairs, 2 * pairs))))
    most = (float(size.max(1).min()), float(size.max()))
    return {"share": share, "value": span.value(share), "stations": (size.min(0), size.max(0)), "deflection": most}


def _name(field: Equations, state: Floats, length: float) -> str:
    host, first = field.host, field.rotor
    if host.forces is not None:
        return state_at_rest(host, field.speed, state[first : first + field.balls], 0).name
    center, true = centers_of(host, state[: first + 2 * field.balls]), nearly_true_races(field, state, length)
    stations = set(host.station.tolist())
    balanced = set(host.station[true].tolist())
    if balanced:
        return "balanced" if balanced == stations else "mixed"
    sides = (np.exp(-1j * state[first : first + host.moment.size]) * center).real > 0.0
    alike = all(side.all() or not side.any() for side in (sides[host.station == place] for place in stations))
    return "coincident" if alike else "in line"


# One side of a branch of periodic orbits, from a start to where it ends.


FIRST, LEAST, MOST = 0.02, 1e-6, 5.0  # steps; the largest in units of that of steady states
INACCURATE = 1e-3  # error of the trivial multiplier above which an orbit is not trusted
COUNT = 500  # at most so many orbits
LONG = 60.0  # times the shortest period of the branch
SETTLED, NEARLY = 1e-3, 2e-2  # change of the parameter while the period doubles: it has no limit, or seems to have none


@dataclass
class Side:
    """Orbits in order, the special ones among them, and how it ended."""

    rows: list[Row]
    specials: list[tuple[Special, Row]] = field(default_factory=list)
    ended: str = "could not be followed further"


def follow_orbits(
    problem: Orbits, u: Floats, like: Floats, most: float, *, born: bool, say: Callable[[float], None]
) -> Side:
    """Follow orbits until the range ends, they close, shrink to a Hopf point (if ``born`` at one) or take for ever."""
    side = Side([orbit_row(problem, u)])
    rows, here = side.rows, problem.orbit(u)
    loop, grown, shortest = Loop(_mark(rows[0])), 0.0, here.period
    for now, a, b in follow(problem, u, like, steps=Steps(FIRST, LEAST, MOST * most, COUNT)):
        # the trivial multiplier must be one: how far it is tells how exact the orbit is
        there = now.orbit(b.u)
        if abs(there.multipliers[0] - 1.0) > INACCURATE:
            side.ended = "too unstable to be followed"
            break
        # special points on the way, as rows of their own
        for special in special_orbits(now, a, b, here, there):
            row = orbit_row(now, special.point.u)
            side.specials.append((special, row))
            rows.append(row)
        rows.append(orbit_row(now, b.u))
        say(float(b.u[-1]))
        # does it end: at a Hopf point, in itself, at an infinite period, or at the end of the range?
        here, shortest = there, min(shortest, there.period)
        size = float(np.ptp(now.states(b.u)[:, now.balls], axis=0).max())
        grown = max(grown, size)
        if born and size < FIRST_AMPLITUDE < 0.5 * grown:
            side.ended = "Hopf"
        elif loop.closed(_mark(rows[-2]), _mark(rows[-1])):
            side.ended = "closed"
        elif there.period > LONG * shortest or _without_limit(rows, SETTLED):
            side.ended = "period without limit"
        elif not 0.0 < b.u[-1] < 1.0:
            side.ended = "end of the range"
        else:
            continue
        break
    # a period that grows without limit ends at an orbit of infinite period
    if side.ended in ("too unstable to be followed", "period without limit") and _without_limit(rows, NEARLY):
        side.ended = "period without limit"
        # at a fold on a stable orbit 1/T^2 runs to zero linearly; elsewhere it is about here
        (x, p), (y, q), (z, r) = ((row.period**-2, row.share) for row in rows[-3:])
        share = r
        if not rows[-1].unstable and q != p and y != x and abs((r - q) / (q - p) * (y - x) / (z - y) - 1.0) < 0.3:
            share = r - z * (r - q) / (z - y)
        last = replace(rows[-1], share=share, value=problem.span.value(share), period=math.inf)
        side.specials.append((Special("infinite period", Point(u, like), 0.0), last))
    return side


def _mark(row: Row) -> Floats:
    """Numbers by which an orbit is known again: where all balls turn, its growth rate stands in for their angles."""
    span = np.concatenate([row.low, row.high])
    enough = bool(np.isfinite(span).any() and np.isnan(span).any())
    growth = 0.0 if enough else 10.0 * row.growth / row.speed
    return np.concatenate([[row.share, math.log(row.period), growth], np.nan_to_num(span)])


def _without_limit(rows: list[Row], change: float) -> bool:
    """Whether the period has at least doubled at the end while the parameter changed by no more than this share of it."""
    period = rows[-1].period
    values = [row.value for row in rows if row.period > 0.5 * period]
    longer = len(values) > 3 and period > 2.0 * min(row.period for row in rows if math.isfinite(row.period))
    return longer and max(values) - min(values) < change * max(map(abs, values))


# Special points of a curve of periodic orbits: folds, period doublings, tori and branch points.


PRECISION = 1e-11  # of the share of a step at which a special point lies


def special_orbits(problem: Orbits, a: Point, b: Point, before: Orbit, after: Orbit) -> list[Special]:
    """Special points between two orbits of a curve; ``before`` and ``after`` are the orbits at ``a`` and ``b``."""

    def at(p: Point) -> Orbit:
        return before if p is a else after if p is b else problem.orbit(p.u)

    # multipliers that pass +1: a fold where the parameter turns, else another branch
    specials: list[Special] = []
    if a.tangent[-1] * b.tangent[-1] < 0.0:
        specials += _located(problem, a, b, "fold", lambda p: float(p.tangent[-1]))
    elif _sign(before.own[1:], 1.0) * _sign(after.own[1:], 1.0) < 0.0:
        specials += _located(problem, a, b, "branch point", lambda p: _distance(at(p).own[1:], 1.0))
    if _sign(before.apart, 1.0) * _sign(after.apart, 1.0) < 0.0:
        specials += _located(problem, a, b, "branch point", lambda p: _distance(at(p).apart, 1.0))
    # those that pass -1: twice the period
    if _sign(before.multipliers, -1.0) * _sign(after.multipliers, -1.0) < 0.0:
        specials += _located(problem, a, b, "period doubling", lambda p: _distance(at(p).multipliers, -1.0))
    # pairs that pass the unit circle: a torus
    counts = [int((_turning(m) > 0.0).sum()) for m in (before.multipliers, after.multipliers)]
    for rank in range(min(counts), max(counts)):

        def crossing(p: Point, rank: int = rank) -> float:
            sizes = _turning(at(p).multipliers)
            return float(sizes[rank]) if rank < sizes.size else -1.0

        specials += _located(problem, a, b, "torus", crossing)
    chord = (b.u - a.u) * problem.weight
    return sorted(specials, key=lambda s: float(chord @ s.point.u))


def _located(problem: Orbits, a: Point, b: Point, kind: str, test: Callable[[Point], float]) -> list[Special]:
    try:
        point = locate(problem, a, b, test, PRECISION)
    except (NoConvergence, np.linalg.LinAlgError):
        return []
    if kind != "fold" and abs(test(point)) > 1e-4:  # the sign changed because multipliers met, not because they crossed
        return []
    return [Special(kind, point, 2.0 * math.pi / problem.period(point.u))]


def _sign(values: Complexes, at: float) -> float:
    """Sign of the product of all distances from ``at``: changes where a real multiplier passes."""
    return float(np.prod(np.sign((at - values[np.abs(values.imag) < 1e-12 * np.abs(values)]).real)))


def _distance(values: Complexes, at: float) -> float:
    """Distance of the nearest real multiplier from ``at``, with the sign of the product of all."""
    real = values[np.abs(values.imag) < 1e-12 * np.abs(values)].real
    return float(np.abs(real - at).min(initial=1.0)) * _sign(values, at)


def _turning(values: Complexes) -> Floats:
    """ln|multiplier| of the complex pairs, greatest first."""
    return np.sort(np.log(np.abs(values[values.imag > 1e-9 * np.abs(values)])))[::-1]
