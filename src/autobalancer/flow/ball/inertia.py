"""Steady flow with inertia of the fluid: Navier and Stokes' equations in the frame of the ball.

With w the velocity of the walls and u = w + u' they are Re/2 ((u . grad) u' + (u' . grad) w) = -grad p + Laplace u', div u' = 0;
the pressure of the fluid that turns with the walls is left out. Each step solves them with the last u as carrier (Picard), by
GMRES only as far as the step deserves.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, gmres

from autobalancer.errors import QuestionError
from autobalancer.flow.ball.mesh import Floats
from autobalancer.flow.ball.slow import Flow, component_solver, equations, factors, of_unknowns
from autobalancer.flow.ball.spaces import Spaces, Sparse

SMALL = 1e-6  # of the unbalanced forces over those of the flow without inertia
ENOUGH = 0.03  # of its own residual, for one step
MOST_STEPS = 60


def flow_with_inertia(start: Flow, reynolds: float) -> Flow:
    """The steady flow at a Reynolds number, from one at another.

    Raises
    ------
    QuestionError
        If the steps do not converge, because the flow is no longer steady or the mesh too coarse for it.
    """
    spaces, spin = start.spaces, start.spin
    given = spaces.balls_deviation(spin).ravel()
    scale = float(np.linalg.norm(spaces.unknown.T @ (spaces.diffusion @ given.reshape(3, -1).T).T.ravel()))
    found, velocity = unknowns(start), start.deviation
    pressures = factors(spaces.pressure_mass)
    for _ in range(MOST_STEPS):
        one = spaces.diffusion + 0.5 * reynolds * spaces.convection(velocity + spaces.walls_velocity())
        transport = _transport(spaces, one, 0.5 * reynolds)
        matrix, load = equations(spaces, transport, given)
        rest = load - matrix @ found
        if float(np.linalg.norm(rest)) < SMALL * scale:
            return of_unknowns(spaces, reynolds, spin, transport, found)
        found = found + _step(spaces, matrix, rest, one, transport, pressures)
        velocity = of_unknowns(spaces, reynolds, spin, transport, found).deviation
    raise QuestionError(
        f"ball_drag: no steady flow was found at a Reynolds number of {reynolds:g}; ask for smaller ones, for some in between, "
        "or for a higher fineness"
    )


def unknowns(flow: Flow) -> Floats:
    """The vector of unknowns of a flow."""
    spaces = flow.spaces
    through = [flow.through] if np.isfinite(spaces.shape.rest) else []
    return np.concatenate([flow.deviation.ravel()[spaces.free], through, flow.pressure])


def _transport(spaces: Spaces, one: Sparse, inertia: float) -> Sparse:
    bend = inertia * spaces.shape.turning * spaces.mass
    return sp.bmat([[one, -bend, None], [bend, one, None], [None, None, one]], format="csr")


def _step(spaces: Spaces, matrix: Sparse, rest: Floats, one: Sparse, transport: Sparse, pressures: object) -> Floats:
    count = spaces.unknown.shape[1]
    velocities, gradient = component_solver(spaces, one, transport), matrix[:count, count:]

    def preconditioned(x: Floats) -> Floats:
        p = -pressures(x[count:])  # type: ignore[operator]
        return np.concatenate([velocities(x[:count] - gradient @ p), p])

    operator = LinearOperator(matrix.shape, lambda x: matrix @ preconditioned(x))
    found, _ = gmres(operator, rest, rtol=ENOUGH, restart=80, maxiter=3)
    return preconditioned(found)
