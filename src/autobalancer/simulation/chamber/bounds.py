"""What a deep chamber can do at best, from closed forms that cost nothing."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.linalg import eigh
from scipy.spatial.distance import cdist

from autobalancer.assembly.chamber_assembly import machine_row, profile_rows
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import balls_in_chambers
from autobalancer.laws import deep_chamber
from autobalancer.laws.capabilities import chamber_capability
from autobalancer.laws.impacts import greatest_pressure, reduced_modulus
from autobalancer.laws.stall import held_whirl
from autobalancer.machine.chamber import Chamber, ChamberMachine, FreeBalls
from autobalancer.machine.drive import AsynchronousMotor
from autobalancer.random_numbers import generator
from autobalancer.results.display_units import couple_text, force_text, length_text, moment_text
from autobalancer.results.time_series import end_of_run_up
from autobalancer.tables import Described, rpm_and_si

# Balls put into their chambers, as many as fit.


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
        sizes = joined_sizes([sizes_of(group, group.count) for group in groups])
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
        placed, sizes = np.vstack([placed, sites[k]]), joined_sizes([sizes, sizes_of(group, count)])
    return np.vstack([sites[k] for k in range(len(groups))])


def _packing(chamber: Chamber, radius: float, half_width: float, down: Array) -> Array:
    sites = filling_sites(float(chamber.radius), chamber.inner_depth, radius, float(chamber.inner_radius), half_width)
    # the packing, made for gravity along -z, turned about x so that its bottom is down
    across = math.hypot(down[1], down[2])
    if across < 1e-9 or not len(sites):
        return sites
    c, s = -down[2] / across, down[1] / across
    return np.column_stack([sites[:, 0], c * sites[:, 1] - s * sites[:, 2], s * sites[:, 1] + c * sites[:, 2]])


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


def joined_sizes(sizes: list[Sizes]) -> Sizes:
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


SPEEDS = 400  # at which the shaking of the run-up is looked at


@dataclass(frozen=True, repr=False)
class ChamberBounds(Described):
    """What the balls of one chamber can do at best, and how well that bounds a run. SI.

    ``least_`` and ``greatest_`` values are those that no run gets below or above. ``axial_rows`` says in how many
    rows along the axis the balls lie at the bottom before the start. nan where something is not known.
    """

    name: str
    speed: float
    critical_speed: float
    unbalance: float
    capability: float
    least_residual: float
    swung_residual: float
    held_residual: float
    vibration_without_balls: float
    least_vibration: float
    friction: float
    drag_ratio: float
    least_friction: float
    axial_rows: int
    shaking: float
    run_up_time: float
    decay_rate: float
    best_decay_rate: float
    least_settled_at: float
    least_settling_time: float
    drag: float
    best_drag: float
    race_force: float
    race_pressure: float
    greatest_couple: float
    couple_bearing_force: float
    least_bearing_force: float
    warnings: tuple[str, ...] = ()

    def rows(self, said: Callable[[float], str] = rpm_and_si) -> list[tuple[str, str]]:
        """A name and a text each, with speeds as ``said`` writes them."""
        calm = "calm: balls stay in touch with the bottom" if self.shaking < 1.0 else "balls hop at the bottom"
        one = "one row along the axis, which acts as one ball"
        lying = one if self.axial_rows == 1 else f"{self.axial_rows} rows along the axis"
        pressure = "" if math.isnan(self.race_pressure) else f", {1e-6 * self.race_pressure:.4g} MPa"
        held = moment_text(self.held_residual) if self.held_residual else "nothing, for gravity keeps the balls moving"
        rate = f"{self.decay_rate:.3g} 1/s, at best {self.best_decay_rate:.3g} 1/s with a drag of {self.best_drag:.3g} N s/m"
        return [
            ("speed", f"{said(self.speed)}, highest critical speed {said(self.critical_speed)}"),
            ("unbalance", f"{moment_text(self.unbalance)}; the balls can balance {moment_text(self.capability)}"),
            ("residual", f"at least {moment_text(self.least_residual)}; rolling resistance can hold {held}"),
            (
                "vibration",
                f"{length_text(self.vibration_without_balls)} without balls; at least {length_text(self.least_vibration)}",
            ),
            (
                "pick-up",
                f"one sliding ball needs a friction of {self.least_friction:.3g} on a calm rotor and has {self.friction:g}\n"
                f"the balls lie in {lying}\n"
                f"the rotor shakes with {self.shaking:.3g} g at most, {calm}",
            ),
            ("run-up", f"critical speed passed after {self.run_up_time:.3g} s or later"),
            ("small motions", f"decay with {rate}"),
            ("settling", f"{self.least_settled_at:.3g} s after the start or later"),
            ("ball on the race", f"{force_text(self.race_force)}{pressure}"),
            (
                "couple of the balls",
                f"at most {couple_text(self.greatest_couple)}, {force_text(self.couple_bearing_force)} on each bearing",
            ),
            ("bearings", f"the more loaded one bears {force_text(self.least_bearing_force)} or more"),
        ]


def bounds(machine: ChamberMachine | str | Path) -> ChamberBounds:
    """What the equal balls of a machine with one deep chamber can do at best, from closed forms.

    Capability by :func:`~autobalancer.laws.capabilities.chamber_capability`; pick-up, settling and swing by the
    derivations in ``autobalancer.laws.deep_chamber``; pressure by Hertz.

    Raises
    ------
    QuestionError
        If the machine has several chambers or groups of balls, cylinders, no unbalance, nothing that turns it, or a fixed body.
    """
    machine = balls_in_chambers(machine)
    (chamber, group), contact = one_group(machine, "bounds are"), machine.contact
    mass, radius, count = group.ball_mass, group.radius, group.count
    path = float(chamber.radius) - radius
    speed = final_speed(machine)
    if not speed > 0.0:
        raise QuestionError("drive: the rotor does not turn at the end; bounds need a speed")
    gravity = math.hypot(*machine.gravity[1:])
    size = float(abs(sum(part.vector for part in machine.unbalances)))
    if not size > 0.0:
        raise QuestionError("unbalances: the rotor has none to balance; give one")
    without = body_without_balancing(machine, speed)
    if not without > 0.0:
        raise QuestionError(
            "body: does not move with the unbalance at the final speed, so no ball feels it; free the body"
        )
    # what the balls can reach at best: the residual by capability, swinging and rolling resistance
    moved = size / without
    capability = chamber_capability(float(chamber.radius), chamber.inner_depth, [(count, radius, mass)])
    lacking = abs(size - mass * path) if count == 1 else max(size - capability, 0.0)
    roll = float(contact.rolling_arm) / radius * speed**2 * path  # rolling resistance over the mass
    swung = deep_chamber.swung_residual(count * mass, deep_chamber.swing(gravity, speed, roll))
    # whether the fluid and friction carry a ball over the top
    drag, square = float(chamber.drag), float(chamber.square_drag)
    slip = speed * path
    ratio = (drag + square * slip) * slip / (mass * gravity) if gravity > 0.0 else math.inf
    # how early it can be settled: not before the critical speed is passed, then by the slowest decay
    critical = max(chamber_critical_speeds(machine)[0], default=math.nan)
    passed = time_to(machine, critical)
    best = deep_chamber.best_decay_rate(drag, mass, count, moved, speed)
    smoothed = deep_chamber.smoothed_drag(roll, gravity, speed) if roll > 0.0 else 0.0
    # what race and bearings carry
    force = mass * speed**2 * path
    span = abs(machine.rotor.bearings[0] - machine.rotor.bearings[1])
    couple = count * mass * path * (0.5 * chamber.inner_depth - radius)
    return ChamberBounds(
        name=machine.name,
        speed=speed,
        critical_speed=critical,
        unbalance=size,
        capability=capability,
        least_residual=max(lacking, swung if lacking == 0.0 else 0.0),
        swung_residual=swung,
        held_residual=moved * max(held_whirl(path, roll / (speed**2 * path), weight=gravity / speed**2), 0.0),
        vibration_without_balls=without,
        least_vibration=without * lacking / size,
        friction=float(contact.friction),
        drag_ratio=ratio,
        least_friction=deep_chamber.least_friction(ratio),
        axial_rows=math.ceil(count / balls_beside(chamber.inner_depth, radius)),
        shaking=_shaking(machine, speed, gravity),
        run_up_time=passed,
        decay_rate=deep_chamber.decay_rate(drag + mass * smoothed, mass, count, moved, speed)
        if smoothed < math.inf
        else 0.0,
        best_decay_rate=best,
        least_settled_at=passed + 1.0 / best,
        least_settling_time=_after_run_up(machine, passed + 1.0 / best),
        drag=drag,
        best_drag=deep_chamber.best_drag(mass, count, moved, speed),
        race_force=force,
        race_pressure=_pressure(machine, force, radius, float(chamber.radius)),
        greatest_couple=couple,
        couple_bearing_force=couple * speed**2 / span,
        least_bearing_force=0.5 * gravity * (float(machine.rotor.mass) + count * mass),
    )


def one_group(machine: ChamberMachine, what: str, *, cylinders: bool = False) -> tuple[Chamber, FreeBalls]:
    """The chamber of a machine that has one, with equal balls or, if they may be, ``cylinders``; ``what`` asks for it.

    Raises
    ------
    QuestionError
        If it has more, or cylinders.
    """
    chamber = machine.chambers[0]
    if len(machine.chambers) != 1 or len(chamber.balls) != 1:
        raise QuestionError(f"machine: has several chambers or groups of balls; {what} of one chamber with equal balls")
    if chamber.balls[0].body != "ball" and not cylinders:
        raise QuestionError(
            f"machine: its chamber has cylinders; {what} of balls only; check and simulate take cylinders"
        )
    return chamber, chamber.balls[0]


def final_speed(machine: ChamberMachine) -> float:
    """Speed at the end of the run-up (rad/s); that of a motor without load."""
    if isinstance(machine.drive, AsynchronousMotor):
        return float(machine.drive.synchronous_speed)
    return float(profile_rows(machine).speed[-1])


def highest_speed(machine: ChamberMachine) -> float:
    """Greatest speed of a run (rad/s); that of a motor without load."""
    if isinstance(machine.drive, AsynchronousMotor):
        return float(machine.drive.synchronous_speed)
    return float(profile_rows(machine).speed.max())


def time_to(machine: ChamberMachine, speed: float) -> float:
    """Least time (s) after which the rotor has a ``speed``: that of a motor that turns the rotor alone, without losses."""
    drive = machine.drive
    if math.isnan(speed):
        return 0.0
    if not isinstance(drive, AsynchronousMotor):
        rows = profile_rows(machine)
        above = np.flatnonzero(rows.speed >= speed)
        if not above.size:
            return math.inf
        last = int(above[0])
        return float(np.interp(speed, rows.speed[last - 1 : last + 1], rows.time[last - 1 : last + 1])) if last else 0.0
    width = drive.synchronous_speed * drive.breakdown_slip
    first, end = drive.synchronous_speed - float(machine.start.speed), drive.synchronous_speed - speed
    if end <= 0.0:
        return math.inf
    if end >= first:
        return 0.0
    work = width**2 * math.log(first / end) + 0.5 * (first**2 - end**2)
    return float(machine.rotor.polar_inertia * work / (2.0 * drive.rated_torque * drive.overload * width))


def _after_run_up(machine: ChamberMachine, time: float) -> float:
    """A time (s) from the start as one from the end of the run-up; 0 for a motor, which may take any time."""
    if isinstance(machine.drive, AsynchronousMotor):
        return 0.0
    rows = profile_rows(machine)
    return max(time - end_of_run_up(rows.time, rows.speed, 0.0), 0.0)


def pressure_between_balls(machine: ChamberMachine, force: float) -> float:
    """Greatest pressure (Pa) of a contact with this force (N) between two balls, the hardest there is; nan without a material."""
    return _pressure(machine, force, 0.5 * machine.chambers[0].balls[0].radius, math.inf)


def _pressure(machine: ChamberMachine, force: float, radius: float, wall: float) -> float:
    contact = machine.contact
    if contact.youngs_modulus is None:
        return math.nan
    modulus = reduced_modulus(float(contact.youngs_modulus), float(contact.poisson_ratio))
    return greatest_pressure(force, modulus, radius, wall)


def _shaking(machine: ChamberMachine, highest: float, gravity: float) -> float:
    speeds = np.linspace(highest / SPEEDS, highest, SPEEDS)
    whirls = vibrations_without_balancing(machine, speeds)
    return max(deep_chamber.shaking(float(w), float(s), gravity) for w, s in zip(whirls, speeds, strict=True) if w == w)


# Places for equal balls in a cylinder or ring, in layers from the bottom (after Pakuła 2021, appendix 3).


AIR = 1.002  # distance of neighbors over their diameter


def filling_sites(
    radius: float, depth: float, ball_radius: float, inner_radius: float = 0.0, half_width: float | None = None
) -> Array:
    """Places (sites, 3) for balls in a cylinder along x, from its middle, with the bottom at -z.

    Cylinders along x have another ``half_width`` there than their radius.
    Of several packings the one with most places: columns of staggered rows, staggered columns of straight rows, and around an
    inner wall circles within each other.
    """
    wide = ball_radius if half_width is None else half_width
    reach, half = radius - ball_radius, 0.5 * depth - wide
    pitch = 2.0 * ball_radius * AIR
    if half < 0.0 or reach < 0.0:
        return np.zeros((0, 3))
    along = _line(half, 2.0 * wide * AIR)
    best = np.zeros((0, 3))
    for sites in [*_rows(reach, pitch, along), *([_circles(reach, pitch, along)] if inner_radius > 0.0 else [])]:
        near = inner_radius + ball_radius if inner_radius > 0.0 else 0.0
        inside = sites[np.hypot(sites[:, 1], sites[:, 2]) >= near * (1.0 - 1e-12)]
        if len(inside) > len(best):
            best = inside
    return best


def balls_beside(depth: float, ball_radius: float) -> int:
    """How many balls lie beside each other over the depth of a chamber."""
    return _count(0.5 * depth - ball_radius, 2.0 * ball_radius * AIR)


def _count(half: float, pitch: float) -> int:
    return math.floor(2.0 * half / pitch * (1.0 + 1e-12)) + 1


def _line(half: float, pitch: float) -> Array:
    count = _count(half, pitch)
    pitch = min(pitch, 2.0 * half) if count > 1 else pitch
    return (np.arange(count) - 0.5 * (count - 1)) * pitch


def _rows(reach: float, pitch: float, along: Array) -> list[Array]:
    rows = []
    for lift in (0.5 * math.sqrt(3.0) * pitch, pitch):
        for low in (0.0, 0.5):
            sites = [np.zeros((0, 3))]
            height, row = -reach * (1.0 - 1e-9) if low == 0.0 else -lift * math.floor(reach / lift), 0
            while height <= reach:
                width = math.sqrt(max(reach**2 - height**2, 0.0))
                shift = 0.5 * pitch if (row % 2 and lift < pitch) else 0.0
                count = math.floor((width - shift) / pitch)
                offsets = np.arange(-count - (1 if shift else 0), count + 1) * pitch + shift
                inside = offsets[np.abs(offsets) <= width]
                sites.append(_row(inside, np.full(inside.size, height), along))
                height += lift
                row += 1
            rows.append(np.vstack(sites))
    return rows


def _circles(reach: float, pitch: float, along: Array) -> Array:
    sites = [np.zeros((0, 3))]
    circle = reach
    while circle > 0.5 * pitch:
        turn = 2.0 * math.asin(0.5 * pitch / circle)
        count = math.floor(2.0 * math.pi / turn * (1.0 + 1e-12))
        angles = (np.arange(count) - count // 2) * turn
        sites.append(_row(circle * np.sin(angles), -circle * np.cos(angles), along))
        circle -= pitch
    return np.vstack(sites)


def _row(y: Array, z: Array, along: Array) -> Array:
    """A line of places along x at each (y, z)."""
    n = along.size
    return np.column_stack([np.tile(along, y.size), np.repeat(y, n), np.repeat(z, n)])


# Critical speeds of the body of a machine with chambers.


# force and moment of an unbalance and of a couple that turn from y to z, in the order x, y, z, then about them
UNBALANCES = np.array([[0, 1, -1j, 0, 0, 0], [0, 0, 0, 0, 1j, 1]]).T


def chamber_critical_speeds(machine: ChamberMachine) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Speeds at which the undamped machine meets its unbalance (rad/s), ascending, and the damping ratios there.

    The balls count as masses in the middles of their chambers. With a motion exp(i w t) at the speed w of the rotor the
    gyroscopic moment goes with the square of w as the inertia does, so that K u = w² (M - i G) u with Hermitian M - i G.
    Motions on which no unbalance or couple does work are left out: those along the axis, and backward whirl in a circle.
    """
    free, m, g, k, c = linear_body(machine)
    if not len(free) or not k.any():
        return (), ()  # nothing moves, or nothing holds it
    # K is definite or nearly so and M - i G need not be: 1/w² are the eigenvalues of the pencil turned around
    softest = 1e-12 * np.trace(k) * np.eye(len(free))
    inverse, shapes = eigh(m - 1j * g, k + softest)
    work = np.abs(shapes.T.conj() @ UNBALANCES[free]) / np.linalg.norm(shapes, axis=0)[:, None]
    met = sorted(
        float(value) ** -0.5 for value, own in zip(inverse, work, strict=True) if own.max() > 1e-6 and 0 < value < 1e10
    )
    speeds = [speed for speed, before in zip(met, [0.0, *met], strict=False) if speed > before * (1.0 + 1e-9)]
    return tuple(speeds), tuple(_ratio(m, c + speed * g, k, speed) for speed in speeds)


