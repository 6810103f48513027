"""Balls on real races, as the rows of kernels/race_layout.py."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from autobalancer.assembly.excitations import add_excitations
from autobalancer.assembly.fluid_numbers import FluidNumbers, Lags
from autobalancer.assembly.spatial import Parts
from autobalancer.catalog.resolve import Ball
from autobalancer.kernels import race_layout as at
from autobalancer.kernels.rotor_layout import BALL_ROWS, RUBBING, SHAKERS
from autobalancer.kernels.system import Floats, Matrix
from autobalancer.machine import Machine, Race


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


class Shapes:
    """Appends the waves of races to ``numbers``, each once."""

    def __init__(self, machine: Machine, numbers: list[float]) -> None:
        self.machine, self.numbers = machine, numbers
        self.places: dict[tuple[int, int], int] = {}

    def place(self, ball: Ball) -> int:
        """Where the shape of a ball's race is; 0 for a circle."""
        key = (ball.balancer, ball.race)
        if key not in self.places:
            waves = race_harmonics(self.machine.balancers[ball.balancer].races[ball.race])
            self.places[key] = len(self.numbers) if waves.size else 0
            if waves.size:
                self.numbers += [float(waves.shape[0]), *waves.ravel().tolist()]
        return self.places[key]


def race_numbers(
    machine: Machine, parts: Parts, balls: tuple[Ball, ...], rotor: Floats, lags: Lags, first_mode: int
) -> Floats:
    """``rotor`` with all further numbers behind it. Relaxation modes have their states from ``first_mode`` on."""
    numbers = list(rotor)
    rows = len(numbers)
    numbers += [0.0] * (len(balls) * at.RACE_COLUMNS)
    rubbing = False
    shapes = Shapes(machine, numbers)
    fluids = FluidNumbers(numbers, at, balls, lags, first_mode)
    for i, ball in enumerate(balls):
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
        put(at.SHAPE, shapes.place(ball))
        fluids.put(i, put)
    numbers[BALL_ROWS], numbers[RUBBING] = rows, float(rubbing)
    numbers[SHAKERS] = add_excitations(machine, parts, numbers)
    return np.array(numbers, np.float64)


def _put(numbers: list[float], row: int, column: int, value: float) -> None:
    numbers[row + column] = float(value)
