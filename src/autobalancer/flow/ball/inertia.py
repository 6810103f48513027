"""Steady flow with inertia of the fluid: Navier and Stokes' equations in the frame of the ball.

With w the velocity of the walls and u = w + u' they are Re/2 ((u . grad) u' + (u' . grad) w) = -grad p + Laplace u', div u' = 0;
the pressure of the fluid that turns with the walls is left out. The first steps take the last u as carrier (Picard), the others
its change too (Newton); each is solved by GMRES only as far as it deserves.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, gmres

from autobalancer.errors import QuestionError
from autobalancer.flow.ball.mesh import Floats
from autobalancer.flow.ball.slow import Flow, component_solver, equations, factors, of_unknowns
from autobalancer.flow.ball.spaces import Spaces, Sparse

SMALL = 1e-6  # of the unbalanced forces over those of the flow without inertia
ENOUGH = 0.03  # of its own residual, for one step
MOST_STEPS = 40
PICARD_STEPS = 2


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
    found, pressures = unknowns(start), factors(spaces.pressure_mass)
    state, rest = _balance(spaces, reynolds, spin, found, given)
    for number in range(MOST_STEPS):
        size = float(np.linalg.norm(rest))
        if size < SMALL * scale:
            return of_unknowns(spaces, reynolds, spin, state.transport, found)
        slope = spaces.change_of_convection(state.velocity) if number >= PICARD_STEPS else None
        step, part = _step(state, rest, slope, pressures), 1.0
        while True:
            state, rest = _balance(spaces, reynolds, spin, found + part * step, given)
            if slope is None or float(np.linalg.norm(rest)) < size or part < 0.1:
                break
            part *= 0.5
        found = found + part * step
    raise QuestionError(
        f"ball_drag: no steady flow was found at a Reynolds number of {reynolds:g}; ask for smaller ones, for some in between, "
        "or for a higher fineness"
    )


def unknowns(flow: Flow) -> Floats:
    """The vector of unknowns of a flow."""
    spaces = flow.spaces
    through = [flow.through] if np.isfinite(spaces.shape.rest) else []
    return np.concatenate([flow.deviation.ravel()[spaces.free], through, flow.pressure])


class _State(NamedTuple):
    """Equations at one velocity: ``one`` of a component, ``transport`` of all, ``matrix`` of the unknowns."""

    spaces: Spaces
    reynolds: float
    velocity: Floats
    one: Sparse
    transport: Sparse
    matrix: Sparse


def _balance(spaces: Spaces, reynolds: float, spin: float, found: Floats, given: Floats) -> tuple[_State, Floats]:
    """The equations with the velocity found as carrier, and what it leaves unbalanced."""
    velocity = (given + spaces.unknown @ found[: spaces.unknown.shape[1]]).reshape(3, -1)
    one = spaces.diffusion + 0.5 * reynolds * spaces.convection(velocity + spaces.walls_velocity())
    bend = 0.5 * reynolds * spaces.shape.turning * spaces.mass
    transport = sp.bmat([[one, -bend, None], [bend, one, None], [None, None, one]], format="csr")
    matrix, load = equations(spaces, transport, given)
    return _State(spaces, reynolds, velocity, one, transport, matrix), load - matrix @ found


def _step(state: _State, rest: Floats, slope: Sparse | None, pressures: Callable[[Floats], Floats]) -> Floats:
    spaces, matrix = state.spaces, state.matrix
    count = spaces.unknown.shape[1]
    velocities, gradient = component_solver(spaces, state.one, state.transport), matrix[:count, count:]
    if slope is not None:
        inner = 0.5 * state.reynolds * spaces.unknown.T @ slope @ spaces.unknown
        matrix = matrix + sp.block_diag([inner, sp.csr_matrix((rest.size - count,) * 2)], format="csr")

    def preconditioned(x: Floats) -> Floats:
        p = -pressures(x[count:])
        return np.concatenate([velocities(x[:count] - gradient @ p), p])

    operator = LinearOperator(matrix.shape, lambda x: matrix @ preconditioned(x))
    found, _ = gmres(operator, rest, rtol=ENOUGH, restart=80, maxiter=3)
    return preconditioned(found)