def linear_body(machine: ChamberMachine) -> tuple[Array, Array, Array, Array, Array]:
    """Free coordinates of the body, and M, G of speed one, K and C over them, balls in the middles of their chambers."""
    numbers = machine_row(machine, held=True)
    free = numbers.free[numbers.free >= 0]
    gyroscopic = np.zeros((6, 6))
    gyroscopic[4, 5], gyroscopic[5, 4] = machine.rotor.polar_inertia, -machine.rotor.polar_inertia
    chosen = np.ix_(free, free)
    return free, numbers.inertia[chosen], gyroscopic[chosen], numbers.stiffness[chosen], numbers.damping[chosen]


def body_without_balancing(machine: ChamberMachine, speed: float) -> float:
    """Greatest vibration (m) of the middle of the rotor at a steady speed, with the balls in the middles of the chambers.

    nan at a critical speed of an undamped body.
    """
    return float(vibrations_without_balancing(machine, [speed])[0])


def vibrations_without_balancing(machine: ChamberMachine, speeds: Array) -> Array:
    """The same at many speeds, (speeds,) m."""
    free, m, g, k, c = linear_body(machine)
    static = sum(part.vector for part in machine.unbalances)
    couple = sum(part.vector * part.position for part in machine.unbalances)
    load = (UNBALANCES @ np.array([static, couple], complex))[free]
    vibrations = np.full(len(speeds), np.nan)
    for i, speed in enumerate(speeds):
        moved = np.zeros(6, complex)
        try:
            moved[free] = np.linalg.solve(k + 1j * speed * (c + speed * g) - speed**2 * m, speed**2 * load)
        except np.linalg.LinAlgError:
            continue
        vibrations[i] = 0.5 * float(abs(moved[1] + 1j * moved[2]) + abs(moved[1] - 1j * moved[2]))
    return vibrations


