"""The drawing of a machine before it runs: what is where along its axis, and its races from above."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Circle, Rectangle

from autobalancer.assembly.drive_train import unbalance_factor
from autobalancer.assembly.rotors import spring_model
from autobalancer.catalog.resolve import Ball, occupied_angle, resolve
from autobalancer.files.machine_file import any_machine
from autobalancer.machine import Machine, MultibodyRotor, RigidRotor, ShaftRotor
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.machine.machine import LiquidRing
from autobalancer.machine.rotors.body import GROUND
from autobalancer.machine.rotors.joint import PointJoint
from autobalancer.machine_kinds import machine_kind
from autobalancer.plots.run.race_and_orbit import WIDTH, RacePanel, Vector
from autobalancer.plots.style import INK, RACE, UNBALANCE, ball_color, heading, label_point, look, picture
from autobalancer.results.display_units import moment_text
from autobalancer.results.drawn import Moments, Races

# The drawing of a machine: the public function.


COLUMNS = 3  # balancers side by side
SIDE = 3.9  # inches of the view from the side
LEAST = 7.0  # of the whole width


def machine(machine: Machine | ChamberMachine | str | Path, *, title: str | None = None) -> Figure:
    """Draw a machine: bodies, supports, stations and races along its axis, and each balancer from above.

    All lengths are to scale, in mm. A shaft has its own outline; a rigid rotor, a disk and a body of a rig are drawn dashed as
    the solid cylinder of their mass and inertias, and a planar rotor, which has no length, as a disc. Below the axis are the
    springs of the supports. From above, each ball is at its start angle; balls without one lie side by side. Arrows are the
    unbalances at time zero, to a scale of their own.

    Parameters
    ----------
    machine
        A machine with balls in races or deep chambers, or without balls; or the path of its file.
    title
        Above the picture; by default the name of the machine.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    MachineError
        If the file cannot be read, or its parts do not fit.
    """
    given = any_machine(machine)
    count = len(getattr(given, "balancers", ()))
    balls = resolve(given) if isinstance(given, Machine) and count else ()
    layout = machine_kind(given)["layout"](given)
    columns = min(count, COLUMNS)
    rows = -(-count // max(columns, 1))
    with look():
        figure = picture(max(WIDTH * columns, LEAST), SIDE)
        heading(figure, given.name if title is None else title)
        if not isinstance(given, Machine) or not count:  # the side says all
            side_view(figure.subplots(), layout, balls)
            return figure
        side, fronts = figure.subfigures(2, 1, squeeze=False, height_ratios=[SIDE, 6.0 * rows]).ravel()
        side_view(side.subplots(), layout, balls)
        height = _fronts(fronts, given, balls, rows, columns)
        figure.set_size_inches(figure.get_figwidth(), SIDE + height * rows + 0.35)
    return figure


def _fronts(figure: SubFigure, given: Machine, balls: tuple[Ball, ...], rows: int, columns: int) -> float:
    """Each balancer from above; returns the height of one in inches."""
    races, moments = races_at_start(given, balls)
    colors = [ball_color(k) for k in range(len(balls))]
    vectors = _unbalances(given)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    drawn = []
    for number, axes in enumerate(panels):
        mine = np.flatnonzero(races.balancer == number + 1)
        if not mine.size:
            axes.set_axis_off()
            continue
        drawn.append(RacePanel(axes, races, moments, mine, colors, {}))
        drawn[-1].arrows(vectors, max((abs(one.value) for one in vectors), default=1.0))
        at_random = drawn_at_random(tuple(balls[k] for k in mine))
        drawn[-1].notes(["a run begins with balls at random places" if at_random else ""])
        if len(given.balancers) > 1:
            drawn[-1].title(given.balancers[number].name or f"balancer {number + 1}")
    lines = max(panel.lines for panel in drawn)
    return max(panel.room(lines) for panel in drawn)


def _unbalances(given: Machine) -> list[Vector]:
    """The point unbalances at time zero, each with its place."""
    found = []
    for one in given.unbalances:
        if one.is_couple:
            continue
        value = one.vector * unbalance_factor(one, 0.0)
        where = "" if given.rotor.one_plane or one.station is None else f" at {_station_label(one.station)}"
        found.append(Vector(value, f"unbalance{where} {moment_text(abs(value))}", UNBALANCE))
    return found


def _station_label(station: float | str) -> str:
    return station if isinstance(station, str) else f"{1e3 * float(station):.4g} mm"


# A machine from the side: its axis to the right, the balls of each race in section above and below it.


RIM, STANDING, TURNING, GREY = "#8A949C", "#F4F1EA", "#DDE3E8", "#606060"
SIDE_LEAST = 0.018  # of the picture: what a point ball or an unbalance is drawn as


def side_view(axes: Axes, layout: Layout, balls: tuple[Ball, ...], mm: float = 1e3) -> None:
    """Draw it to scale, in mm."""
    high = max([block.radius for block in layout.blocks] + [ball.orbit_radius + ball.radius for ball in balls])
    low, up = min(block.start for block in layout.blocks), max(block.end for block in layout.blocks)
    size = max(up - low, 2.0 * high)
    for block in layout.blocks:
        _block(axes, block, mm)
    for spring in layout.springs:
        _spring(axes, spring, size, mm)
    for number, place in enumerate(layout.planes):
        _section(axes, place, [(k, ball) for k, ball in enumerate(balls) if ball.balancer == number], size, mm)
    for filling in layout.fillings:
        _filling(axes, filling, mm)
    for place, angle in layout.unbalances:
        at = 0.55 * layout.radius_at(place) * (1.0 if math.sin(angle) >= 0.0 else -1.0)
        axes.plot([place * mm], [at * mm], marker="D", ms=7, color=UNBALANCE, mec="white", mew=0.8, zorder=6)
    for place, name in layout.stations:
        axes.plot([place * mm], [0.0], marker="|", ms=16, mew=1.2, color=INK, zorder=5)
        label_point(axes, name, place * mm, 0.0, color=INK)
    more = 0.06 * size * mm
    axes.axhline(0.0, color=INK, lw=0.7, ls=(0, (12, 3, 2, 3)), zorder=4)
    axes.update_datalim([(low * mm - more, -high * mm - 2.6 * more), (up * mm + more, high * mm + 1.5 * more)])
    axes.margins(0.0)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="along the axis, z (mm)" if not layout.fillings else "along the axis, x (mm)", ylabel="radius (mm)")
    axes.grid(False)
    couples = f"{layout.couples} couple unbalance{'s' * (layout.couples > 1)} not drawn" if layout.couples else ""
    axes.set_title(
        "; ".join(text for text in (layout.note, couples) if text), fontsize=8.5, weight="normal", color=GREY
    )


def _filling(axes: Axes, filling: Filling, mm: float) -> None:
    """A row of balls on the lower wall, as many as lie side by side."""
    fit = max(int((filling.end - filling.start) / filling.ball_width), 1)
    places = filling.start + 0.5 * (filling.end - filling.start) * (1.0 + (2.0 * np.arange(fit) - fit + 1.0) / fit)
    for place in places:
        center = (place * mm, (filling.ball_radius - filling.radius) * mm)
        axes.add_patch(Circle(center, filling.ball_radius * mm, fc=ball_color(0), ec=INK, lw=0.7, zorder=5))
    label_point(axes, filling.text, 0.5 * (filling.start + filling.end) * mm, filling.radius * mm)


def _block(axes: Axes, block: Block, mm: float) -> None:
    fill = TURNING if block.turning else STANDING
    line = "-" if block.known else (0, (4, 2))
    for low, high in (
        ((block.bore, block.radius), (-block.radius, -block.bore)) if block.bore else ((-block.radius, block.radius),)
    ):
        shape = Rectangle(
            (block.start * mm, low * mm), (block.end - block.start) * mm, (high - low) * mm, fc=fill, ec=RIM, lw=1.0,
            ls=line, zorder=1.2 if block.turning else 1.0,
        )  # fmt: skip
        axes.add_patch(shape)
    if block.name and block.radius > 0.0:
        label_point(axes, block.name, 0.5 * (block.start + block.end) * mm, block.radius * mm, color="#606060")


def _spring(axes: Axes, spring: Spring, size: float, mm: float) -> None:
    """A zigzag down to the ground, or a short one between two bodies."""
    length = 0.09 * size if spring.grounded else 0.05 * size
    across = 0.012 * size
    steps = np.linspace(0.0, 1.0, 12)
    sway = np.where(np.arange(12) % 2, 1.0, -1.0) * across
    sway[[0, 1, -2, -1]] = 0.0
    for side in (-1.0,) if spring.grounded else (-1.0, 1.0):
        start = side * spring.radius
        down = start + side * steps * length
        axes.plot((spring.place + sway) * mm, down * mm, color=INK, lw=1.1, zorder=3)
        if spring.grounded:
            wide = 3.0 * across
            axes.plot([(spring.place - wide) * mm, (spring.place + wide) * mm], [down[-1] * mm] * 2, color=INK, lw=1.6)
            axes.add_patch(
                Rectangle(
                    ((spring.place - wide) * mm, (down[-1] - across) * mm), 2.0 * wide * mm, across * mm, fc="none",
                    ec=RIM, lw=0.0, hatch="/////", zorder=2,
                )
            )  # fmt: skip


def _section(axes: Axes, place: float, balls: list[tuple[int, Ball]], size: float, mm: float) -> None:
    """The races of a plane: a channel and a ball above and below the axis."""
    for race in sorted({ball.race for _, ball in balls}):
        inside = [(k, ball) for k, ball in balls if ball.race == race]
        thick = max(ball.diameter for _, ball in inside)
        number, ball = inside[0]
        radius = 0.5 * thick or 0.5 * SIDE_LEAST * size
        for side in (-1.0, 1.0):
            center = side * ball.orbit_radius
            channel = ((place - radius) * mm, (center - radius) * mm)
            if ball.body != "pendulum":
                axes.add_patch(
                    Rectangle(channel, 2.0 * radius * mm, 2.0 * radius * mm, fc=RACE, ec=INK, lw=1.0, zorder=3)
                )
            else:
                axes.plot([place * mm] * 2, [0.0, center * mm], color=INK, lw=2.0, zorder=3)
            looks = {"fc": ball_color(number), "ec": INK, "lw": 0.8, "zorder": 5}
            if not thick:
                looks |= {"fc": "white", "ec": ball_color(number), "lw": 1.6}
            axes.add_patch(Circle((place * mm, center * mm), radius * mm, **looks))


# The races of a machine from above, with their balls where they start.


def races_at_start(machine: Machine, balls: tuple[Ball, ...]) -> tuple[Races, Moments]:
    """Races and balls at rest: each ball at its start angle, those without one side by side from the zero mark."""
    planes = [balancer.station for balancer in machine.balancers]
    plane = [planes.index(planes[ball.balancer]) for ball in balls]
    diameters = np.array([ball.diameter for ball in balls])
    races = Races(
        np.array([ball.orbit_radius for ball in balls]),
        diameters,
        np.array([ball.moment for ball in balls]),
        np.array([ball.eccentricity for ball in balls], np.complex128),
        np.array([ball.balancer + 1 for ball in balls]),
        np.array([ball.race + 1 for ball in balls]),
        np.array(plane),
        np.array([ball.body for ball in balls], dtype=object),
        np.maximum(diameters, [_channel(machine, ball) for ball in balls]),
    )
    none, zero = np.zeros(1), np.zeros(1, np.complex128)
    angles = np.array(_angles(balls))[None]
    still = np.zeros((1, len(planes)), np.complex128)
    moments = Moments(none, none, none, zero, angles, np.zeros((1, len(balls))), zero, still, still, zero)
    return races, moments


def drawn_at_random(balls: tuple[Ball, ...]) -> bool:
    """Whether some balls have no start angle of their own."""
    return any(ball.start_angle is None for ball in balls)


def _angles(balls: tuple[Ball, ...]) -> list[float]:
    angles: list[float] = []
    ends: dict[tuple[int, int], float] = {}
    for ball in balls:
        half = 0.5 * occupied_angle([ball]) or 0.1
        place = (ball.balancer, ball.race)
        begin = ends.get(place, 0.0)
        angles.append(begin + half if ball.start_angle is None else float(ball.start_angle))
        ends[place] = begin + 2.1 * half
    return angles


def _channel(machine: Machine, ball: Ball) -> float:
    """From wall to wall, where resolved balls have room."""
    race = machine.balancers[ball.balancer].races[ball.race]
    return float(race.width or 0.0) if race.resolved is not None else 0.0


# What a drawing of a machine shows along its axis, as plain shapes; lengths in m.


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


def layout_of(machine: Machine) -> Layout:
    """Where the parts of a machine with balls in races are."""
    balls = resolve(machine)
    named = {station.name: float(station.position) for station in machine.stations}
    middle = _middle(machine)

    def place(station: float | str | None) -> float:
        if machine.rotor.one_plane or station is None:
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
    if rotor.one_plane:
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
    if isinstance(rotor, MultibodyRotor):
        return (*_bodies(rotor, carried, reach), "bodies are cylinders of their masses and inertias")
    held = [float(support.position) for support in getattr(rotor, "supports", ())]
    nodes = [place for place, _ in spring_model(machine).axis.line()]
    places = [*nodes, *held, *carried]
    axis = _axis(places, 0.06 * max(max(places) - min(places), reach))
    ends = [axis.start, *sorted({round(place, 9) for place in nodes}), axis.end]
    pieces = [Block(start, end, axis.radius) for start, end in pairwise(ends)]
    return pieces, [Spring(place, axis.radius) for place in held], "of the rotor axis, nodes and supports are drawn"


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
