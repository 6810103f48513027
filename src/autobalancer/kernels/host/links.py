"""Elastic links between rotor and motor: couplings, and the mount of the motor's stator.

From the rotor (theta_0, w_0) to the motor (theta_n, w_n), with the twist d_i = theta_i - theta_(i-1) as coordinate,

    M_i = k_i (d_i - e_i) + c_i (d_i - e_i)',    e_i = a_i cos(n_i theta_(i-1) + p_i),
    J_i w_i' = - M_i + (1 + e_(i+1)') M_(i+1),   and the rotor feels (1 + e_1') M_1,

with e' = de/dtheta: what follows from the energies with an error e of the twist. The motor adds its torque at the end, which
depends on its speed against the stator, and the stator bears it: J w' = - T - k a - c w.
"""

from __future__ import annotations

from typing import Any

from autobalancer.kernels.flags import EQUATIONS_PART, njit
from autobalancer.kernels.host.drive import drive_value, motor_torque
from autobalancer.kernels.pointers import behind
from autobalancer.kernels.records.drive import MOUNT, PRESCRIBED
from autobalancer.kernels.system import SPEED, THETA, system_at
from autobalancer.kernels.trigonometry import sine_cosine


@njit(**EQUATIONS_PART)
def turn_links(time: float, y: Any, dy: Any, system: Any) -> float:
    """Write the rates of all links; returns the torque on the rotor, N m."""
    drive = behind(system_at(system)).drive
    count = drive.links.shape[0]
    mounted = count > 0 and drive.links[count - 1].kind == MOUNT
    couplings = count - 1 if mounted else count
    value, rate = drive_value(time, drive)
    angle, speed = y[THETA], y[SPEED]
    on_rotor, before = 0.0, -1  # the state of the part before, whose acceleration is not complete yet
    for i in range(couplings):
        link = drive.links[i]
        at = link.state
        next_speed = y[at + 1]
        free, slope = y[at], 0.0
        if link.error != 0.0:
            s, c = sine_cosine(link.order * angle + link.phase)
            free -= link.error * c
            slope = -link.error * link.order * s
        torque = link.stiffness * free + link.damping * (next_speed - (1.0 + slope) * speed)
        if before < 0:
            on_rotor = (1.0 + slope) * torque
        else:
            dy[before + 1] += (1.0 + slope) * torque / drive.links[i - 1].inertia
        dy[at] = next_speed - speed
        if link.inertia > 0.0:
            dy[at + 1] = -torque / link.inertia
        else:
            dy[at + 1] = rate
        angle, speed, before = angle + y[at], next_speed, at
    if drive.motor == PRESCRIBED:
        return on_rotor
    if mounted:
        at = drive.links[couplings].state
        angle -= y[at]
        speed -= y[at + 1]
    torque = motor_torque(value, speed, drive)
    for i in range(drive.ripples.shape[0]):
        ripple = drive.ripples[i]
        torque += ripple.torque * sine_cosine(ripple.order * angle + ripple.phase)[1]
    if before < 0:
        on_rotor = torque
    else:
        dy[before + 1] += torque / drive.links[couplings - 1].inertia
    if mounted:
        stator = drive.links[couplings]
        at = stator.state
        dy[at] = y[at + 1]
        dy[at + 1] = -(torque + stator.stiffness * y[at] + stator.damping * y[at + 1]) / stator.inertia
    return on_rotor
