"""Small machines with deep chambers: few balls, soft contacts, so that steps are long."""

from __future__ import annotations

from typing import Any

from autobalancer.machine.chamber import ChamberMachine

SUPPORT = {"stiffness": [8125.0, 8125.0, 16250.0], "damping": [40.0, 40.0, 80.0]}


def small_machine(**changed: Any) -> ChamberMachine:
    """Three balls of 1 kg together in a deep chamber on a planar body; contacts a hundred times softer than steel."""
    described: dict[str, Any] = {
        "name": "Small chamber",
        "body": {"freedom": "planar", "mass": 110.0, "inertia": [20.0, 25.0, 20.0]},
        "supports": [{"position": [x, y, -0.15], **SUPPORT} for x in (0.3, -0.3) for y in (0.4, -0.4)],
        "rotor": {"mass": 10.0, "polar_inertia": 0.05, "transverse_inertia": 0.06, "bearings": [0.1, -0.1]},
        "unbalances": [{"moment": 0.06}],
        "chambers": [
            {"radius": 0.1, "depth": 0.2, "balls": [{"count": 3, "density": 7800.0, "total_mass": 1.0}]},
        ],
        "contact": {"law": "restitution", "restitution": 0.54, "friction": 0.5, "rolling_arm": 2e-5, "stiffness": 1e8},
        "drive": {
            "kind": "asynchronous",
            "rated_torque": 14.6,
            "overload": 2.2,
            "synchronous_speed": 157.08,
            "breakdown_slip": 0.2,
        },
    }
    return ChamberMachine(**(described | changed))


def free_machine(**changed: Any) -> ChamberMachine:
    """A released body of 20 kg around a rotor of 3 kg, without supports, weight and unbalance, in soft contact."""
    described: dict[str, Any] = {
        "name": "Free machine",
        "gravity": [0.0, 0.0, 0.0],
        "body": {"freedom": "free", "mass": 20.0, "inertia": [0.5, 0.5, 0.5]},
        "rotor": {"mass": 3.0, "polar_inertia": 0.5, "transverse_inertia": 0.32, "bearings": [0.1, -0.1]},
        "chambers": [{"radius": 0.06, "depth": 0.1, "balls": [{"count": 8, "density": 7800.0, "mass": 0.1}]}],
        "contact": {"law": "restitution", "restitution": 0.6, "friction": 0.4, "rolling_arm": 1e-4, "stiffness": 1e8},
        "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}},
    }
    contact = described["contact"] | changed.pop("contact", {})
    return ChamberMachine(**(described | changed | {"contact": contact}))


def cylinder_machine(**changed: Any) -> ChamberMachine:
    """Cylinders of 20 mm by 30 mm in a drum of 100 mm that is held; ``balls`` and ``contact`` are changed in part."""
    balls: dict[str, Any] = {"body": "cylinder", "count": 1, "density": 7800.0, "diameter": 0.02, "length": 0.03}
    contact = {"law": "restitution", "restitution": 0.6, "friction": 0.0, "youngs_modulus": 1e8, "poisson_ratio": 0.3}
    chamber: dict[str, Any] = {"radius": 0.1, "depth": 0.2, "balls": [balls | changed.pop("balls", {})]}
    described: dict[str, Any] = {
        "name": "Cylinders",
        "gravity": [0.0, 0.0, 0.0],
        "body": {"freedom": "fixed"},
        "rotor": {"mass": 3.0, "polar_inertia": 0.5, "transverse_inertia": 0.32, "bearings": [0.1, -0.1]},
        "chambers": [chamber | changed.pop("chamber", {})],
        "contact": contact | changed.pop("contact", {}),
        "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": changed.pop("speed", 0.0)}},
    }
    return ChamberMachine(**(described | changed))
