"""Tetrahedra around a ball in its channel, finer where the gap is narrow."""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError

Floats = NDArray[np.float64]
NARROWEST = 0.003
"""Gap in ball radii below which the number of elements, which grows as its inverse, is beyond what is solved here."""
MOST = 150_000
"""Elements of a mesh that a few minutes and about 4 GB are enough for."""
ON = 1e-7  # ball radii: what is nearer to a surface lies on it


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
        on = np.abs(np.linalg.norm(arm[:, :count], axis=0) - radius) < ON * radius
        middle = count + np.flatnonzero(on[edges].all(axis=0) & outside)
        places[:, middle] += arm[:, middle] * (radius / np.linalg.norm(arm[:, middle], axis=0) - 1.0)
    return np.asarray(places)
