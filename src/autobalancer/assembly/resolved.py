"""Balls that are free in the plane of their race, and the walls they feel, as numbers."""

from __future__ import annotations

import cmath
import math
from functools import lru_cache
from typing import Any

import numpy as np

from autobalancer.assembly.contact import Tables, dampers, least_rebound, meeting_table, restitution, sector
from autobalancer.assembly.drive_train import highest_prescribed
from autobalancer.assembly.guided_balls import FluidRows, WaveRows, race_harmonics
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError, Problem
from autobalancer.kernels import records
from autobalancer.kernels.compiler.callbacks import FRICTION, CompiledFunction, compile_function, in_words, numbers_row
from autobalancer.kernels.laws.contact_law import LEAST_SLIP
from autobalancer.kernels.records import FREE, FREE_BALL, NONE, PARTITION, SLIP
from autobalancer.kernels.system import Floats, Integers, Matrix, Rows, System
from autobalancer.laws.impacts import damping_ratio, hertz_damping_ratio, hertz_stiffness
from autobalancer.machine import Friction, FrictionLaw, Machine, Race, ResolvedContact
from autobalancer.machine.plugins import find
from autobalancer.machine.rebound import Rebound
from autobalancer.progress import returned

# Contact-resolved balls as rows and states of kernels/records.py.


def is_resolved(machine: Machine) -> bool:
    """Whether the balls are resolved in contact.

    Raises
    ------
    MachineError
        If they are in some races only, or something else is asked for that these balls do not know.
    """
    races = [(b, r, race) for b, balancer in enumerate(machine.balancers) for r, race in enumerate(balancer.races)]
    if not any(race.resolved is not None for _, _, race in races):
        return False
    problems: list[Problem] = [
        (("balancers", b, "races", r, "resolved"), "missing here, but given for another race; give it for all or none")
        for b, r, race in races
        if race.resolved is None
    ]
    if problems:
        raise MachineError.of("Machine", problems)
    if machine.tilting_races == "full":
        raise MachineError("tilting_races: resolved balls do not follow the tilt of their race; use 'deflection'")
    return True


def free_rows(machine: Machine, balls: tuple[Ball, ...], angles: Floats, fluids: FluidRows) -> dict[str, Rows]:
    """Rows of the balls, of their partitions and of the waves of their races, as fields of a system.

    ``angles`` at the start say between which partitions a ball is; drawn ones that overlap one are moved to its side.
    """
    rows, waves, tables = FREE_BALL.rows(len(balls)), WaveRows(machine), Tables(dampers)
    bounded = [i for i, b in enumerate(balls) if machine.balancers[b.balancer].races[b.race].partitions is not None]
    partitions = PARTITION.rows(len(bounded))
    for i, (row, ball) in enumerate(zip(rows, balls, strict=True)):
        race = machine.balancers[ball.balancer].races[ball.race]
        _fill(row, machine, race, ball)
        contact = race.resolved
        assert contact is not None
        least = least_rebound(contact.rebound, ball)
        row.rebound = tables.first(contact.rebound, float(contact.restitution or 0.0), least)
        waves.fill(row, ball)
        fluids.fill(row, i)
        row.partition = bounded.index(i) if i in bounded else NONE
        if i in bounded:
            angles[i] = set_partitions(partitions[row.partition], race, ball, angles[i], relative_mass(ball), tables)
    pairs = _pair_tables(tables, machine, balls)
    others = friction_rows(machine, balls, rows) | {"rebounds": tables.numbers, "pair_rebounds": pairs}
    return {"free_balls": rows, "free": FREE.rows(len(balls)), "partitions": partitions, "waves": waves.rows} | others


def _pair_tables(tables: Tables, machine: Machine, balls: tuple[Ball, ...]) -> Integers:
    """Where those of balls that meet begin, row by row; empty if there are none."""
    pair_tables = np.full((len(balls), len(balls)), NONE, np.int64)
    for i, ball in enumerate(balls):
        race = machine.balancers[ball.balancer].races[ball.race]
        for j, other in enumerate(balls):
            if i < j and (ball.balancer, ball.race) == (other.balancer, other.race):
                pair_tables[i, j] = meeting_table(tables, race, ball, other)
    return pair_tables.ravel() if (pair_tables != NONE).any() else np.zeros(0, np.int64)


def relative_mass(ball: Ball) -> float:
    """Mass, with virtual mass, that motion relative to the chamber has, kg."""
    return ball.mass + ball.virtual_mass * ball.displaced


