"""The rigid rotor that moves and tilts on its supports (Rodrigues et al. 2011, equation 1)."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from autobalancer.machine.part import Inertia, Listed, Mass, Time, key
from autobalancer.machine.rotors.body import RotorModel
from autobalancer.machine.rotors.support import Support


class RigidRotor(RotorModel):
    """A rigid rotor with four lateral degrees of freedom; positions count from its mass center along the axis.

    Mass and inertias are without balls. ``stiffness_proportional_damping`` is the factor t in C = t K, s, added to what
    the supports bring.
    """

    kind: Literal["rigid"] = "rigid"
    mass: Mass = key("without balls, with all attached parts, and races full of fluid", symbol="M")
    transverse_inertia: Inertia = key("about a diameter through the mass center, without balls", symbol="J_t")
    polar_inertia: Inertia = key("about the axis, without balls; at most twice the transverse one", symbol="J_p")
    supports: Annotated[tuple[Support, ...], Field(min_length=1), Listed] = key(
        "springs at two positions, or one with `tilt_stiffness`"
    )
    stiffness_proportional_damping: Time = key("factor t in C = t K, added to the damping of the supports", 0.0)

    @model_validator(mode="after")
    def _possible(self) -> RigidRotor:
        if self.polar_inertia > 2.0 * self.transverse_inertia * (1.0 + 1e-9):
            raise ValueError(
                f"polar_inertia: given {self.polar_inertia:g} kg m^2; no body has more than twice its transverse inertia, "
                f"{2.0 * self.transverse_inertia:g} kg m^2 here"
            )
        held = {float(s.position) for s in self.supports if s.carries}
        tilt = any(s.tilt_stiffness > 0.0 for s in self.supports)
        if self.stiffness_proportional_damping and any(s.rubber is not None for s in self.supports):
            raise ValueError(
                "stiffness_proportional_damping: given beside 'rubber', which has its own loss; leave it out"
            )
        if not held or (len(held) < 2 and not tilt):
            raise ValueError(
                "supports: nothing supports the rotor against tilting; give springs at two positions, or 'tilt_stiffness'"
            )
        return self

    @property
    def inertia(self) -> float:
        """About the shaft, what a torque accelerates."""
        return float(self.polar_inertia)
