"""Two equal balls in one race, eccentric or not, on orthotropic supports: resting angles and deflection in closed form.

Spannan (2021), (4.52)-(4.67), with exp(-i gamma) on the right of (4.51), which is what makes them solutions. The torque
on each ball vanishes because the forward whirl carries the race center onto the axis of rotation, Z = -E e^(i gamma).
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

import numpy as np

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.stability.averaged import MachineArgument, averaged_plane


@dataclass(frozen=True)
class TwoBallState:
    """Steady state of two equal balls, angles from the zero mark; x = A_x cos(Wt) - B_x sin(Wt), y likewise (4.18)."""

    angles: Floats  # (2,) rad
    a_x: complex  # A_0x + i B_0x, m
    a_y: complex  # A_0y + i B_0y, m
    chi: complex  # chi_c + i chi_s, sum of both directions; a state exists for |chi| <= 2, (4.67)


def chi_of_two_balls(machine: MachineArgument, speed: float, unbalance: complex | float | None = None) -> TwoBallState:
    """Amplitudes (4.52)-(4.60) and chi of (4.61), (4.62), whether or not the balls can reach it; else angles are nan."""
    p = averaged_plane(machine, unbalance)
    if p.moment.size != 2 or np.ptp(p.moment) > 0.0 or np.ptp(np.abs(p.offset)) > 0.0 or p.offset[0] != p.offset[1]:
        raise QuestionError("two-ball state: the closed form is for two equal balls in one race; use equilibria")
    w, m = speed, p.mass
    (kx, ky), (bx, by) = p.stiffness, p.damping
    s = w**2 * (bx + by) ** 2 + (2.0 * m * w**2 - kx - ky) ** 2  # (4.60)
    if s == 0.0:
        raise QuestionError(f"two-ball state: {speed:.6g} rad/s is a resonance of an undamped rotor")
    turn = cmath.exp(1j * cmath.phase(p.unbalance))  # the source counts angles from the unbalance
    eccentricity = complex(p.offset[0]) / turn
    e_cos, e_sin = eccentricity.real, eccentricity.imag
    p_xy = w**3 * m * (by - bx) + w * (bx * ky - by * kx)  # (4.56)
    p_yx = w**3 * m * (bx - by) + w * (by * kx - bx * ky)  # (4.57)
    q_xy = 2.0 * m**2 * w**4 - m * w**2 * (kx + 3.0 * ky) + kx * ky + ky**2 + w**2 * (bx * by + by**2)  # (4.58)
    q_yx = 2.0 * m**2 * w**4 - m * w**2 * (ky + 3.0 * kx) + kx * ky + kx**2 + w**2 * (bx * by + bx**2)  # (4.59)
    a_0x = -2.0 * (p_xy * e_sin + q_xy * e_cos) / s  # (4.52)
    a_0y = -2.0 * (p_yx * e_sin + q_yx * e_cos) / s  # (4.53)
    b_0x = -2.0 * (q_xy * e_sin + p_yx * e_cos) / s  # (4.54)
    b_0y = -2.0 * (q_yx * e_sin + p_xy * e_cos) / s  # (4.55)
    moment, ball = float(p.moment[0]), float(p.ball_mass.sum())
    chi_s = (bx / w * a_0x + (kx / w**2 - m) * b_0x - ball * e_sin) / moment  # (4.61)
    chi_c = (-bx / w * b_0x + (kx / w**2 - m) * a_0x - ball * e_cos - abs(p.unbalance)) / moment  # (4.62)
    half = 0.5 * (chi_s**2 + chi_c**2) - 1.0
    opening = 0.5 * math.acos(max(half, -1.0)) if half <= 1.0 else math.nan
    middle = math.atan2(chi_s, chi_c) + cmath.phase(turn)
    return TwoBallState(
        angles=np.array([middle + opening, middle - opening]),  # (4.65), (4.66)
        a_x=complex(a_0x, b_0x) * turn,
        a_y=complex(a_0y, b_0y) * turn,
        chi=complex(chi_c, chi_s) * turn,
    )


def two_ball_state(
    machine: MachineArgument, speed: float, unbalance: complex | float | None = None
) -> TwoBallState | None:
    """The steady state with the balls apart, or none if (4.67) fails: then the balls cannot carry what they should."""
    state = chi_of_two_balls(machine, speed, unbalance)
    return None if math.isnan(float(state.angles[0])) else state
