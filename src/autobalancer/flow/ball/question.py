"""The drag of one ball in its race."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from scipy.interpolate import LinearNDInterpolator

from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.flow.ball.channel import Channel, channel_of
from autobalancer.flow.ball.forces import BallForces, ball_forces
from autobalancer.flow.ball.mesh import Fineness, Floats, Shape, expect
from autobalancer.flow.ball.slow import Flow
from autobalancer.laws.lubrication import FilmSlopes, film_slopes
from autobalancer.machine import Machine
from autobalancer.patience import shows_progress
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance
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


# The drag of a ball as a labelled dataset.


LABELS = {
    "reynolds": ("Reynolds number of the ball", "1"),
    "drag_coefficient": ("drag coefficient", "1"),
    "cd_re": ("drag coefficient times Reynolds number", "1"),
    "cd_re_of_mesh": ("drag coefficient times Reynolds number at the gap of the mesh", "1"),
    "cd_re_ahead": ("drag coefficient times Reynolds number of the ball ahead", "1"),
    "force": ("force of the fluid against the motion over mu r U", "1"),
    "torque": ("torque of the fluid against rolling over mu r^2 U", "1"),
    "lift": ("force of the fluid away from the outer wall over mu r U", "1"),
    "through_flow": ("mean velocity around the closed race relative to its walls over that of the ball", "1"),
    "x": ("distance ahead of the ball center", "m"),
    "y": ("distance from the ball center inward", "m"),
    "velocity_x": ("velocity along x relative to the ball over its speed", "1"),
    "velocity_y": ("velocity along y relative to the ball over its speed", "1"),
}
STOKES_END = 1.0  # Reynolds number up to which inertia adds less than 0.1 % to the drag in a race


@dataclass(frozen=True)
class Solved:
    """Flows at the Reynolds ``numbers``: forces and flow through the race, the ``last`` of them entire; ``share`` of rolling,
    ``gap`` in ball radii, ``error`` of the mesh over the drag; ``others`` are the forces on a ball ahead."""

    numbers: list[float]
    flows: list[tuple[BallForces, float]]
    last: Flow
    share: float
    gap: float
    error: float
    others: list[BallForces]


def drag_dataset(channel: Channel, name: str, solved: Solved) -> xr.Dataset:
    """Label what was solved, and continue it from the gap of the mesh to the narrow one."""
    shape, share = solved.last.spaces.shape, solved.share
    slopes = slopes_of(shape, share)
    film = math.log(shape.gap / solved.gap)
    numbers = np.array(solved.numbers)
    along, lift, torque = (np.array([getattr(f, key) for f, _ in solved.flows]) for key in BallForces._fields)
    force, turned = along - slopes.force * film, torque + slopes.torque * film
    cd_re, of_mesh = (4.0 / math.pi * (f + share * t) for f, t in ((force, turned), (along, torque)))
    x, y, velocity = plane(solved.last)
    with np.errstate(divide="ignore"):
        coefficient = cd_re / numbers
    over = {
        "drag_coefficient": coefficient,
        "cd_re": cd_re,
        "cd_re_of_mesh": of_mesh,
        "force": force,
        "torque": turned,
        "lift": lift,
        "through_flow": np.array([through for _, through in solved.flows]),
    }
    if solved.others:
        added = share * slopes.torque * film - slopes.force * film
        over["cd_re_ahead"] = np.array([4.0 / math.pi * (f.drag(share) + added) for f in solved.others])
    data = {key: ("reynolds", values) for key, values in over.items()}
    fields = {f"velocity_{key}": (("x", "y"), part) for key, part in zip("xy", velocity, strict=True)}
    radius = channel.ball_radius
    found = xr.Dataset(data | fields, {"reynolds": numbers, "x": radius * x, "y": radius * y})
    for key in found.variables:
        text, unit = LABELS[str(key)]
        found[key].attrs = {"long_name": text, "units": unit}
    found.attrs = {
        "title": f"Drag of a ball in {name}",
        **provenance(),
        "machine_name": name,
        "rolling_share": share,
        "gap": solved.gap * radius,
        "mesh_gap": shape.gap,
        "cd_re_per_decade": 4.0 / math.pi * math.log(10.0) * (share * slopes.torque - slopes.force),
        "mesh_error": solved.error,
        "ball_ahead": shape.second * radius,
        "elements": int(solved.last.spaces.velocity.mesh.nelements),
        "drag": drag_lines(numbers, cd_re),
        **asdict(channel),
    }
    return Labeled.of(found)


def slopes_of(shape: Shape, share: float) -> FilmSlopes:
    """How force and torque grow as the gap closes; the ball turns with a ``share`` of rolling."""
    speed = -shape.outer / shape.orbit if math.isfinite(shape.orbit) else -1.0
    return film_slopes(share * speed, speed, shape.outer)


def drag_lines(numbers: Floats, cd_re: Floats) -> str:
    """The law as lines of a race in a machine file; where c_d Re falls by an error of the mesh, it is kept."""
    moving = numbers > 0.0
    first = [] if moving.all() else [min([STOKES_END, *(numbers[moving] / 3.0)])]
    points = np.concatenate([first, numbers[moving]])
    kept = np.maximum.accumulate(cd_re)
    if points.size == 1:
        return f'drag = {{ law = "cd_re", cd_re = {kept[0]:.4g} }}'
    rows = {"reynolds": points, "coefficient": kept / points}
    lines = [f"drag.{key} = [{', '.join(f'{value:.4g}' for value in values)}]" for key, values in rows.items()]
    return "\n".join(['drag.law = "table"', *lines])


# Velocities in the plane of the ball centers on a regular grid, for pictures.


REACH = 4.0  # ball radii to both sides
STEP = 0.04


def plane(flow: Flow) -> tuple[Floats, Floats, Floats]:
    """x, y and the velocity relative to the ball, (2, x, y), in ball radii and its speed; nan in balls and walls, but
    for a strip at their surface."""
    spaces = flow.spaces
    shape, nodes = spaces.shape, spaces.nodes
    on = np.abs(nodes[2]) < 1e-9
    low, high = max(-shape.behind, -REACH), min(shape.ahead, REACH + np.nan_to_num(shape.second))
    seen = nodes[1, on & (nodes[0] > low) & (nodes[0] < high)]
    x, y = (np.linspace(a, b, math.ceil((b - a) / STEP) + 1) for a, b in ((low, high), (seen.min(), seen.max())))
    grid = np.meshgrid(x, y, indexing="ij")
    velocity = (flow.deviation + spaces.walls_velocity())[:2, on]
    found = np.moveaxis(LinearNDInterpolator(nodes[:2, on].T, velocity.T)(*grid), -1, 0)
    depth = shape.depth(*grid)
    out = np.maximum(-depth, depth - shape.width)
    found[0] = np.where(
        out > 0.0, -1.0 - shape.turning * grid[1], found[0]
    )  # a strip of the walls, so that pictures reach them
    found[1] = np.where(out > 0.0, shape.turning * grid[0], found[1])
    outside = out > STEP
    for a, b in shape.centers():
        outside |= np.hypot(grid[0] - a, grid[1] - b) < 1.0 - STEP
    found[:, outside] = np.nan
    return x, y, found
