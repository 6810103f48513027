"""From a machine with deep chambers to what its kernels take."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.assembly.chamber.contact import (
    ball_groups,
    contact_row,
    has_cylinders,
    pair_stiffness,
    rebound_tables,
    reduced_modulus,
    wall_stiffness,
)
from autobalancer.assembly.chamber.machine import body_row, machine_row, profile_rows
from autobalancer.kernels.chamber import records as of
from autobalancer.kernels.chamber.chamber import Chamber, Pairs, Scratch, Search
from autobalancer.kernels.fields import Row, Rows
from autobalancer.laws.hertz import end_stiffness, line_stiffness
from autobalancer.machine.chamber import Chamber as RoundChamber
from autobalancer.machine.chamber import ChamberMachine, FreeBalls

Array = Any
MARGIN = 0.3  # of the least ball radius: how far beyond contact pairs are listed
NEIGHBORS = 24  # pairs kept for each ball


def assemble_chamber(machine: ChamberMachine, positions: Array, step: float) -> Chamber:
    """Numbers of a machine at rest whose balls are at ``positions`` (n, 3) from the middles of their chambers."""
    groups = ball_groups(machine)
    least = min(min(balls.radius, balls.half_width) for _, balls in groups)
    n = sum(balls.count for _, balls in groups)
    room = NEIGHBORS * n + 64
    rebounds, pair_rebounds = rebound_tables(machine)
    return Chamber(
        run=of.RUN.row(step=step, margin=MARGIN * least),
        contact=_contact(machine),
        machine=machine_row(machine),
        rooms=_rooms(machine),
        pair_stiffness=_pair_stiffness(machine),
        rebounds=rebounds,
        pair_rebounds=pair_rebounds,
        profile=profile_rows(machine),
        balls=_balls(machine, positions),
        wall_stretch=np.zeros((n, of.WALLS, 3)),
        pairs=_pairs(n, room),
        body=body_row(machine),
        power=of.POWER.row(),
        before=of.POWER.row(),
        account=of.ACCOUNT.row(),
        since=of.SINCE.row(),
        progress=of.PROGRESS.row(),
        scratch=_scratch(n, room),
    )


def _contact(machine: ChamberMachine) -> Row:
    row = contact_row(machine.contact)
    row.cylinders = has_cylinders(machine)
    return row


def _pair_stiffness(machine: ChamberMachine) -> Array:
    """Of balls k for each pair of groups; of cylinders the reduced modulus, as k depends on where they meet."""
    radii = [balls.radius for _, balls in ball_groups(machine)]
    if has_cylinders(machine):
        return np.full((len(radii), len(radii)), reduced_modulus(machine.contact))
    return np.array([[pair_stiffness(machine.contact, a, b) for b in radii] for a in radii])


def _pairs(n: int, room: int) -> Pairs:
    first, second = np.zeros(room, np.int32), np.zeros(room, np.int32)
    return Pairs(first, second, np.zeros(room, np.int8), np.zeros((room, 3)), np.zeros((n, 3)))


def _scratch(n: int, room: int) -> Scratch:
    return Scratch(
        search=Search(
            old_row=np.zeros(n + 1, np.int32),
            old_second=np.zeros(room, np.int32),
            old_stretch=np.zeros((room, 3)),
            cells=np.zeros(max(8 * n, 64) + 2, np.int64),
            order=np.zeros(n, np.int32),
            places=np.zeros(n, np.int32),
        ),
        # places that are not in use are computed too
        contacts=of.CONTACTS.row(line=1.0, stiffness=1.0, lightness=1.0, roll_radius=1.0),
        equations=np.zeros((7, 8)),
        reduced=np.zeros((7, 8)),
        begun=of.MOTION.rows(n),
        gone=of.MOTION.rows(n),
        body_begun=of.BODY_MOTION.row(),
        body_gone=of.BODY_MOTION.row(),
    )


def _balls(machine: ChamberMachine, positions: Array) -> Rows:
    groups = ball_groups(machine)
    rows = of.BALL.rows(sum(balls.count for _, balls in groups))
    i = 0
    for kind, (number, group) in enumerate(groups):
        chamber = machine.chambers[number]
        own = rows[i : i + group.count]
        own.position = positions[i : i + group.count]
        own.position[:, 0] += chamber.position
        own.radius, own.mass = group.radius, group.ball_mass
        own.inertia = group.spin_inertia
        own.inverse_mass, own.inverse_inertia = 1.0 / own.mass, 1.0 / own.inertia
        own.kind, own.chamber = kind, number
        _walls(machine, own, group, chamber)
        if group.velocities is not None:
            own.velocity = group.velocities
        if group.spins is not None:
            own.spin = group.spins
        i += group.count
    return rows


def _walls(machine: ChamberMachine, own: Rows, group: FreeBalls, chamber: RoundChamber) -> None:
    """Stiffness of the walls, and what a cylinder is along the rotor."""
    contact, radius = machine.contact, group.radius
    if group.length is not None:
        own.half_length = group.half_width
        own.race_stiffness = own.inner_stiffness = line_stiffness(reduced_modulus(contact), float(group.length))
        own.flat_stiffness = end_stiffness(reduced_modulus(contact), radius)
        return
    own.race_stiffness = wall_stiffness(contact, radius, float(chamber.radius))
    own.flat_stiffness = wall_stiffness(contact, radius)
    if chamber.inner_radius > 0.0:
        own.inner_stiffness = wall_stiffness(contact, radius, -float(chamber.inner_radius))


def _rooms(machine: ChamberMachine) -> Rows:
    rows = of.ROOM.rows(len(machine.chambers))
    for room, chamber in zip(rows, machine.chambers, strict=True):
        room.center, room.wall_radius, room.half_depth = chamber.position, chamber.radius, 0.5 * chamber.inner_depth
        room.drag, room.square_drag = chamber.drag, chamber.square_drag
        room.inner_radius = chamber.inner_radius or -math.inf
    return rows
