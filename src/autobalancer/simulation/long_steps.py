"""Which machines can be integrated in long steps, and the modes of their rotors for it."""

from __future__ import annotations

import math

import numpy as np

from autobalancer.assembly.system import Assembly, Model
from autobalancer.kernels.balls.open_gaps import open_gaps
from autobalancer.kernels.balls.planar_nodes import planar_nodes
from autobalancer.kernels.integrators.collocation.amplitudes import amplitudes
from autobalancer.kernels.integrators.collocation.inside import by_powers
from autobalancer.kernels.integrators.memory import Memory
from autobalancer.kernels.system import VX, VY, X, Y
from autobalancer.kernels.wide import NODES
from autobalancer.simulation.steppers import LongSteps

DAMPED = 0.9  # of the critical damping: beyond it both modes are nearly one, and amplitudes lose digits


def why_no_long_steps(assembly: Assembly) -> str:
    """What is in the way, as a sentence; empty if nothing is."""
    system = assembly.system
    if assembly.model is not Model.PLANAR:
        return "it takes planar rotors with balls on plain races only"
    if not system.rotating:
        return "it takes equal springs along x and y without gravity in the plane only"
    if system.forces.shape[0] > 0:
        return "it does not take forces on the balls"
    rotor = system.planar
    if rotor.damping_x > 2.0 * DAMPED * math.sqrt(rotor.stiffness_x * rotor.mass):
        return f"the rotor is damped by more than {DAMPED:.0%} of its critical damping"
    return ""


def amplitudes_of(assembly: Assembly, memory: Memory) -> LongSteps:
    """Long steps of a planar rotor, beside a pair with this memory."""
    rotor = assembly.system.planar
    stiffness, damping = rotor.stiffness_x / rotor.mass, rotor.damping_x / rotor.mass
    decay = 0.5 * damping
    turn = math.sqrt(stiffness - decay * decay)
    # zeta = p+ + p-, nu = mu+ p+ + mu- p-, real and imaginary parts apart
    shapes = np.array(
        [[1, 0, 1, 0], [0, 1, 0, 1], [-decay, -turn, -decay, turn], [turn, -decay, -turn, -decay]], np.float64
    )
    unknowns = amplitudes(
        np.array([complex(-decay, turn), complex(-decay, -turn)]),
        shapes,
        np.array([X, Y, VX, VY]),
        assembly.system.ball_count,
        np.array([stiffness, damping, decay, turn]),
        assembly.state.size,
        turning=True,
    )
    width = memory.trial.size
    own = memory._replace(stages=np.zeros((NODES, width)), dense=np.zeros((NODES, width)), shares=np.zeros(NODES))
    return LongSteps(planar_nodes, open_gaps, by_powers(), own, unknowns)
