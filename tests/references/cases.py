"""Machines with which the stepper is tested, and a closed form."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from autobalancer.assembly.system import assemble
from autobalancer.kernels.integrators.integrator_state import Memory
from autobalancer.kernels.integrators.recording import Record
from autobalancer.kernels.integrators.tableau import Tableau, dormand_prince_8, tsitouras
from autobalancer.machine import Machine
from autobalancer.simulation.record import Event, Sampling, record_for
from autobalancer.simulation.steppers import memory_for

PAIRS = {"tsitouras": tsitouras(), "dormand_prince_8": dormand_prince_8()}
ORDERS = {"tsitouras": (5, 4, 4), "dormand_prince_8": (8, 5, 7)}  # solution, embedded, dense output
both = pytest.mark.parametrize("method", PAIRS)


def run_up(**changes: Any) -> Machine:
    """Two rolling balls, driven by a torque through the critical speed of 250 rad/s."""
    data: dict[str, Any] = {
        "name": "run-up",
        "axis": "vertical",
        "rotor": {"mass": 10.0, "stiffness": 6.25e5, "damping": 100.0, "inertia": 0.05},
        "unbalances": [{"mass": 5e-3, "radius": 0.1}],
        "balancers": [
            {
                "races": [
                    {
                        "collisions": False,
                        "orbit_radius": 0.1,
                        "drag": {"law": "viscous", "damping": 1.5e-4},
                        "balls": [{"count": 2, "mass": 2.5e-3, "diameter": 8e-3, "start_angles": [1.0, -1.9]}],
                    }
                ]
            }
        ],
        "drive": {"kind": "torque", "torque": 15.0, "damping": 0.0},
    }
    return Machine(**(data | changes))


def oscillator(speed: float = 100.0, **start: Any) -> Machine:
    """No balls, a constant speed: linear, with a solution in closed form."""
    return Machine(
        name="oscillator",
        axis="vertical",
        rotor={"mass": 2.0, "stiffness": [8e4, 5e4], "damping": [10.0, 6.0]},
        unbalances=[{"moment": 1e-3, "angle": 0.5}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": speed}},
        start={"deflection": [1e-3, -5e-4], "velocity": [0.1, 0.2], **start},
    )


def exact(machine: Machine, t: Any) -> tuple[Any, Any]:
    """x and y of the oscillator."""
    result = []
    w, u = machine.drive.profile.speed, machine.unbalances[0]  # type: ignore[union-attr]
    for i in range(2):
        m, k, b = 2.0, machine.rotor.stiffness_xy[i], machine.rotor.damping_xy[i]
        force = u.size * w**2 * np.exp(1j * (u.angle - i * np.pi / 2))
        forced = force / (k - m * w**2 + 1j * b * w)
        root = -b / (2 * m) + 1j * np.sqrt(k / m - (b / (2 * m)) ** 2)
        x0 = machine.start.deflection[i] - forced.real
        v0 = machine.start.velocity[i] - (1j * w * forced).real
        free = x0 + 1j * (root.real * x0 - v0) / root.imag
        result.append((forced * np.exp(1j * w * t)).real + (free * np.exp(root * t)).real)
    return result[0], result[1]


def prepared(
    machine: Machine,
    end: float,
    save: list[Sampling] | None = None,
    events: list[Event] | None = None,
    *,
    tolerance: float = 1e-8,
    pair: Tableau | None = None,
    rotating: bool | None = None,
) -> tuple[Any, Tableau, Record, Memory]:
    pair = pair or dormand_prince_8()
    assembly = assemble(machine, rotating=rotating)
    return (
        assembly.system,
        pair,
        record_for(save or [], events or [], assembly, end),
        memory_for(assembly, end, tolerance, pair),
    )


CORNERS = [0.2, 0.35, 0.5123, 1.1]
CORNERED = {
    "drive": {"kind": "speed", "profile": {"kind": "table", "time": CORNERS, "speed": [100.0, 300.0, 300.0, 150.0]}},
    "unbalances": [
        {"moment": 4e-4, "schedule": {"time": [0.77, 0.77, 0.9], "factor": [1.0, 0.2, 1.5]}},
    ],
}
