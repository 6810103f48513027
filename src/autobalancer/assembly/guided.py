"""Guided balls as rows of kernels/records.py."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels.records import BALL, GUIDED, LINE, NONE, POINT, RELAXATION, TABLE, WAVE
from autobalancer.kernels.system import Floats, Fluid, Matrix, Rows
from autobalancer.laws.drag_coefficient import DISTANCE, FIT, REYNOLDS
from autobalancer.machine import Machine, Race


def is_real(machine: Machine, balls: tuple[Ball, ...], lags: Lags | None = None) -> bool:
    """Whether the machine needs more than linear drag on smooth circular races."""
    races = [race for balancer in machine.balancers for race in balancer.races]
    rough = any(race.friction is not None or race.harmonics or race.roundness is not None for race in races)
    curved = any(ball.drag_curve is not None or ball.slipstream for ball in balls)
    return bool(rough or curved or machine.excitations or lags)


def ball_inertia(ball: Ball) -> float:
    """Inertia of a ball about the shaft, its own spin included, kg m^2."""
    return ball.own_inertia + ball.effective_mass * (abs(ball.eccentricity) ** 2 + ball.orbit_radius**2)


def ball_rows(balls: tuple[Ball, ...]) -> Rows:
    """Balls on smooth circles with linear drag."""
    rows = BALL.rows(len(balls))
    for row, ball in zip(rows, balls, strict=True):
        roll = ball.spin_ratio * ball.mass * ball.rolling_radius
        row.station, row.orbit = ball.balancer, ball.orbit_radius
        row.mass, row.moment, row.inertia = ball.effective_mass, ball.moment, ball.inertia
        row.stretch = ball.inertia / ball.orbit_radius**2
        row.spin = ball.moment * ball.orbit_radius - roll * ball.orbit_radius
        row.roll, row.own_spin = roll, ball.own_inertia
        row.drag, row.viscous = ball.drag, ball.drag / ball.orbit_radius**2
        row.center_x, row.center_y = ball.eccentricity.real, ball.eccentricity.imag
    rows.drag_curve = rows.slipstream = rows.lag_table = NONE
    return rows


def moving_rows(balls: tuple[Ball, ...]) -> Rows:
    """What the equations find of each ball, before they found anything: all roll."""
    rows = GUIDED.rows(len(balls))
    rows.mode = 1.0
    return rows


def put_on_races(machine: Machine, balls: tuple[Ball, ...], rows: Rows, moving: Rows, fluids: FluidRows) -> WaveRows:
    """Give balls the friction, drag and shape of their races; returns the waves of these."""
    waves = WaveRows(machine)
    for number, (row, now, ball) in enumerate(zip(rows, moving, balls, strict=True)):
        if ball.adherence > 0.0:
            row.rolling, row.adherence = ball.rolling_resistance, ball.adherence
            row.pulls = 1.0 if ball.body == "pendulum" else 0.0
            now.mode = math.copysign(1.0, ball.start_speed) if ball.start_speed else 0.0
        waves.fill(row, ball)
        fluids.fill(row, number)
    return waves


# What balls of every kind need of their fluid: drag curves, slipstream, lags; and tables over time.


LONGEST_TABLE = 400_000


@dataclass(frozen=True)
class Lag:
    """How the fluid at the orbit lags behind its chamber: W_f = w - lag.

    Either relaxation modes, lag = sum c_k, c_k' = gain_k w' - rate_k c_k, or a table over time (uniform steps).
    """

    rates: Floats = field(default_factory=lambda: np.zeros(0))
    gains: Floats = field(default_factory=lambda: np.zeros(0))
    times: Floats = field(default_factory=lambda: np.zeros(0))
    values: Floats = field(default_factory=lambda: np.zeros(0))


Lags = Mapping[tuple[int, int], Lag]  # by numbers of balancer and race, from 0


def mode_count(lags: Lags) -> int:
    """Further states that the relaxation modes need."""
    return sum(int(lag.rates.size) for lag in lags.values())


@dataclass(frozen=True)
class UniformTable:
    """A curve over a uniform grid."""

    start: float
    step: float
    values: Floats
    slopes: Floats  # per step


class FluidRows:
    """Collects curves, modes, lines and tables, each once, and writes into the row of a ball which are its own.

    The states of the modes begin at ``first_state``.
    """

    def __init__(self, balls: tuple[Ball, ...], lags: Lags, first_state: int) -> None:
        self.balls, self.lags, self.first_state = balls, lags, first_state
        self.tables: list[UniformTable] = []
        self.modes: list[tuple[float, float]] = []
        self.lines: list[tuple[Ball, int, list[int]]] = []
        self.known: dict[object, int] = {}

    def fill(self, row: Any, number: int) -> None:
        """Fill the fields of the ball of this ``number`` that name curves, modes, lines and tables."""
        ball = self.balls[number]
        place = ball.balancer, ball.race
        row.drag_curve = row.slipstream = row.lag_table = NONE
        if ball.drag_curve is not None:
            row.drag_curve = self._once(ball.drag_curve, lambda: self.add_table(_curve(ball)))
        if ball.slipstream:
            row.slipstream = len(self.lines)
            mates = [i for i, b in enumerate(self.balls) if (b.balancer, b.race) == place and i != number]
            self.lines.append((ball, number, mates))
        lag = self.lags.get(place, Lag())
        if lag.rates.size:
            row.modes = lag.rates.size
            row.first_mode = self._once(("modes", place), lambda: self._add_modes(lag))
        if lag.times.size:
            row.lag_table = self._once(("lag", place), lambda: self.add_table(uniform_table(lag.times, lag.values)))

    def add_table(self, table: UniformTable) -> int:
        """The number of a further table."""
        self.tables.append(table)
        return len(self.tables) - 1

    def _once(self, key: object, add: Any) -> int:
        if key not in self.known:
            self.known[key] = add()
        return self.known[key]

    def _add_modes(self, lag: Lag) -> int:
        self.modes += zip(lag.rates.tolist(), lag.gains.tolist(), strict=True)
        return len(self.modes) - int(lag.rates.size)

    @property
    def fluid(self) -> Fluid:
        """All of it."""
        tables, lines, modes = (
            TABLE.rows(len(self.tables)),
            LINE.rows(len(self.lines)),
            RELAXATION.rows(len(self.modes)),
        )
        points = POINT.rows(sum(table.values.size for table in self.tables))
        first = 0
        for row, table in zip(tables, self.tables, strict=True):
            row.start, row.step, row.count, row.first = table.start, table.step, table.values.size, first
            points[first : first + row.count].value, points[first : first + row.count].slope = (
                table.values,
                table.slopes,
            )
            first += int(row.count)
        others: list[int] = []
        for row, (ball, number, mates) in zip(lines, self.lines, strict=True):
            row.ball, row.first, row.others = number, len(others), len(mates)
            row.per_speed, row.per_angle = ball.diameter / ball.fluid_viscosity, ball.orbit_radius / ball.diameter
            row.greatest, row.reach = REYNOLDS[1], DISTANCE[1]
            others += mates
        for number, (row, (rate, gain)) in enumerate(zip(modes, self.modes, strict=True)):
            row.state, row.rate, row.gain = self.first_state + number, rate, gain
        return Fluid(tables, points, modes, lines, np.array(others, np.int64), np.array(FIT, np.float64))


def _curve(ball: Ball) -> UniformTable:
    """The drag curve of a ball: log force over log velocity."""
    assert ball.drag_curve is not None
    velocities, forces, slopes = ball.drag_curve.points()
    step = (velocities[-1] - velocities[0]) / (velocities.size - 1)
    return UniformTable(float(velocities[0]), float(step), forces, slopes)


def uniform_table(times: Floats, values: Floats) -> UniformTable:
    """A uniform table through these points, monotone between them; zero slope where it ends."""
    from scipy.interpolate import PchipInterpolator  # only where needed: it takes a tenth of a second to load

    step = float(np.diff(times).min())
    count = round((times[-1] - times[0]) / step) + 1
    if count > LONGEST_TABLE:
        raise MachineError(f"a record of {count} equal steps is too long; give at most {LONGEST_TABLE}")
    grid = np.linspace(times[0], times[-1], max(count, 2))
    curve = PchipInterpolator(times, values)
    step = float(grid[1] - grid[0])
    return UniformTable(float(grid[0]), step, curve(grid), step * curve.derivative()(grid))


# The waves of races that are not round.


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
    race_harmonics = np.zeros((max(h.order for h in race.harmonics), 2))
    for h in race.harmonics:
        turn = h.order * float(h.angle)
        race_harmonics[h.order - 1] += float(h.amplitude) * np.array([math.cos(turn), math.sin(turn)])
    return race_harmonics


class WaveRows:
    """Collects the waves of races, those of each once, and writes into the row of a ball which are its own."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.amplitudes = np.zeros((0, 2))
        self.places: dict[tuple[int, int], tuple[int, int]] = {}

    def fill(self, row: Any, ball: Ball) -> None:
        """Fill the fields of a ball that say how many waves its race has, and where they are."""
        place = ball.balancer, ball.race
        if place not in self.places:
            harmonics = race_harmonics(self.machine.balancers[ball.balancer].races[ball.race])
            self.places[place] = harmonics.shape[0], self.amplitudes.shape[0]
            self.amplitudes = np.concatenate([self.amplitudes, harmonics])
        row.waves, row.first_wave = self.places[place]

    @property
    def rows(self) -> Rows:
        """All of them."""
        rows = WAVE.rows(self.amplitudes.shape[0])
        rows.cosine, rows.sine = self.amplitudes.T
        return rows
