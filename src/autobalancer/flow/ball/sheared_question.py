"""The drag of a ball in a fluid whose viscosity depends on the rate of shear, and the one rate that stands for it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from autobalancer.errors import QuestionError, RangeWarning, warn
from autobalancer.files.given import balls_in_races
from autobalancer.flow.annulus import annulus_of
from autobalancer.flow.ball.channel import channel_of
from autobalancer.flow.ball.forces import ball_forces
from autobalancer.flow.ball.mesh import Fineness, Floats, expect
from autobalancer.flow.ball.question import MESH_GAP, Progress, fineness_of, mesh_gap_of, shape_of, share_of_rolling
from autobalancer.flow.ball.sheared_answer import ShearedDrag, labelled
from autobalancer.laws.drag_curve import STOKES
from autobalancer.laws.liquid.sheared_drag import Sheared
from autobalancer.machine import Machine
from autobalancer.patience import shows_progress
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
