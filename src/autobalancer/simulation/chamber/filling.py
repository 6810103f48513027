"""Balls put into their chambers, as many as fit."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.distance import cdist

from autobalancer.errors import MachineError
from autobalancer.machine.chamber import Chamber, ChamberMachine, FreeBalls
from autobalancer.random_numbers import generator
from autobalancer.simulation.chamber.bounds import AIR, filling_sites

Array = Any


def fill(machine: ChamberMachine, seed: int = 0) -> tuple[Array, bool]:
    """Start positions of all balls, (n, 3) from the middles of their chambers, and whether they need to settle.

    Raises
    ------
    MachineError
        If they do not fit (with the largest number that does), or given ones overlap or stand in a wall.
    """
    random = generator(seed)
    down = _down(machine)
    fill: list[Array] = []
    settle = False
    for number, chamber in enumerate(machine.chambers, 1):
        groups = chamber.balls
        given = [group for group in groups if group.positions is not None]
        if given and len(given) < len(groups):
            raise MachineError(f"chambers[{number}]: give the positions of all balls in a chamber, or of none")
        sizes = together([sizes_of(group, group.count) for group in groups])
        if given:
            places = np.vstack([np.asarray(group.positions, np.float64) for group in groups])
            _apart(places, sizes, chamber, number)
        else:
            settle = True
            places = _loosened(_sites(chamber, number, down, random), sizes, chamber, random)
        fill.append(places)
    return np.vstack(fill), settle


def _sites(chamber: Chamber, number: int, down: Array, random: np.random.Generator) -> Array:
    """A place for each ball: all mixed on a grid as wide as the largest asks for, else size by size, the largest lowest."""
    groups = chamber.balls
    largest, widest = max(group.radius for group in groups), max(group.half_width for group in groups)
    grid = _packing(chamber, largest, widest, down)
    wanted = sum(group.count for group in groups)
    if wanted <= len(grid):
        chosen = _lowest(grid, down, largest)[:wanted]
        return chosen[random.permutation(wanted)] if len(groups) > 1 else chosen
    placed, sizes = np.zeros((0, 3)), sizes_of(groups[0], 0)
    sites: dict[int, Array] = {}
    for k in sorted(range(len(groups)), key=lambda k: -groups[k].radius):
        group, count = groups[k], groups[k].count
        free = _packing(chamber, group.radius, group.half_width, down)
        if len(placed):
            free = free[(gaps(free, sizes_of(group, len(free)), placed, sizes, AIR) >= 0.0).all(axis=1)]
        if count > len(free):
            raise MachineError(_no_room(chamber, number, k, max(len(free), len(grid) - wanted + count)))
        sites[k] = _lowest(free, down, group.radius)[:count]
        placed, sizes = np.vstack([placed, sites[k]]), together([sizes, sizes_of(group, count)])
    return np.vstack([sites[k] for k in range(len(groups))])


def _packing(chamber: Chamber, radius: float, half_width: float, down: Array) -> Array:
    sites = filling_sites(float(chamber.radius), chamber.inner_depth, radius, float(chamber.inner_radius), half_width)
    return _turned(sites, down)


def _no_room(chamber: Chamber, number: int, k: int, most: int) -> str:
    group: FreeBalls = chamber.balls[k]
    several = len(chamber.balls) > 1
    place = f"chambers[{number}].balls[{k + 1}]" if several else f"chambers[{number}]"
    inner = f"{1e3 * chamber.inner_radius:.4g} to " if chamber.inner_radius > 0.0 else ""
    return (
        f"{place}: {group.count} {sized(group)} do not fit into a chamber of radius "
        f"{inner}{1e3 * chamber.radius:.4g} mm and depth {1e3 * chamber.inner_depth:.4g} mm"
        f"{' beside the others' if several else ''}; at most {max(most, 0)} do"
    )


def _lowest(sites: Array, down: Array, radius: float) -> Array:
    """In the order of their heights, near the middle first."""
    depth = np.round(sites @ -down / (1e-3 * radius))
    return sites[np.lexsort((np.abs(sites[:, 0]), np.hypot(sites[:, 1], sites[:, 2]), depth))]


def _loosened(places: Array, sizes: Sizes, chamber: Chamber, random: np.random.Generator) -> Array:
    """With a trace of disorder, within the air between neighbors, and inside the walls."""
    radii = sizes.radius
    wide = np.minimum(radii, sizes.half)
    places = places + random.uniform(-0.2, 0.2, places.shape) * (AIR - 1.0) * 2.0 * wide[:, None]
    free = 0.5 * chamber.inner_depth - sizes.half
    places[:, 0] = np.clip(places[:, 0], -free, free)
    across = np.maximum(np.hypot(places[:, 1], places[:, 2]), 1e-300)
    within = np.minimum(across, chamber.radius - radii)
    if chamber.inner_radius > 0.0:
        within = np.maximum(within, chamber.inner_radius + radii)
    places[:, 1:] *= (within / across)[:, None]
    return places


def _down(machine: ChamberMachine) -> Array:
    gravity = np.array(machine.gravity, np.float64)
    size = float(np.linalg.norm(gravity))
    return gravity / size if size > 0.0 else np.array([0.0, 0.0, -1.0])


def _turned(sites: Array, down: Array) -> Array:
    """The packing, made for gravity along -z, turned about x so that its bottom is down."""
    across = math.hypot(down[1], down[2])
    if across < 1e-9 or not len(sites):
        return sites
    c, s = -down[2] / across, down[1] / across
    return np.column_stack([sites[:, 0], c * sites[:, 1] - s * sites[:, 2], s * sites[:, 1] + c * sites[:, 2]])


def _apart(places: Array, sizes: Sizes, chamber: Chamber, number: int) -> None:
    room, what = 1.0 + 1e-9, "cylinder" if sizes.flat.any() else "ball"
    for i, (place, own, half) in enumerate(zip(places, sizes.radius, sizes.half, strict=True)):
        across = math.hypot(place[1], place[2])
        inside = across + own <= chamber.radius * room and abs(place[0]) + half <= 0.5 * chamber.inner_depth * room
        around = chamber.inner_radius == 0.0 or (across - own) * room >= chamber.inner_radius
        if not (inside and around):
            raise MachineError(f"chambers[{number}]: {what} {i + 1} stands in the wall; move it inside")
        before = Sizes(*(size[:i] for size in sizes))
        apart = gaps(places[i : i + 1], Sizes(*(size[i : i + 1] for size in sizes)), places[:i], before)[0]
        for j in np.flatnonzero(apart < -1e-9 * min(own, half)):
            raise MachineError(
                f"chambers[{number}]: {what}s {j + 1} and {i + 1} overlap by {-1e3 * apart[j]:.4g} mm; move them apart"
            )


# How much room balls and cylinders take, and how far they are from each other.


class Sizes(NamedTuple):
    """Of each ball (n,): radius and half of what it takes along the rotor, m; 1 for a cylinder, 0 for a ball."""

    radius: Array
    half: Array
    flat: Array


def sizes_of(group: FreeBalls, count: int) -> Sizes:
    """Of ``count`` balls of a group."""
    return Sizes(
        *(np.full(count, value) for value in (group.radius, group.half_width, float(group.body == "cylinder")))
    )


def together(sizes: list[Sizes]) -> Sizes:
    """Of several groups, one after the other."""
    return Sizes(*(np.concatenate(parts) for parts in zip(*sizes, strict=True)))


def gaps(one: Array, own: Sizes, others: Array, sizes: Sizes, air: float = 1.0) -> Array:
    """Distances (k, n) of the surfaces of balls or cylinders at ``one`` (k, 3) and ``others`` (n, 3), m.

    Negative where they overlap; with ``air`` above one they count as that much larger.
    """
    both = air * (own.radius[:, None] + sizes.radius)
    if not own.flat.any():
        return cdist(one, others) - both
    across = cdist(one[:, 1:], others[:, 1:]) - both
    along = cdist(one[:, :1], others[:, :1]) - air * (own.half[:, None] + sizes.half)
    return np.maximum(across, along)


def sized(group: FreeBalls, *, plural: bool = True) -> str:
    """Balls or cylinders with their size, for a message."""
    many = "s" * plural
    if group.length is None:
        return f"ball{many} of {2e3 * group.radius:.4g} mm"
    return f"cylinder{many} of {2e3 * group.radius:.4g} mm by {1e3 * group.length:.4g} mm"
