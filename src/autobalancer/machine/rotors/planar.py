"""The planar rotor: a mass that moves in its plane on springs and dampers (Spannan 2021, section 4.1)."""

from __future__ import annotations

from typing import Literal

from autobalancer.machine.part import Damping, Inertia, Mass, Part, Stiffness


class PlanarRotor(Part):
    """A rotor with two lateral degrees of freedom, isotropic or orthotropic.

    ``mass`` is without balls but with everything that is screwed to the rotor. A pair of values is along x and y.
    ``inertia`` (about the shaft, without balls) is needed only where a torque drives.
    """

    kind: Literal["planar"] = "planar"
    mass: Mass
    stiffness: Stiffness
    damping: Damping
    inertia: Inertia | None = None

    @property
    def stiffness_xy(self) -> tuple[float, float]:
        """Stiffness along x and y, N/m."""
        return _pair(self.stiffness)

    @property
    def damping_xy(self) -> tuple[float, float]:
        """Damping along x and y, N s/m."""
        return _pair(self.damping)

    @property
    def isotropic(self) -> bool:
        """Whether x and y are alike."""
        return self.stiffness_xy[0] == self.stiffness_xy[1] and self.damping_xy[0] == self.damping_xy[1]


def _pair(value: float | tuple[float, float]) -> tuple[float, float]:
    return (float(value[0]), float(value[1])) if isinstance(value, tuple) else (float(value), float(value))