def _ratio(m: Array, c: Array, k: Array, speed: float) -> float:
    size = len(m)
    state = np.block([[np.zeros((size, size)), np.eye(size)], [-np.linalg.solve(m, k), -np.linalg.solve(m, c)]])
    root = min(np.linalg.eigvals(state), key=lambda value: abs(value - 1j * speed))
    return float(-root.real / abs(root))


# Whether cylinders, which a run holds parallel to the rotor, would stay so.


MUCH = math.radians(5.0)  # tilt between the flat walls beyond which a run is doubtful


def tilt_between_walls(length: float, diameter: float, gap: float) -> float:
    """How far a cylinder can tilt between flat walls that are ``gap`` apart, rad; pi/2 where it can turn over.

    Its corners meet the walls where L cos a + D sin a is the gap.
    """
    diagonal = math.hypot(length, diameter)
    if gap >= diagonal:
        return 0.5 * math.pi
    return max(math.atan2(diameter, length) - math.acos(min(gap / diagonal, 1.0)), 0.0)


def tilt_clearance(chamber: Chamber, group: FreeBalls) -> float | None:
    """How far the flat walls let a cylinder tilt that is alone between them, rad; ``None`` of a ball."""
    if group.length is None:
        return None
    return tilt_between_walls(float(group.length), 2.0 * group.radius, chamber.inner_depth)


