"""Which machines can be integrated in long steps, and the modes of their rotors for it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from autobalancer.assembly.system import Assembly, Model
from autobalancer.kernels.balls.at_nodes.planar_contacts import contacts_in_steps
from autobalancer.kernels.balls.planar_nodes import planar_nodes
from autobalancer.kernels.integrators.collocation.amplitudes import Amplitudes, amplitudes
from autobalancer.kernels.integrators.collocation.inside import by_powers
from autobalancer.kernels.integrators.memory import Memory
from autobalancer.kernels.records.drive import RECORDED
from autobalancer.kernels.system import VX, VY, X, Y
from autobalancer.kernels.wide import NODES
from autobalancer.simulation.modes import rotor_modes
from autobalancer.simulation.steppers import LongSteps

DAMPED = 0.9  # of the critical damping: beyond it both modes are nearly one, and amplitudes lose digits
NEARLY_THE_SAME = "two modes of its rotor are nearly equal, or one decays without vibrating"


def why_no_long_steps(assembly: Assembly) -> str:
    """What is in the way, as a sentence; empty if nothing is."""
    system = assembly.system
    if system.forces.shape[0] > 0:
        return "it does not take forces on the balls"
    if assembly.model is not Model.PLANAR:
        return _why_no_modes(assembly)
    if not system.rotating:
        return "of planar rotors it takes those with equal springs along x and y without gravity in the plane only"
    rotor = system.planar
    if rotor.damping_x > 2.0 * DAMPED * math.sqrt(rotor.stiffness_x * rotor.mass):
        return f"the rotor is damped by more than {DAMPED:.0%} of its critical damping"
    return ""


def _why_no_modes(assembly: Assembly) -> str:
    """The same of a rotor that tilts or bends, or has real races."""
    system = assembly.system
    obstacles = {
        "balls that are resolved in contact": assembly.model is Model.RESOLVED,
        "real races that tilt": assembly.model is Model.ROUGH_TILTING,
        "recorded excitations": bool((system.shakes.kind == RECORDED).any()),
        "a stop of a bearing": bool((system.bearings.springs.contact > 0.0).any()),
        "rubber that softens": system.rubber.mounts.shape[0] > 0,
        "couplings, a mount of the motor or ripples of its torque": system.drive.linked == 1,
        "tables over the speed": len(system.host.speeds) > 1,
        "a fluid that lags by itself": system.fluid.modes.shape[0] > 0,
        "slipstream": system.fluid.lines.shape[0] > 0,
    }
    return next((f"it does not take {what}" for what, there in obstacles.items() if there), "")


def long_steps(assembly: Assembly, memory: Memory, near: float | None = None) -> LongSteps | None:
    """Long steps of a machine, beside a pair with this memory; None if its modes carry no motion.

    Of a rotor that stays ``near`` a speed, the modes there are enough.
    """
    if assembly.model is Model.PLANAR:
        nodes, watch, unknowns = planar_nodes, contacts_in_steps, planar_amplitudes(assembly)
    else:
        found = rotor_modes(assembly.system, assembly.state, assembly.critical_speeds, near)
        if found is None:
            return None
        (nodes, watch), unknowns = _equations(assembly), found
    width = memory.trial.size
    own = memory._replace(stages=np.zeros((NODES, width)), dense=np.zeros((NODES, width)), shares=np.zeros(NODES))
    return LongSteps(nodes, watch, by_powers(), own, unknowns)


def _equations(assembly: Assembly) -> tuple[Any, Any]:
    """The forces at the nodes of a rotor with stations, and how far they hold."""
    if assembly.model is Model.ROUGH:
        from autobalancer.kernels.balls.at_nodes.real_races import open_and_rolling, rough_station_nodes

        return rough_station_nodes, open_and_rolling
    from autobalancer.kernels.balls.at_nodes.contacts import contacts_at_nodes
    from autobalancer.kernels.balls.at_nodes.stations import station_nodes, tilting_station_nodes

    return (tilting_station_nodes if assembly.model is Model.TILTING else station_nodes), contacts_at_nodes


def planar_amplitudes(assembly: Assembly) -> Amplitudes:
    """The modes of a planar rotor."""
    rotor = assembly.system.planar
    stiffness, damping = rotor.stiffness_x / rotor.mass, rotor.damping_x / rotor.mass
    decay = 0.5 * damping
    turn = math.sqrt(stiffness - decay * decay)
    # zeta = p+ + p-, nu = mu+ p+ + mu- p-, real and imaginary parts apart
    shapes = np.array(
        [[1, 0, 1, 0], [0, 1, 0, 1], [-decay, -turn, -decay, turn], [turn, -decay, -turn, -decay]], np.float64
    )
    return amplitudes(
        np.array([complex(-decay, turn), complex(-decay, -turn)]),
        shapes,
        np.array([X, Y, VX, VY]),
        assembly.system.ball_count,
        np.array([stiffness, damping, decay, turn]),
        assembly.state.size,
        turning=True,
    )
