"""The drag of a ball in a fluid whose viscosity depends on the rate of shear, and the one rate that stands for it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
import xarray as xr
from scipy.sparse.linalg import LinearOperator, minres

from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.files.machine_file import balls_in_races
from autobalancer.flow.annulus import annulus_of
from autobalancer.flow.ball_problem import (
    MESH_GAP,
    Channel,
    Progress,
    ball_forces,
    channel_of,
    fineness_of,
    mesh_gap_of,
    shape_of,
    share_of_rolling,
)
from autobalancer.flow.finite_elements import (
    Fineness,
    Floats,
    Flow,
    Spaces,
    Sparse,
    equations,
    expect,
    factors,
    unknowns,
)
from autobalancer.laws.drag_coefficient import STOKES, Sheared
from autobalancer.machine import Machine
from autobalancer.progress import shows_progress
from autobalancer.results.answers.answer import Answer
from autobalancer.results.provenance import provenance
from autobalancer.tables import Column
from autobalancer.units import list_argument


@shows_progress
def sheared_drag(
    machine: Machine | str | Path,
    velocities: Sequence[float | str] | str,
    *,
    mesh_gap: float = MESH_GAP,
    motion: str | float = "rolling",
    fineness: float = 1.0,
    balancer: int = 1,
    race: int = 1,
    progress: Progress | None = None,
) -> ShearedDrag:
    """Slow drag of a ball along its race in a fluid with a shear law, over that at rest, by finite elements.

    Inertia of the fluid is left out, and the flow that balls drive around a closed race. Only the gap of the mesh is known: a
    narrower film is sheared faster, and the theory that continues the drag of a constant viscosity does not hold in it.

    Parameters
    ----------
    machine
        A machine or the path of its file, whose race has width, height and a fluid with ``shear``; its ``at_ball`` is not used.
    velocities
        Of the ball along its walls, m/s; ascending.
    mesh_gap
        Between ball and outer wall, ball radii.
    motion
        ``"rolling"`` on the outer wall, ``"sliding"`` without turning, or the share of rolling.
    fineness
        2 halves all elements.
    balancer, race
        Counted from 1.
    progress
        Called with the number of flows solved and their count.

    Returns
    -------
    xarray.Dataset
        Over ``velocity``: ``share`` of the drag that a fluid with the viscosity at rest would have; ``rate_factor``, for which
        the law has this share at the rate of shear U/d times it (nan where the share is nearly 1 or the law does not reach it);
        ``reduced_share`` with the one factor ``attrs["at_ball"]`` that fits all velocities best, and its ``error``;
        ``first_order``, the mean of the law over the flow of constant viscosity weighted with the dissipation; ``reynolds`` with
        the viscosity of the share.

    Raises
    ------
    MachineError
        If the race lacks width, height or fluid, or the ball does not fit.
    QuestionError
        If the fluid has no shear law, a number is out of range, the mesh cannot resolve the gap, or gmsh or scikit-fem is not
        installed.
    """
    from autobalancer.flow.finite_elements import slow_flow, spaces

    machine = balls_in_races(machine)
    asked = _velocities(velocities)
    channel = replace(channel_of(machine, balancer, race), length_per_ball=math.inf)
    annulus = annulus_of(machine, balancer, race)
    if annulus.sheared is None:
        raise QuestionError(
            "sheared_drag: the fluid of the race has a constant viscosity; give it 'shear', or ask ball_drag"
        )
    law, radius, turn = annulus.sheared, channel.ball_radius, share_of_rolling(motion)
    shape = shape_of(channel, mesh_gap_of(mesh_gap, mesh_gap, channel), 0.0)
    sizes = Fineness(bulk=0.27 * min(shape.width, shape.height)).finer(fineness_of(fineness))
    expect(shape, sizes)
    report = progress or (lambda done, total: None)

    def drags(one: Fineness, speeds: Floats) -> tuple[Floats, Floats, int]:
        """Drag over mu r U without and with the law, and its means to first order."""
        mesh = spaces(shape, one)
        gradients = Gradients(mesh)
        flow = sheared_flow(slow_flow(mesh, turn * mesh.rolling), gradients, np.ones_like)
        rest = ball_forces(flow).drag(turn)
        rates = gradients.rate(gradients.strain(flow.deviation))
        weight = gradients.weight * rates**2
        found, mean = [], []
        for number, speed in enumerate(speeds):
            scale = speed / radius
            flow = sheared_flow(flow, gradients, partial(_at_scale, law, scale))
            found.append(ball_forces(flow).drag(turn) / rest)
            mean.append(float(weight @ law.share(scale * rates) / weight.sum()))
            report(number + 1.0, speeds.size + 1.0)
        return np.array(found), np.array(mean), int(mesh.velocity.mesh.nelements)

    coarse, _, _ = drags(sizes.finer(1.0 / 1.5), asked[-1:])
    share, mean, elements = drags(sizes, asked)
    reynolds = asked * channel.ball_diameter / (annulus.viscosity * share)
    if reynolds.max() > STOKES:
        warn(
            f"sheared_drag: the Reynolds number reaches {reynolds.max():.3g}, but inertia of the fluid is left out; up to about "
            f"{STOKES:g} it adds little",
            RangeWarning,
        )
    error = abs(float(coarse[0] / share[-1]) - 1.0)
    return labelled(machine, channel, law, (asked, share, mean, reynolds), shape.gap, error, elements)


def _at_scale(law: Sheared, scale: float, rates: Floats) -> Floats:
    return law.share(scale * rates)


def _velocities(given: Sequence[float | str] | str) -> Floats:
    found = np.atleast_1d(np.asarray(list_argument("velocities", given, "m/s"), float))
    if not found.size or not np.all(np.isfinite(found) & (found > 0.0)) or (np.diff(found) <= 0.0).any():
        raise QuestionError("velocities: give at least one in m/s; they must be above zero and ascend")
    return found


# The drag of a ball in a sheared fluid as a labelled dataset that shows itself.


FACTORS = np.geomspace(1e-3, 1e3, 3001)  # of the rate of shear U/d that are tried
NEAR = 1e-2  # difference of a share from 1 below which no rate follows from it
LABELS = {
    "velocity": ("velocity of the ball along its walls", "m/s"),
    "share": ("drag over that with the viscosity at rest", "1"),
    "rate_factor": ("rate of shear over velocity and diameter that has this share", "1"),
    "reduced_share": ("share at one effective rate of shear", "1"),
    "error": ("reduced drag over that by finite elements, less 1", "1"),
    "first_order": ("mean of the law over the flow of constant viscosity", "1"),
    "reynolds": ("Reynolds number", "1"),
}


class ShearedDrag(Answer):
    """Drag over that at rest, and how far one rate of shear stands for it."""

    __slots__ = ()
    drawn_by = "sheared_drag"
    row_of, needed = "velocity", ("share", "rate_factor", "error")

    def facts(self) -> Sequence[tuple[str, str]]:
        """What a machine file takes, and how good it is."""
        a = self.attrs
        return [
            ("at_ball", f"{a['at_ball']:.3g}; the drag by it is wrong by at most {100.0 * a['greatest_error']:.2g} % here"),
            ("mesh", f"{a['elements']} elements, gap of {a['mesh_gap']:.3g} ball radii; one 1.5 times coarser differs by "
                     f"{100.0 * a['mesh_error']:.2g} %"),
        ]  # fmt: skip

    def columns(self, unit: str = "") -> list[Column]:
        """A row for each velocity."""
        return [
            Column("velocity", self["velocity"].values, "m/s", ".4g"),
            Column("drag over that at rest", self["share"].values, form=".4g"),
            Column("rate factor", self["rate_factor"].values, form=".3g"),
            Column("with at_ball", self["reduced_share"].values, form=".4g"),
            Column("error", 100.0 * self["error"].values, "%", ".2g"),
            Column("to first order", self["first_order"].values, form=".4g"),
            Column("Re", self["reynolds"].values, form=".3g"),
        ]

    def remarks(self) -> Sequence[str]:
        """What is left out."""
        return (str(self.attrs["leaves_out"]),)


def labelled(
    machine: Machine,
    channel: Channel,
    law: Sheared,
    arrays: tuple[Floats, Floats, Floats, Floats],
    gap: float,
    mesh_error: float,
    elements: int,
) -> ShearedDrag:
    """Label what was solved, and fit the factor; ``arrays`` are velocities, shares, first order and Reynolds numbers."""
    velocity, share, mean, reynolds = arrays
    rate = velocity / channel.ball_diameter
    table = law.share(FACTORS[:, None] * rate)  # (factor, velocity)
    worst = np.abs(table / share - 1.0).max(axis=1)
    if np.abs(share - 1.0).max() < NEAR:
        raise QuestionError(
            f"sheared_drag: at these velocities the drag is that at rest ({share[-1]:.4g} of it at {velocity[-1]:g} m/s); ask "
            "for faster ones"
        )
    best = int(worst.argmin())
    data = {
        "share": share,
        "rate_factor": np.array([_factor(table[:, i], share[i]) for i in range(share.size)]),
        "reduced_share": table[best],
        "error": table[best] / share - 1.0,
        "first_order": mean,
        "reynolds": reynolds,
    }
    found = xr.Dataset({key: ("velocity", values) for key, values in data.items()}, {"velocity": velocity})
    for key in found.variables:
        text, unit = LABELS[str(key)]
        found[key].attrs = {"long_name": text, "units": unit}
    found.attrs = {
        "title": f"Drag of a ball, sheared fluid: {machine.name}",
        **provenance(),
        "machine_name": machine.name,
        "at_ball": float(FACTORS[best]),
        "greatest_error": float(worst[best]),
        "mesh_gap": gap,
        "mesh_error": mesh_error,
        "elements": elements,
        "ball_diameter": channel.ball_diameter,
        "leaves_out": "no inertia of the fluid, no flow around the closed race, no film narrower than the gap of the mesh",
    }
    return ShearedDrag.of(found)


def _factor(shares: Floats, share: float) -> float:
    """Where a law over the factors has a share; nan where that is not certain."""
    ascending = shares if shares[-1] > shares[0] else shares[::-1]
    if abs(share - 1.0) < NEAR or not ascending[0] < share < ascending[-1] or (np.diff(ascending) < 0.0).any():
        return float("nan")
    factors = FACTORS if shares[-1] > shares[0] else FACTORS[::-1]
    return float(np.exp(np.interp(share, ascending, np.log(factors))))


# Slow flow around a ball of a fluid whose viscosity depends on the rate of shear.
#
# div(2 n D) = grad p with D the symmetric gradient of the velocity and n = s(g U/r) at the rate of shear g = sqrt(2 D
# : D), in the units of the package. Newton's steps, shortened where they overshoot the least dissipation; each by
# MINRES with the equations of the components at the present viscosity and the mass matrix of the pressure over it as
# preconditioner.


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
    QuestionError
        If the steps do not converge.
    """
    spaces = start.spaces
    count = spaces.unknown.shape[1]
    given, found = spaces.balls_deviation(start.spin).ravel(), unknowns(start)
    state = _State.at(gradients, share, given, found)
    for number in range(MOST_STEPS):
        if number and state.size < SMALL * state.scale:
            velocity = (given + spaces.unknown @ found[:count]).reshape(3, -1)
            residual = (state.friction + spaces.divergence.T @ found[count:]).reshape(3, -1)
            return Flow(spaces, 0.0, start.spin, velocity, found[count:], residual, whole_stress=True)
        step, part = _step(state, given), 1.0
        falls = _State.at(gradients, share, given, found + step)
        slope, other = float(step[:count] @ state.rest[:count]), float(step[:count] @ falls.rest[:count])
        for _ in range(MOST_HALVINGS):  # the work of the step along itself vanishes where the dissipation is least
            if abs(other) <= FLAT * abs(slope) or other * slope > 0.0:
                break
            part *= slope / (slope - other)
            falls = _State.at(gradients, share, given, found + part * step)
            other = float(step[:count] @ falls.rest[:count])
        state, found = falls, found + part * step
    raise QuestionError(
        "sheared_drag: the flow did not converge; add velocities in between, or take a wider mesh_gap or a law that changes less"
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
    def at(cls, gradients: Gradients, share: Share, given: Floats, found: Floats) -> _State:
        """With the velocity of these unknowns."""
        spaces = gradients.spaces
        count = spaces.unknown.shape[1]
        velocity = given + spaces.unknown @ found[:count]
        strain = gradients.strain(velocity.reshape(3, -1))
        rate = np.maximum(gradients.rate(strain), REST)
        viscosity = share(rate)
        rising = 4.0 * (share(rate * (1.0 + STEEP)) - viscosity) / (STEEP * rate**2)
        stress = 2.0 * gradients.weight * viscosity * strain
        along = gradients.along
        friction = np.concatenate([sum(along[j].T @ stress[i, j] for j in range(3)) for i in range(3)])
        pushed = friction + spaces.divergence.T @ found[count:]
        rest = np.concatenate([-(spaces.unknown.T @ pushed), -(spaces.divergence @ velocity)])
        return cls(gradients, strain, rate, viscosity, rising, friction, rest)

    @property
    def size(self) -> float:
        """Of what is unbalanced."""
        return float(np.linalg.norm(self.rest))

    @property
    def scale(self) -> float:
        """Of the forces of the viscosity."""
        return float(np.linalg.norm(self.friction))


def _step(state: _State, given: Floats) -> Floats:
    spaces, gradients = state.gradients.spaces, state.gradients
    transport, one = gradients.stress(state.viscosity)
    matrix, _ = equations(spaces, transport + gradients.slope(state.strain, state.rising), given)
    parts = np.split(spaces.free, 3)
    solvers = [factors(one[part][:, part]) for part in (parts[0], parts[2])]
    over = sp.diags(gradients.weight / state.viscosity)
    pressures = factors((gradients.pressure.T @ over @ gradients.pressure).tocsr())
    ends = np.cumsum([int(part.sum()) for part in parts])

    def preconditioned(x: Floats) -> Floats:
        first, second, third, rest = np.split(x, ends)
        return np.concatenate([solvers[0](first), solvers[0](second), solvers[1](third), pressures(rest)])

    operator = LinearOperator(matrix.shape, preconditioned)
    found, _ = minres(matrix, state.rest, M=operator, rtol=ENOUGH, maxiter=MOST_INNER)
    return np.asarray(found)


def _at_gauss(values: Any, dofs: Any, count: int) -> Sparse:
    """Values of shape functions (function, element, gauss) as a matrix (gauss, unknown)."""
    number, elements, points = values.shape
    rows = np.broadcast_to(np.arange(elements * points).reshape(elements, points), values.shape)
    columns = np.broadcast_to(dofs[:, :, None], (number, elements, points))
    return sp.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=(elements * points, count))