def _fill(row: Any, machine: Machine, race: Race, ball: Ball) -> None:
    """All of a row that is not a place of further numbers."""
    # stiffness of both walls and between balls, and damping by the restitution
    contact = race.resolved
    assert contact is not None
    whole, gap = relative_mass(ball), room(race, ball)
    refuse_sharp_waves(race, ball, gap)
    outer_k, inner_k, ball_k = stiffnesses(contact, ball, ball.orbit_radius - gap - ball.radius)
    hertz = contact.reduced_modulus is not None
    refuse_soft_wall(machine, ball, outer_k, hertz)
    left = contact.restitution
    ratio = damping_number(contact, float(left), contact.rebound) if left is not None else 0.0
    if race.contact is not None and race.contact.stiffness is not None and not hertz:
        ball_k = float(race.contact.stiffness)
    # friction, adherence and the floor
    friction = race.friction
    hold = float(contact.adherence_stiffness)
    vertical = machine.axis == "vertical"
    row.mass = ball.effective_mass
    row.extra = whole - ball.effective_mass
    row.spin_inertia = ball.own_inertia
    row.radius = ball.radius
    row.orbit = ball.orbit_radius
    row.center_x = ball.eccentricity.real
    row.center_y = ball.eccentricity.imag
    row.station = ball.balancer
    row.race = 1000 * ball.balancer + ball.race if race.collisions else -1
    row.gap = gap
    row.hertz = int(hertz)
    row.wall_stiffness = outer_k
    row.inner_stiffness = inner_k
    row.wall_damping = float(contact.damping) if contact.damping is not None else ratio * math.sqrt(outer_k * whole)
    row.inner_damping = float(contact.damping) if contact.damping is not None else ratio * math.sqrt(inner_k * whole)
    row.ball_stiffness = ball_k
    row.ball_damping = meeting_damping(contact, race)
    row.sliding = float(contact.sliding_friction)
    row.slip_speed = float(contact.slip_speed)
    row.rolling_arm = float(friction.rolling_resistance) * ball.radius if friction is not None else 0.0
    row.rest_speed = float(contact.rest_speed or 1.0)
    row.adherence = float(friction.adherence or 0.0) if friction is not None else 0.0
    row.hold_stiffness = hold
    row.hold_damping = 2.0 * math.sqrt(hold * whole)
    row.floor = float(contact.floor_friction)
    row.floor_arm = ball.radius if contact.floor_motion == "rolling" and vertical and row.floor > 0.0 else 0.0
    row.weight = ball.effective_mass * float(machine.gravity) if vertical else 0.0
    row.ball_sliding = float(contact.ball_friction)
    row.viscous = ball.drag / ball.orbit_radius**2


def start_states(machine: Machine, balls: tuple[Ball, ...], angles: Floats, rows: Rows, speed: float) -> Matrix:
    """Balls that roll at their start angles and speeds, pressed on their wall by the ``speed`` of the rotor (rad/s)."""
    states = np.zeros((len(balls), records.BALL_STATES))
    for row, numbers, ball, angle in zip(states, rows, balls, angles, strict=True):
        race = machine.balancers[ball.balancer].races[ball.race]
        assert race.resolved is not None
        radius, slope = orbit_at(race, ball, angle)
        steep = math.hypot(1.0, slope / radius)  # distance along the radius over distance from the wall
        beyond = -float(race.resolved.start_gap)
        if race.resolved.start_gap == 0.0:
            in_space, rest = speed + ball.start_speed, relative_mass(ball) - ball.effective_mass
            force = ball.orbit_radius * (ball.effective_mass * in_space**2 + rest * ball.start_speed**2)
            beyond = _depth(numbers, force)
        place = (radius + beyond * steep) * cmath.rect(1.0, angle)
        velocity = (slope * cmath.rect(1.0, angle) + 1j * place) * ball.start_speed
        row[[records.BALL_X, records.BALL_Y]] = place.real, place.imag
        row[[records.BALL_VX, records.BALL_VY]] = velocity.real, velocity.imag
        if race.resolved.start_gap == 0.0:
            along = (velocity * (1j * radius + slope).conjugate() * cmath.rect(1.0, -angle)).real / abs(
                radius + 1j * slope
            )
            row[records.BALL_SPIN] = -along / ball.radius
            if numbers.floor_arm > 0.0:  # on floor and wall at once it turns about their diagonal
                normal = (radius - 1j * slope) * cmath.rect(1.0, angle) / abs(radius + 1j * slope)
                spin = row[records.BALL_SPIN]
                row[[records.TUMBLE_X, records.TUMBLE_Y]] = spin * normal.real, spin * normal.imag
    return states


