"""The waves of races that are not round."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.catalog.resolve import Ball
from autobalancer.kernels.records.guided import WAVE
from autobalancer.kernels.system import Matrix, Rows
from autobalancer.machine import Machine, Race


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
            found = race_harmonics(self.machine.balancers[ball.balancer].races[ball.race])
            self.places[place] = found.shape[0], self.amplitudes.shape[0]
            self.amplitudes = np.concatenate([self.amplitudes, found])
        row.waves, row.first_wave = self.places[place]

    @property
    def rows(self) -> Rows:
        """All of them."""
        rows = WAVE.rows(self.amplitudes.shape[0])
        rows.cosine, rows.sine = self.amplitudes.T
        return rows
