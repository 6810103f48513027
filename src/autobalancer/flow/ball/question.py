"""The drag of one ball in its race."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.flow.ball.channel import Channel, channel_of
from autobalancer.flow.ball.forces import BallForces, ball_forces
from autobalancer.flow.ball.mesh import Fineness, Shape, expect
from autobalancer.flow.ball.result import Solved, drag_dataset
from autobalancer.machine import Machine
from autobalancer.patience import shows_progress
from autobalancer.units import argument, list_argument, optional_argument

Progress = Callable[[float, float], None]
MESH_GAP = 0.02
"""Gap in ball radii down to which a mesh is used; the theory of thin films is 0.5 % off there."""
CLOSEST = 1.03  # diameters from center to center
HIGHEST = 300.0  # Reynolds number; a free sphere sheds vortices from about 270 on


@shows_progress
def ball_drag(
    chamber: Channel | Machine | str | Path,
    reynolds: Sequence[float | str] | str = (0.0, 3.0, 10.0, 30.0, 100.0),
    *,
    gap: float | str,
    motion: str | float = "rolling",
    ball_ahead: float | str | None = None,
    mesh_gap: float | None = None,
    fineness: float = 1.0,
    balancer: int = 1,
    race: int = 1,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Drag of a ball that moves along its race, from the equations of the fluid by finite elements.

    The flow is steady in the frame of the ball and symmetric to mid-height; the walls and the fluid far away move with one
    speed, except for the flow that balls drive around a closed race. The ball keeps its place in space: forces of Coriolis, which
    a fast orbit adds, are left out.

    Parameters
    ----------
    chamber
        A channel, or a machine or the path of its file, of which ``balancer`` and ``race`` (from 1) are taken.
    reynolds
        Reynolds numbers, speed of the ball along the walls times its diameter over the kinematic viscosity; ascending, from 0
        (no inertia of the fluid) to 300; or a range such as ``"10:100:4"``.
    gap
        Between ball and outer wall, m: what their roughness leaves, such as ``"1 um"``. The drag grows with the logarithm of its
        inverse.
    motion
        ``"rolling"`` on the outer wall, ``"sliding"`` without turning, or the share of rolling.
    ball_ahead
        Distance of an equal ball ahead along the orbit, from center to center, m; it moves at the same speed. Without it the ball
        is alone between the next ones of its closed race.
    mesh_gap
        Gap of the mesh in ball radii, by default 0.02 or ``gap`` if that is wider. Narrower gaps follow by the theory of thin
        films.
    fineness
        2 halves all elements. The dataset says how much the drag differs with a coarser mesh.
    progress
        Called with the number of flows solved and their count.

    Returns
    -------
    xarray.Dataset
        Over ``reynolds``: ``drag_coefficient`` and ``cd_re`` of what has to push the ball, with a ball ahead also its
        ``cd_re_ahead``; ``force``, ``torque`` and ``lift`` of the fluid, ``through_flow``; over ``(x, y)`` the
        velocity in the plane of the ball centers, at the last Reynolds number. ``attrs["drag"]`` is the law as lines of a machine
        file.

    Raises
    ------
    MachineError
        If the race lacks width or height, or the ball does not fit.
    QuestionError
        If a number is out of range, the mesh cannot resolve the gap, no steady flow is found, or gmsh or scikit-fem is not
        installed.
    """
    from autobalancer.flow.ball.inertia import flow_with_inertia
    from autobalancer.flow.ball.slow import slow_flow
    from autobalancer.flow.ball.spaces import spaces

    channel, name = _channel(chamber, balancer, race)
    numbers, share = _reynolds(reynolds), share_of_rolling(motion)
    narrow = argument("gap", gap, "m") / channel.ball_radius
    second = _second(optional_argument("ball_ahead", ball_ahead, "m"), channel)
    shape = shape_of(channel, mesh_gap_of(narrow, mesh_gap, channel), numbers[-1], second)
    sizes = Fineness(bulk=0.27 * min(shape.width, shape.height)).finer(fineness_of(fineness))
    expect(shape, sizes)
    report = progress or (lambda done, total: None)
    total = len(numbers) + 1.0
    coarse = spaces(shape, sizes.finer(1.0 / 1.5))
    check = ball_forces(slow_flow(coarse, share * coarse.rolling))
    report(1.0, total)
    fine = spaces(shape, sizes)
    flow = slow_flow(fine, share * fine.rolling)
    slow, flows = ball_forces(flow), []
    others: list[BallForces] = []
    for done, number in enumerate(numbers):
        flow = flow_with_inertia(flow, number) if number > 0.0 else flow
        flows.append((ball_forces(flow), flow.through))
        others += [] if math.isnan(second) else [ball_forces(flow, 1)]
        report(done + 2.0, total)
    error = abs(check.drag(share) / slow.drag(share) - 1.0)
    return drag_dataset(channel, name, Solved(numbers, flows, flow, share, min(narrow, shape.gap), error, others))


