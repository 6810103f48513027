"""Which model is good enough, and how many points it needs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.flow.annulus import Annulus, Floats
from autobalancer.flow.relaxation import RelaxationModes
from autobalancer.flow.speed import WallSpeed

SECONDARY = 0.1  # share of the lag that the secondary flow takes away, over (w / slowest decay rate)^2; calibrated
LOOKS = 400  # instants at which the lag is looked at
MOST = {"chebyshev": 160, "differences": 400}
SLOW = 1.6  # lag at the orbit over that of one decaying number: the share (4/pi)^2 of the slowest mode
SWIRLS = 500.0  # Reynolds number of the lag above which the layer at the inner wall breaks into vortices
EDDIES, EDDIES_AT, EDDIES_POWER = 40.0, 8800.0, 0.3  # intervals over the gap that carry them, measured
CONVECTION = 1.2  # rate of the convection limit over lag and intervals, measured
STEP = (4e-6, 8.5e-10)  # s of one step on a common processor: alone, and over (intervals)^3
CELL = (2.6e-8, 9.5e-11)  # s of one step of the differences over the cells: alone, and over the axial ones; measured
LONG = 30.0  # s of computing that are begun without a word
LONGEST = 300.0  # s of computing that are begun without being asked


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


def layer(annulus: Annulus, fastest: float) -> float:
    """Thickness of the Ekman layers, sqrt(nu/w), m; at most the chamber."""
    return min(math.sqrt(annulus.viscosity / max(fastest, 1e-300)), annulus.width, annulus.height)


def points_for(annulus: Annulus, model: str, seen: Expected, error: float) -> tuple[tuple[int, int], tuple[int, int]]:
    """Intervals (radial, axial): what is needed at least, and what gives the orbit within about ``error``.

    Chebyshev points crowd at the walls, so their number grows with the root of length over layer; a stretched grid needs a few
    cells in the layer itself.
    """
    thin = layer(annulus, seen.fastest)
    needed, wanted = [], []
    for length in (annulus.width, annulus.height):
        if model == "chebyshev":
            base = math.sqrt(length / thin)
            low, good = 2.2 * base, (3.0 + 2.5 * seen.lag) * base
            if seen.unsteady:
                eddies = EDDIES * (seen.reynolds / EDDIES_AT) ** EDDIES_POWER
                good = max(good, eddies * math.sqrt(length / annulus.width))
        else:
            low, good = 0.5 * length / thin, (1.5 + 1.5 * seen.lag) * length / thin
        finer = max(0.0, math.log10(1e-3 / error))
        if model == "chebyshev":
            few, good = 12.0 + 6.0 * seen.lag + 4.0 * finer, good * (1.0 + 0.25 * finer)
        else:
            few, good = (32.0 + 16.0 * seen.lag) * 10.0 ** (0.5 * finer), good * 10.0 ** (0.5 * finer)
        needed.append(max(6, math.ceil(low)))
        wanted.append(2 * math.ceil(0.5 * max(few, good)))
    return (needed[0], needed[1]), (wanted[0], wanted[1])


def chosen_points(
    annulus: Annulus, model: str, seen: Expected, points: tuple[int, int] | None, error: float
) -> tuple[int, int]:
    """The intervals to be used.

    Raises
    ------
    QuestionError
        If ``points`` cannot resolve the layers at the walls, or if this takes more than can be afforded.
    """
    needed, wanted = points_for(annulus, model, seen, error)
    for name, count, least, length in zip(
        ("radial", "axial"), points or wanted, needed, (annulus.width, annulus.height), strict=True
    ):
        if count < least:
            raise QuestionError(
                f"points: given {count} in {name} direction, but the layers at the walls are "
                f"{1e3 * layer(annulus, seen.fastest):.3g} mm thin on {1e3 * length:.3g} mm at {seen.fastest:.4g} rad/s; "
                f"take at least {least} ({wanted[0]} by {wanted[1]} are recommended for an error of {error:g})"
            )
        if count > MOST[model]:
            raise QuestionError(
                f"points: {count} in {name} direction are more than the {MOST[model]} this solver is made for; the layers "
                f"at the walls are only {1e3 * layer(annulus, seen.fastest):.3g} mm thin at {seen.fastest:.4g} rad/s"
            )
    return points or wanted


def finer(points: tuple[int, int]) -> tuple[int, int] | None:
    """The next grid for a flow that this one did not resolve; None beyond what the Chebyshev solver is made for."""
    more = tuple(2 * math.ceil(0.65 * count) for count in points)
    return (more[0], more[1]) if max(more) <= MOST["chebyshev"] else None


def seconds(seen: Expected, points: tuple[int, int]) -> float:
    """About how long the Chebyshev solver takes, s: steps within the limits of convection and waves times their cost."""
    steps = CONVECTION * seen.lagged * points[1] + (2.0 * seen.turned if seen.unsteady else 0.0)
    return float(steps / 0.56 * (STEP[0] + STEP[1] * (points[0] * points[1]) ** 1.5))
