"""The drag of a ball in a fluid whose viscosity depends on the rate of shear, and the one rate that stands for it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.files.given import balls_in_races
from autobalancer.flow.annulus import annulus_of
from autobalancer.flow.ball.channel import Channel, channel_of
from autobalancer.flow.ball.forces import ball_forces
from autobalancer.flow.ball.mesh import Fineness, Floats, expect
from autobalancer.flow.ball.question import MESH_GAP, Progress, fineness_of, mesh_gap_of, shape_of, share_of_rolling
from autobalancer.laws.drag_curve import STOKES
from autobalancer.laws.liquid.sheared_drag import Sheared
from autobalancer.machine import Machine
from autobalancer.patience import shows_progress
from autobalancer.results.answers.answer import Answer
from autobalancer.results.provenance import provenance
from autobalancer.shown import Column
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
    from autobalancer.flow.ball.sheared import Gradients, sheared_flow
    from autobalancer.flow.ball.slow import slow_flow
    from autobalancer.flow.ball.spaces import spaces

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
