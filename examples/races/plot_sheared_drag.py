"""
Drag in a fluid that thins
==========================

A ball in a polymer solution, grease or suspension is dragged by a fluid whose viscosity depends on how fast it is sheared.
A machine file says this by one number, ``at_ball``: the rate of shear, over velocity and diameter of the ball, at which the
viscosity gives the drag. Here finite elements find it for a race of your own.
"""

# %%
# Slow flow around a ball, with Newton's method for the viscosity. It starts from the flow of constant viscosity that
# ``ab.flow.ball_drag`` solves; inertia of the fluid and the flow that balls drive around a closed race are left out.
#
# div(2 n D) = grad p, with D the symmetric gradient of the velocity and n = s(g U/r) at the rate of shear g = sqrt(2 D : D), in
# radii r and velocities U of the ball. Steps are shortened where they overshoot the least dissipation; each is solved by MINRES,
# with the equations of the components at the present viscosity and the mass matrix of the pressure over it as preconditioner.

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, minres

import autobalancer as ab
from autobalancer.arrays import Floats
from autobalancer.flow.annulus import annulus_of
from autobalancer.flow.ball_problem import ball_forces, channel_of, shape_of
from autobalancer.flow.finite_elements import (
    Fineness,
    Flow,
    Spaces,
    Sparse,
    equations,
    expect,
    factors,
    slow_flow,
    spaces,
    unknowns,
)

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
    ab.errors.QuestionError
        If the steps do not converge.
    """
    mesh = start.spaces
    count = mesh.unknown.shape[1]
    boundary, solution = mesh.balls_deviation(start.spin).ravel(), unknowns(start)
    state = _State.at(gradients, share, boundary, solution)
    for number in range(MOST_STEPS):
        if number and state.size < SMALL * state.scale:
            velocity = (boundary + mesh.unknown @ solution[:count]).reshape(3, -1)
            residual = (state.friction + mesh.divergence.T @ solution[count:]).reshape(3, -1)
            return Flow(mesh, 0.0, start.spin, velocity, solution[count:], residual, whole_stress=True)
        step, part = _step(state, boundary), 1.0
        falls = _State.at(gradients, share, boundary, solution + step)
        slope, other = float(step[:count] @ state.rest[:count]), float(step[:count] @ falls.rest[:count])
        for _ in range(MOST_HALVINGS):  # the work of the step along itself vanishes where the dissipation is least
            if abs(other) <= FLAT * abs(slope) or other * slope > 0.0:
                break
            part *= slope / (slope - other)
            falls = _State.at(gradients, share, boundary, solution + part * step)
            other = float(step[:count] @ falls.rest[:count])
        state, solution = falls, solution + part * step
    raise ab.errors.QuestionError(
        "sheared drag: the flow did not converge; add velocities in between, or take a wider mesh_gap or a law that changes less"
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
    def at(cls, gradients: Gradients, share: Share, boundary: Floats, solution: Floats) -> _State:
        """With the velocity of these unknowns."""
        mesh = gradients.spaces
        count = mesh.unknown.shape[1]
        velocity = boundary + mesh.unknown @ solution[:count]
        strain = gradients.strain(velocity.reshape(3, -1))
        rate = np.maximum(gradients.rate(strain), REST)
        viscosity = share(rate)
        rising = 4.0 * (share(rate * (1.0 + STEEP)) - viscosity) / (STEEP * rate**2)
        stress = 2.0 * gradients.weight * viscosity * strain
        along = gradients.along
        friction = np.concatenate([sum(along[j].T @ stress[i, j] for j in range(3)) for i in range(3)])
        pushed = friction + mesh.divergence.T @ solution[count:]
        rest = np.concatenate([-(mesh.unknown.T @ pushed), -(mesh.divergence @ velocity)])
        return cls(gradients, strain, rate, viscosity, rising, friction, rest)

    @property
    def size(self) -> float:
        """Of what is unbalanced."""
        return float(np.linalg.norm(self.rest))

    @property
    def scale(self) -> float:
        """Of the forces of the viscosity."""
        return float(np.linalg.norm(self.friction))


def _step(state: _State, boundary: Floats) -> Floats:
    mesh, gradients = state.gradients.spaces, state.gradients
    transport, one = gradients.stress(state.viscosity)
    matrix, _ = equations(mesh, transport + gradients.slope(state.strain, state.rising), boundary)
    parts = np.split(mesh.free, 3)
    solvers = [factors(one[part][:, part]) for part in (parts[0], parts[2])]
    over = sp.diags(gradients.weight / state.viscosity)
    pressures = factors((gradients.pressure.T @ over @ gradients.pressure).tocsr())
    ends = np.cumsum([int(part.sum()) for part in parts])

    def preconditioned(x: Floats) -> Floats:
        first, second, third, rest = np.split(x, ends)
        return np.concatenate([solvers[0](first), solvers[0](second), solvers[1](third), pressures(rest)])

    operator = LinearOperator(matrix.shape, preconditioned)
    solution, _ = minres(matrix, state.rest, M=operator, rtol=ENOUGH, maxiter=MOST_INNER)
    return np.asarray(solution)


def _at_gauss(values: Any, dofs: Any, count: int) -> Sparse:
    """Values of shape functions (function, element, gauss) as a matrix (gauss, unknown)."""
    number, elements, points = values.shape
    rows = np.broadcast_to(np.arange(elements * points).reshape(elements, points), values.shape)
    columns = np.broadcast_to(dofs[:, :, None], (number, elements, points))
    return sp.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=(elements * points, count))


# %%
# The drag over that at rest for some velocities of a ball that rolls along the outer wall, and the one rate of shear that has
# it. ``gap`` is that of the mesh, in radii of the ball: a narrower film is sheared faster than this theory can say.


def sheared_drag(
    machine: Any, velocities: Sequence[float], gap: float = 0.02, fineness: float = 1.0
) -> tuple[Floats, Floats, float]:
    """Drag over that with the viscosity at rest, its first-order estimate, both (velocity,), and the best ``at_ball``."""
    channel, law = replace(channel_of(machine), length_per_ball=math.inf), annulus_of(machine).sheared
    shape = shape_of(channel, gap, 0.0)
    sizes = Fineness(bulk=0.27 * min(shape.width, shape.height)).finer(fineness)
    expect(shape, sizes)  # says so where gmsh or scikit-fem is missing
    mesh = spaces(shape, sizes)
    gradients = Gradients(mesh)
    flow = sheared_flow(slow_flow(mesh, mesh.rolling), gradients, np.ones_like)
    at_rest = ball_forces(flow).drag()
    rates = gradients.rate(gradients.strain(flow.deviation))
    dissipation = gradients.weight * rates**2
    share, first_order = [], []
    for velocity in velocities:
        scale = velocity / channel.ball_radius
        flow = sheared_flow(flow, gradients, lambda rate, scale=scale: law.share(scale * rate))
        share.append(ball_forces(flow).drag() / at_rest)
        first_order.append(float(dissipation @ law.share(scale * rates) / dissipation.sum()))
    at_ball = np.geomspace(1e-3, 1e3, 3001)
    by_one_rate = law.share(at_ball[:, None] * np.array(velocities) / channel.ball_diameter)
    best = np.abs(by_one_rate / np.array(share) - 1.0).max(axis=1).argmin()
    return np.array(share), np.array(first_order), float(at_ball[best])


# %%
# In the race of ``thinning_fluid`` the ball leaves 3 mm to the inner wall and to both lids together. Nearly all dissipation is in
# the narrow places, so ``at_ball`` is about 30 times that of a free sphere.

if __name__ == "__main__":
    import matplotlib.pyplot as plt

    machine = ab.example("thinning_fluid")
    velocities = [0.01, 0.1]
    share, first_order, at_ball = sheared_drag(machine, velocities, gap=0.1, fineness=0.5)
    print(f"at_ball = {at_ball:.3g}; a finer mesh with a gap of 0.02 radii gives 13.5, which the machine file has")
    figure, axes = plt.subplots(layout="constrained")
    axes.semilogx(velocities, share, "o", label="finite elements")
    law = annulus_of(machine).sheared
    axes.semilogx(
        velocities, law.share(at_ball * np.array(velocities) / channel_of(machine).ball_diameter), label="at_ball"
    )
    axes.semilogx(velocities, first_order, ":", label="mean of the law over the flow at rest")
    axes.set(xlabel="velocity of the ball along its walls (m/s)", ylabel="drag over that at rest", ylim=(0.0, 1.1))
    axes.legend()
    assert 10.0 < at_ball < 20.0
