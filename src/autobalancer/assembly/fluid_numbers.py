"""What balls of every kind need of their fluid, behind the other numbers of ``System.rotor``: drag curves, slipstream, lags."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import ModuleType

import numpy as np
from scipy.interpolate import PchipInterpolator

from autobalancer.catalog.resolve import Ball
from autobalancer.errors import MachineError
from autobalancer.kernels.race_layout import LINE_DISTANCE_POWERS, LINE_SPEED_POWERS
from autobalancer.kernels.system import Floats
from autobalancer.laws.slipstream import DISTANCE, FIT, REYNOLDS

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


class FluidNumbers:
    """Appends curves, modes and tables to ``numbers``, each once, and says in the row of one of ``balls`` where they are.

    ``layout`` names the columns of a row; the states of the modes begin at ``first_mode``.
    """

    def __init__(
        self, numbers: list[float], layout: ModuleType, balls: tuple[Ball, ...], lags: Lags, first_mode: int
    ) -> None:
        self.numbers, self.layout, self.lags, self.first_mode = numbers, layout, lags, first_mode
        self.balls = balls
        self.curves: dict[object, int] = {}
        self.tables: dict[tuple[int, int], int] = {}
        self.modes: dict[tuple[int, int], tuple[int, int]] = {}

    def put(self, number: int, put: Callable[[int, float], None]) -> None:
        """Fill the columns of the ball of this ``number`` by ``put(column, value)``."""
        ball = self.balls[number]
        at, numbers, key = self.layout, self.numbers, (ball.balancer, ball.race)
        if ball.drag_curve is not None:
            if ball.drag_curve not in self.curves:
                self.curves[ball.drag_curve] = len(numbers)
                numbers += _curve(ball)
            put(at.DRAG_CURVE, self.curves[ball.drag_curve])
        if ball.slipstream:
            put(at.SLIPSTREAM, len(numbers))
            numbers += _line(self.balls, number)
        lag = self.lags.get(key, Lag())
        if lag.rates.size:
            if key not in self.modes:
                self.modes[key] = self.first_mode, len(numbers)
                self.first_mode += lag.rates.size
                numbers += [*lag.rates.tolist(), *lag.gains.tolist()]
            put(at.MODES, lag.rates.size)
            put(at.FIRST_MODE, self.modes[key][0])
            put(at.MODE_NUMBERS, self.modes[key][1])
        if lag.times.size:
            if key not in self.tables:
                self.tables[key] = len(numbers)
                numbers += table_numbers(lag.times, lag.values)
            put(at.LAG_TABLE, self.tables[key])


def _curve(ball: Ball) -> list[float]:
    """The drag curve of a ball as kernels/curves.py reads it."""
    assert ball.drag_curve is not None
    velocities, forces, slopes = ball.drag_curve.points()
    step = (velocities[-1] - velocities[0]) / (velocities.size - 1)
    return [
        float(velocities[0]),
        float(step),
        float(velocities.size),
        *np.column_stack([forces, slopes]).ravel().tolist(),
    ]


def _line(balls: tuple[Ball, ...], number: int) -> list[float]:
    """A ball and the others of its race as kernels/slipstream.py reads them."""
    assert FIT.shape == (LINE_SPEED_POWERS, LINE_DISTANCE_POWERS)
    ball = balls[number]
    race = [i for i, b in enumerate(balls) if (b.balancer, b.race) == (ball.balancer, ball.race) and i != number]
    per_speed, per_angle = ball.diameter / ball.fluid_viscosity, ball.orbit_radius / ball.diameter
    head = [per_speed, REYNOLDS[1], per_angle, DISTANCE[1], float(number), float(len(race))]
    return [*head, *FIT.ravel().tolist(), *map(float, race)]


def table_numbers(times: Floats, values: Floats) -> list[float]:
    """A uniform table through these points, monotone between them; zero slope where it ends."""
    step = float(np.diff(times).min())
    count = round((times[-1] - times[0]) / step) + 1
    if count > LONGEST_TABLE:
        raise MachineError(f"a record of {count} equal steps is too long; give at most {LONGEST_TABLE}")
    grid = np.linspace(times[0], times[-1], max(count, 2))
    curve = PchipInterpolator(times, values)
    step = float(grid[1] - grid[0])
    pairs = np.column_stack([curve(grid), step * curve.derivative()(grid)])
    return [float(grid[0]), step, float(grid.size), *pairs.ravel().tolist()]
