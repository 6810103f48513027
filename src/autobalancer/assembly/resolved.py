"""Contact-resolved balls as the rows and states of kernels/resolved_layout.py."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from autobalancer.assembly.contacts import CRITICAL, damping_ratio
from autobalancer.assembly.fluid_numbers import FluidNumbers, Lags, mode_count
from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels import resolved_layout as at
from autobalancer.kernels.rotor_layout import BALL_ROWS
from autobalancer.kernels.system import Floats, Matrix, System
from autobalancer.laws.hertz import hertz_stiffness
from autobalancer.machine import Machine, Race
from autobalancer.machine.balancer.resolved import ResolvedContact
from autobalancer.machine.part import ImpossiblePart, Problem


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
        raise ImpossiblePart("Machine", problems)
    if machine.tilting_races == "full":
        raise MachineError("tilting_races: balls with 'resolved' contact feel deflections only; take 'deflection'")
    if machine.excitations:
        raise MachineError("excitations: not with balls in 'resolved' contact; leave out one of them")
    return True


def resolved_size(balls: tuple[Ball, ...], lags: Lags) -> int:
    """Further states of the balls and of their fluids."""
    return len(balls) * at.BALL_STATES + mode_count(lags)


def resolved_numbers(machine: Machine, balls: tuple[Ball, ...], rotor: Floats, lags: Lags, first_state: int) -> Floats:
    """``rotor`` with the rows of the balls behind it; their states begin at ``first_state``, modes of fluids follow."""
    numbers = list(rotor)
    rows, first_mode = len(numbers), first_state + len(balls) * at.BALL_STATES
    numbers += [0.0] * (len(balls) * at.RESOLVED_COLUMNS)
    fluids = FluidNumbers(numbers, at, balls, lags, first_mode)
    for i, ball in enumerate(balls):
        race = machine.balancers[ball.balancer].races[ball.race]
        row = rows + i * at.RESOLVED_COLUMNS
        put = partial(_put, numbers, row)
        for column, value in _columns(machine, race, ball).items():
            put(column, value)
        fluids.put(i, put)
    numbers[BALL_ROWS] = rows
    return np.array(numbers, np.float64)


def _put(numbers: list[float], row: int, column: int, value: float) -> None:
    numbers[row + column] = float(value)


def relative_mass(ball: Ball) -> float:
    """Mass, with virtual mass, that motion relative to the chamber has, kg."""
    return ball.mass + ball.virtual_mass * ball.displaced


def _columns(machine: Machine, race: Race, ball: Ball) -> dict[int, float]:
    """All of a row that is not a place of further numbers."""
    contact = race.resolved
    assert contact is not None
    whole, gap = relative_mass(ball), _gap(race, ball)
    inner = ball.orbit_radius - gap - ball.radius
    outer_k, inner_k, ball_k = _stiffnesses(contact, ball, inner)
    hertz = contact.reduced_modulus is not None
    # with Hertz the damper that stands for the same restitution is sqrt(5) zeta sqrt(m k) d^(1/4) (Antypov and Elliott 2011)
    scale = math.sqrt(5.0) if hertz else 2.0
    ratio = scale * damping_ratio(float(contact.restitution)) if contact.restitution is not None else 0.0
    bounce = float(race.contact.restitution) if race.contact is not None else CRITICAL
    if race.contact is not None and race.contact.stiffness is not None and not hertz:
        ball_k = float(race.contact.stiffness)
    friction = race.friction
    hold = float(contact.adherence_stiffness)
    vertical = machine.axis == "vertical"
    return {
        at.MASS_: ball.effective_mass,
        at.EXTRA: whole - ball.effective_mass,
        at.SPIN_INERTIA: ball.spin_ratio * ball.mass * ball.radius**2,
        at.RADIUS: ball.radius,
        at.ORBIT_: ball.orbit_radius,
        at.CENTER_X: ball.eccentricity.real,
        at.CENTER_Y: ball.eccentricity.imag,
        at.PLACE_: ball.balancer,
        at.RACE_: -1.0 if race.coincidence else 1000.0 * ball.balancer + ball.race,
        at.GAP: gap,
        at.HERTZ: float(hertz),
        at.WALL_STIFFNESS: outer_k,
        at.INNER_STIFFNESS: inner_k,
        at.WALL_DAMPING: float(contact.damping) if contact.damping is not None else ratio * math.sqrt(outer_k * whole),
        at.INNER_DAMPING: float(contact.damping) if contact.damping is not None else ratio * math.sqrt(inner_k * whole),
        at.BALL_STIFFNESS: ball_k,
        at.BALL_DAMPING: scale * damping_ratio(bounce),
        at.SLIDING: float(contact.sliding_friction),
        at.PEAK: float(contact.peak_friction or contact.sliding_friction),
        at.SLIP_SPEED: float(contact.slip_speed),
        at.PEAK_SPEED: float(contact.peak_speed or 1.0),
        at.ROLLING_ARM: float(friction.rolling_resistance) * ball.radius if friction is not None else 0.0,
        at.REST_SPEED: float(contact.rest_speed or 1.0),
        at.ADHERENCE: float(friction.adherence or 0.0) if friction is not None else 0.0,
        at.HOLD_STIFFNESS: hold,
        at.HOLD_DAMPING: 2.0 * math.sqrt(hold * whole),
        at.FLOOR: float(contact.floor_friction),
        at.WEIGHT: ball.effective_mass * float(machine.gravity) if vertical else 0.0,
        at.BALL_SLIDING: float(contact.ball_friction),
        at.VISCOUS: ball.drag / ball.orbit_radius**2,
    }


def _gap(race: Race, ball: Ball) -> float:
    """What the ball center can move between outer and inner wall, m; infinite without an inner wall."""
    assert race.resolved is not None
    where = f"balancers[{ball.balancer + 1}].races[{ball.race + 1}]"
    gap, start = math.inf, float(race.resolved.start_gap)
    if race.width is not None:
        gap = float(race.width) - ball.diameter
        outer = ball.orbit_radius + ball.radius
        if race.width >= outer:
            raise MachineError(
                f"{where}.width: given {1e3 * race.width:.4g} mm; must be less than the radius of the wall, "
                f"{1e3 * outer:.4g} mm; leave it out where there is no inner wall"
            )
    room = min(gap, ball.orbit_radius)
    if start > room:
        raise MachineError(
            f"{where}.resolved.start_gap: given {1e3 * start:.4g} mm; a ball has {1e3 * room:.4g} mm at most"
        )
    return gap


def _stiffnesses(contact: ResolvedContact, ball: Ball, inner: float) -> tuple[float, float, float]:
    """Of outer wall, inner wall and another ball."""
    if contact.reduced_modulus is None:
        stiffness = float(contact.stiffness or 0.0)
        return stiffness, stiffness, stiffness
    modulus = float(contact.reduced_modulus)
    outer = hertz_stiffness(modulus, ball.radius, ball.orbit_radius + ball.radius)
    within = hertz_stiffness(modulus, ball.radius, -inner) if inner > 0.0 else 0.0
    return outer, within, 4.0 / 3.0 * modulus


def start_states(machine: Machine, balls: tuple[Ball, ...], angles: Floats, rotor: Floats, speed: float) -> Matrix:
    """Balls that roll at their start angles and speeds, pressed on their wall by the ``speed`` of the rotor (rad/s)."""
    states = np.zeros((len(balls), at.BALL_STATES))
    for row, numbers, ball, angle in zip(states, rows_of(rotor, len(balls)), balls, angles, strict=True):
        contact = machine.balancers[ball.balancer].races[ball.race].resolved
        assert contact is not None
        radius = ball.orbit_radius - float(contact.start_gap)
        c, s = math.cos(angle), math.sin(angle)
        row[[at.BALL_X, at.BALL_Y]] = radius * c, radius * s
        row[[at.BALL_VX, at.BALL_VY]] = -radius * s * ball.start_speed, radius * c * ball.start_speed
        if contact.start_gap == 0.0:
            in_space, rest = speed + ball.start_speed, relative_mass(ball) - ball.effective_mass
            force = ball.orbit_radius * (ball.effective_mass * in_space**2 + rest * ball.start_speed**2)
            pressed = 1.0 + _depth(numbers, force) / ball.orbit_radius
            row[[at.BALL_X, at.BALL_Y]] *= pressed
            row[[at.BALL_VX, at.BALL_VY]] *= pressed
            row[at.BALL_SPIN] = -pressed * ball.orbit_radius * ball.start_speed / ball.radius
    return states


def resolved_scales(balls: tuple[Ball, ...], rotor: Floats, fastest: float) -> Matrix:
    """Sizes of the states for tolerances, (n, BALL_STATES): depth of contact and its frequency at the speed ``fastest``."""
    scales = np.ones((len(balls), at.BALL_STATES))
    rows = rows_of(rotor, len(balls))
    for scale, row, ball in zip(scales, rows, balls, strict=True):
        force = max(ball.moment * fastest**2, 10.0 * ball.effective_mass)
        power = 1.5 if row[at.HERTZ] else 1.0
        depth = _depth(row, force)
        frequency = math.sqrt(power * force / depth / relative_mass(ball))
        scale[[at.BALL_X, at.BALL_Y, at.HOLD]] = depth
        scale[[at.BALL_VX, at.BALL_VY]] = depth * frequency
        scale[at.BALL_SPIN] = depth * frequency / ball.radius
    return scales


def _depth(row: Floats, force: float) -> float:
    """How deep the outer wall is pressed by a force, m."""
    return float((force / row[at.WALL_STIFFNESS]) ** (2.0 / 3.0 if row[at.HERTZ] else 1.0))


def rows_of(rotor: Floats, count: int) -> Matrix:
    """The rows of the balls, (count, RESOLVED_COLUMNS)."""
    first = int(rotor[BALL_ROWS])
    return np.asarray(rotor[first : first + count * at.RESOLVED_COLUMNS].reshape(count, at.RESOLVED_COLUMNS))


def ball_states(states: Matrix, system: System, rotor_size: int) -> Any:
    """The states of the balls alone, (times, n, BALL_STATES)."""
    count = system.balls.shape[0]
    first = 2 + 2 * rotor_size + 2 * count
    return states[:, first : first + count * at.BALL_STATES].reshape(-1, count, at.BALL_STATES)


def wall_forces(own: Any, system: System) -> Matrix:
    """Normal force of the outer wall on each ball, N; (times, n), from its states ``own``."""
    row = rows_of(system.rotor, system.balls.shape[0]).T
    x, y = own[..., at.BALL_X], own[..., at.BALL_Y]
    away = np.hypot(x, y)
    depth = np.maximum(away - row[at.ORBIT_], 0.0)
    rate = (x * own[..., at.BALL_VX] + y * own[..., at.BALL_VY]) / np.maximum(away, 1e-15)
    power = np.where(row[at.HERTZ] == 1.0, 1.5, 1.0)
    soft = np.where(row[at.HERTZ] == 1.0, depth**0.25, 1.0)
    force = row[at.WALL_STIFFNESS] * depth**power + row[at.WALL_DAMPING] * soft * rate
    return np.asarray(np.where(depth > 0.0, np.maximum(force, 0.0), 0.0))
