"""Why balls at the stations of a rotor never balance it: a motion in which the rotor yields towards its load.

Balls gather on the side to which their plane moves. They balance only where the plane moves away from the load in every
motion they can excite: the receptance between their planes, for loads that turn with the rotor, must be negative
definite (its Hermitian part). A disk-like rotor, J_p > J_t, has no forward conical critical speed and always tilts towards
its load.
"""

from __future__ import annotations

import numpy as np

from autobalancer.errors import QuestionError
from autobalancer.machine import Machine
from autobalancer.machine.rotors.rigid import RigidRotor
from autobalancer.stability.host.stations import Stations

TRIED = 40  # speeds


def why_never(machine: Machine, st: Stations, highest: float) -> str:
    """A reason that holds at all speeds above the lowest critical one up to ``highest``, rad/s; empty if none is known."""
    for speed in np.geomspace(1.02 * st.scale_speed, highest, TRIED):
        if not yields(st, float(speed)):
            return ""
    shape = ""
    if isinstance(machine.rotor, RigidRotor) and machine.rotor.polar_inertia > machine.rotor.transverse_inertia:
        shape = (
            f"the rotor is disk-like, J_p = {machine.rotor.polar_inertia:.4g} > J_t = "
            f"{machine.rotor.transverse_inertia:.4g} kg m^2, and has no conical critical speed to run above: "
        )
    return (
        f"{shape}at every speed the rotor yields towards its load in one motion, so the balls make that motion larger"
    )


def yields(st: Stations, speed: float) -> bool:
    """Whether in some motion that the balls excite the planes move towards the load."""
    try:
        answer = st.rows @ st.compliance(speed) @ st.rows.T
    except QuestionError:  # a critical speed of an undamped rotor
        return True
    return float(np.linalg.eigvalsh(0.5 * (answer + answer.conj().T))[-1]) > 0.0
