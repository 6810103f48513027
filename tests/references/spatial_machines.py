"""Rigid rotors with balls at two stations, and how the package moves them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from tests.references.rates import rates_at

from autobalancer.assembly.system import Assembly, assemble
from autobalancer.kernels.host.shaft_train import enter_segment
from autobalancer.kernels.integrators.runge_kutta import FINISHED, advance
from autobalancer.kernels.integrators.tableau import dormand_prince_8
from autobalancer.kernels.system import BALLS, THETA
from autobalancer.machine import Machine
from autobalancer.simulation.record import SampleTimes, record_for
from autobalancer.simulation.steppers import equations, memory_for


def tilting(
    *, isotropic: bool = False, damping: float = 25.0, beta: float = 2e-5, motion: str = "rolling", **top: Any
) -> Machine:
    """Critical speeds near 170 and 260 rad/s; 2 + 2 unequal balls, one race off center, static and couple unbalance."""
    drag = {"law": "viscous", "damping": beta}
    data: dict[str, Any] = {
        "name": "tilting",
        "axis": "vertical",
        "rotor": {
            "kind": "rigid",
            "mass": 5.0,
            "transverse_inertia": 0.06,
            "polar_inertia": 0.035,
            "supports": [
                {
                    "position": -0.12,
                    "stiffness": 7e4 if isotropic else [7e4, 9e4],
                    "damping": damping if isotropic else [damping, 0.8 * damping],
                },
                {"position": 0.15, "stiffness": 9e4, "damping": damping, "tilt_damping": 1e-3 * damping},
            ],
        },
        "stations": [{"name": "upper", "position": 0.09}, {"name": "lower", "position": -0.07}],
        "unbalances": [
            {"moment": 4e-4, "angle": 0.4, "station": "upper"},
            {"couple": 6e-5, "angle": 2.0},
        ],
        "balancers": [
            {
                "station": "lower",
                "races": [
                    {
                        "collisions": False,
                        "race_radius": 0.085,
                        "drag": drag,
                        "balls": [
                            {"mass": 4e-3, "diameter": 0.01, "motion": motion, "start_angles": 1.0},
                            {"mass": 3e-3, "diameter": 0.009, "motion": motion, "start_angles": -1.9},
                        ],
                    }
                ],
            },
            {
                "station": "upper",
                "races": [
                    {
                        "collisions": False,
                        "race_radius": 0.075,
                        "eccentricity": 1e-3,
                        "eccentricity_angle": 0.7,
                        "drag": drag,
                        "balls": [
                            {"mass": 5e-3, "diameter": 0.011, "motion": motion, "start_angles": 2.5},
                            {
                                "mass": 2e-3,
                                "diameter": 0.008,
                                "motion": motion,
                                "start_angles": 5.0,
                                "start_speeds": -20.0,
                            },
                        ],
                    }
                ],
            },
        ],
        "drive": {"kind": "torque", "torque": 0.0},
        "start": {"speed": 200.0, "deflection": [2e-4, -1e-4], "velocity": [0.03, 0.05], "rotor_angle": 0.3},
    }
    data |= top
    if data["drive"]["kind"] == "speed":
        data["start"] = {key: value for key, value in data["start"].items() if key != "speed"}
    return Machine(**data)


def rates(assembly: Assembly, time: float, state: np.ndarray) -> np.ndarray:
    """Derivative of the state by the compiled equations, in the axes of the system."""
    system = assembly.system
    system.drive.now[0] = 0
    enter_segment(time, system.drive)
    return rates_at(equations(assembly).rates, time, state, system)


def turned(state: np.ndarray, balls: int, sign: float = 1.0) -> np.ndarray:
    """States with all lateral components turned by the rotor angle: from axes of the rotor (sign 1) to axes at rest."""
    state = np.array(state, float)
    rest, turn = BALLS + 2 * balls, np.exp(sign * 1j * state[..., THETA])
    for first in [0, 2, *range(rest, state.shape[-1], 2)]:
        z = (state[..., first] + 1j * state[..., first + 1]) * turn
        state[..., first], state[..., first + 1] = z.real, z.imag
    return state


def states_of(
    machine: Machine,
    times: Sequence[float] | np.ndarray,
    *,
    tolerance: float = 1e-13,
    rotating: bool | None = None,
    start: np.ndarray | None = None,
) -> np.ndarray:
    """States of the package by the general equations at these times, in axes at rest."""
    assembly = assemble(machine, rotating=rotating, general=True)
    if start is not None:
        assembly.state[:] = start
    pair, end = dormand_prince_8(), float(times[-1])
    record = record_for([SampleTimes(times)], [], assembly, end)
    memory = memory_for(assembly, end, tolerance, pair)
    assert advance(*equations(assembly), assembly.system, pair, record, memory, 10**9) == FINISHED
    return turned(record.samples, len(assembly.balls)) if assembly.system.rotating else record.samples
