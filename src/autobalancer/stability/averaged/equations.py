"""The averaged equations of motion of a planar rotor, Spannan (2021), section 4.1.2, with the misprints corrected, for any balls.

With x = Re[a_x e^(i W t)], y = Im[a_y e^(i W t)], a = A + iB (4.18) and the forward whirl Z = (a_x + a_y)/2:

    a_x' = -i/(2 M W) [W^2 F + 2 W sum s e^(i phi) phi' - D_x a_x],   D_x = k_x - M W^2 + i b_x W,   likewise a_y
    beta phi' = s W Im[e^(-i phi) (W c - i Z')],   c = Z + E,   F = U + sum m E + sum s e^(i phi),   s = m eps

Corrected against the print: the sign in (4.24), cos to sin in row 4 of matrix B (4.68). The inertia of the ball angle
is left out, as in the source, and motions are slow against the speed. So borders found here are those of the exact
equations only for heavily damped balls and small S: the decay rate beta/I of a ball large against that of the rotor,
b/(2M), and against (N S/2) w_c, and N S/2 below about 0.1. Then they agree to better than a percent.

They are linearized as those of one station of any rotor, :mod:`autobalancer.stability.averaged.stations`.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.stability.averaged.stations import averaged_station_eigenvalues, averaged_station_growth
from autobalancer.stability.host.planar import Complexes, Floats, Plane, plane
from autobalancer.stability.host.stations import of_plane
from autobalancer.stability.states.planar import Equilibrium, balanced_about
from autobalancer.stability.states.state import StationState
from autobalancer.units import unbalance_argument

Given = Plane | Machine | str | Path


def averaged_plane(machine: Given, unbalance: complex | float | str | None = None) -> Plane:
    """The numbers of a machine (or the path of its file) that this theory needs, with another unbalance if given."""
    unbalance = unbalance_argument(unbalance)
    if isinstance(machine, Plane):
        return machine if unbalance is None else replace(machine, unbalance=complex(unbalance))
    return plane(balls_in_races(machine), unbalance)


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
