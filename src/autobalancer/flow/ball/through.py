"""Flow through the whole race: balls push the fluid around their ring, against its resistance between them."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from autobalancer.flow.ball.mesh import Floats, Shape, extra

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
