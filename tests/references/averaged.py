"""The averaged equations as they are printed, apart from the matrices of the package."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from tests.references.planar_states import Equilibrium, balanced_about

from autobalancer.arrays import Complexes, Floats
from autobalancer.stability.averaged import (
    averaged_plane,
    averaged_station_eigenvalues,
    averaged_station_growth,
    damping_share,
    eigenvalues_at,
    refuse_without_drag,
)
from autobalancer.stability.border import Border
from autobalancer.stability.host.stations import Plane, of_plane
from autobalancer.stability.states.ball_positions import close_polygon
from autobalancer.stability.states.rest_states import StationState


def averaged_residuals(
    p: Plane, speed: float, angles: Floats, a_x: complex, a_y: complex
) -> tuple[complex, complex, Floats]:
    """Right-hand sides of the steady averaged equations; all zero in a steady state.

    Returns
    -------
    rate_x, rate_y, torque
        A_x' + i B_x' and A_y' + i B_y' of (4.25)-(4.28), m/s, and the torque on each ball, (4.29) times m eps, N m.
    """
    load = speed**2 * (p.fixed_load + complex((p.moment * np.exp(1j * angles)).sum()))
    factor = -0.5j / (p.mass * speed)
    x, y = stiffness_xy(p, speed)
    torque = p.moment * speed**2 * np.imag(np.exp(-1j * angles) * (0.5 * (a_x + a_y) + p.offset))
    return factor * (load - x * a_x), factor * (load - y * a_y), torque


def unbalance_whirl(p: Plane, speed: float) -> tuple[complex, complex]:
    """Forward and backward part (a, b) of the unbalance response z = a e^(iWt) + b e^(-iWt), m, balls left out.

    Without damping this is (4.72) of Spannan (2021) with the lost factor 1/M restored.
    """
    x, y = stiffness_xy(p, speed)
    load = p.unbalance * speed**2
    return 0.5 * load * (1.0 / x + 1.0 / y), complex(np.conj(0.5 * load * (1.0 / x - 1.0 / y)))


# The averaged theory of a planar rotor, as that of its only station.


def stiffness_xy(p: Plane, speed: float) -> tuple[complex, complex]:
    """D_x and D_y: force over amplitude along x and y for synchronous motion, N/m."""
    x, y = (complex(k - p.mass * speed**2, b * speed) for k, b in zip(p.stiffness, p.damping, strict=True))
    return x, y


def amplitudes(p: Plane, speed: float, angles: Floats) -> tuple[complex, complex]:
    """a_x = A_0x + i B_0x and a_y of the rotor when the balls rest at these angles, m."""
    load = speed**2 * (p.fixed_load + complex((p.moment * np.exp(1j * angles)).sum()))
    x, y = stiffness_xy(p, speed)
    return load / x, load / y


def averaged_eigenvalues(p: Plane, speed: float, state: Equilibrium) -> Complexes:
    """Eigenvalues of (4.69), 1/s, the fastest growing first; on isotropic supports without those of the backward whirl.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    return averaged_station_eigenvalues(of_plane(p), speed, at_station(state))


def averaged_growth_rate(p: Plane, speed: float, state: Equilibrium) -> float:
    """Greatest real part of the averaged eigenvalues, 1/s, without the zeros of balls that may be moved for nothing."""
    return averaged_station_growth(of_plane(p), speed, at_station(state))


def at_station(state: Equilibrium) -> StationState:
    """A state of a planar rotor as that of its only station."""
    whirl = np.array([state.whirl], np.complex128)
    return StationState(state.name, state.angles, whirl, state.freedom, state.outward)


def balanced_growth_rate(p: Plane, speed: float) -> float:
    """Averaged growth rate of the most stable balanced state at a speed, 1/s; nan if there is none."""
    states = balanced_about(p, speed, p.dynamic_stiffness(speed))
    return min((averaged_growth_rate(p, speed, state) for state in states), default=float("nan"))


