"""What a drawing of a machine shows along its axis, as plain shapes; lengths in m."""

from __future__ import annotations

import math
from typing import NamedTuple

from autobalancer.catalog.resolve import Ball
from autobalancer.machine import Machine, ModalRotor, MultibodyRotor, PlanarRotor, RigidRotor, ShaftRotor
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.liquid_ring import LiquidRing
from autobalancer.machine.rotors.body import GROUND
from autobalancer.machine.rotors.joint import PointJoint

SLAB = 0.25  # thickness of a body of which only the mass is known, over its radius
ROOM = 1.12  # radius of such a body over that of what it carries
ALONE = 0.05  # m; radius of one that carries nothing


class Block(NamedTuple):
    """A round body seen from the side."""

    start: float
    end: float
    radius: float
    bore: float = 0.0
    turning: bool = True
    known: bool = False  # whether its outline is that of the machine; otherwise a cylinder of its mass and inertias
    name: str = ""


class Spring(NamedTuple):
    """A support, or a joint between two bodies."""

    place: float
    radius: float  # of what it carries
    grounded: bool = True


class Filling(NamedTuple):
    """Balls of one kind on the wall of a deep chamber."""

    start: float
    end: float
    radius: float  # of the wall
    ball_radius: float
    ball_width: float
    text: str


class Layout(NamedTuple):
    """Along the axis of a machine."""

    blocks: list[Block]
    springs: list[Spring]
    planes: list[float]  # of the balancers
    unbalances: list[tuple[float, float]]  # place, angle
    couples: int
    stations: list[tuple[float, str]]
    note: str
    fillings: tuple[Filling, ...] = ()

    def radius_at(self, place: float) -> float:
        """Of the largest body there, of all bodies where there is none."""
        there = [block.radius for block in self.blocks if block.start - 1e-9 <= place <= block.end + 1e-9]
        return max(there, default=max(block.radius for block in self.blocks))


def layout_of(machine: Machine, balls: tuple[Ball, ...]) -> Layout:
    """Where the parts of a machine are."""
    named = {station.name: float(station.position) for station in machine.stations}
    middle = _middle(machine)

    def place(station: float | str | None) -> float:
        if isinstance(machine.rotor, (ModalRotor, PlanarRotor)) or station is None:
            return middle
        return named.get(station, middle) if isinstance(station, str) else float(station)

    rings = [place(None) for _ in machine.liquid_rings]
    planes = [place(balancer.station) for balancer in machine.balancers]
    reach = max((ball.orbit_radius + ball.radius + abs(ball.eccentricity) for ball in balls), default=0.0)
    reach = max([reach, *(float(ring.radius) for ring in machine.liquid_rings)])
    blocks, springs, note = _rotor(machine, [*planes, *rings], reach)
    blocks += [_ring(place, ring) for place, ring in zip(rings, machine.liquid_rings, strict=True)]
    points = [one for one in machine.unbalances if not one.is_couple]
    return Layout(
        blocks,
        springs,
        planes,
        [(place(one.station), float(one.angle)) for one in points],
        len(machine.unbalances) - len(points),
        [(float(station.position), station.name) for station in machine.stations],
        note,
    )


def chamber_layout(machine: ChamberMachine) -> Layout:
    """Where the parts of a machine with deep chambers are."""
    rotor = machine.rotor
    body = _cylinder(0.0, float(rotor.mass), float(rotor.polar_inertia), float(rotor.transverse_inertia))
    chambers, fillings = [], []
    for chamber in machine.chambers:
        middle, half, radius = float(chamber.position), 0.5 * chamber.inner_depth, float(chamber.radius)
        chambers.append(Block(middle - half, middle + half, radius, float(chamber.inner_radius), known=True))
        for group in chamber.balls:
            many = f"{group.count} {group.body}{'s' * (group.count != 1)} {2e3 * group.radius:.3g} mm"
            fillings.append(Filling(middle - half, middle + half, radius, group.radius, 2.0 * group.half_width, many))
    ends = [*map(float, rotor.bearings), *(end for block in chambers for end in (block.start, block.end))]
    axis = _axis(ends, 0.5 * float(rotor.neck_diameter) or 0.04 * max(block.radius for block in chambers))
    return Layout(
        [axis, body, *chambers],
        [Spring(float(place), axis.radius, grounded=False) for place in rotor.bearings],
        [],
        [(float(one.position), float(one.angle)) for one in machine.unbalances],
        0,
        [],
        "dashed: the cylinder of mass and inertias of the rotor; zigzags: its bearings",
        tuple(fillings),
    )


