"""Colors and legend entries of the balls of a run, names of balancers and planes: the same in every picture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.colors import to_hex, to_rgb

from autobalancer.plots.drawing.style import BALLS, ball_color
from autobalancer.results.drawn.motion import Floats, bodies_of

FEW = len(BALLS)  # so many balls have a color of their own


class BallLook(NamedTuple):
    """How one ball is drawn; label "_" hides an entry of the legend."""

    color: str
    label: str


def ball_looks(run: xr.Dataset) -> list[BallLook]:
    """A color for each of few balls; of more, one for each race, in shades from its first ball to its last."""
    count = run.sizes.get("ball", 0)
    if count <= FEW:
        return [BallLook(ball_color(i), f"{body} {i + 1}") for i, body in enumerate(bodies_of(run))]
    places = list(zip(_column(run, "balancer", count), _column(run, "race", count), strict=True))
    groups = sorted(set(places))
    looks = [BallLook("", "_")] * count
    for number, place in enumerate(groups):
        members = [i for i, where in enumerate(places) if where == place]
        for shade, i in zip(np.linspace(-0.4, 0.4, len(members)), members, strict=True):
            looks[i] = BallLook(shaded(ball_color(number), float(shade)), "_")
        middle = members[len(members) // 2]
        name = group_name(run, place, groups)
        body = bodies_of(run)[members[0]] if len(set(bodies_of(run)[members])) == 1 else "ball"
        first, last = members[0] + 1, members[-1] + 1
        text = f"{body}s {first} to {last}" if len(members) > 1 else f"{body} {first}"
        looks[middle] = looks[middle]._replace(label=f"{text}, {name}" if name else text)
    return looks


def group_name(run: xr.Dataset, place: tuple[int, int], groups: list[tuple[int, int]]) -> str:
    """What tells a race (its balancer and number, from 1) from the others: the name of its balancer, its number, or both."""
    parts = []
    if len({balancer for balancer, _ in groups}) > 1:
        parts.append(balancer_name(run, place[0]))
    if sum(balancer == place[0] for balancer, _ in groups) > 1:
        parts.append(f"race {place[1]}")
    return ", ".join(parts)


def balancer_name(run: xr.Dataset, number: int) -> str:
    """The name of a balancer, counted from 1; its number if the run knows no names."""
    if "balancer_name" in run and "balancer" in run:
        held = run["balancer_name"].values[run["balancer"].values == number]
        if held.size:
            return str(held[0])
    return f"balancer {number}"


class Planes(NamedTuple):
    """The planes of the balancers; a rotor that only moves sideways has one."""

    names: tuple[str, ...]  # of the balancers in each
    position: Floats  # m along the axis; nan if not known


def planes_of(run: xr.Dataset) -> Planes:
    """The planes of a run."""
    count = run.sizes.get("plane", 1)
    if "ball_plane" not in run or (count == 1 and "station" not in run):
        return Planes(("rotor",), np.array([np.nan]))
    where, held = run["ball_plane"].values, _column(run, "balancer", run.sizes["ball"])
    names = []
    for plane in range(1, count + 1):
        balancers = sorted({number for number, place in zip(held, where, strict=True) if place == plane})
        names.append(" and ".join(balancer_name(run, number) for number in balancers) or f"plane {plane}")
    position = run["plane_position"].values if "plane_position" in run else np.full(count, np.nan)
    return Planes(tuple(names), np.asarray(position, np.float64))


def shaded(color: str, share: float) -> str:
    """A color lighter (towards 1: white) or darker (towards -1: black)."""
    rgb = np.array(to_rgb(color))
    red, green, blue = (rgb + (1.0 - rgb) * share if share > 0.0 else rgb * (1.0 + share)).tolist()
    return str(to_hex((red, green, blue)))


def _column(run: xr.Dataset, name: str, count: int) -> list[int]:
    return [int(value) for value in run[name].values] if name in run else [1] * count