def tilting_warnings(machine: ChamberMachine) -> list[str]:
    """What lets cylinders tilt, as sentences."""
    tilting_warnings, friction = [], float(machine.contact.friction)
    for number, chamber in enumerate(machine.chambers, 1):
        for group in chamber.balls:
            if group.length is None:
                continue
            length, diameter = float(group.length), 2.0 * group.radius
            size = f"{1e3 * diameter:.4g} mm by {1e3 * length:.4g} mm"
            tilt = tilt_clearance(chamber, group) or 0.0
            if tilt > MUCH:
                room = "turn over" if tilt > 1.57 else f"tilt by {math.degrees(tilt):.3g} degrees"
                tilting_warnings.append(
                    f"chamber {number} is {1e3 * chamber.inner_depth:.4g} mm deep: a cylinder of {size} could {room} there, and "
                    "the run holds it parallel to the rotor; look at 'tilting' of the run, or take a chamber little deeper "
                    "than the cylinders are long"
                )
            if friction * length > diameter:
                tilting_warnings.append(
                    f"friction of {friction:g} at a flat wall can tip a cylinder of {size} (its length times friction is more "
                    "than its diameter); the run holds it parallel to the rotor"
                )
            if friction * diameter > length:
                tilting_warnings.append(
                    f"friction of {friction:g} at the race can tip a cylinder of {size} (its diameter times friction is more "
                    "than its length); the run holds it parallel to the rotor"
                )
    return tilting_warnings


def tilting_note(run: xr.Dataset) -> str:
    """How far the contacts of a run press its cylinders to tilt; empty for balls."""
    if "tilting" not in run:
        return ""
    tilting = run["tilting"].values
    most, over = float(tilting.max(initial=0.0)), 100.0 * float(np.mean(tilting > 1.0))
    if over == 0.0:
        return f"the cylinders stay parallel: what would tilt one is at most {most:.2g} of what its contacts can bear"
    at = float(run["time"].values[int(np.argmax(tilting))])
    return (
        f"the cylinders are held parallel to the rotor; in {over:.2g} % of the samples a contact would tilt one, with up to "
        f"{most:.2g} times what its contacts can bear (at {at:.4g} s)"
    )
