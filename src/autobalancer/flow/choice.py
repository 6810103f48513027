"""Which model is good enough: what to expect of a speed profile before the flow is solved."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalancer.flow.annulus import Annulus, Floats
from autobalancer.flow.relaxation import RelaxationModes
from autobalancer.flow.speed import WallSpeed

SECONDARY = 0.1  # share of the lag that the secondary flow takes away, over (w / slowest decay rate)^2; calibrated
LOOKS = 400  # instants at which the lag is looked at
SLOW = 1.6  # lag at the orbit over that of one decaying number: the share (4/pi)^2 of the slowest mode
SWIRLS = 500.0  # Reynolds number of the lag above which the layer at the inner wall breaks into vortices


@dataclass(frozen=True)
class Expected:
    """What to expect of a speed profile before the flow is solved."""

    fastest: float  # rad/s
    lag: float  # greatest lag over the greatest speed, at most 1
    error: float  # of the fluid's speed at the orbit by diffusion alone, over the greatest speed
    reynolds: float = 0.0  # of the greatest lag, over the gap
    lagged: float = 0.0  # integral of the lag over time, rad
    turned: float = 0.0  # integral of the speed over time, rad

    @property
    def unsteady(self) -> bool:
        """Whether vortices at the inner wall are to be expected, which no grid follows one by one."""
        return self.reynolds > SWIRLS


def expected(annulus: Annulus, modes: RelaxationModes, speed: WallSpeed, end: float) -> Expected:
    """From the modes: their lag, and the share of it that a secondary flow would take away.

    Where the rotor is slow against the slowest mode, that share grows as the square of w over its decay rate
    nu (pi^2/W^2 + pi^2/H^2); the factor was found with the full equations for gaps of 0.4 to 2.7 times the height, slow ramps
    (0.05 to 0.1) and impulsive starts (0.02 to 0.05).
    """
    fastest = speed.fastest(end)
    if fastest == 0.0:
        return Expected(0.0, 0.0, 0.0)
    times = np.unique(np.concatenate([np.linspace(0.0, end, LOOKS), speed.corners(end)]))
    speeds = speed.over(times)
    lag = np.abs(speeds - modes.response(speed, times))
    share = np.minimum(1.0, SECONDARY * (speeds / annulus.decay_rate) ** 2)
    behind = np.minimum(lag, _behind(annulus, speed.before, times, speeds))
    return Expected(
        fastest,
        lag=float(min(1.0, behind.max() / fastest)),
        error=float((lag * share).max() / fastest),
        reynolds=float(behind.max() * annulus.orbit_radius * annulus.width / annulus.viscosity),
        lagged=float(np.trapezoid(behind, times)),
        turned=float(np.trapezoid(np.abs(speeds), times)),
    )


def _behind(annulus: Annulus, before: float, times: Floats, speeds: Floats) -> Floats:
    """A guess of the lag where Ekman layers, at the rate 2 sqrt(nu w)/H, and diffusion bring the fluid along, rad/s."""
    rates = annulus.decay_rate + 2.0 * np.sqrt(annulus.viscosity * np.abs(speeds)) / annulus.height
    behind = np.empty_like(times)
    behind[0] = abs(speeds[0] - before)
    for i in range(1, times.size):
        x = 0.5 * (rates[i - 1] + rates[i]) * (times[i] - times[i - 1])
        rise = abs(speeds[i] - speeds[i - 1]) * -math.expm1(-x) / max(x, 1e-300)
        behind[i] = behind[i - 1] * math.exp(-x) + rise
    return np.asarray(SLOW * behind, np.float64)
