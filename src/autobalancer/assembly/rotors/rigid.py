"""The rigid rotor; the planar one, which is its limit without tilt; and modes at one plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from autobalancer.assembly.rotors.lateral_model import LateralModel, Rows, add_support, matrices, table_speeds
from autobalancer.machine import ModalRotor, PlanarRotor, RigidRotor


@dataclass(frozen=True)
class RigidAxis:
    """A straight axis: deflection x + z slope; ``reach`` are the outermost places that matter."""

    reach: tuple[float, float]

    def rows(self, position: float | None, body: str | None) -> Rows:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        if body is not None:
            raise ValueError(f"body {body!r}: a rigid rotor is one body; leave it out")
        return Rows(np.array([1.0, float(position or 0.0)]), np.array([0.0, 1.0]))

    def line(self) -> list[tuple[float, Rows]]:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        return [(z, self.rows(z, None)) for z in self.reach]


@dataclass(frozen=True)
class Point:
    """The one plane of a rotor that has no length; it moves as all its coordinates together."""

    pairs: int = 1

    def rows(self, position: float | None, body: str | None) -> Rows:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        if position or body is not None:
            raise ValueError("this rotor has one plane only; leave the place out")
        return Rows(np.ones(self.pairs), np.zeros(self.pairs))

    def line(self) -> list[tuple[float, Rows]]:
        """See :class:`autobalancer.assembly.rotors.lateral_model.Axis`."""
        return [(0.0, self.rows(None, None))]


@matrices.register
def rigid(rotor: RigidRotor, gravity: float = 0.0) -> LateralModel:
    """Coordinates X, phi_Y, Y, -phi_X of Rodrigues et al. 2011, (1)."""
    positions = [float(support.position) for support in rotor.supports]
    axis = RigidAxis((min(positions), max(positions)))
    speeds = table_speeds(filter(None, (support.frequencies() for support in rotor.supports)))
    damping, stiffness = np.zeros((2, speeds.size, 4, 4))
    for support in rotor.supports:
        add_support(support, axis.rows(float(support.position), None), speeds, damping, stiffness)
    damping += float(rotor.stiffness_proportional_damping) * stiffness
    mass, gyroscopic = np.diag([rotor.mass, rotor.transverse_inertia] * 2), np.zeros((4, 4))
    gyroscopic[1, 3], gyroscopic[3, 1] = rotor.polar_inertia, -rotor.polar_inertia
    return LateralModel(
        mass, gyroscopic, speeds, damping, stiffness, 2, ("x", "slope of x", "y", "slope of y"), axis,
        float(rotor.polar_inertia), float(rotor.mass),
    )  # fmt: skip


@matrices.register
def planar(rotor: PlanarRotor, gravity: float = 0.0) -> LateralModel:
    """Coordinates X, Y."""
    inertia = None if rotor.inertia is None else float(rotor.inertia)
    return LateralModel(
        float(rotor.mass) * np.eye(2), np.zeros((2, 2)), np.zeros(1), np.diag(rotor.damping_xy)[None],
        np.diag(rotor.stiffness_xy)[None], 1, ("x", "y"), Point(), inertia, float(rotor.mass),
    )  # fmt: skip


@matrices.register
def modal(rotor: ModalRotor, gravity: float = 0.0) -> LateralModel:
    """Coordinates: the deflection that each mode brings to the plane along x, then along y."""
    mass, frequency, ratio = np.array(
        [(mode.mass, mode.frequency, mode.damping_ratio) for mode in rotor.resonances], np.float64
    ).T
    count = mass.size
    mass, frequency, ratio = (np.tile(values, 2) for values in (mass, frequency, ratio))
    names = tuple(f"mode {number} along {axis}" for axis in "xy" for number in range(1, count + 1))
    inertia = None if rotor.inertia is None else float(rotor.inertia)
    return LateralModel(
        np.diag(mass), np.zeros((2 * count, 2 * count)), np.zeros(1), np.diag(2.0 * ratio * frequency * mass)[None],
        np.diag(mass * frequency**2)[None], count, names, Point(count), inertia, rotor.mass,
    )  # fmt: skip
