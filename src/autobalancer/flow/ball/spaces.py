"""Quadratic velocities and linear pressures on a mesh, their matrices, and which nodes lie on which wall."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from autobalancer.flow.ball.mesh import Fineness, Floats, Shape, extra, tetrahedra

Mask = NDArray[np.bool_]
Sparse = Any
ON = 1e-6  # ball radii


@dataclass(frozen=True)
class Spaces:
    """``velocity`` and ``pressure`` are bases of scikit-fem; the components of velocity share one."""

    shape: Shape
    velocity: Any
    pressure: Any

    @cached_property
    def nodes(self) -> Floats:
        """Places of the velocities, ball radii; (3, node)."""
        return np.asarray(self.velocity.doflocs, float)

    @cached_property
    def diffusion(self) -> Sparse:
        """Of one component; (node, node)."""
        skfem = extra("skfem")
        return skfem.BilinearForm(lambda u, v, w: _dot(u.grad, v.grad)).assemble(self.velocity)

    @cached_property
    def mass(self) -> Sparse:
        """Of one component; (node, node)."""
        return extra("skfem").BilinearForm(lambda u, v, w: u * v).assemble(self.velocity)

    @cached_property
    def pressure_mass(self) -> Sparse:
        """(pressure, pressure)."""
        return extra("skfem").BilinearForm(lambda u, v, w: u * v).assemble(self.pressure)

    @cached_property
    def divergence(self) -> Sparse:
        """-div of the three components after each other, against pressures; (pressure, 3 node)."""
        skfem = extra("skfem")
        parts = [
            skfem.BilinearForm(lambda u, v, w, i=i: -u.grad[i] * v).assemble(self.velocity, self.pressure)
            for i in range(3)
        ]
        return sp.hstack(parts, format="csr")

    def convection(self, carrier: Floats) -> Sparse:
        """(carrier . grad) of one component; ``carrier`` (3, node)."""
        skfem = extra("skfem")
        fields = [self.velocity.interpolate(part) for part in carrier]
        form = skfem.BilinearForm(lambda u, v, w: (w.a * u.grad[0] + w.b * u.grad[1] + w.c * u.grad[2]) * v)
        return form.assemble(self.velocity, a=fields[0], b=fields[1], c=fields[2])

    def change_of_convection(self, velocity: Floats) -> Sparse:
        """(change . grad) velocity of all components, as a matrix for the change; ``velocity`` (3, node)."""
        basis, dofs = self.velocity, self.velocity.element_dofs
        count, weights = dofs.shape[0], np.asarray(self.velocity.dx)
        shapes = np.array([np.broadcast_to(np.asarray(part[0]), weights.shape)[0] for part in basis.basis])
        pairs = np.einsum("iq,jq->qij", shapes, shapes).reshape(weights.shape[1], -1)
        rows, columns = (
            np.broadcast_to(part, (dofs.shape[1], count, count)).ravel()
            for part in (dofs.T[:, :, None], dofs.T[:, None, :])
        )

        def block(slope: Floats) -> Sparse:
            return sp.csr_matrix((((weights * slope) @ pairs).ravel(), (rows, columns)), shape=self.diffusion.shape)

        slopes = [np.asarray(basis.interpolate(part).grad) for part in velocity]
        return sp.bmat([[block(part) for part in slope] for slope in slopes], format="csr")

    def on_ball(self, number: int) -> Mask:
        """Nodes on a ball, counted from 0; (node,)."""
        x, y = self.shape.centers()[number]
        arm = self.nodes - np.array([x, y, 0.0])[:, None]
        return np.asarray(np.abs(np.linalg.norm(arm, axis=0) - 1.0) < ON)

    @cached_property
    def on_walls(self) -> Mask:
        """Nodes on walls of the race and where undisturbed fluid enters, ahead of the ball; (node,)."""
        shape, (x, y, z) = self.shape, self.nodes
        depth = shape.depth(x, y)
        near = [depth, shape.width - depth, 0.5 * shape.height - z, shape.ahead - shape.along(x, y)]
        return np.asarray(np.min(np.abs(near), axis=0) < ON * max(shape.width, shape.height, shape.ahead))

    @cached_property
    def free(self) -> Mask:
        """Velocities that are unknown; (3 node,)."""
        held = self.on_walls.copy()
        for number in range(len(self.shape.centers())):
            held |= self.on_ball(number)
        across = held | (np.abs(self.nodes[2]) < ON)
        return ~np.concatenate([held, held, across])

    @cached_property
    def unknown(self) -> Sparse:
        """Velocities by their unknowns: the free nodes and, in a closed race, the mean flow through it; (3 node, unknown)."""
        count = self.free.size
        columns = [sp.identity(count, format="csc")[:, np.flatnonzero(self.free)]]
        if math.isfinite(self.shape.rest):
            columns.append(sp.csc_matrix(self._through[0].reshape(-1, 1)))
        return sp.hstack(columns, format="csr")

    @cached_property
    def resistance(self) -> float:
        """Of the closed race beyond the mesh to the mean flow: its pressure times the flux at mean velocity one."""
        return self._through[1]

    @cached_property
    def _through(self) -> tuple[Floats, float]:
        shape, (x, y, z) = self.shape, self.nodes
        entry = np.flatnonzero(np.abs(shape.ahead - shape.along(x, y)) < ON * shape.ahead)
        flow = developed(shape, shape.depth(x, y)[entry], z[entry])
        field = np.zeros_like(self.nodes)
        field[:2, entry] = -self.walls_velocity()[:2, entry]
        field[:, entry] *= flow.profile / np.linalg.norm(field[:, entry], axis=0)
        return field, flow.flux * flow.drop * shape.rest

    def walls_velocity(self) -> Floats:
        """w, the velocity of the walls, continued through the fluid; (3, node)."""
        x, y, z = self.nodes
        turn = self.shape.turning
        return np.array([-1.0 - turn * y, turn * x, 0.0 * z])

    def balls_deviation(self, spin: float) -> Floats:
        """Velocity of the surfaces of all balls that turn with ``spin`` in this frame, less w; zero elsewhere; (3, node)."""
        found, walls = np.zeros_like(self.nodes), self.walls_velocity()
        for number, (x, y) in enumerate(self.shape.centers()):
            on = self.on_ball(number)
            own = np.array([-spin * (self.nodes[1] - y), spin * (self.nodes[0] - x), 0.0 * self.nodes[2]])
            found[:, on] = (own - walls)[:, on]
        return found

    @property
    def rolling(self) -> float:
        """Angular velocity at which a ball does not slip on the outer wall, in the frame of its center."""
        return -1.0 if math.isinf(self.shape.orbit) else -self.shape.outer / self.shape.orbit


def spaces(shape: Shape, fineness: Fineness) -> Spaces:
    """Mesh a channel; raises as :func:`~autobalancer.flow.ball.mesh.tetrahedra`."""
    skfem = extra("skfem")
    mesh = tetrahedra(shape, fineness)
    return Spaces(
        shape, skfem.Basis(mesh, skfem.ElementTetP2(), intorder=4), skfem.Basis(mesh, skfem.ElementTetP1(), intorder=4)
    )


def _dot(a: Any, b: Any) -> Any:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


# Flow through the whole race: balls push the fluid around their ring, against its resistance between them.


CELLS = 16  # of the cross-section in each direction


class Developed(NamedTuple):
    """Flow along the race that a pressure drives between two balls: ``profile`` at places in a cross-section, (node,), its
    ``flux`` through the half above the plane of symmetry, and the ``drop`` of pressure along a unit of length of the orbit; all
    in ball radii."""

    profile: Floats
    flux: float
    drop: float


def developed(shape: Shape, depth: Floats, height: Floats) -> Developed:
    """Of mean velocity one; ``depth`` from the outer wall and ``height`` above mid-height say where, (node,).

    In a bent race u'' + u'/R - u/R^2 + u_zz = (dp/ds) eps/R over the radius R, in a straight one without the middle terms.
    """
    skfem = extra("skfem")
    lines = [np.linspace(0.0, length, CELLS + 1) for length in (shape.width, 0.5 * shape.height)]
    basis = skfem.Basis(skfem.MeshQuad.init_tensor(*lines), skfem.ElementQuad2(), intorder=5)
    straight = math.isinf(shape.orbit)

    def curve(x: Any) -> Any:
        return np.ones_like(x) if straight else (shape.outer - x) / shape.orbit

    def friction(u: Any, v: Any, w: Any) -> Any:
        r = curve(w.x[0])
        bend = 0.0 if straight else u * v / (r * shape.orbit**2)
        return (u.grad[0] * v.grad[0] + u.grad[1] * v.grad[1]) * r + bend

    matrix = skfem.BilinearForm(friction).assemble(basis)
    load = skfem.LinearForm(lambda v, w: v).assemble(basis)
    x, y = basis.doflocs
    walls = np.flatnonzero((x == 0.0) | (x == shape.width) | (y == 0.5 * shape.height))
    found = skfem.solve(*skfem.condense(matrix, load, D=walls))
    flux = float(load @ found)
    area = 0.5 * shape.width * shape.height
    points = np.array([np.clip(depth, 0.0, shape.width), np.clip(height, 0.0, 0.5 * shape.height)])
    values = basis.probes(points) @ found if depth.size else np.zeros(0)
    return Developed(np.asarray(values) * area / flux, area, area / flux)
