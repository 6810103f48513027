"""Relaxation modes: a fluid that only diffuses as a few numbers that decay."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.flow.annulus import Annulus, Floats, Matrix
from autobalancer.flow.modes import mode_table, radial_modes, radial_roots, radial_shares
from autobalancer.flow.speed import WallSpeed

MANY = 60  # modes in each direction from which the fewest that matter are taken


@dataclass(frozen=True)
class RelaxationModes:
    """Lag of the fluid at the orbit in modes: W_f = w - sum c_k with c_k' = -rate_k c_k + gain_k w'.

    To be integrated with the equations of motion where the speed w is a coordinate. The gains of all modes add up to 1:
    right after a jump of the speed the fluid still rotates as before. Modes that were left out follow without lag.

    Parameters
    ----------
    rates
        Decay rates, 1/s; (mode,).
    gains
        Share of each mode in a jump of the speed; (mode,). They are of either sign.
    """

    rates: Floats
    gains: Floats

    @property
    def ramp_lag(self) -> float:
        """Lag w - W_f after a long ramp over its rate w', s."""
        return float((self.gains / self.rates).sum())

    def step(self, lags: Floats, duration: float, change: float) -> Floats:
        """The lags c (rad/s) a time ``duration`` later in which the speed changes by ``change`` at a steady rate; exact."""
        x = self.rates * duration
        return lags * np.exp(-x) + self.gains * change * _mean_decay(x)

    def lags(self, speed: WallSpeed, times: Floats) -> Matrix:
        """c at ``times`` (ascending, from 0 on), rad/s; (time, mode). Exact for straight pieces with corners in ``times``."""
        speeds = speed.over(times)
        found = np.empty((times.size, self.rates.size))
        found[0] = self.gains * (speeds[0] - speed.before)
        for i in range(1, times.size):
            found[i] = self.step(found[i - 1], times[i] - times[i - 1], speeds[i] - speeds[i - 1])
        return found

    def response(self, speed: WallSpeed, times: Floats) -> Floats:
        """W_f at ``times``, rad/s; as :meth:`lags`."""
        return np.asarray(speed.over(times) - self.lags(speed, times).sum(axis=1), np.float64)


def all_modes(annulus: Annulus) -> RelaxationModes:
    """As many modes at the orbit as the exact series is worked out with."""
    rates, gains = mode_table(annulus, MANY, MANY)
    return RelaxationModes(rates.ravel(), gains.ravel())


def relaxation_modes(annulus: Annulus, error: float = 1e-3) -> RelaxationModes:
    """The fewest modes of an ``annulus`` that give the lag after a long ramp within the share ``error``.

    A jump of the speed is followed with the same error only after a time: about ln(1/error) over the rate of the fastest mode
    that is kept.

    Raises
    ------
    QuestionError
        If ``error`` is not between 1e-6 and 0.5.
    """
    if not 1e-6 <= error <= 0.5:
        raise QuestionError(f"error: given {error:g}; must be between 1e-6 and 0.5")
    exact = all_modes(annulus)
    rates, gains = exact.rates, exact.gains
    weight = np.abs(gains) / rates
    order = np.argsort(-weight, kind="stable")
    lag = (gains / rates)[order]
    missing = np.abs(lag.cumsum() - lag.sum())
    kept = order[: int(np.flatnonzero(missing > error * abs(lag.sum()))[-1]) + 2]
    return RelaxationModes(rates[kept], gains[kept])


def diffusive_swirl(annulus: Annulus, speed: WallSpeed, times: Floats, radius: Floats, height: Floats) -> Matrix:
    """W - w of a fluid that only diffuses, rad/s; (time, radius, height).

    ``times`` ascend from 0 on and contain the corners of the speed; walls that jump at time 0 need some time to be seen with
    a finite number of modes.
    """
    waves = radial_roots(annulus.inner, annulus.outer, MANY)
    k = math.pi * (2.0 * np.arange(MANY) + 1.0)
    rates = annulus.viscosity * (waves[:, None] ** 2 + (k[None, :] / annulus.height) ** 2)
    gains = np.outer(radial_shares(annulus.inner, annulus.outer, waves), 4.0 / k)
    lags = RelaxationModes(rates.ravel(), gains.ravel()).lags(speed, times).reshape(-1, MANY, MANY)
    shape = radial_modes(annulus.inner, waves, radius) / radius[:, None]
    return np.asarray(-(shape @ lags @ np.sin(np.outer(k, height / annulus.height))), np.float64)


def _mean_decay(x: Floats) -> Floats:
    """(1 - exp(-x))/x."""
    return np.asarray(-np.expm1(-x) / np.maximum(x, math.ulp(1.0) ** 2), np.float64)
