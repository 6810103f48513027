"""What a result says of the links between rotor and motor: twist, speed and torque of each."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.assembly.torsion.links import link_names
from autobalancer.kernels.records.drive import COUPLING
from autobalancer.kernels.system import SPEED, THETA, Drive, Matrix
from autobalancer.machine import Machine


def link_coordinates(machine: Machine) -> dict[str, Any]:
    """Names of what is behind each link."""
    names = link_names(machine)
    return {"link": np.array(names, dtype=object)} if names else {}


def over_links(states: Matrix, drive: Drive) -> dict[str, Any]:
    """Twist (rad), speed on the side of the motor (rad/s) and torque towards the rotor (N m), over time and link."""
    if not len(drive.links):
        return {}
    at = drive.links.state
    twist, speed = states[:, at], states[:, at + 1]
    torque, angle, before = np.zeros_like(twist), states[:, THETA], states[:, SPEED]
    for i, link in enumerate(drive.links):
        free, change = twist[:, i].copy(), speed[:, i].copy()
        if link.kind == COUPLING:
            turned = link.order * angle + link.phase
            free -= link.error * np.cos(turned)
            change -= (1.0 - link.error * link.order * np.sin(turned)) * before
            angle, before = angle + twist[:, i], speed[:, i]
        torque[:, i] = link.stiffness * free + link.damping * change
    both = ("time", "link")
    return {"twist": (both, twist), "link_speed": (both, speed), "link_torque": (both, torque)}
