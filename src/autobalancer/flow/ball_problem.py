"""The drag of one ball in its race."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import LinearNDInterpolator

from autobalancer.arrays import Floats
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import balls_in_races
from autobalancer.flow.annulus import walls_of
from autobalancer.flow.finite_elements import Fineness, Flow, Shape, expect
from autobalancer.laws.impacts import film_slopes
from autobalancer.machine import Machine
from autobalancer.progress import Progress, shows_progress
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.units import argument, field_arguments, list_argument, optional_argument

# Force and torque of the fluid on a ball, from the forces that hold its nodes.


class BallForces(NamedTuple):
    """On a whole ball: ``along`` the race against its motion and ``lift`` away from the outer wall over mu r U, ``torque``
    against rolling over mu r^2 U."""

    along: float
    lift: float
    torque: float

    def drag(self, share: float = 1.0) -> float:
        """What has to push a ball that turns with a ``share`` of rolling: force and torque over the radius work together."""
        return self.along + share * self.torque


def ball_forces(flow: Flow, ball: int = 0) -> BallForces:
    """Of the ball with this number, 0 for the one at the origin.

    The equations use mu grad u for the stress; its transpose adds no force, and to a sphere that turns relative to the walls
    with s the torque -8 pi/3 s.
    """
    spaces = flow.spaces
    on, (x, y) = spaces.on_ball(ball), spaces.shape.centers()[ball]
    force = -2.0 * flow.residual[:, on]
    arm = spaces.nodes[:2, on] - np.array([[x], [y]])
    turning = flow.spin - spaces.shape.turning
    added = 0.0 if flow.whole_stress else -8.0 * math.pi / 3.0 * turning
    torque = float(np.sum(arm[0] * force[1] - arm[1] * force[0])) + added
    # the second ball stands at another angle of the race
    orbit = spaces.shape.orbit
    tangent = np.array([1.0, 0.0]) if math.isinf(orbit) else np.array([orbit - y, x]) / orbit
    along, inward = tangent @ force[:2].sum(axis=1), np.array([-tangent[1], tangent[0]]) @ force[:2].sum(axis=1)
    return BallForces(-float(along), float(inward), torque)


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
    balancer, race
        Counted from 1.
    progress
        Called with the number of flows solved and their count.

    Returns
    -------
    xarray.Dataset
        Over ``reynolds``: ``drag_coefficient`` and ``cd_times_re`` of what has to push the ball, with a ball ahead also its
        ``cd_times_re_ahead``; ``force``, ``torque`` and ``lift`` of the fluid, ``through_flow``; over ``(x, y)`` the
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
    from autobalancer.flow.finite_elements import flow_with_inertia, slow_flow, spaces

    channel, name = _channel(chamber, balancer, race)
    numbers, share = _reynolds(reynolds), share_of_rolling(motion)
    narrow = argument("gap", gap, "m") / channel.ball_radius
    second = _second(optional_argument("ball_ahead", ball_ahead, "m"), channel)
    shape = shape_of(channel, mesh_gap_of(narrow, mesh_gap, channel), numbers[-1], second)
    if not 0.5 <= fineness <= 4.0:
        raise QuestionError(f"fineness: given {fineness:g}; must be between 0.5 and 4")
    sizes = Fineness(bulk=0.27 * min(shape.width, shape.height)).finer(float(fineness))
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


def _reynolds(values: Sequence[float | str] | str) -> list[float]:
    numbers = list_argument("reynolds", values, "")
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


def mesh_gap_of(narrow: float, mesh_gap: float | None, channel: Channel) -> float:
    """The gap of the mesh, ball radii, for a ``narrow`` gap between ball and wall."""
    room = channel.width / channel.ball_radius - 2.0
    if not 0.0 < narrow < room:
        raise QuestionError(
            f"gap: given {1e3 * narrow * channel.ball_radius:.4g} mm; must be positive, and smaller than the play of the ball "
            f"between the walls, {1e3 * room * channel.ball_radius:.4g} mm"
        )
    gap = max(narrow, min(MESH_GAP, 0.5 * room)) if mesh_gap is None else float(mesh_gap)
    if not (math.isfinite(gap) and narrow <= gap * (1.0 + 1e-9) and gap < room):
        raise QuestionError(
            f"mesh_gap: given {gap:g} ball radii; must be at least the gap, {narrow:.3g}, and less than the play, {room:.3g}"
        )
    return gap


# The drag of a ball as a labelled dataset.


LABELS = {
    "reynolds": ("Reynolds number of the ball", "1"),
    "drag_coefficient": ("drag coefficient", "1"),
    "cd_times_re": ("drag coefficient times Reynolds number", "1"),
    "cd_times_re_of_mesh": ("drag coefficient times Reynolds number at the gap of the mesh", "1"),
    "cd_times_re_ahead": ("drag coefficient times Reynolds number of the ball ahead", "1"),
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
    # how force and torque grow as the gap closes; the ball turns with a share of rolling
    speed = -shape.outer / shape.orbit if math.isfinite(shape.orbit) else -1.0
    slopes = film_slopes(share * speed, speed, shape.outer)
    film = math.log(shape.gap / solved.gap)
    numbers = np.array(solved.numbers)
    along, lift, torque = (np.array([getattr(f, key) for f, _ in solved.flows]) for key in BallForces._fields)
    force, turned = along - slopes.force * film, torque + slopes.torque * film
    cd_times_re, of_mesh = (4.0 / math.pi * (f + share * t) for f, t in ((force, turned), (along, torque)))
    x, y, velocity = plane(solved.last)
    with np.errstate(divide="ignore"):
        coefficient = cd_times_re / numbers
    over = {
        "drag_coefficient": coefficient,
        "cd_times_re": cd_times_re,
        "cd_times_re_of_mesh": of_mesh,
        "force": force,
        "torque": turned,
        "lift": lift,
        "through_flow": np.array([through for _, through in solved.flows]),
    }
    if solved.others:
        added = share * slopes.torque * film - slopes.force * film
        over["cd_times_re_ahead"] = np.array([4.0 / math.pi * (f.drag(share) + added) for f in solved.others])
    data = {key: ("reynolds", values) for key, values in over.items()}
    fields = {f"velocity_{key}": (("x", "y"), part) for key, part in zip("xy", velocity, strict=True)}
    radius = channel.ball_radius
    dataset = xr.Dataset(data | fields, {"reynolds": numbers, "x": radius * x, "y": radius * y})
    for key in dataset.variables:
        text, unit = LABELS[str(key)]
        dataset[key].attrs = {"long_name": text, "units": unit}
    dataset.attrs = {
        "title": f"Drag of a ball in {name}",
        **provenance(),
        "machine_name": name,
        "rolling_share": share,
        "gap": solved.gap * radius,
        "mesh_gap": shape.gap,
        "cd_times_re_per_decade": 4.0 / math.pi * math.log(10.0) * (share * slopes.torque - slopes.force),
        "mesh_error": solved.error,
        "ball_ahead": shape.second * radius,
        "elements": int(solved.last.spaces.velocity.mesh.nelements),
        "drag": drag_lines(numbers, cd_times_re),
        **asdict(channel),
    }
    return Labeled.of(dataset)


def drag_lines(numbers: Floats, cd_times_re: Floats) -> str:
    """The law as lines of a race in a machine file; where c_d Re falls by an error of the mesh, it is kept."""
    moving = numbers > 0.0
    first = [] if moving.all() else [min([STOKES_END, *(numbers[moving] / 3.0)])]
    points = np.concatenate([first, numbers[moving]])
    kept = np.maximum.accumulate(cd_times_re)
    if points.size == 1:
        return f'drag = {{ law = "cd_times_re", cd_times_re = {kept[0]:.4g} }}'
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
    field = np.moveaxis(LinearNDInterpolator(nodes[:2, on].T, velocity.T)(*grid), -1, 0)
    depth = shape.depth(*grid)
    out = np.maximum(-depth, depth - shape.width)
    field[0] = np.where(
        out > 0.0, -1.0 - shape.turning * grid[1], field[0]
    )  # a strip of the walls, so that pictures reach them
    field[1] = np.where(out > 0.0, shape.turning * grid[0], field[1])
    outside = out > STEP
    for a, b in shape.centers():
        outside |= np.hypot(grid[0] - a, grid[1] - b) < 1.0 - STEP
    field[:, outside] = np.nan
    return x, y, field


# The race as a ball sees it: a channel, straight or bent, with the ball near its outer wall.


@dataclass(frozen=True)
class Channel:
    """A race of rectangular cross-section, seen from one of its balls.

    Parameters
    ----------
    ball_diameter
        m.
    width, height
        Of the cross-section: radially and along the axis, m.
    orbit_radius
        Of the ball centers, m; infinite if the channel is straight.
    length_per_ball
        Of the orbit, m. Balls push the fluid around a closed race, the less the longer it is for each of them; infinite if the
        fluid far away moves with the walls.

    Raises
    ------
    MachineError
        If the ball does not fit into the cross-section, or the orbit into the machine.
    """

    ball_diameter: float
    width: float
    height: float
    orbit_radius: float = math.inf
    length_per_ball: float = math.inf

    def __post_init__(self) -> None:
        field_arguments(self, ball_diameter="m", width="m", height="m", orbit_radius="m", length_per_ball="m")
        if not (self.ball_diameter > 0.0 and math.isfinite(self.ball_diameter)):
            raise MachineError(f"channel: given a ball diameter of {self.ball_diameter:g} m; must be positive")
        for name in ("width", "height"):
            length = getattr(self, name)
            if not (length > self.ball_diameter and math.isfinite(length)):
                raise MachineError(
                    f"channel: given a {name} of {1e3 * length:.4g} mm for a ball of {1e3 * self.ball_diameter:.4g} mm; "
                    "must be larger than the ball and finite"
                )
        if not self.orbit_radius + 0.5 * self.ball_diameter > self.width:
            raise MachineError(
                f"channel: given an orbit radius of {1e3 * self.orbit_radius:.4g} mm and a width of "
                f"{1e3 * self.width:.4g} mm, so the inner wall has no radius left; take a narrower race"
            )

        whole, length = 2.0 * math.pi * self.orbit_radius * (1.0 + 1e-9), self.length_per_ball
        if not self.ball_diameter < length or whole < length < math.inf:
            raise MachineError(
                f"channel: given {1e3 * self.length_per_ball:.4g} mm of orbit for each ball; must be more than its diameter, and "
                "at most the whole orbit, or infinite"
            )

    @property
    def ball_radius(self) -> float:
        """m."""
        return 0.5 * self.ball_diameter


def channel_of(machine: Machine, balancer: int = 1, race: int = 1) -> Channel:
    """The ``race`` of a ``balancer`` of ``machine``, counted from 1, as its largest ball sees it, all balls spread evenly."""
    walls = walls_of(machine, balancer, race)
    count = sum(group.count for group in machine.balancers[balancer - 1].races[race - 1].balls)
    length = 2.0 * math.pi * walls.orbit_radius / count
    return Channel(walls.ball_diameter, walls.outer - walls.inner, walls.height, walls.orbit_radius, length)
