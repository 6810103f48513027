"""Balls put into a chamber in layers from the bottom, as many as fit (after Pakuła 2021, appendix 3)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.errors import MachineError
from autobalancer.machine.chamber import ChamberMachine

Array = Any
AIR = 1.002  # distance of neighbors over their diameter


def filling_sites(radius: float, depth: float, ball_radius: float) -> Array:
    """Places (sites, 3) for balls in a cylinder along x, from its middle; rows across are staggered.

    Of two packings, columns of staggered rows and staggered columns of straight rows, the one with more places.
    """
    reach, half = radius - ball_radius, 0.5 * depth - ball_radius
    pitch = 2.0 * ball_radius * AIR
    if half < 0.0 or reach < 0.0:
        return np.zeros((0, 3))
    along = _line(half, pitch)
    best = np.zeros((0, 3))
    for lift in (0.5 * math.sqrt(3.0) * pitch, pitch):
        for low in (0.0, 0.5):
            sites = []
            height, row = -reach * (1.0 - 1e-9) if low == 0.0 else -lift * math.floor(reach / lift), 0
            while height <= reach:
                width = math.sqrt(max(reach**2 - height**2, 0.0))
                shift = 0.5 * pitch if (row % 2 and lift < pitch) else 0.0
                count = math.floor((width - shift) / pitch)
                offsets = np.arange(-count - (1 if shift else 0), count + 1) * pitch + shift
                sites += [(x, y, height) for y in offsets if abs(y) <= width for x in along]
                height += lift
                row += 1
            if len(sites) > len(best):
                best = np.array(sites)
    return best


def _line(half: float, pitch: float) -> Array:
    count = math.floor(2.0 * half / pitch * (1.0 + 1e-12)) + 1
    pitch = min(pitch, 2.0 * half) if count > 1 else pitch
    return (np.arange(count) - 0.5 * (count - 1)) * pitch


def fill(machine: ChamberMachine, seed: int = 0) -> tuple[Array, bool]:
    """Start positions of all balls, (n, 3) from the middles of their chambers, and whether they need to settle.

    Raises
    ------
    MachineError
        If they do not fit (with the largest number that does), or given ones overlap or stand in a wall.
    """
    random = np.random.default_rng(seed)
    down = _down(machine)
    found: list[Array] = []
    settle = False
    for number, chamber in enumerate(machine.chambers, 1):
        groups = chamber.balls
        given = [group for group in groups if group.positions is not None]
        if given and len(given) < len(groups):
            raise MachineError(f"chambers[{number}]: give the positions of all balls in a chamber, or of none")
        if given:
            places = np.vstack([np.asarray(group.positions, np.float64) for group in groups])
            radii = np.concatenate([np.full(group.count, group.radius) for group in groups])
            _apart(places, radii, float(chamber.radius), chamber.inner_depth, number)
            found.append(places)
            continue
        settle = True
        radius = max(group.radius for group in groups)
        sites = _turned(filling_sites(float(chamber.radius), chamber.inner_depth, radius), down)
        wanted = sum(group.count for group in groups)
        if wanted > len(sites):
            raise MachineError(
                f"chambers[{number}]: {wanted} balls of up to {2e3 * radius:.4g} mm do not fit into a chamber of radius "
                f"{1e3 * chamber.radius:.4g} mm and depth {1e3 * chamber.inner_depth:.4g} mm; at most {len(sites)} do"
            )
        depth = np.round(sites @ -down / (1e-3 * radius))
        order = np.lexsort((np.abs(sites[:, 0]), np.hypot(sites[:, 1], sites[:, 2]), depth))[:wanted]
        chosen = sites[order]
        # a trace of disorder, within the air between neighbors
        chosen = chosen + random.uniform(-0.2, 0.2, chosen.shape) * (AIR - 1.0) * 2.0 * radius
        free = 0.5 * chamber.inner_depth - radius
        chosen[:, 0] = np.clip(chosen[:, 0], -free, free)
        across = np.hypot(chosen[:, 1], chosen[:, 2])
        chosen[:, 1:] *= np.minimum(1.0, (chamber.radius - radius) / np.maximum(across, 1e-300))[:, None]
        found.append(chosen[random.permutation(wanted)] if len(groups) > 1 else chosen)
    return np.vstack(found), settle


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


def _apart(places: Array, radii: Array, radius: float, depth: float, number: int) -> None:
    room = 1.0 + 1e-9
    for i, (place, own) in enumerate(zip(places, radii, strict=True)):
        across = math.hypot(place[1], place[2])
        if across + own > radius * room or abs(place[0]) + own > 0.5 * depth * room:
            raise MachineError(f"chambers[{number}]: ball {i + 1} stands in the wall; move it inside")
        for j in range(i):
            gap = float(np.linalg.norm(places[j] - place)) - own - radii[j]
            if gap < -1e-9 * own:
                raise MachineError(
                    f"chambers[{number}]: balls {j + 1} and {i + 1} overlap by {-1e3 * gap:.4g} mm; move them apart"
                )
