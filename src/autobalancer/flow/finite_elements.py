"""Quadratic velocities and linear pressures on a mesh, their matrices, and which nodes lie on which wall."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import LinearOperator, gmres, minres, splu

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError

# Tetrahedra around a ball in its channel, finer where the gap is narrow.


NARROWEST = 0.003
"""Gap in ball radii below which the number of elements, which grows as its inverse, is beyond what is solved here."""
MOST = 150_000
"""Elements of a mesh that a few minutes and about 4 GB are enough for."""
MESH_ON = 1e-7  # ball radii: what is nearer to a surface lies on it


@dataclass(frozen=True)
class Shape:
    """The channel in ball radii.

    ``gap`` between ball and outer wall; ``orbit`` of the ball center, infinite if straight; ``ahead`` and ``behind`` are the
    lengths of the channel on both sides; ``second`` the distance along the orbit of another ball ahead, or nan. ``rest`` is what
    the closed race has beyond; infinite if the fluid far away moves with the walls.
    """

    width: float
    height: float
    gap: float
    ahead: float
    behind: float
    orbit: float = math.inf
    second: float = math.nan
    rest: float = math.inf

    @property
    def turning(self) -> float:
        """Angular velocity of the walls in the frame of the ball; 0 if straight."""
        return -1.0 / self.orbit

    def centers(self) -> list[tuple[float, float]]:
        """Places of the balls in the plane of symmetry."""
        return [(0.0, 0.0)] if math.isnan(self.second) else [(0.0, 0.0), self.place(self.second)]

    def place(self, along: float) -> tuple[float, float]:
        """The point of the orbit at a distance along it, positive ahead."""
        if math.isinf(self.orbit):
            return along, 0.0
        angle = along / self.orbit
        return self.orbit * math.sin(angle), self.orbit * (1.0 - math.cos(angle))

    def depth(self, x: Any, y: Any) -> Any:
        """Distance from the outer wall."""
        return y + 1.0 + self.gap if math.isinf(self.orbit) else self.outer - np.hypot(x, y - self.orbit)

    def along(self, x: Any, y: Any) -> Any:
        """Distance along the orbit."""
        return x if math.isinf(self.orbit) else self.orbit * np.arctan2(x, self.orbit - y)

    @property
    def outer(self) -> float:
        """Radius of the outer wall."""
        return self.orbit + 1.0 + self.gap


@dataclass(frozen=True)
class Fineness:
    """Sizes of elements in ball radii: ``ball`` on it, ``growth`` away from it, ``bulk`` at most; in a narrow place ``across``
    times its thickness. The default suits a first look, :meth:`finer` the answer."""

    ball: float = 0.22
    growth: float = 0.3
    bulk: float = 0.6
    across: float = 0.6

    def finer(self, factor: float) -> Fineness:
        """All sizes divided by ``factor``."""
        return Fineness(*(size / factor for size in (self.ball, self.growth, self.bulk, self.across)))


def tetrahedra(shape: Shape, fineness: Fineness) -> Any:
    """A quadratic mesh of scikit-fem, with the middles of edges on the curved walls moved onto them.

    Raises
    ------
    QuestionError
        If the gap is too narrow, the mesh would be too large, or gmsh or scikit-fem are not installed.
    """
    expect(shape, fineness)
    skfem = extra("skfem")
    points, corners = _gmsh_mesh(shape, fineness)
    if len(corners) > MOST:
        raise QuestionError(
            f"ball_drag: the mesh has {len(corners)} elements, more than {MOST}; ask for a wider mesh_gap, a shorter channel or "
            "a lower fineness"
        )
    mesh = skfem.MeshTet2.from_mesh(skfem.MeshTet1(points.T.copy(), corners.T.copy()))
    return skfem.MeshTet2(_onto_walls(mesh, shape), mesh.t)


def expect(shape: Shape, fineness: Fineness) -> None:
    """Refuse a gap, or a play elsewhere, that this mesh cannot resolve."""
    if shape.gap < NARROWEST:
        raise QuestionError(
            f"mesh_gap: given {shape.gap:.3g} ball radii; a mesh resolves gaps from {NARROWEST:g} on; the drag at narrower ones "
            "follows by the theory of thin films, so give the narrow one as 'gap' and leave out 'mesh_gap'"
        )
    plays = {"inner wall": shape.width - 2.0 - shape.gap, "lids": 0.5 * shape.height - 1.0}
    place = min(plays, key=lambda name: plays[name])
    if plays[place] < NARROWEST:
        raise QuestionError(
            f"ball_drag: the play of the ball at the {place} is {plays[place]:.3g} ball radii; a mesh resolves {NARROWEST:g} "
            "and more"
        )
    film = math.pi / (min(shape.gap, *plays.values()) * fineness.across**2) * 6.0
    if film > MOST:
        raise QuestionError(
            f"mesh_gap: given {shape.gap:.3g} ball radii, which with the play elsewhere takes about {film:.2g} elements with "
            f"this fineness, more than {MOST}; give a wider one, or a lower fineness"
        )


def extra(name: str) -> Any:
    """A package of the extra ``drag``."""
    try:
        return import_module(name)
    except (ImportError, OSError) as reason:
        raise QuestionError(
            f"ball_drag: {name} cannot be imported ({str(reason).strip().splitlines()[0]}); install what the drag of a ball "
            'needs by: pip install "autobalancer[drag]"'
        ) from None


def _gmsh_mesh(shape: Shape, fineness: Fineness) -> tuple[Floats, NDArray[np.int64]]:
    gmsh = extra("gmsh")
    began = not gmsh.isInitialized()
    if began:
        gmsh.initialize(interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        gmsh.model.add("ball in its race")
        _geometry(gmsh.model.occ, shape)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.setSizeCallback(_sizes(shape, fineness))
        for option in ("MeshSizeExtendFromBoundary", "MeshSizeFromPoints", "MeshSizeFromCurvature"):
            gmsh.option.setNumber(f"Mesh.{option}", 0)
        gmsh.option.setNumber("Mesh.Algorithm3D", 10)
        gmsh.model.mesh.generate(3)
        tags, places, _ = gmsh.model.mesh.getNodes()
        corners = gmsh.model.mesh.getElementsByType(4)[1].reshape(-1, 4)
    except QuestionError:
        raise
    except Exception as reason:
        raise QuestionError(f"ball_drag: gmsh made no mesh: {reason}; try another mesh_gap or fineness") from None
    finally:
        gmsh.model.mesh.removeSizeCallback()
        gmsh.model.remove()
        if began:
            gmsh.finalize()
    used, number = np.unique(corners, return_inverse=True)
    order = np.argsort(tags)
    rows = order[np.searchsorted(tags[order], used)]
    return np.asarray(places.reshape(-1, 3)[rows], float), number.reshape(corners.shape)


def _geometry(occ: Any, shape: Shape) -> None:
    half, floor = 0.5 * shape.height, -(1.0 + shape.gap)
    if math.isinf(shape.orbit):
        body = [(3, occ.addBox(-shape.behind, floor, 0.0, shape.ahead + shape.behind, shape.width, half))]
    else:
        angle, axis = (shape.ahead + shape.behind) / shape.orbit, (0.0, shape.orbit, 0.0)
        rings = [
            (3, occ.addCylinder(*axis, 0.0, 0.0, half, r, angle=angle))
            for r in (shape.outer, shape.outer - shape.width)
        ]
        occ.rotate(rings, *axis, 0.0, 0.0, 1.0, -0.5 * math.pi - shape.behind / shape.orbit)
        body, _ = occ.cut(rings[:1], rings[1:])
    balls = [(3, occ.addSphere(x, y, 0.0, 1.0)) for x, y in shape.centers()]
    occ.cut(body, balls)


def _sizes(shape: Shape, fineness: Fineness) -> Any:
    centers = shape.centers()

    def size(dim: int, tag: int, x: float, y: float, z: float, lc: float) -> float:
        off = sorted(max(math.dist((x, y, z), (*c, 0.0)) - 1.0, 0.0) for c in centers)
        depth = float(shape.depth(x, y))
        wall = max(min(depth, shape.width - depth, 0.5 * shape.height - z), 0.0)
        thin = off[0] + min([wall, *off[1:]])
        return min(
            fineness.ball + fineness.growth * off[0], fineness.across * max(thin, 0.5 * shape.gap), fineness.bulk
        )

    return size


def _onto_walls(mesh: Any, shape: Shape) -> Floats:
    """Places of the nodes, those in the middle of edges of a curved wall moved onto it."""
    places, count = mesh.doflocs.copy(), mesh.nvertices
    edges, outside = mesh.edges, np.zeros(mesh.edges.shape[1], bool)
    outside[np.unique(mesh.f2e[:, mesh.boundary_facets()])] = True
    rounds = [((x, y), 1.0, True) for x, y in shape.centers()]
    if math.isfinite(shape.orbit):
        rounds += [((0.0, shape.orbit), r, False) for r in (shape.outer, shape.outer - shape.width)]
    for (x, y), radius, sphere in rounds:
        center = np.array([x, y, 0.0])[:, None]
        arm = (places - center) * np.array([1.0, 1.0, float(sphere)])[:, None]
        on = np.abs(np.linalg.norm(arm[:, :count], axis=0) - radius) < MESH_ON * radius
        middle = count + np.flatnonzero(on[edges].all(axis=0) & outside)
        places[:, middle] += arm[:, middle] * (radius / np.linalg.norm(arm[:, middle], axis=0) - 1.0)
    return np.asarray(places)


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
        balls_deviation, walls = np.zeros_like(self.nodes), self.walls_velocity()
        for number, (x, y) in enumerate(self.shape.centers()):
            on = self.on_ball(number)
            own = np.array([-spin * (self.nodes[1] - y), spin * (self.nodes[0] - x), 0.0 * self.nodes[2]])
            balls_deviation[:, on] = (own - walls)[:, on]
        return balls_deviation

    @property
    def rolling(self) -> float:
        """Angular velocity at which a ball does not slip on the outer wall, in the frame of its center."""
        return -1.0 if math.isinf(self.shape.orbit) else -self.shape.outer / self.shape.orbit


def spaces(shape: Shape, fineness: Fineness) -> Spaces:
    """Mesh a channel; raises as :func:`~autobalancer.flow.finite_elements.tetrahedra`."""
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
    result = skfem.solve(*skfem.condense(matrix, load, D=walls))
    flux = float(load @ result)
    area = 0.5 * shape.width * shape.height
    points = np.array([np.clip(depth, 0.0, shape.width), np.clip(height, 0.0, 0.5 * shape.height)])
    values = basis.probes(points) @ result if depth.size else np.zeros(0)
    return Developed(np.asarray(values) * area / flux, area, area / flux)


# Flow without inertia of the fluid: Stokes' equations.


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

    solution, failed = minres(
        matrix, load, M=LinearOperator(matrix.shape, preconditioned), rtol=SMALL, maxiter=MOST_STEPS
    )
    if failed:
        raise QuestionError("ball_drag: the flow without inertia did not converge; ask for a wider mesh_gap")
    return of_unknowns(spaces, 0.0, spin, transport, solution)


def equations(spaces: Spaces, transport: Sparse, argument: Floats) -> tuple[Sparse, Floats]:
    """Matrix and right-hand side for the unknown velocities and pressures; ``transport`` is the matrix of all velocities,
    ``argument`` those on the balls."""
    unknown = spaces.unknown
    inner, divergence = (unknown.T @ transport @ unknown).tolil(), spaces.divergence @ unknown
    if math.isfinite(spaces.shape.rest):
        inner[-1, -1] += spaces.resistance
    load = np.concatenate([-(unknown.T @ (transport @ argument)), -(spaces.divergence @ argument)])
    return sp.bmat([[inner.tocsr(), divergence.T], [divergence, None]], format="csr"), load


def of_unknowns(spaces: Spaces, reynolds: float, spin: float, transport: Sparse, values: Floats) -> Flow:
    """A flow from the vector of its unknowns; ``transport`` is the matrix of all velocities."""
    count = spaces.unknown.shape[1]
    velocity = spaces.balls_deviation(spin).ravel() + spaces.unknown @ values[:count]
    residual = transport @ velocity + spaces.divergence.T @ values[count:]
    through = float(values[count - 1]) if math.isfinite(spaces.shape.rest) else 0.0
    return Flow(spaces, reynolds, spin, velocity.reshape(3, -1), values[count:], residual.reshape(3, -1), through)


def component_solver(spaces: Spaces, sparse: Sparse, transport: Sparse) -> Callable[[Floats], Floats]:
    """Solves the equations of the unknown velocities component by component; ``sparse`` is the matrix of one component."""
    parts = np.split(spaces.free, 3)
    solvers = [factors(sparse[part][:, part]) for part in (parts[0], parts[2])]
    ends = np.cumsum([int(part.sum()) for part in parts])
    through = spaces.unknown[:, int(ends[-1]) :]
    last = np.asarray((through.T @ transport @ through).diagonal()) + (spaces.resistance if through.shape[1] else 0.0)

    def solved(x: Floats) -> Floats:
        first, second, third, mean = np.split(x, ends)
        return np.concatenate([solvers[0](first), solvers[0](second), solvers[1](third), mean / last])

    return solved


def factors(matrix: Sparse) -> Callable[[Floats], Floats]:
    """Solves with a matrix that is symmetric or nearly so."""
    result: Any = splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options={"SymmetricMode": True}
    )
    solve: Callable[[Floats], Floats] = result.solve
    return solve


# Steady flow with inertia of the fluid: Navier and Stokes' equations in the frame of the ball.
#
# With w the velocity of the walls and u = w + u' they are Re/2 ((u . grad) u' + (u' . grad) w) = -grad p + Laplace u',
# div u' = 0; the pressure of the fluid that turns with the walls is left out. The first steps take the last u as
# carrier (Picard), the others its change too (Newton); each is solved by GMRES only as far as it deserves.


NEGLIGIBLE_INERTIA = 1e-6  # of the unbalanced forces over those of the flow without inertia
ENOUGH = 0.03  # of its own residual, for one step
MOST_NEWTON_STEPS = 40
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
    flow, pressures = unknowns(start), factors(spaces.pressure_mass)
    state, rest = _balance(spaces, reynolds, spin, flow, given)
    for number in range(MOST_NEWTON_STEPS):
        size = float(np.linalg.norm(rest))
        if size < NEGLIGIBLE_INERTIA * scale:
            return of_unknowns(spaces, reynolds, spin, state.transport, flow)
        slope = spaces.change_of_convection(state.velocity) if number >= PICARD_STEPS else None
        step, part = _step(state, rest, slope, pressures), 1.0
        while True:
            state, rest = _balance(spaces, reynolds, spin, flow + part * step, given)
            if slope is None or float(np.linalg.norm(rest)) < size or part < 0.1:
                break
            part *= 0.5
        flow = flow + part * step
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


def _balance(spaces: Spaces, reynolds: float, spin: float, values: Floats, argument: Floats) -> tuple[_State, Floats]:
    """The equations with the velocity found as carrier, and what it leaves unbalanced."""
    velocity = (argument + spaces.unknown @ values[: spaces.unknown.shape[1]]).reshape(3, -1)
    one = spaces.diffusion + 0.5 * reynolds * spaces.convection(velocity + spaces.walls_velocity())
    bend = 0.5 * reynolds * spaces.shape.turning * spaces.mass
    transport = sp.bmat([[one, -bend, None], [bend, one, None], [None, None, one]], format="csr")
    matrix, load = equations(spaces, transport, argument)
    return _State(spaces, reynolds, velocity, one, transport, matrix), load - matrix @ values


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
    step, _ = gmres(operator, rest, rtol=ENOUGH, restart=80, maxiter=3)
    return preconditioned(step)
