"""Periodic steady states by shooting with the compiled equations, and their Floquet multipliers: planar machines.

At constant speed the machine is periodic with one revolution. The state of rest in the rotor becomes a state that returns
after a revolution. The multipliers are the eigenvalues of the derivative of that map.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from tests.references.planar_states import Equilibrium, backward_whirl

from autobalancer.arrays import Complexes, Floats, Matrix
from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.stability.basins import Turn
from autobalancer.stability.host.stations import Plane

NEWTON_STEPS = 30


@dataclass(frozen=True)
class PeriodicState:
    """A steady state that repeats with every revolution."""

    start: Floats  # (4 + 2 n,) X, Y, VX, VY, ball angles, ball speeds in the rotor, at rotor angle 0, axes in space
    multipliers: Complexes  # (4 + 2 n,) largest amount first
    speed: float
    error: float  # scaled mismatch after a turn

    @property
    def exponents(self) -> Complexes:
        """ln(multiplier) / time of a turn, 1/s."""
        return np.asarray(np.log(self.multipliers) * self.speed / (2.0 * math.pi), np.complex128)


def periodic_state(machine: Machine, p: Plane, speed: float, guess: Equilibrium) -> PeriodicState:
    """Refine a state of the averaged torque to the periodic state of the full equations.

    Raises
    ------
    QuestionError
        If shooting does not converge: then there is no such state near the guess.
    """
    turn = Turn(machine, p, speed)
    backward = backward_whirl(p, speed, guess.whirl)
    z = guess.whirl + backward
    v = 1j * speed * (guess.whirl - backward)
    state = np.concatenate([[z.real, z.imag, v.real, v.imag], guess.angles, np.zeros(turn.count)])
    miss = turn(state) - state
    for _ in range(NEWTON_STEPS):
        error = float(np.abs(miss / turn.scale).max())
        if error < 1e-9:
            break
        slope = derivative(turn, state) - np.eye(state.size)
        # least squares: along a continuum of states the derivative is singular and any point of it will do
        scaled = slope * turn.scale / turn.scale[:, None]
        step = np.linalg.lstsq(scaled, -miss / turn.scale, rcond=1e-9)[0] * turn.scale
        damping = min(1.0, 0.5 / max(float(np.abs(step[4:]).max(initial=0.0)), 1e-300))
        state = state + damping * step
        miss = turn(state) - state
    error = float(np.abs(miss / turn.scale).max())
    if not error < 1e-7:
        raise QuestionError(f"steady state: shooting did not converge at {speed:.6g} rad/s (mismatch {error:.2g})")
    multipliers = np.linalg.eigvals(derivative(turn, state))
    order = np.argsort(-np.abs(multipliers))
    return PeriodicState(state, multipliers[order].astype(np.complex128), speed, error)


def derivative(turn: Turn, state: Floats) -> Matrix:
    """Derivative of the map by differences of fourth order, accurate to about 1e-10 in scaled components."""
    n = state.size
    result = np.empty((n, n))
    for i in range(n):
        step = 3e-3 * turn.scale[i] if i >= 4 else 1e-2 * turn.scale[i]
        offset = np.zeros(n)
        offset[i] = step
        near = turn(state + offset) - turn(state - offset)
        far = turn(state + 2.0 * offset) - turn(state - 2.0 * offset)
        result[:, i] = (8.0 * near - far) / (12.0 * step)
    return result
