"""Balls on real races and what shakes the machine, as the rows of kernels/race_layout.py."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from autobalancer.assembly.fluid_numbers import FluidNumbers, Lags, table_numbers
from autobalancer.assembly.rotors import rows_at
from autobalancer.assembly.spatial import Parts
from autobalancer.catalog.resolve import Ball
from autobalancer.kernels import race_layout as at
from autobalancer.kernels.rotor_layout import BALL_ROWS, RUBBING, SHAKERS, WIDTH
from autobalancer.kernels.system import Floats, Matrix
from autobalancer.machine import (
    BaseMotion,
    HarmonicForce,
    Machine,
    Race,
    RecordedBaseMotion,
    RecordedForce,
)


def is_real(machine: Machine, balls: tuple[Ball, ...], lags: Lags | None = None) -> bool:
    """Whether the machine needs more than linear drag on smooth circular races."""
    races = [race for balancer in machine.balancers for race in balancer.races]
    rough = any(race.friction is not None or race.harmonics or race.roundness is not None for race in races)
    curved = any(ball.drag_curve is not None or ball.slipstream for ball in balls)
    return bool(rough or curved or machine.excitations or lags)


def race_harmonics(race: Race) -> Matrix:
    """Deviation of the orbit radius as (order, cosine, sine amplitudes), (H, 2) from order 1 on, m."""
    if race.roundness is not None:
        values = np.array([float(v) for v in race.roundness.deviations])
        count, first = values.size, float(race.roundness.angle)
        spectrum = np.fft.rfft(values) / count
        orders = np.arange(1, race.roundness.harmonics + 1)
        turned = 2.0 * spectrum[orders] * np.exp(-1j * orders * first)
        return np.column_stack([turned.real, -turned.imag])
    if not race.harmonics:
        return np.zeros((0, 2))
    found = np.zeros((max(h.order for h in race.harmonics), 2))
    for h in race.harmonics:
        turn = h.order * float(h.angle)
        found[h.order - 1] += float(h.amplitude) * np.array([math.cos(turn), math.sin(turn)])
    return found


def race_numbers(
    machine: Machine, parts: Parts, balls: tuple[Ball, ...], rotor: Floats, lags: Lags, first_mode: int
) -> Floats:
    """``rotor`` with all further numbers behind it. Relaxation modes have their states from ``first_mode`` on."""
    numbers = list(rotor)
    rows = len(numbers)
    numbers += [0.0] * (len(balls) * at.RACE_COLUMNS)
    rubbing = False
    shapes: dict[tuple[int, int], int] = {}
    fluids = FluidNumbers(numbers, at, balls, lags, first_mode)
    for i, ball in enumerate(balls):
        key = (ball.balancer, ball.race)
        race = machine.balancers[ball.balancer].races[ball.race]
        row = rows + i * at.RACE_COLUMNS

        put = partial(_put, numbers, row)
        put(at.MASS_, ball.effective_mass)
        put(at.STRETCH, ball.inertia / ball.orbit_radius**2)
        put(at.ROLL, ball.spin_ratio * ball.mass * ball.radius)
        put(at.OWN_SPIN, ball.spin_ratio * ball.mass * ball.radius**2)
        put(at.ORBIT_, ball.orbit_radius)
        put(at.CENTER_X, ball.eccentricity.real)
        put(at.CENTER_Y, ball.eccentricity.imag)
        put(at.PLACE_, ball.balancer)
        put(at.VISCOUS, ball.drag / ball.orbit_radius**2)
        put(at.MODE, math.copysign(1.0, ball.start_speed) if ball.start_speed else 0.0)
        if race.friction is not None and race.friction.holding > 0.0:
            put(at.ROLLING, race.friction.rolling_resistance)
            put(at.ADHERENCE, race.friction.holding)
            rubbing = True
        else:
            put(at.MODE, 1.0)
        waves = race_harmonics(race)
        if waves.size:
            if key not in shapes:
                shapes[key] = len(numbers)
                numbers += [float(waves.shape[0]), *waves.ravel().tolist()]
            put(at.SHAPE, shapes[key])
        fluids.put(i, put)
    numbers[BALL_ROWS], numbers[RUBBING] = rows, float(rubbing)
    if machine.excitations:
        numbers[SHAKERS] = _add_excitations(machine, parts, numbers)
    return np.array(numbers, np.float64)


def _put(numbers: list[float], row: int, column: int, value: float) -> None:
    numbers[row + column] = float(value)


def _add_excitations(machine: Machine, parts: Parts, numbers: list[float]) -> int:
    width = int(numbers[WIDTH])
    inverse = np.linalg.inv(parts.mass)
    n = parts.model.pairs
    basis = parts.reduction.basis
    moved = np.zeros((parts.model.size, 2))
    for name, part in (("x", slice(0, n)), ("y", slice(n, 2 * n))):
        shape = parts.model.translation
        moved[part, 0 if name == "x" else 1] = shape
    base = -inverse @ basis.T @ parts.model.mass @ moved
    blocks, tables = [], []
    for number, shake in enumerate(machine.excitations):
        block = np.zeros(at.SHAKE_VECTORS + 2 * width)
        direction = np.array([math.cos(float(shake.direction)), math.sin(float(shake.direction))])
        if isinstance(shake, (BaseMotion, RecordedBaseMotion)):
            vectors = base
            block[at.FELT] = 1.0
        else:
            rows = rows_at(machine, parts.model, shake.station, "excitations", number, "station")
            vectors = inverse @ (parts.model.both(rows.deflection[None]) @ basis).T
        block[at.SHAKE_VECTORS : at.SHAKE_VECTORS + parts.size] = vectors[:, 0]
        block[at.SHAKE_VECTORS + width : at.SHAKE_VECTORS + width + parts.size] = vectors[:, 1]
        if isinstance(shake, (BaseMotion, HarmonicForce)):
            if isinstance(shake, HarmonicForce):
                size = float(shake.force)
            elif shake.acceleration is not None:
                size = float(shake.acceleration)
            else:
                size = -float(shake.displacement or 0.0) * float(shake.frequency or 0.0) ** 2
            vector = size * direction[:, None] * np.array([math.cos(float(shake.phase)), math.sin(float(shake.phase))])
            block[at.AMP_XR : at.AMP_YI + 1] = vector.ravel()
            block[at.SHAKE_FREQUENCY] = float(shake.frequency if shake.frequency is not None else shake.order or 0.0)
            block[at.BY_ANGLE] = float(shake.frequency is None)
            blocks.append(block)
            continue
        assert isinstance(shake, (RecordedBaseMotion, RecordedForce))
        block[at.SHAKE_KIND] = at.RECORDED
        values = shake.acceleration if isinstance(shake, RecordedBaseMotion) else shake.force
        times, record = _with_silence(np.array(shake.time, np.float64), np.array(values, np.float64))
        for column, share in ((at.TABLE_X, direction[0]), (at.TABLE_Y, direction[1])):
            tables.append((len(blocks), column, table_numbers(times, share * record)))
        blocks.append(block)
    for which, column, table in tables:
        blocks[which][column] = len(numbers)
        numbers += table
    begin = len(numbers)
    numbers += [float(len(blocks)), *np.concatenate(blocks).tolist()]
    return begin


def _with_silence(times: Floats, values: Floats) -> tuple[Floats, Floats]:
    """The record with zeros one step before and after it, since a table keeps its last value."""
    step = float(np.diff(times).min())
    if values[-1] != 0.0:
        times, values = np.append(times, times[-1] + step), np.append(values, 0.0)
    if values[0] != 0.0 and times[0] > step:
        times, values = np.insert(times, 0, times[0] - step), np.insert(values, 0, 0.0)
    return times, values
