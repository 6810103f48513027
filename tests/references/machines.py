"""Random machines and random states, for properties that hold for all of them."""

from __future__ import annotations

from typing import Any

import numpy as np
from tests.references.lagrange import Planar

from autobalancer.machine import Machine

DRIVES = ("torque", "target_torque", "torque_table", "constant", "ramp", "table", "hill", "dwell")


def random_machine(
    random: np.random.Generator,
    *,
    isotropic: bool | None = None,
    axis: str | None = None,
    drive: str | None = None,
    scheduled: bool = True,
) -> Machine:
    """One or two balancers, races with equal and unequal balls, with and without fluid, offset or not."""
    u = random.uniform
    isotropic = bool(random.integers(2)) if isotropic is None else isotropic
    pair = (lambda a, b: u(a, b)) if isotropic else (lambda a, b: [u(a, b), u(a, b)])
    data: dict[str, Any] = {
        "name": "random",
        "axis": axis or str(random.choice(["vertical", "horizontal"])),
        "rotor": {
            "mass": u(2.0, 20.0),
            "stiffness": pair(1e4, 1e6),
            "damping": pair(0.0, 200.0),
            "inertia": u(0.02, 0.5),
        },
        "unbalances": [_unbalance(random, scheduled) for _ in range(random.integers(0, 3))],
        "balancers": [
            {"races": [_race(random) for _ in range(random.integers(1, 3))]} for _ in range(random.integers(1, 3))
        ],
        "drive": _drive(random, drive or str(random.choice(DRIVES))),
        "start": {"rotor_angle": u(-3.0, 3.0)},
    }
    return Machine(**data)


def random_state(random: np.random.Generator, reference: Planar) -> tuple[float, np.ndarray]:
    """A time and a state in axes at rest; the speed is the prescribed one if there is one."""
    n, u = reference.balls, random.uniform
    time = float(u(0.1, 12.0))
    speed = reference.speed(time)[0] if reference.speed is not None else u(50.0, 400.0)
    host = [*u(-1e-3, 1e-3, 2), *u(-0.3, 0.3, 2), u(-10.0, 10.0), speed]
    return time, np.concatenate([host, u(-3.0, 3.0, n), u(-30.0, 30.0, n)])


def _unbalance(random: np.random.Generator, scheduled: bool) -> dict[str, Any]:
    u = random.uniform
    data: dict[str, Any] = {"mass": u(1e-3, 1e-2), "radius": u(0.02, 0.2), "angle": u(-3.0, 3.0)}
    if scheduled and random.integers(2):
        data["schedule"] = {"time": [2.0, 5.0, 8.0], "factor": list(u(0.0, 2.0, 3))}
    return data


def _race(random: np.random.Generator) -> dict[str, Any]:
    u = random.uniform
    race: dict[str, Any] = {"collisions": False, "drag": {"law": "viscous", "damping": u(1e-5, 1e-3)}, "balls": []}
    if random.integers(2):
        race["fluid"] = {"density": u(700.0, 1200.0), "viscosity": u(1e-6, 1e-4), "virtual_mass": u(0.0, 2.0)}
        if random.integers(2):
            race["drag"] = {"law": "cd_times_re", "cd_times_re": u(24.0, 400.0)}
    if random.integers(3):
        race["eccentricity"], race["eccentricity_angle"] = u(0.0, 5e-3), u(-3.0, 3.0)
    unequal = bool(random.integers(2))
    race["race_radius" if unequal else "orbit_radius"] = u(0.08, 0.2)
    for _ in range(random.integers(1, 3) if unequal else 1):
        race["balls"].append(
            {
                "count": int(random.integers(1, 4)),
                "diameter": u(0.005, 0.015),
                "density": u(3000.0, 9000.0),
                "motion": str(random.choice(["rolling", "point"])),
            }
        )
    return race


def _drive(random: np.random.Generator, kind: str) -> dict[str, Any]:
    u = random.uniform
    if kind == "torque":
        return {"kind": "torque", "torque": u(-5.0, 5.0), "damping": u(0.0, 0.05)}
    if kind == "torque_table":
        speeds = np.cumsum(u(50.0, 150.0, 4)) - 100.0
        return {"kind": kind, "speed": list(speeds), "torque": list(u(-5.0, 5.0, 4)), "damping": u(0.0, 0.05)}
    profiles = {
        "constant": {"kind": "constant", "speed": u(50.0, 400.0)},
        "ramp": {
            "kind": "ramp",
            "start": u(0.0, 50.0),
            "end": u(100.0, 400.0),
            "duration": u(3.0, 6.0),
            "delay": u(1.0, 3.0),
        },
        "table": {"kind": "table", "time": [1.0, 3.0, 7.0], "speed": list(u(50.0, 400.0, 3))},
        "hill": {
            "kind": "hill",
            "start": u(0.0, 50.0),
            "end": u(100.0, 400.0),
            "half_time": u(2.0, 5.0),
            "exponent": u(1.0, 4.0),
        },
        "dwell": {
            "kind": "dwell",
            "speeds": list(u(50.0, 400.0, 3)),
            "hold": u(1.0, 2.0),
            "acceleration": u(50.0, 200.0),
        },
    }
    if kind == "target_torque":
        chosen = str(random.choice(list(profiles)))
        return {"kind": kind, "gain": u(0.1, 1.0), "damping": u(0.1, 1.0), "profile": profiles[chosen]}
    return {"kind": "speed", "profile": profiles[kind]}
