"""Periodic steady states and their Floquet multipliers: orthotropic supports, gravity, whatever turns with the rotor.

At constant speed the machine is periodic with one revolution. The state of rest in the rotor becomes a state that returns
after a revolution; it is found by shooting, with the compiled equations integrated over one turn. The multipliers are the
eigenvalues of the derivative of that map; growth rate = ln|multiplier| over the time of a turn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.system import Assembly, assemble
from autobalancer.errors import QuestionError
from autobalancer.kernels.guided_balls import planar
from autobalancer.kernels.integrators import tableau as tableaus
from autobalancer.kernels.integrators.memory import memory
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.system import BALLS, LINEAR, PRESCRIBED, SEGMENT_COLUMNS, THETA, UNBALANCE, VX, VY, X, Y
from autobalancer.machine import Machine
from autobalancer.simulation.record import record_for
from autobalancer.stability.host.planar import Complexes, Floats, Matrix, Plane
from autobalancer.stability.states.planar import Equilibrium

TOLERANCE = 1e-13
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


class Turn:
    """The map over one revolution of a machine at constant speed, in axes at rest."""

    def __init__(self, machine: Machine, p: Plane, speed: float) -> None:
        self.assembly: Assembly = assemble(machine, rotating=False, contact=False, real=False)
        segments = np.zeros((1, SEGMENT_COLUMNS))
        segments[0, 1], segments[0, 2] = LINEAR, speed
        segments[0, UNBALANCE : UNBALANCE + 2] = p.unbalance.real, p.unbalance.imag
        self.system = self.assembly.system._replace(drive=PRESCRIBED, segments=segments)
        self.speed, self.count = speed, p.moment.size
        self.period = 2.0 * math.pi / speed
        self.pair = tableaus.dormand_prince_8()
        scale = self.assembly.scale
        self.scale = np.concatenate([scale[[X, Y, VX, VY]], scale[BALLS:]])
        self.record = record_for((), (), self.assembly, self.period)

    def __call__(self, state: Floats, turns: int = 1) -> Floats:
        """The state after so many revolutions."""
        full = np.zeros(BALLS + 2 * self.count)
        full[[X, Y, VX, VY]], full[BALLS:] = state[:4], state[4:]
        run = memory(
            full,
            turns * self.period,
            TOLERANCE * self.assembly.scale,
            TOLERANCE * self.assembly.growing,
            total=self.pair.total,
            degree=self.pair.degree,
            longest=self.period,
        )
        run.state[THETA] = 0.0
        self.system.now[0] = 0
        if advance(planar, self.system, self.pair, self.record, run, 10_000_000) != FINISHED:
            raise QuestionError(
                "steady state: the motion grows without limit within one revolution; the start is too far off"
            )
        return np.concatenate([run.state[[X, Y, VX, VY]], run.state[BALLS:]])

    def derivative(self, state: Floats) -> Matrix:
        """Derivative of the map by differences of fourth order, accurate to about 1e-10 in scaled components."""
        n = state.size
        result = np.empty((n, n))
        for i in range(n):
            step = 3e-3 * self.scale[i] if i >= 4 else 1e-2 * self.scale[i]
            offset = np.zeros(n)
            offset[i] = step
            near = self(state + offset) - self(state - offset)
            far = self(state + 2.0 * offset) - self(state - 2.0 * offset)
            result[:, i] = (8.0 * near - far) / (12.0 * step)
        return result


def periodic_state(machine: Machine, p: Plane, speed: float, guess: Equilibrium) -> PeriodicState:
    """Refine a state of the averaged torque to the periodic state of the full equations.

    Raises
    ------
    QuestionError
        If shooting does not converge: then there is no such state near the guess.
    """
    turn = Turn(machine, p, speed)
    backward = p.backward(speed, guess.whirl)
    z = guess.whirl + backward
    v = 1j * speed * (guess.whirl - backward)
    state = np.concatenate([[z.real, z.imag, v.real, v.imag], guess.angles, np.zeros(turn.count)])
    miss = turn(state) - state
    for _ in range(NEWTON_STEPS):
        error = float(np.abs(miss / turn.scale).max())
        if error < 1e-9:
            break
        slope = turn.derivative(state) - np.eye(state.size)
        # least squares: along a continuum of states the derivative is singular and any point of it will do
        scaled = slope * turn.scale / turn.scale[:, None]
        step = np.linalg.lstsq(scaled, -miss / turn.scale, rcond=1e-9)[0] * turn.scale
        damping = min(1.0, 0.5 / max(float(np.abs(step[4:]).max(initial=0.0)), 1e-300))
        state = state + damping * step
        miss = turn(state) - state
    error = float(np.abs(miss / turn.scale).max())
    if not error < 1e-7:
        raise QuestionError(f"steady state: shooting did not converge at {speed:.6g} rad/s (mismatch {error:.2g})")
    multipliers = np.linalg.eigvals(turn.derivative(state))
    order = np.argsort(-np.abs(multipliers))
    return PeriodicState(state, multipliers[order].astype(np.complex128), speed, error)