def _ring(place: float, ring: LiquidRing) -> Block:
    half, radius = 0.5 * float(ring.height), float(ring.radius)
    return Block(
        place - half, place + half, radius, radius - float(ring.width or 0.25 * radius), known=True, name=ring.name
    )


def _middle(machine: Machine) -> float:
    """A place without a station."""
    rotor = machine.rotor
    if isinstance(rotor, ShaftRotor):
        return 0.5 * rotor.length
    if isinstance(rotor, MultibodyRotor):
        turning = [float(body.position) for body in rotor.bodies if body.rotating]
        return sum(turning) / len(turning)
    return 0.0


def _rotor(machine: Machine, carried: list[float], reach: float) -> tuple[list[Block], list[Spring], str]:
    rotor = machine.rotor
    if isinstance(rotor, (ModalRotor, PlanarRotor)):
        radius = ROOM * reach or ALONE
        half = 0.5 * SLAB * radius
        springs = [Spring(place, radius) for place in (-half, half)]
        return (
            [Block(-half, half, radius)],
            springs,
            f"a {rotor.kind} rotor has no length: disc and supports are symbols",
        )
    if isinstance(rotor, RigidRotor):
        held = [float(support.position) for support in rotor.supports]
        body = _cylinder(0.0, float(rotor.mass), float(rotor.polar_inertia), float(rotor.transverse_inertia))
        axis = _axis([*held, *carried, body.start, body.end], 0.06 * max(body.radius, reach))
        note = "the body is the cylinder of the same mass and inertias"
        return [axis, body], [Spring(place, _radius_at([body, axis], place)) for place in held], note
    if isinstance(rotor, ShaftRotor):
        return (*_shaft(rotor, reach), "")
    return (*_bodies(rotor, carried, reach), "bodies are cylinders of their masses and inertias")


def _shaft(rotor: ShaftRotor, reach: float) -> tuple[list[Block], list[Spring]]:
    blocks, at = [], 0.0
    for segment in rotor.segments:
        end = at + float(segment.length)
        blocks.append(Block(at, end, 0.5 * float(segment.diameter), 0.5 * float(segment.inner_diameter), known=True))
        at = end
    outline = list(blocks)
    for disk in rotor.disks:
        center = float(disk.position) + float(disk.offset)
        blocks.append(
            _cylinder(center, float(disk.mass), float(disk.polar_inertia), float(disk.transverse_inertia), disk.name)
        )
    places = [float(support.position) for support in rotor.supports]
    return blocks, [Spring(place, _radius_at(outline, place)) for place in places]


def _bodies(rotor: MultibodyRotor, carried: list[float], reach: float) -> tuple[list[Block], list[Spring]]:
    blocks = []
    for body in rotor.bodies:
        jx, jy, jz = body.inertias
        solid = _cylinder(float(body.position), float(body.mass), jz, 0.5 * (jx + jy), body.name)
        blocks.append(solid._replace(turning=body.rotating))
    turning = [block for block in blocks if block.turning]
    ends = [end for block in turning for end in (block.start, block.end)]
    axis = _axis([*ends, *carried], 0.05 * max(reach, *(block.radius for block in blocks)))
    springs = []
    for joint in rotor.joints:
        if not isinstance(joint, PointJoint):
            continue
        grounded = GROUND in joint.between
        joined = [block for block in blocks if block.name in joint.between]
        radius = min((block.radius for block in joined), default=axis.radius)
        springs += [Spring(spot.point[2], radius, grounded) for spot in joint.spots()]
    distinct = {(round(spring.place, 6), spring.grounded): spring for spring in springs}
    return [*sorted(blocks, key=lambda block: block.turning), axis], list(distinct.values())


def _cylinder(center: float, mass: float, polar: float, transverse: float, name: str = "") -> Block:
    """The solid cylinder of a mass and its inertias; flat where these are those of less than a disc, a point without."""
    radius = math.sqrt(max(2.0 * polar / mass, 0.0))
    length = math.sqrt(max(12.0 * transverse / mass - 3.0 * radius**2, (0.05 * radius) ** 2))
    return Block(center - 0.5 * length, center + 0.5 * length, radius, name=name)


def _axis(places: list[float], radius: float) -> Block:
    low, high = min(places), max(places)
    more = 0.04 * (high - low) + radius
    return Block(low - more, high + more, radius)


def _radius_at(outline: list[Block], place: float) -> float:
    return next((block.radius for block in outline if block.start <= place <= block.end), outline[-1].radius)
