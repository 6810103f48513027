"""What the source does not print of its machine, and the machine that follows."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields, replace
from typing import Any

from autobalancer.machine.chamber import ChamberMachine

DEPTH, TOTAL_MASS, RESTITUTION = 0.2, 120.0, 0.54  # printed: B, M of (52), R of section 3.1
STIFFNESS, DAMPING = 32500.0, 41.0  # printed: (53), along x and y; twice as much along z
ROTOR_MASS, POISSON = 10.0, 0.3
STEEL, SOFT_STEEL = 206e9, 20.6e9  # Pa; the second one in screening, so that steps are longer
SPEEDS = (104.72, 157.08, 314.16)  # rad/s: motors with six, four and two poles at 50 Hz


@dataclass(frozen=True)
class Candidate:
    """The free numbers. SI."""

    unbalance: float = 0.0901
    ball_mass: float = 2.739  # of all balls
    density: float = 7800.0
    radius: float = 0.108  # of the chamber
    rolling_arm: float = 6.6e-5
    between: float = 1.0  # friction between balls over that of the walls
    torque: float = 21.6
    overload: float = 2.2
    slip: float = 0.374
    speed: float = 157.08
    rotor_inertia: float = 0.64
    supports: float = 2.0  # total stiffness and damping over (53): 1 as in (2), 2 as in (52)
    half_span: float = 1.0  # l
    below: float = 0.29  # h, of the supports below the axis
    body_below: float = 0.147  # H, of the mass center of the body
    body_inertia: float = 21.4  # about the axis

    def machine(
        self, *, balls: int, friction: float, layers: str = "deep", youngs_modulus: float = STEEL
    ) -> ChamberMachine:
        """With so many balls of the same total mass.

        Raises
        ------
        MachineError
            If they do not fit.
        """
        x, y = 0.3, self.half_span
        part = 0.25 * self.supports
        support = {
            "stiffness": [part * STIFFNESS * k for k in (1, 1, 2)],
            "damping": [part * DAMPING * k for k in (1, 1, 2)],
        }
        group = {"count": balls, "density": self.density, "total_mass": self.ball_mass}
        chamber: dict[str, Any] = {"radius": self.radius, "balls": [group]}
        if layers == "deep":
            chamber["depth"] = DEPTH
        own = {} if self.between == 1.0 else {"ball_friction": self.between * friction}
        return ChamberMachine(
            name="Lost machine",
            body={
                "freedom": "planar", "mass": TOTAL_MASS - ROTOR_MASS, "inertia": [self.body_inertia, 25.0, 20.0],
                "center": [0.0, 0.0, -self.body_below],
            },
            supports=[{"position": [i * x, j * y, -self.below], **support} for i in (1, -1) for j in (1, -1)],
            rotor={
                "mass": ROTOR_MASS, "polar_inertia": self.rotor_inertia,
                "transverse_inertia": max(0.06, 0.6 * self.rotor_inertia), "bearings": [0.1, -0.1],
                "neck_diameter": 0.03, "bearing_friction": 0.0015,
            },
            unbalances=[{"moment": self.unbalance}],
            chambers=[chamber],
            contact={
                "law": "restitution", "restitution": RESTITUTION, "friction": friction, "rolling_arm": self.rolling_arm,
                "youngs_modulus": youngs_modulus, "poisson_ratio": POISSON, **own,
            },
            drive={
                "kind": "asynchronous", "rated_torque": self.torque, "overload": self.overload,
                "synchronous_speed": self.speed, "breakdown_slip": self.slip,
            },
        )  # fmt: skip

    def ball_radius(self, balls: int) -> float:
        """m."""
        return float((0.75 * self.ball_mass / (balls * math.pi * self.density)) ** (1.0 / 3.0))

    def as_dict(self) -> dict[str, float]:
        """Names and numbers."""
        return asdict(self)


NAMES = tuple(field.name for field in fields(Candidate))
A = Candidate()
B = Candidate(
    unbalance=0.103, ball_mass=2.47, radius=0.095, rolling_arm=2e-6, torque=10.2, rotor_inertia=0.315, slip=0.24, supports=1.0,
    half_span=0.4, below=0.08, body_below=0.20, body_inertia=11.0,
)  # fmt: skip
C = replace(A, unbalance=0.13, slip=0.31, body_inertia=15.0)
B2 = replace(B, rolling_arm=6.6e-5)
BETWEEN = (  # A settles well, B saves vibration; less rolling resistance leaves less with many balls
    replace(A, unbalance=0.11, rolling_arm=1e-5),
    replace(A, unbalance=0.085, ball_mass=2.4, radius=0.094, rolling_arm=1e-5),
    replace(A, unbalance=0.08, ball_mass=2.3, radius=0.088, rolling_arm=1e-5),
    B2,
    replace(B2, torque=9.2),
    replace(B2, unbalance=0.095, rolling_arm=3e-5),
    replace(B2, radius=0.099, rolling_arm=3e-5),
    replace(B2, torque=9.5, radius=0.098),
    replace(B2, ball_mass=2.3, rolling_arm=3e-5),
)