def resolved_scales(balls: tuple[Ball, ...], rows: Rows, speed: float) -> Matrix:
    """Sizes of the states for tolerances, (n, BALL_STATES): depth of contact and its frequency at this speed of the rotor."""
    scales = np.ones((len(balls), records.BALL_STATES))
    for scale, row, ball in zip(scales, rows, balls, strict=True):
        force = max(ball.moment * speed**2, 10.0 * ball.effective_mass)
        power = 1.5 if row.hertz else 1.0
        depth = _depth(row, force)
        frequency = math.sqrt(power * force / depth / relative_mass(ball))
        scale[[records.BALL_X, records.BALL_Y, records.HOLD]] = depth
        scale[[records.BALL_VX, records.BALL_VY]] = depth * frequency
        scale[[records.BALL_SPIN, records.TUMBLE_X, records.TUMBLE_Y]] = depth * frequency / ball.radius
    return scales


def _depth(row: Any, force: float) -> float:
    """How deep the outer wall is pressed by a force, m."""
    return float((force / row.wall_stiffness) ** (2.0 / 3.0 if row.hertz else 1.0))


def ball_states(states: Matrix, system: System, rotor_size: int) -> Any:
    """The states of the balls alone, (times, n, BALL_STATES)."""
    count = system.ball_count
    first = 2 + 2 * rotor_size + 2 * count
    return states[:, first : first + count * records.BALL_STATES].reshape(-1, count, records.BALL_STATES)


# Walls and partitions of races with contact-resolved balls: room, stiffness, shape.


DEEPEST = 0.1  # of the ball radius, by which a wall may give way under centrifugal force
ROUNDING = 1.0 + 1e-9  # a ball may start on the inner wall, however its distance was rounded


def room(race: Race, ball: Ball) -> float:
    """What the ball center can move between outer and inner wall, m; infinite without an inner wall."""
    assert race.resolved is not None
    gap, start = math.inf, float(race.resolved.start_gap)
    if race.width is not None:
        gap = float(race.width) - ball.diameter
        outer = ball.orbit_radius + ball.radius
        if race.width >= outer:
            raise MachineError(
                f"{_name(ball)}.width: given {1e3 * race.width:.4g} mm; must be less than the radius of the wall, "
                f"{1e3 * outer:.4g} mm; leave it out where there is no inner wall"
            )
    most = min(gap, ball.orbit_radius)
    if start > most * ROUNDING:
        raise MachineError(
            f"{_name(ball)}.resolved.start_gap: given {1e3 * start:.4g} mm; a ball has {1e3 * most:.4g} mm at most"
        )
    return gap


def _name(ball: Ball) -> str:
    return f"balancers[{ball.balancer + 1}].races[{ball.race + 1}]"


def refuse_soft_wall(machine: Machine, ball: Ball, stiffness: float, hertz: bool) -> None:
    """Refuse a wall that centrifugal force at the greatest known speed pushes in by more than a tenth of the ball radius."""
    highest = highest_prescribed(machine)
    if highest is None:
        return
    force = ball.effective_mass * highest**2 * ball.orbit_radius
    power = 1.5 if hertz else 1.0
    depth, most = (force / stiffness) ** (1.0 / power), DEEPEST * ball.radius
    if depth > most:
        key = "reduced_modulus" if hertz else "stiffness"
        raise MachineError(
            f"{_name(ball)}.resolved.{key}: at {highest:.4g} rad/s the wall is compressed by "
            f"{1e3 * depth:.3g} mm under a ball of {2e3 * ball.radius:.3g} mm, which would pass through it; use at least "
            f"{force / most**power / stiffness:.2g} times this value"
        )


def refuse_sharp_waves(race: Race, ball: Ball, gap: float) -> None:
    """Refuse an orbit that no wall can make, because it is bent more sharply around a wall than the ball is round."""
    key, orders = "roundness" if race.roundness is not None else "harmonics", race_harmonics(race).shape[0]
    if orders == 0:
        return
    radius, first, second = _orbit(race, ball, np.linspace(0.0, 2.0 * math.pi, 40 * orders, endpoint=False))
    for level, sign, wall in ((radius, -1.0, "outer"), (radius - gap, 1.0, "inner")):
        if not np.isfinite(level).all():
            continue
        if level.min() <= 0.0:
            raise MachineError(
                f"{_name(ball)}.{key}: the {wall} wall would leave the ball center {1e3 * level.min():.4g} mm from the center "
                "of the race; take smaller waves"
            )
        bend = sign * (level**2 + 2.0 * first**2 - level * second) / np.hypot(level, first) ** 3
        if bend.max() * ball.radius >= 1.0:
            raise MachineError(
                f"{_name(ball)}.{key}: a ball of {1e3 * ball.radius:.4g} mm radius cannot follow the {wall} wall: "
                f"its orbit is curved around it with a radius of {1e3 / bend.max():.4g} mm; use smaller or fewer waves"
            )


