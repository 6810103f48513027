"""Drag of a ball in a sheared fluid by finite elements: exact properties, a variational solution, a sample."""

from __future__ import annotations

import math
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.flow.ball_problem import ball_forces
from autobalancer.flow.finite_elements import Fineness, Flow, Shape, slow_flow, spaces

pytest.importorskip("gmsh", exc_type=(ImportError, OSError))
pytest.importorskip("skfem")
sys.path.insert(0, str(Path(__file__).parents[1] / "examples" / "races"))
from plot_sheared_drag import Gradients, sheared_drag, sheared_flow

SMALL = Shape(2.24, 3.25, 0.1, 3.5, 3.5)
COARSE = Fineness(0.35, 0.4, 0.8, 0.8)


@cache
def start(shape: Shape = SMALL, fineness: Fineness = COARSE, share: float = 1.0) -> tuple[Flow, Gradients]:
    """The flow of constant viscosity."""
    mesh = spaces(shape, fineness)
    gradients = Gradients(mesh)
    return sheared_flow(slow_flow(mesh, share * mesh.rolling), gradients, np.ones_like), gradients


def drag(law: Any, shape: Shape = SMALL, fineness: Fineness = COARSE, share: float = 1.0) -> float:
    flow, gradients = start(shape, fineness, share)
    return ball_forces(sheared_flow(flow, gradients, law)).drag(share)


def power(n: float, scale: float = 1.0) -> Any:
    return lambda g: (scale * np.maximum(g, 1e-9)) ** (n - 1.0)


def test_a_constant_viscosity_multiplies_the_drag_whatever_form_the_stress_has() -> None:
    flow, _ = start()
    whole = ball_forces(flow).drag()
    assert drag(lambda g: np.full(g.shape, 3.0)) == pytest.approx(3.0 * whole, rel=1e-6)
    mesh = flow.spaces
    plain = ball_forces(slow_flow(mesh, mesh.rolling)).drag()
    assert whole == pytest.approx(
        plain, rel=0.04
    )  # both forms agree as the mesh becomes finer; this one is the coarsest


def test_the_drag_of_a_power_law_fluid_is_a_power_of_the_velocity() -> None:
    n = 1.5
    assert drag(power(n, 3.0)) / drag(power(n)) == pytest.approx(3.0 ** (n - 1.0), rel=1e-5)


def test_the_work_on_the_ball_is_dissipated_in_the_fluid() -> None:
    n = 0.5
    flow, gradients = start()
    sheared = sheared_flow(flow, gradients, power(n))
    rate = gradients.rate(gradients.strain(sheared.deviation))
    dissipated = 2.0 * float(gradients.weight @ (power(n)(rate) * rate**2))  # both halves
    forces = ball_forces(sheared)
    # against walls that pass with 1 a rolling ball does the work of force and torque
    assert forces.along + forces.torque == pytest.approx(dissipated, rel=1e-5)


def test_the_drag_is_the_mean_over_the_flow_at_rest_to_first_order_and_never_more() -> None:
    flow, gradients = start()
    rest = ball_forces(flow).drag()
    rate = gradients.rate(gradients.strain(flow.deviation))
    weight = gradients.weight * rate**2
    below = []
    for n in (0.9, 0.8):
        mean = float(weight @ power(n)(rate) / weight.sum())
        below.append(mean - drag(power(n)) / rest)
    assert below[0] > 0.0
    assert below[1] / below[0] == pytest.approx(4.0, rel=0.3)  # of second order in 1 - n


