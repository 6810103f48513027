"""A sphere in a power-law fluid far from walls, and the fluid between turning cylinders."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np

from autobalancer.flow.annulus import Annulus, Walls
from autobalancer.flow.annulus_problem import ShearFlow
from autobalancer.flow.ball_problem import ball_forces
from autobalancer.flow.finite_elements import Fineness, Shape, slow_flow, spaces
from autobalancer.laws.drag_coefficient import Sheared
from autobalancer.shear.power_law import PowerLaw
from reproductions import Found, compared_all

sys.path.insert(0, str(Path(__file__).parents[2] / "examples" / "races"))
from plot_sheared_drag import Gradients, sheared_flow

LEAST = {0.5: 1.476}  # by least dissipation, tests/test_sheared_drag.py
REST = 1e-6  # rate of shear U/r below which the viscosity is constant
FAR = 15.0  # radii to the walls


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Drag factors X, and the angular velocity in the middle of a gap."""
    rows = compared_all("own least dissipation", "drag factor X(n)", _spheres())
    return rows + compared_all("Bird, Armstrong and Hassager 1987", "tangential annular flow", [_cylinders(0.5)])


def _spheres() -> list[Found]:
    mesh = spaces(Shape(2 * FAR, 2 * FAR, FAR - 1.0, FAR, FAR), Fineness(0.23, 0.3, FAR / 3.0, 0.6))
    start, gradients = slow_flow(mesh, 0.0), Gradients(mesh)
    found = []
    for n, least in LEAST.items():
        flow = sheared_flow(start, gradients, lambda g, n=n: (np.maximum(g, REST) / REST) ** (n - 1.0))
        x = ball_forces(flow).along / (6.0 * math.pi) / (2.0 * REST) ** (1.0 - n)
        note = (
            f"walls {FAR:g} radii away add to the drag here; 1.42, quoted from memory for a table of Chhabra (2006), could not "
            "be checked against the book and is no target"
        )
        found.append(
            Found("internal", f"drag factor of a sphere in a power-law fluid, n = {n:g}", "1", least, x, 0.03, note)
        )
    return found


def _cylinders(n: float) -> Found:
    law = Sheared(PowerLaw(exponent=n, lowest=1e-6))
    flow = ShearFlow(Annulus(0.05, 0.1, 0.02, 0.075, 1e-4, 900.0, law), walls=Walls(inner=10.0))
    r, k = 0.075, -2.0 / n
    expected = 10.0 * (r**k - 0.1**k) / (0.05**k - 0.1**k)
    quantity = f"angular velocity in the middle between cylinders, the inner one turns with 10 rad/s, n = {n:g}"
    return Found("closed form", quantity, "rad/s", expected, float(flow.at_orbit(flow.steady())), 1e-3)