def shape_of(channel: Channel, gap: float, reynolds: float, second: float = math.nan) -> Shape:
    """The channel in ball radii, long enough for the wake; ``second`` is the distance of a ball ahead, or nan."""
    radius = channel.ball_radius
    width, height = channel.width / radius, channel.height / radius
    alone = 1.0 + 1.8 * max(width, height)
    balls, more = (1, 0.0) if math.isnan(second) else (2, second)
    behind = alone + 0.5 * reynolds / (math.pi**2 * (width**-2 + height**-2))
    cell = balls * channel.length_per_ball / radius
    free = min(cell, 0.9 * 2.0 * math.pi * channel.orbit_radius / radius) - more
    if free < 3.0:
        raise QuestionError(
            f"ball_ahead: given {1e3 * second * radius:.4g} mm, which leaves no room for the next ball on an orbit of "
            f"{1e3 * cell * radius:.4g} mm for both; must be shorter"
        )
    ahead = min(alone, 0.5 * free)
    behind = min(behind, free - ahead)
    rest = cell - ahead - behind - more
    return Shape(width, height, gap, ahead + more, behind, channel.orbit_radius / radius, second, rest)


def _second(distance: float | None, channel: Channel) -> float:
    if distance is None:
        return math.nan
    if not (math.isfinite(distance) and distance >= CLOSEST * channel.ball_diameter):
        raise QuestionError(
            f"ball_ahead: given {1e3 * distance:.4g} mm from center to center; must be at least {CLOSEST:g} diameters, "
            f"{1e3 * CLOSEST * channel.ball_diameter:.4g} mm, because the film between balls must be resolved"
        )
    return distance / channel.ball_radius


def _channel(chamber: Channel | Machine | str | Path, balancer: int, race: int) -> tuple[Channel, str]:
    if isinstance(chamber, Channel):
        return chamber, "a channel"
    machine = balls_in_races(chamber)
    return channel_of(machine, balancer, race), machine.name


def _reynolds(given: Sequence[float | str] | str) -> list[float]:
    numbers = list_argument("reynolds", given, "")
    if not numbers or not all(0.0 <= number <= HIGHEST for number in numbers) or (np.diff(numbers) <= 0.0).any():
        raise QuestionError(
            f"reynolds: given {', '.join(f'{n:g}' for n in numbers) or 'nothing'}; must be ascending numbers from 0 to "
            f"{HIGHEST:g}, because faster flow is not steady"
        )
    return numbers


def share_of_rolling(motion: str | float) -> float:
    """Share of rolling that a word or a number means."""
    known = {"rolling": 1.0, "sliding": 0.0}
    if isinstance(motion, str) and motion not in known:
        raise QuestionError(
            f"motion: given {motion!r}; must be 'rolling', 'sliding' or the share of rolling, such as 0.5"
        )
    share = known[motion] if isinstance(motion, str) else float(motion)
    if not math.isfinite(share):
        raise QuestionError(f"motion: given {share:g}; must be a finite share of rolling, 1 if the ball does not slip")
    return share


def fineness_of(given: float) -> float:
    """Refuse a fineness that no mesh has."""
    if not 0.5 <= given <= 4.0:
        raise QuestionError(f"fineness: given {given:g}; must be between 0.5 and 4")
    return float(given)


def mesh_gap_of(narrow: float, mesh_gap: float | None, channel: Channel) -> float:
    """The gap of the mesh, ball radii, for a ``narrow`` gap between ball and wall."""
    room = channel.width / channel.ball_radius - 2.0
    if not 0.0 < narrow < room:
        raise QuestionError(
            f"gap: given {1e3 * narrow * channel.ball_radius:.4g} mm; must be positive, and smaller than the play of the ball "
            f"between the walls, {1e3 * room * channel.ball_radius:.4g} mm"
        )
    found = max(narrow, min(MESH_GAP, 0.5 * room)) if mesh_gap is None else float(mesh_gap)
    if not (math.isfinite(found) and narrow <= found * (1.0 + 1e-9) and found < room):
        raise QuestionError(
            f"mesh_gap: given {found:g} ball radii; must be at least the gap, {narrow:.3g}, and less than the play, {room:.3g}"
        )
    return found
