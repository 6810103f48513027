"""Slow flow around a ball of a fluid whose viscosity depends on the rate of shear.

div(2 n D) = grad p with D the symmetric gradient of the velocity and n = s(g U/r) at the rate of shear g = sqrt(2 D : D), in the
units of the package. Newton's steps, shortened where they overshoot the least dissipation; each by MINRES with the equations of
the components at the present viscosity and the mass matrix of the pressure over it as preconditioner.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, minres

from autobalancer.errors import QuestionError
from autobalancer.flow.ball.inertia import unknowns
from autobalancer.flow.ball.mesh import Floats
from autobalancer.flow.ball.slow import Flow, equations, factors
from autobalancer.flow.ball.spaces import Spaces, Sparse

Share = Callable[[Floats], Floats]

SMALL = 1e-7  # of the unbalanced forces over those of the flow of constant viscosity
ENOUGH = 1e-8  # of one step, as MINRES counts it: over matrix times step
MOST_STEPS, MOST_INNER = 60, 1500
FLAT = 0.3  # of the work of a step at its beginning that may be left at its end
MOST_HALVINGS = 6
STEEP = 1e-4  # relative step for the slope of the viscosity
REST = 1e-12  # least rate of shear, U/r


@dataclass(frozen=True)
class Gradients:
    """Derivatives of a velocity at the Gauss points of a mesh."""

    spaces: Spaces

    @cached_property
    def along(self) -> list[Sparse]:
        """Of one component along x, y and z; each (gauss, node)."""
        basis = self.spaces.velocity
        parts = np.array([np.broadcast_to(np.asarray(part[0].grad), (3, *basis.dx.shape)) for part in basis.basis])
        return [_at_gauss(parts[:, i], basis.element_dofs, self.spaces.nodes.shape[1]) for i in range(3)]

    @cached_property
    def pressure(self) -> Sparse:
        """Pressure at the Gauss points; (gauss, pressure)."""
        basis = self.spaces.pressure
        parts = np.array([np.broadcast_to(np.asarray(part[0]), basis.dx.shape) for part in basis.basis])
        return _at_gauss(parts, basis.element_dofs, int(basis.N))

    @cached_property
    def weight(self) -> Floats:
        """Volume of the Gauss points."""
        return np.asarray(self.spaces.velocity.dx, float).ravel()

    def strain(self, velocity: Floats) -> Floats:
        """D, (3, 3, gauss); ``velocity`` (3, node)."""
        slopes = np.array([[along @ part for along in self.along] for part in velocity])
        return np.asarray(0.5 * (slopes + slopes.transpose(1, 0, 2)))

    def rate(self, strain: Floats) -> Floats:
        """Rate of shear, (gauss,)."""
        return np.asarray(np.sqrt(2.0 * np.einsum("ijq,ijq->q", strain, strain)))

    def stress(self, viscosity: Floats) -> tuple[Sparse, Sparse]:
        """The equations of all velocities at a viscosity (gauss,), and those of a component alone."""
        scale = sp.diags(self.weight * viscosity)
        parts = [[left.T @ scale @ right for right in self.along] for left in self.along]
        one = (parts[0][0] + parts[1][1] + parts[2][2]).tocsr()
        rows = [[parts[j][i] + one if i == j else parts[j][i] for j in range(3)] for i in range(3)]
        return sp.bmat(rows, format="csr"), one

    def slope(self, strain: Floats, scale: Floats) -> Sparse:
        """What a viscosity that changes with the rate adds to the equations of a change of all velocities."""
        turned = sp.hstack([sum(sp.diags(strain[i, j]) @ self.along[j] for j in range(3)) for i in range(3)], "csr")
        return turned.T @ sp.diags(self.weight * scale) @ turned


def sheared_flow(start: Flow, gradients: Gradients, share: Share) -> Flow:
    """The slow flow of a fluid with the viscosity ``share`` over rates of shear in U/r, from a flow nearby.

    Raises
    ------
    QuestionError
        If the steps do not converge.
    """
    spaces = start.spaces
    count = spaces.unknown.shape[1]
    given, found = spaces.balls_deviation(start.spin).ravel(), unknowns(start)
    state = _State.at(gradients, share, given, found)
    for number in range(MOST_STEPS):
        if number and state.size < SMALL * state.scale:
            velocity = (given + spaces.unknown @ found[:count]).reshape(3, -1)
            residual = (state.friction + spaces.divergence.T @ found[count:]).reshape(3, -1)
            return Flow(spaces, 0.0, start.spin, velocity, found[count:], residual, whole_stress=True)
        step, part = _step(state, given), 1.0
        falls = _State.at(gradients, share, given, found + step)
        slope, other = float(step[:count] @ state.rest[:count]), float(step[:count] @ falls.rest[:count])
        for _ in range(MOST_HALVINGS):  # the work of the step along itself vanishes where the dissipation is least
            if abs(other) <= FLAT * abs(slope) or other * slope > 0.0:
                break
            part *= slope / (slope - other)
            falls = _State.at(gradients, share, given, found + part * step)
            other = float(step[:count] @ falls.rest[:count])
        state, found = falls, found + part * step
    raise QuestionError(
        "sheared_drag: the flow did not converge; add velocities in between, or take a wider mesh_gap or a law that changes less"
    )


@dataclass(frozen=True)
class _State:
    """The fluid at one velocity: its strain, viscosity and what is unbalanced."""

    gradients: Gradients
    strain: Floats
    rate: Floats
    viscosity: Floats
    rising: Floats  # 4 n'(g)/g
    friction: Floats  # forces of the viscosity on all nodes, (3 node,)
    rest: Floats

    @classmethod
    def at(cls, gradients: Gradients, share: Share, given: Floats, found: Floats) -> _State:
        """With the velocity of these unknowns."""
        spaces = gradients.spaces
        count = spaces.unknown.shape[1]
        velocity = given + spaces.unknown @ found[:count]
        strain = gradients.strain(velocity.reshape(3, -1))
        rate = np.maximum(gradients.rate(strain), REST)
        viscosity = share(rate)
        rising = 4.0 * (share(rate * (1.0 + STEEP)) - viscosity) / (STEEP * rate**2)
        stress = 2.0 * gradients.weight * viscosity * strain
        along = gradients.along
        friction = np.concatenate([sum(along[j].T @ stress[i, j] for j in range(3)) for i in range(3)])
        pushed = friction + spaces.divergence.T @ found[count:]
        rest = np.concatenate([-(spaces.unknown.T @ pushed), -(spaces.divergence @ velocity)])
        return cls(gradients, strain, rate, viscosity, rising, friction, rest)

    @property
    def size(self) -> float:
        """Of what is unbalanced."""
        return float(np.linalg.norm(self.rest))

    @property
    def scale(self) -> float:
        """Of the forces of the viscosity."""
        return float(np.linalg.norm(self.friction))


def _step(state: _State, given: Floats) -> Floats:
    spaces, gradients = state.gradients.spaces, state.gradients
    transport, one = gradients.stress(state.viscosity)
    matrix, _ = equations(spaces, transport + gradients.slope(state.strain, state.rising), given)
    parts = np.split(spaces.free, 3)
    solvers = [factors(one[part][:, part]) for part in (parts[0], parts[2])]
    over = sp.diags(gradients.weight / state.viscosity)
    pressures = factors((gradients.pressure.T @ over @ gradients.pressure).tocsr())
    ends = np.cumsum([int(part.sum()) for part in parts])

    def preconditioned(x: Floats) -> Floats:
        first, second, third, rest = np.split(x, ends)
        return np.concatenate([solvers[0](first), solvers[0](second), solvers[1](third), pressures(rest)])

    operator = LinearOperator(matrix.shape, preconditioned)
    found, _ = minres(matrix, state.rest, M=operator, rtol=ENOUGH, maxiter=MOST_INNER)
    return np.asarray(found)


def _at_gauss(values: Any, dofs: Any, count: int) -> Sparse:
    """Values of shape functions (function, element, gauss) as a matrix (gauss, unknown)."""
    number, elements, points = values.shape
    rows = np.broadcast_to(np.arange(elements * points).reshape(elements, points), values.shape)
    columns = np.broadcast_to(dofs[:, :, None], (number, elements, points))
    return sp.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=(elements * points, count))
