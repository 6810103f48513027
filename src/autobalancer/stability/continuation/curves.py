"""Curves of Hopf points and of folds in a plane of two parameters: where steady states are born, vanish or lose stability."""

from __future__ import annotations

from typing import Self

import numpy as np

from autobalancer.stability.continuation.bifurcations import (
    as_ball_angle,
    hopf_equations,
    hopf_slopes,
    lyapunov_coefficient,
)
from autobalancer.stability.continuation.special import Special
from autobalancer.stability.continuation.steady import DIFFERENCE, Range, Steady
from autobalancer.stability.continuation.symmetry import Groups
from autobalancer.stability.host.planar import Complexes, Floats, Matrix


class Curve:
    """Unknowns: those of a special point along the first parameter, then the share of the second parameter's range."""

    def __init__(self, span: Range, groups: Groups, start: float, end: float, border: Complexes) -> None:
        self.span, self.groups, self.start, self.end, self.border = span, groups, start, end, border
        self.size = span.count * (span.rotor + 2 * len(groups))  # of the state
        self.weight = np.ones(self.unknowns)

    unknowns: int

    def second(self, u: Floats) -> float:
        """The second parameter."""
        return self.start + (self.end - self.start) * float(u[-1])

    def steady(self, second: float) -> Steady:
        """The steady states at a value of the second parameter."""
        return Steady(self.span.moved(second), self.groups)

    def equations(self, u: Floats, second: float) -> Floats:
        """The mismatch."""
        raise NotImplementedError

    def slopes(self, u: Floats, second: float) -> Matrix:
        """Its derivative with respect to all unknowns but the last."""
        raise NotImplementedError

    def renewed(self, u: Floats, tangent: Floats) -> tuple[Self, Floats, Floats]:
        """The mode is measured against itself from step to step."""
        raise NotImplementedError

    def residual(self, u: Floats) -> Floats:
        return self.equations(u, self.second(u))

    def solve(self, u: Floats, row: Floats, right: Floats, last: float) -> Floats:
        value = self.second(u)
        step = DIFFERENCE * (abs(value) or abs(self.end - self.start))
        four = [self.equations(u, value + k * step) for k in (-2, -1, 1, 2)]
        slope = (four[0] - 8.0 * four[1] + 8.0 * four[2] - four[3]) / (12.0 * step) * (self.end - self.start)
        matrix = np.vstack([np.column_stack([self.slopes(u, value), slope]), row])
        return np.asarray(np.linalg.solve(matrix, np.append(right, last)))

    def tail(self, u: Floats) -> float:
        """Size of the highest harmonic of the state; zero of one at rest."""
        return self.steady(self.second(u)).tail(u[: self.size + 1])

    def share(self, u: Floats) -> float:
        """Share of the first parameter's range."""
        return float(u[self.size])


class HopfCurve(Curve):
    """Unknowns: state, first share, frequency, mode (real and imaginary part), second share."""

    @property
    def unknowns(self) -> int:  # type: ignore[override]
        """3 d + 3."""
        return 3 * self.size + 3

    def parts(self, u: Floats) -> tuple[Floats, float, Complexes]:
        """State with first share, frequency, mode."""
        d = self.size
        return u[: d + 1], float(u[d + 1]), u[d + 2 : 2 * d + 2] + 1j * u[2 * d + 2 : 3 * d + 2]

    def equations(self, u: Floats, second: float) -> Floats:
        return hopf_equations(self.steady(second), *self.parts(u), self.border)

    def slopes(self, u: Floats, second: float) -> Matrix:
        return hopf_slopes(self.steady(second), *self.parts(u), self.border)

    def renewed(self, u: Floats, tangent: Floats) -> tuple[Self, Floats, Floats]:
        q = self.parts(u)[2]
        return type(self)(self.span, self.groups, self.start, self.end, np.conj(q) / np.vdot(q, q)), u, tangent

    def lyapunov(self, u: Floats) -> float:
        """First Lyapunov coefficient, as for a Hopf point."""
        point, frequency, q = self.parts(u)
        return lyapunov_coefficient(
            self.steady(self.second(u)), point, as_ball_angle(q, self.steady(self.second(u))), frequency
        )

    def frequency(self, u: Floats) -> float:
        """rad/s."""
        return float(u[self.size + 1]) * self.span.frequency


class FoldCurve(Curve):
    """Unknowns: state, first share, null vector, second share."""

    @property
    def unknowns(self) -> int:  # type: ignore[override]
        """2 d + 2."""
        return 2 * self.size + 2

    def equations(self, u: Floats, second: float) -> Floats:
        d, problem = self.size, self.steady(second)
        point, q = u[: d + 1], u[d + 1 : 2 * d + 1]
        return np.concatenate(
            [problem.residual(point), problem.jacobian(point) @ q, [float(self.border.real @ q) - 1.0]]
        )

    def slopes(self, u: Floats, second: float) -> Matrix:
        d, problem = self.size, self.steady(second)
        point, q = u[: d + 1], u[d + 1 : 2 * d + 1]
        j, c = problem.jacobian(point), self.border.real
        shares, weights = problem.span.offsets(float(point[-1]))
        moved = sum(m * problem.jacobian(np.append(point[:-1], s)) @ q for s, m in zip(shares, weights, strict=True))
        bent = problem.bent(point, q)
        return np.block(
            [
                [j, problem.slope(point)[:, None], np.zeros((d, d))],
                [bent, np.asarray(moved)[:, None], j],
                [np.zeros((1, d + 1)), c[None]],
            ]
        )

    def renewed(self, u: Floats, tangent: Floats) -> tuple[Self, Floats, Floats]:
        q = u[self.size + 1 : 2 * self.size + 1]
        return type(self)(self.span, self.groups, self.start, self.end, (q / (q @ q)).astype(np.complex128)), u, tangent

    def curvature(self, u: Floats) -> float:
        """Quadratic coefficient of the fold; zero at a cusp."""
        d, problem = self.size, self.steady(self.second(u))
        point, q = u[: d + 1], u[d + 1 : 2 * d + 1]
        left = np.linalg.svd(problem.jacobian(point).T)[2][-1]
        return float(left @ problem.second(point, q, q) / np.sign(left @ problem.slope(point)))


def curve_from(special: Special, problem: Steady, second: float, ends: tuple[float, float]) -> tuple[Curve, Floats]:
    """The curve through a Hopf point or a fold found at the value ``second`` of the second parameter."""
    u, share = special.point.u, (second - ends[0]) / (ends[1] - ends[0])
    if special.kind == "Hopf":
        q = special.mode / np.linalg.norm(special.mode)
        start = np.concatenate([u, [special.frequency / problem.span.frequency], q.real, q.imag, [share]])
        return HopfCurve(problem.span, problem.groups, *ends, np.conj(q)), start
    null = np.linalg.svd(problem.jacobian(u))[2][-1]
    start = np.concatenate([u, null, [share]])
    return FoldCurve(problem.span, problem.groups, *ends, null.astype(np.complex128)), start
