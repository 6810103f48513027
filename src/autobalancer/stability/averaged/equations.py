"""The averaged equations of motion, Spannan (2021), section 4.1.2, with the misprints corrected and for any balls.

With x = Re[a_x e^(i W t)], y = Im[a_y e^(i W t)], a = A + iB (4.18) and the forward whirl Z = (a_x + a_y)/2:

    a_x' = -i/(2 M W) [W^2 F + 2 W sum s e^(i phi) phi' - D_x a_x],   D_x = k_x - M W^2 + i b_x W,   likewise a_y
    beta phi' = s W Im[e^(-i phi) (W c - i Z')],   c = Z + E,   F = U + sum m E + sum s e^(i phi),   s = m eps

Corrected against the print: the sign in (4.24), cos to sin in row 4 of matrix B (4.68). The inertia of the ball angle
is left out, as in the source, and motions are slow against the speed. So borders found here are those of the exact
equations only for heavily damped balls and small S: the decay rate beta/I of a ball large against that of the rotor,
b/(2M), and against (N S/2) w_c, and N S/2 below about 0.1. Then they agree to better than a percent.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.files.given import balls_in_races
from autobalancer.machine import Machine
from autobalancer.stability.host.planar import Complexes, Floats, Plane, plane
from autobalancer.stability.states.linear import kept
from autobalancer.stability.states.planar import Equilibrium, equilibria_of
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


def averaged_matrices(p: Plane, speed: float, state: Equilibrium) -> tuple[Floats, Floats]:
    """A and B of (4.68) for (A_x, B_x, A_y, B_y, phi_1 ... phi_n), any number of balls, equal or not.

    Each ball row is divided by m eps of its ball, as in the source. For states whose race does not run true B gains the
    diagonal term W^2 Re[e^(-i phi) c], which the source does not need.
    """
    n, w = p.moment.size, speed
    a, b = np.zeros((4 + n, 4 + n)), np.zeros((4 + n, 4 + n))
    a[:4, :4] = -np.eye(4)
    for i, (k, damping) in enumerate(zip(p.stiffness, p.damping, strict=True)):
        detuning, decay = 0.5 * w - k / (2.0 * p.mass * w), -damping / (2.0 * p.mass)
        b[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[decay, detuning], [-detuning, decay]]
    cos, sin, share = np.cos(state.angles), np.sin(state.angles), p.moment / p.mass
    a[:4, 4:] = np.vstack([share * sin, -share * cos] * 2)
    b[:4, 4:] = 0.5 * w * np.vstack([share * cos, share * sin] * 2)
    a[4:, :4] = 0.5 * w * np.column_stack([cos, sin] * 2)
    b[4:, :4] = 0.5 * w * w * np.column_stack([sin, -cos] * 2)
    a[4:, 4:] = np.diag(p.drag / p.moment)
    b[4:, 4:] = np.diag(w * w * np.real(np.exp(-1j * state.angles) * (state.whirl + p.offset)))
    return a, b


def averaged_eigenvalues(p: Plane, speed: float, state: Equilibrium) -> Complexes:
    """Eigenvalues of (4.69), 1/s, the fastest growing first.

    Raises
    ------
    QuestionError
        If a ball has no drag.
    """
    refuse_without_drag(p.drag)
    a, b = averaged_matrices(p, speed, state)
    unit = np.concatenate([np.full(4, p.moment.max() / p.mass), np.ones(p.moment.size)])  # amplitudes, angles
    return slow_eigenvalues(a * unit, b * unit)


def refuse_without_drag(drag: Floats) -> None:
    """Refuse balls without drag: the averaged equations, which leave out their inertia, say nothing about them.

    Raises
    ------
    QuestionError
        If there is one.
    """
    if not (drag > 0.0).all():
        raise QuestionError("averaged theory: a ball without drag has no averaged equation of motion; give it some")


def slow_eigenvalues(a: Floats, b: Floats) -> Complexes:
    """Eigenvalues of A x' + B x = 0, the fastest growing first."""
    values = np.linalg.eigvals(-np.linalg.solve(a, b))
    return np.asarray(values[np.argsort(-values.real, kind="stable")], np.complex128)


def averaged_growth_rate(p: Plane, speed: float, state: Equilibrium) -> float:
    """Greatest real part of the averaged eigenvalues, 1/s, without the zeros of balls that may be moved for nothing."""
    return float(kept(averaged_eigenvalues(p, speed, state), neutral_directions(state)).real.max())


def neutral_directions(state: Equilibrium) -> int:
    """Dimension of the small ball motions that leave a balanced rotor balanced: n - 2, or n - 1 for balls in line."""
    if state.name != "balanced":
        return 0
    reach = np.linalg.svd(np.vstack([np.cos(state.angles), np.sin(state.angles)]), compute_uv=False)
    lost = int(np.sum(reach < 1e-7 * reach[0])) if state.angles.size > 1 else 0
    return state.freedom + lost


def balanced_growth_rate(p: Plane, speed: float) -> float:
    """Averaged growth rate of the most stable balanced state at a speed, 1/s; nan if there is none."""
    states = [state for state in equilibria_of(p, speed) if state.name == "balanced"]
    return min((averaged_growth_rate(p, speed, state) for state in states), default=float("nan"))
