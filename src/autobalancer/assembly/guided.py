"""Guided balls as rows of kernels/records/guided.py."""

from __future__ import annotations

import math

from autobalancer.assembly.fluids import FluidRows, Lags
from autobalancer.assembly.waves import WaveRows
from autobalancer.catalog.resolve import Ball
from autobalancer.kernels.records.fluid import NONE
from autobalancer.kernels.records.guided import BALL, GUIDED
from autobalancer.kernels.system import Rows
from autobalancer.machine import Machine


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
