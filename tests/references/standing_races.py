"""Balls in a race that a rotor too heavy to move holds, and their pendulum equation."""

from __future__ import annotations

import math
from typing import Any

from autobalancer.machine import Machine

ORBIT, DIAMETER, DENSITY, GRAVITY = 0.1, 0.01, 7800.0, 9.80665
ROLLING = 1.4  # 1 + j
BOTTOM = -0.5 * math.pi


def standing(
    *,
    axis: str = "horizontal",
    angles: list[float] | None = None,
    speeds: list[float] | None = None,
    speed: float = 0.0,
    beta: float = 0.0,
    excitations: list[dict[str, Any]] | None = None,
    firm: bool = False,
    **race: Any,
) -> Machine:
    """``angles`` are counted from the bottom of the race; ``speed`` is that of the rotor, rad/s.

    A ``firm`` rotor follows a base that moves within 1e-8.
    """
    angles = [0.3] if angles is None else angles
    balls = {
        "count": len(angles),
        "diameter": DIAMETER,
        "density": DENSITY,
        "start_angles": [BOTTOM + angle for angle in angles],
        "start_speeds": speeds or [0.0] * len(angles),
    }
    whole = {"orbit_radius": ORBIT, "drag": {"law": "viscous", "damping": beta}, "balls": [balls], **race}
    return Machine(
        name="standing race",
        axis=axis,
        gravity=GRAVITY,
        rotor={"mass": 1e8, "stiffness": 1e17 if firm else 1e13, "damping": 3e12 if firm else 3e10},
        balancers=[{"races": [whole]}],
        excitations=excitations or [],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": speed}},
    )
