"""Periodic orbits in the frame of the rotor as points of a curve: balls that swing, and balls that stall.

A ball may turn by whole revolutions in a period (``winding``): balls that hang at the critical speed while the rotor runs on
fall behind by one revolution per period. Where groups of equal balls coincide they move as one; their falling apart is seen
by the multipliers of all balls.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from autobalancer.stability.continuation.follow import NoConvergence, correct
from autobalancer.stability.continuation.special import Special
from autobalancer.stability.continuation.steady import Range
from autobalancer.stability.continuation.symmetry import Groups, expanded
from autobalancer.stability.host.cycle import Equations
from autobalancer.stability.host.planar import Complexes, Floats, Matrix
from autobalancer.stability.periodic.collocation import DEGREE, Condensed, Mesh, basis, condensed

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
    def stable(self) -> bool:
        """Whether all multipliers but the trivial one are within the unit circle."""
        return self.unstable == 0

    @property
    def unstable(self) -> int:
        """How many multipliers are outside the unit circle."""
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
        return np.concatenate([defect.ravel(), ends, [float((self._phase() * states).sum()) - self._level()]])

    def _phase(self) -> Matrix:
        """Row of the phase condition: integral of x . reference' (Doedel 1981)."""
        weighted = self.mesh.slopes_at_gauss(self.reference) * self.mesh.weights()[:, :, None]
        return self._to_nodes(weighted)

    def _level(self) -> float:
        return float((self._phase() * self.reference).sum())

    def _to_nodes(self, at_gauss: Matrix) -> Matrix:
        """Transpose of :meth:`Mesh.at_gauss`."""
        pieces = np.einsum("kj,nkd->njd", basis()[0], at_gauss)
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
        inside = condensed(self.mesh, jacobians, extra, right[:count].reshape(rates.shape)).nodes
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
        whole: Condensed = condensed(self.mesh, jacobians, np.zeros((n, m, d, 0)), np.zeros((n, m, d)))
        values = np.linalg.eigvals(whole.monodromy).astype(np.complex128)
        trivial = int(np.argmin(np.abs(values - 1.0)))
        others = np.delete(values, trivial)
        return np.concatenate([values[trivial : trivial + 1], others[np.argsort(-np.abs(others))]])


def born_at(span: Range, groups: Groups, hopf: Special, intervals: int) -> tuple[Orbits, Floats, Floats]:
    """The problem, a small orbit that is born at a Hopf point, and the direction in which it grows."""
    mesh = Mesh(np.linspace(0.0, 1.0, intervals + 1))
    turn = np.exp(2j * np.pi * mesh.nodes)[:, None]
    swing = 2.0 * (hopf.mode * turn).real
    center = np.broadcast_to(hopf.point.u[:-1], swing.shape)
    problem = Orbits(span, groups, (0,) * len(groups), mesh, 2.0 * math.pi / hopf.frequency, swing)
    u = np.append(center.ravel(), [0.0, hopf.point.u[-1]])
    way = np.append(swing.ravel(), [0.0, 0.0])
    row = way * problem.weight
    amplitude = FIRST_AMPLITUDE
    while True:  # at amplitude zero the period has no effect and the equations are singular: step off first
        try:
            first = correct(problem, u + amplitude * way, row, float(row @ (u + amplitude * way)))[0]
            return problem, first, way / math.sqrt(float(problem.weight @ way**2))
        except NoConvergence:
            amplitude *= 0.5
            if amplitude < 1e-4:
                raise
