"""Run-ups of two rolling balls on any rotor, guided and resolved, and how far they are apart."""

from __future__ import annotations

from typing import Any

import numpy as np
from tests.references.resolved import states_at
from tests.references.shafts import shaft

from autobalancer.assembly.system import assemble
from autobalancer.kernels.system import BALLS, X, Y
from autobalancer.machine import Machine

ORBIT = 0.1
RIGID = {
    "kind": "rigid", "mass": 10.0, "transverse_inertia": 0.05, "polar_inertia": 0.06,
    "supports": [
        {"position": -0.1, "stiffness": [4e5, 5e5], "damping": [60.0, 50.0]},
        {"position": 0.15, "stiffness": [3e5, 3.5e5], "damping": [40.0, 50.0]},
    ],
}  # fmt: skip
PLANAR = {"mass": 10.0, "stiffness": 6.25e5, "damping": 100.0, "inertia": 0.05}
SHAFT = shaft(
    length=0.6,
    diameter=0.025,
    supports=[
        {"position": 0.0, "stiffness": 2e6, "damping": 200.0},
        {"position": 0.6, "stiffness": [2e6, 3e6], "damping": 200.0},
    ],
    disks=[{"position": 0.3, "mass": 8.0, "transverse_inertia": 0.02, "polar_inertia": 0.04}],
)
RIG = {
    "kind": "multibody",
    "bodies": [
        {"name": "disc", "mass": 8.0, "transverse_inertia": 0.04, "polar_inertia": 0.05, "position": 0.05, "rotating": True},
        {"name": "housing", "mass": 3.0, "transverse_inertia": 0.03, "polar_inertia": 0.03, "position": -0.05},
    ],
    "joints": [
        {"kind": "bearing", "between": ["disc", "housing"], "position": 0.0, "stiffness": 2e6, "damping": 30.0,
         "axial_stiffness": 3e6},
        {"kind": "bearing", "between": ["disc", "housing"], "position": -0.08, "stiffness": 2e6, "damping": 30.0},
        {"kind": "bushing", "between": ["housing", "ground"], "position": -0.08, "count": 4, "radius": 0.1,
         "shear_stiffness": 1.2e5, "shear_damping": 60.0, "axial_stiffness": 3e5, "axial_damping": 60.0},
    ],
}  # fmt: skip
GRIP = {"restitution": 0.3, "sliding_friction": 0.5}


def run_up(
    resolved: dict[str, Any] | None = None,
    *,
    rotor: dict[str, Any] = PLANAR,
    torque: bool = False,
    excitations: list[dict[str, Any]] | None = None,
    station: float = 0.05,
    **race: Any,
) -> Machine:
    """Two rolling balls through the critical speed."""
    where = {"station": station} if "kind" in rotor else {}
    profile = {"kind": "ramp", "start": 150.0, "end": 400.0, "duration": 0.6}
    drive: dict[str, Any] = {"kind": "torque", "torque": 20.0} if torque else {"kind": "speed", "profile": profile}
    return Machine(
        name="run-up",
        axis="vertical",
        rotor=rotor,
        unbalances=[{"mass": 5e-3, "radius": 0.1, **where}],
        balancers=[
            {
                "races": [
                    {
                        "orbit_radius": ORBIT,
                        "collisions": False,
                        "drag": {"law": "viscous", "damping": 3e-4},
                        "balls": [{"count": 2, "mass": 2.5e-3, "diameter": 8e-3, "start_angles": [1.0, -1.9]}],
                        **race,
                        **({"resolved": resolved} if resolved else {}),
                    }
                ],
                **where,
            }
        ],
        excitations=excitations or [],
        drive=drive,
        **({"start": {"speed": 150.0}} if torque else {}),
    )


def apart(one: Machine, other: Machine, **options: Any) -> float:
    """The greatest difference of ball angles, rad, and of deflections over the greatest deflection."""
    times, n = np.linspace(0.0, 0.6, 301), 2
    a, b = (states_at(assemble(machine, **options), times, 1e-9) for machine in (one, other))
    deflections = [np.hypot(s[:, X], s[:, Y]) for s in (a, b)]
    angle = np.abs(a[:, BALLS : BALLS + n] - b[:, BALLS : BALLS + n]).max()
    return float(max(angle, np.abs(deflections[0] - deflections[1]).max() / deflections[0].max()))
