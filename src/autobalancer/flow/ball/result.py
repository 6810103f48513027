"""The drag of a ball as a labelled dataset."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
import xarray as xr

from autobalancer.flow.ball.channel import Channel
from autobalancer.flow.ball.forces import BallForces
from autobalancer.flow.ball.mesh import Floats, Shape
from autobalancer.flow.ball.plane import plane
from autobalancer.flow.ball.slow import Flow
from autobalancer.laws.lubrication import FilmSlopes, film_slopes
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance

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
