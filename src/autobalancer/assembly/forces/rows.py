"""Forces on balls as rows of kernels/records/forces.py."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import numpy as np

from autobalancer.assembly.contact.meetings import ring
from autobalancer.assembly.forces.tried import compiled_force, made_of
from autobalancer.catalog.resolve import Ball
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.records.forces import FORCE, PLACE
from autobalancer.kernels.system import Floats, System
from autobalancer.machine import Force, Machine


def has_forces(machine: Machine) -> bool:
    """Whether any race has forces on its balls."""
    return any(race.forces for balancer in machine.balancers for race in balancer.races)


def force_rows(machine: Machine, balls: tuple[Ball, ...], angles: Floats, *, tried: bool = True) -> dict[str, Any]:
    """Forces and the places of balls as fields of a system; ``angles`` at the start give the order of the balls.

    ``tried`` is ``False`` for a machine whose forces were tried before, with other numbers.

    Raises
    ------
    MachineError
        If a force cannot be used; the message says which one, and why.
    """
    if not has_forces(machine):
        return {}
    places = PLACE.rows(len(balls))
    for row, ball in zip(places, balls, strict=True):
        row.mass, row.radius, row.orbit = ball.effective_mass, ball.radius, ball.orbit_radius
        row.gravity = float(machine.gravity) if machine.axis == "vertical" else 0.0
    rows: list[Any] = []
    numbers: list[float] = []
    for path, force, members in forces_in(machine, balls):
        its_balls = tuple(balls[i] for i in members)
        made = compiled_force(force, path, its_balls, float(places[members[0]].gravity)) if tried else made_of(force)
        fields = {"address": made.force.address, "energy": made.energy.address if made.energy else 0}
        fields["first"] = len(numbers)
        numbers += force.numbers().values() or (0.0,)
        rows += [FORCE.row(ball=i, other=j, wrap=wrap, **fields) for i, j, wrap in _acting(force, members, angles)]
    return {"places": places, "forces": _array(rows), "force_numbers": np.array(numbers, np.float64)}


def forces_in(machine: Machine, balls: tuple[Ball, ...]) -> Iterator[tuple[str, Force, list[int]]]:
    """Each force of a machine: its path, itself, the numbers of the balls of its race."""
    for b, balancer in enumerate(machine.balancers):
        for r, race in enumerate(balancer.races):
            members = [i for i, ball in enumerate(balls) if (ball.balancer, ball.race) == (b, r)]
            for f, force in enumerate(race.forces):
                yield f"balancers[{b + 1}].races[{r + 1}].forces[{f + 1}]", force, members


def force_at_fault(machine: Machine, balls: tuple[Ball, ...], system: System) -> str:
    """Which force was not a number during a run, and where; empty if none was."""
    wrong = system.forces[system.forces.wrong != 0]
    if not len(wrong):
        return ""
    row, first = wrong[0], 0
    for path, force, _ in forces_in(machine, balls):
        if row.first == first:
            return (
                f"the force {force.word()!r} ({path}) was not a number on ball {row.ball + 1} at "
                f"x = {row.wrong_x:.6g} m, y = {row.wrong_y:.6g} m in the race, at a velocity of {row.wrong_vx:.4g} and "
                f"{row.wrong_vy:.4g} m/s and a rotor speed of {row.wrong_speed:.6g} rad/s"
            )
        first += len(force.numbers()) or 1
    return ""


def _acting(force: Force, members: list[int], angles: Floats) -> list[tuple[int, int, float]]:
    if force.pairs == "":
        return [(i, NONE, 0.0) for i in members]
    if force.pairs == "neighbors":
        return [link for link in ring(members, angles) if link[0] != link[1]]
    return [ring(pair, angles)[0] for pair in combinations(members, 2)]


def _array(rows: list[Any]) -> Any:
    found = FORCE.rows(len(rows))
    for i, row in enumerate(rows):
        found[i] = row
    return found