def orbit_at(race: Race, ball: Ball, angle: float) -> tuple[float, float]:
    """Radius of the orbit and its derivative at an angle, m."""
    radius, first, _ = _orbit(race, ball, np.array([angle]))
    return float(radius[0]), float(first[0])


def _orbit(race: Race, ball: Ball, angles: Floats) -> tuple[Floats, Floats, Floats]:
    waves = race_harmonics(race)
    orders = np.arange(1, waves.shape[0] + 1)
    turning = np.exp(1j * np.outer(angles, orders)) * (waves[:, 0] - 1j * waves[:, 1])
    radius, first, second = (np.asarray((turning * (1j * orders) ** n).sum(axis=1).real) for n in range(3))
    return ball.orbit_radius + radius, first, second


def stiffnesses(contact: ResolvedContact, ball: Ball, inner: float) -> tuple[float, float, float]:
    """Of outer wall, inner wall (of radius ``inner``, m) and another ball."""
    if contact.reduced_modulus is None:
        stiffness = float(contact.stiffness or 0.0)
        return stiffness, stiffness, stiffness
    modulus = float(contact.reduced_modulus)
    outer = hertz_stiffness(modulus, ball.radius, ball.orbit_radius + ball.radius)
    within = hertz_stiffness(modulus, ball.radius, -inner) if inner > 0.0 else 0.0
    return outer, within, hertz_stiffness(modulus, 1.0)  # of a pair whose radii reduce to 1 m


def damping_number(contact: ResolvedContact, share: float, rebound: Rebound | None) -> float:
    """Damping over sqrt(stiffness mass) that leaves this ``share`` of the speed; with Hertz that of d^(1/4).

    Where it depends on the impact, that of damping ratio 1.
    """
    if contact.reduced_modulus is not None:
        return hertz_damping_ratio(share) if rebound is None else math.sqrt(5.0)
    return 2.0 * (damping_ratio(share) if rebound is None else 1.0)


def meeting_damping(contact: ResolvedContact, race: Race) -> float:
    """The same of balls that meet each other or a partition."""
    return damping_number(contact, restitution(race), race.contact.rebound if race.contact is not None else None)


def set_partitions(row: Any, race: Race, ball: Ball, angle: float, mass: float, tables: Tables) -> float:
    """Fill a row with the partitions around a ball that starts at ``angle``; returns the angle beside them."""
    contact = race.resolved
    assert contact is not None
    half = math.asin(ball.radius / max(ball.orbit_radius - float(contact.start_gap), ball.radius))
    low, high = sector(race, ball, angle, half)
    stiffness = stiffnesses(contact, ball, math.inf)[0]
    if contact.reduced_modulus is not None:
        stiffness = hertz_stiffness(float(contact.reduced_modulus), ball.radius)
    elif race.contact is not None and race.contact.stiffness is not None:
        stiffness = 2.0 * float(
            race.contact.stiffness
        )  # a partition is where the mirror image of the ball would meet it
    behind, ahead = cmath.rect(1.0, low) * 1j, cmath.rect(1.0, high) * -1j
    row.behind_x, row.behind_y, row.ahead_x, row.ahead_y = behind.real, behind.imag, ahead.real, ahead.imag
    row.middle, row.stiffness = 0.5 * (low + high), stiffness
    row.damping = meeting_damping(contact, race) * math.sqrt(stiffness * mass)
    row.rebound = meeting_table(tables, race, ball)
    return min(max(angle, low + half), high - half)


# Friction laws: compiled, tried, and put into the rows of the balls.


SLIPS = np.geomspace(1e-6, 10.0, 29)  # m/s, at which a law is tried in both directions
PRESSED = (1e-2, 1.0, 1e3)  # N
REST = 1e-6  # share of the greatest coefficient that a law may have without slip