def heavily_damped_border(machine: Plane) -> Border:
    """Exact border, worst case over the unbalance, in the limit of balls without inertia: w_c (1 + w_c^2 g/(2 b)).

    From one factor of the exact equation with I = 0: beta s = (N/2) (m eps)^2 (s + iW)^4 H(s + iW) has the imaginary
    root s = i (w_c - W) at this speed. Always finite, where (4.74) may say never.

    Raises
    ------
    QuestionError
        As :func:`damping_share`.
    """
    p = averaged_plane(machine)
    critical = math.sqrt(p.stiffness[0] / p.mass)
    return Border("exact border, worst case", critical * (1.0 + damping_share(p)), "limit of balls without inertia")


def balanced_growth_rates(p: Plane, speeds: Floats) -> Floats:
    """Averaged growth rates of the most stable balanced state, 1/s; nan where there is none.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    if one_center(p):
        return growth_rates(p, speeds, spreads_of(p, speeds))
    return np.array([balanced_growth_rate(p, speed) for speed in speeds.tolist()])


# Averaged growth rates of balanced states at many speeds at once: of balls whose races have one center.
#
# The averaged equations see the balls through g = sum s^2/beta and |g2|, g2 = sum (s^2/beta) e^(2 i phi), only: two
# balls with the same stand for all of them. The other motions of more balls are for nothing. An eccentric race
# changes only the angles at which its balls balance.


IN_LINE = (
    1e-13  # balls count as standing in line if 1 - |g2|/g is below: one root is zero by symmetry and does not count
)


def one_center(p: Plane) -> bool:
    """Whether all races have the same center."""
    return p.moment.size > 0 and bool(np.all(p.offset == p.offset[0]))


def spreads_of(p: Plane, speeds: Floats) -> Floats:
    """|g2|/g of the balls that balance at each speed; nan where they cannot."""
    center = complex(p.offset[0])
    if center == 0.0:
        return np.full(speeds.size, _spread(p, -p.fixed_load))
    return np.array([_spread(p, -center * p.dynamic_stiffness(w) / w**2 - p.fixed_load) for w in speeds.tolist()])


def _spread(p: Plane, target: complex) -> float:
    found = close_polygon(p.moment, target) if np.isfinite(target) else []
    if not found:
        return float("nan")
    weight = p.moment**2 / p.drag
    return float(abs((weight * np.exp(2j * found[0])).sum()) / weight.sum())


def growth_rates(p: Plane, speeds: Floats, spreads: Floats | float) -> Floats:
    """Greatest real part at each speed, 1/s, with these |g2|/g; nan where one is nan.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    refuse_without_drag(p.drag)
    spreads = np.broadcast_to(np.asarray(spreads, np.float64), speeds.shape)
    rates = np.full(speeds.size, np.nan)
    there = np.flatnonzero(np.isfinite(spreads))
    if there.size == 0:
        return rates
    values = _eigenvalues(p, speeds[there], spreads[there])
    in_line = spreads[there] > 1.0 - IN_LINE
    values[in_line, np.abs(values).argmin(axis=1)[in_line]] = -np.inf
    rates[there] = values.real.max(axis=1)
    return rates


def _eigenvalues(p: Plane, speeds: Floats, spreads: Floats) -> Complexes:
    """Of two balls at +-a, cos 2a = |g2|/g, in races that run true, (k, size)."""
    drag = float(p.drag.mean())
    two = {name: getattr(p, name)[[0, 0]] for name in ("ball_mass", "inertia", "race", "offset")}
    moment = np.full(2, np.sqrt(0.5 * drag * float((p.moment**2 / p.drag).sum())))
    pair = of_plane(replace(p, moment=moment, drag=np.full(2, drag), **two))
    angle = 0.5 * np.arccos(np.minimum(spreads, 1.0))
    true = np.zeros((speeds.size, 2), np.complex128)
    return eigenvalues_at(pair, speeds, np.stack([angle, -angle], axis=1), true)