def variational(n: float, powers: int = 6, angles: int = 3) -> float:
    """X of a sphere far from walls: the least dissipation of stream functions sin^2 f(1/r) cos^(2l), K (rate)^(n+1) integrated.

    The stream function decays as r^(3 - 2/n), as that of a force in a power-law fluid does.
    """
    x, wx = np.polynomial.legendre.leggauss(60)
    c, wc = np.polynomial.legendre.leggauss(24)
    s = 0.5 * (x[:, None] + 1.0)
    c, r = c[None], 1.0 / s
    sine = np.sqrt(1.0 - c * c)
    weight = (math.pi * r**4 * wx[:, None] * wc[None]).ravel()

    def strain(terms: list[tuple[float, float]], angle: int) -> Any:
        g, g1, g2 = (
            sum(k * factor(a) * s ** (a + m) for k, a in terms)
            for m, factor in ((0, lambda a: 1.0), (1, lambda a: -a), (2, lambda a: a * (a + 1.0)))
        )
        q = c ** (2 * angle)
        dq = 2 * angle * c ** (2 * angle - 1) if angle else 0.0 * c
        ddq = 2 * angle * (2 * angle - 1) * c ** (2 * angle - 2) if angle else 0.0 * c
        h, dh = 2.0 * c * q - sine**2 * dq, 2.0 * q + 4.0 * c * dq - sine**2 * ddq
        radial = g * h / r**2
        rr = (g1 / r**2 - 2.0 * g / r**3) * h
        tt = -g1 / r**2 * (c * q - sine**2 * dq) + radial / r
        pp = radial / r - g1 * q * c / r**2
        rt = 0.5 * (-(g2 / r - g1 / r**2) * sine * q + g1 * sine * q / r**2 - g * dh * sine / r**3)
        return np.array([rr, tt, pp, math.sqrt(2.0) * rt]).reshape(4, -1)

    a = 2.0 / n - 3.0
    fixed = strain([(0.5 + (1.0 + 0.5 * a), a), (-(1.0 + 0.5 * a), a + 1.0)], 0)
    free = np.array(
        [strain([(1.0, a + k), (-2.0, a + k + 1), (1.0, a + k + 2)], m) for k in range(powers) for m in range(angles)]
    )
    found = np.zeros(len(free))
    for _ in range(30):  # Newton's steps on a convex function
        d = fixed + np.tensordot(found, free, 1)
        rate = np.sqrt(2.0 * (d**2).sum(0)) + 1e-30
        scale = weight * rate ** (n - 1.0)
        slope = np.einsum("cq,mcq->m", scale * d, free)
        along = np.einsum("cq,mcq->mq", d, free)
        second = np.einsum("mcq,kcq->mk", free * scale, free, optimize=True)
        second += (along * (2.0 * (n - 1.0) * scale / rate**2)) @ along.T
        found = found - np.linalg.lstsq(second, slope, rcond=1e-13)[0]
    d = fixed + np.tensordot(found, free, 1)
    dissipated = float(weight @ np.sqrt(2.0 * (d**2).sum(0)) ** (n + 1.0))
    return dissipated / (6.0 * math.pi) * 2.0 ** (n - 1.0)


def test_the_variational_solution_is_that_of_stokes_at_constant_viscosity() -> None:
    assert variational(1.0) == pytest.approx(1.0, rel=1e-9)


@pytest.mark.slow
def test_a_sphere_far_from_walls_in_a_thinning_fluid_has_the_drag_of_the_variational_solution() -> None:
    n, wall = 0.5, 0.02
    far = Shape(40.0, 40.0, 19.0, 20.0, 20.0)
    thin = 1e-6  # rate below which the viscosity is constant
    found = drag(lambda g: (np.maximum(g, thin) / thin) ** (n - 1.0), far, Fineness(0.22, 0.3, 20.0 / 3.0, 0.6), 0.0)
    x = found / (6.0 * math.pi) / (2.0 * thin) ** (1.0 - n)
    assert x == pytest.approx(variational(n), rel=wall)  # walls 20 radii away and elements of 0.22 radii add to it
    assert x > variational(n)


def test_one_rate_of_shear_stands_for_the_flow_of_the_sample() -> None:
    machine, velocity = ab.example("thinning_fluid"), np.array([0.01, 0.1])
    share, first_order, at_ball = sheared_drag(machine, velocity, gap=0.1, fineness=0.5)
    law = ab.machine.plugins.find(ab.machine.ShearLaw, "carreau")(time=0.02, exponent=0.6)
    assert law.share(at_ball * velocity / 0.009) == pytest.approx(share, rel=0.03)
    assert share[0] > share[1]
    assert (share < first_order).all()