def friction_rows(machine: Machine, balls: tuple[Ball, ...], rows: Rows) -> dict[str, Any]:
    """Slips and numbers of friction laws as fields of a system, none without a law; these go into the ``rows`` of the balls.

    Raises
    ------
    MachineError
        If a law cannot be used; the message says which one, and why.
    """
    slips = SLIP.rows(len(balls))
    numbers: list[float] = []
    for row, slip, ball in zip(rows, slips, balls, strict=True):
        path, law, (slip.sliding, slip.slip_speed, most) = _law(machine, ball)
        slip.radius, slip.pressed = ball.radius, math.nan
        if law is None:
            continue
        try:
            row.friction = _tried(law, float(slip.sliding), float(slip.slip_speed), ball.radius, most).address
        except MachineError as reason:
            raise MachineError(f"{_name(ball)}.{path}: the friction law {law.word()!r} {reason}") from None
        row.first_number = len(numbers)
        numbers += law.numbers().values() or (0.0,)
    return {"slips": slips, "friction_numbers": np.array(numbers, np.float64)} if numbers else {}


def friction_at_fault(machine: Machine, balls: tuple[Ball, ...], system: System) -> str:
    """Which friction law was not a number during a run, and where; empty if none was."""
    wrong = np.flatnonzero(system.slips.wrong)
    if not wrong.size:
        return ""
    number = int(wrong[0])
    at, law = system.slips[number], _law(machine, balls[number])[1]
    assert law is not None
    return (
        f"the friction law {law.word()!r} was not a number on ball {number + 1} {_at(at.wrong_slip, at.wrong_pressed)}"
    )


def _at(slip: float, pressed: float) -> str:
    wall = "" if math.isnan(pressed) else f" on a wall that presses with {pressed:.4g} N"
    return f"at a slip of {slip:.6g} m/s{wall}"


def _law(machine: Machine, ball: Ball) -> tuple[str, FrictionLaw | None, tuple[float, float, float]]:
    """Where the law of a ball stands, and itself; coefficient and speed of its slip, and the greatest with which it may begin."""
    race = machine.balancers[ball.balancer].races[ball.race]
    if race.resolved is None:
        given = race.friction or Friction()
        return "friction.rolling_law", given.rolling_law, (given.rolling_resistance, 1e-3 * LEAST_SLIP, given.holding)
    contact, law = race.resolved, race.resolved.friction_law or find(FrictionLaw, "coulomb")()
    assert isinstance(law, FrictionLaw)
    return "resolved.friction_law", law, (float(contact.sliding_friction), float(contact.slip_speed), math.inf)


@lru_cache(maxsize=256)
def _tried(law: FrictionLaw, sliding: float, slip_speed: float, radius: float, most: float) -> CompiledFunction:
    """The compiled law of a ball: a number everywhere, against the slip, and nothing without it.

    A guided ball, which adherence holds, begins to roll with ``most`` at most.
    """
    function = getattr(type(law), "coefficient", None)
    if function is None:
        raise MachineError("has no 'coefficient'; write it as a static method: coefficient(at, own) -> float")
    requested = function, tuple(law.numbers()), FRICTION
    try:
        made = compile_function(*requested)
    except Exception as reason:
        raise MachineError(f"does not compile: {in_words(reason, *requested)}") from None
    at = SLIP.row(sliding=sliding, slip_speed=slip_speed, radius=radius)
    returned(lambda: _refuse_driving(law, made, at, most), f"the friction law {law.word()!r}")
    return made


def _refuse_driving(law: FrictionLaw, made: CompiledFunction, at: Any, most: float) -> None:
    """Refuse a law that is not a number somewhere, or drives a ball."""
    own, greatest = numbers_row(law.numbers()), 0.0
    for pressed in PRESSED if math.isinf(most) else (math.nan,):
        for slip in (LEAST_SLIP, *SLIPS, *-SLIPS, 0.0):
            at.slip, at.pressed = slip, pressed
            value, where = float(made.function(at, own)), _at(slip, pressed)
            if value > most * ROUNDING and slip == LEAST_SLIP:
                raise MachineError(
                    f"begins to roll with {value:.4g}; the adherence must not be less, now it is {most:.4g}"
                )
            if not math.isfinite(value):
                raise MachineError(f"is not a number {where}: it returned {value:g}")
            greatest = max(greatest, abs(value))
            if slip == 0.0 and abs(value) > REST * greatest:
                raise MachineError(
                    f"drives a ball that does not slip, with the coefficient {value:.4g}; it must be zero there"
                )
            if value * slip < 0.0:
                raise MachineError(
                    f"drives the ball {where}: its coefficient is {value:.4g}; it must have the sign of the slip, against "
                    "which friction acts"
                )
