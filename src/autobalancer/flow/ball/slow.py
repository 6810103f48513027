"""Flow without inertia of the fluid: Stokes' equations."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import LinearOperator, minres, splu

from autobalancer.errors import QuestionError
from autobalancer.flow.ball.mesh import Floats
from autobalancer.flow.ball.spaces import Spaces, Sparse

SMALL = 1e-10  # of the residual over that of the start; thin films need it
MOST_STEPS = 3000


@dataclass(frozen=True)
class Flow:
    """A solved flow: ``deviation`` of the velocity from that of the walls, (3, node), ``pressure``, (pressure,), the Reynolds
    number and the ``spin`` of the balls. ``residual`` are the forces of the nodes on the fluid that hold it, (3, node), and
    ``through`` the mean velocity around a closed race relative to its walls."""

    spaces: Spaces
    reynolds: float
    spin: float
    deviation: Floats
    pressure: Floats
    residual: Floats
    through: float = 0.0
    whole_stress: bool = False  # whether the residual has the transpose of grad u, too


def slow_flow(spaces: Spaces, spin: float) -> Flow:
    """Solve Stokes' equations with balls of one angular velocity.

    MINRES, with exact factors of the velocities' equations and the mass matrix of the pressure as preconditioner.
    """
    given = spaces.balls_deviation(spin).ravel()
    transport = sp.block_diag([spaces.diffusion] * 3, format="csr")
    matrix, load = equations(spaces, transport, given)
    velocities, pressures = component_solver(spaces, spaces.diffusion, transport), factors(spaces.pressure_mass)
    count = spaces.unknown.shape[1]

    def preconditioned(x: Floats) -> Floats:
        return np.concatenate([velocities(x[:count]), pressures(x[count:])])

    found, failed = minres(matrix, load, M=LinearOperator(matrix.shape, preconditioned), rtol=SMALL, maxiter=MOST_STEPS)
    if failed:
        raise QuestionError("ball_drag: the flow without inertia did not converge; ask for a wider mesh_gap")
    return of_unknowns(spaces, 0.0, spin, transport, found)


def equations(spaces: Spaces, transport: Sparse, given: Floats) -> tuple[Sparse, Floats]:
    """Matrix and right-hand side for the unknown velocities and pressures; ``transport`` is the matrix of all velocities,
    ``given`` those on the balls."""
    unknown = spaces.unknown
    inner, divergence = (unknown.T @ transport @ unknown).tolil(), spaces.divergence @ unknown
    if math.isfinite(spaces.shape.rest):
        inner[-1, -1] += spaces.resistance
    load = np.concatenate([-(unknown.T @ (transport @ given)), -(spaces.divergence @ given)])
    return sp.bmat([[inner.tocsr(), divergence.T], [divergence, None]], format="csr"), load


def of_unknowns(spaces: Spaces, reynolds: float, spin: float, transport: Sparse, found: Floats) -> Flow:
    """A flow from the vector of its unknowns; ``transport`` is the matrix of all velocities."""
    count = spaces.unknown.shape[1]
    velocity = spaces.balls_deviation(spin).ravel() + spaces.unknown @ found[:count]
    residual = transport @ velocity + spaces.divergence.T @ found[count:]
    through = float(found[count - 1]) if math.isfinite(spaces.shape.rest) else 0.0
    return Flow(spaces, reynolds, spin, velocity.reshape(3, -1), found[count:], residual.reshape(3, -1), through)


def component_solver(spaces: Spaces, one: Sparse, transport: Sparse) -> Callable[[Floats], Floats]:
    """Solves the equations of the unknown velocities component by component; ``one`` is the matrix of one component."""
    parts = np.split(spaces.free, 3)
    solvers = [factors(one[part][:, part]) for part in (parts[0], parts[2])]
    ends = np.cumsum([int(part.sum()) for part in parts])
    through = spaces.unknown[:, int(ends[-1]) :]
    last = np.asarray((through.T @ transport @ through).diagonal()) + (spaces.resistance if through.shape[1] else 0.0)

    def solved(x: Floats) -> Floats:
        first, second, third, mean = np.split(x, ends)
        return np.concatenate([solvers[0](first), solvers[0](second), solvers[1](third), mean / last])

    return solved


def factors(matrix: Sparse) -> Callable[[Floats], Floats]:
    """Solves with a matrix that is symmetric or nearly so."""
    found: Any = splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options={"SymmetricMode": True}
    )
    solve: Callable[[Floats], Floats] = found.solve
    return solve
