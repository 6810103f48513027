"""The fluid in a race."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from autobalancer.machine.balancer.shear import ShearLaw
from autobalancer.machine.leaves import OneOf
from autobalancer.machine.part import Part, key
from autobalancer.machine.quantity import Density, Ratio, Temperature, Viscosity


class Fluid(Part):
    """A fluid of the catalog at a temperature, or one given by density and kinematic viscosity.

    The balls lose the mass of the fluid they displace as balancing mass and gain ``virtual_mass`` times it as
    inertia (2 near a wall: Jan and Chen 1997; Spannan 2021, section 5.2.3).

    ``lag`` says how the fluid follows its chamber when the speed changes: at once (``none``), by diffusion (``modes``), by the
    ``full`` equations of the flow, or whichever of both is needed (``auto``). With a drive that is a torque the full equations
    take a few runs.
    """

    name: str | None = key("of the catalog; this, or density and viscosity", None)
    temperature: Temperature | None = key("of a fluid of the catalog; without it 25 °C", None, symbol="T")
    density: Density | None = key("with viscosity, instead of a name", None, symbol=r"\rho")
    viscosity: Viscosity | None = key("kinematic", None, symbol=r"\nu")
    virtual_mass: Ratio = key("fluid mass that moves with a ball, over the mass it displaces", 2.0)
    shear: Annotated[ShearLaw, OneOf(ShearLaw)] | None = key(
        "how the viscosity changes with the rate of shear; `viscosity`, or that of the catalog, is the one at rest",
        None,
    )
    lag: Literal["none", "modes", "full", "auto"] = key(
        "how the fluid follows the rotor when the speed changes; needs `width` and `height` of the race", "none"
    )

    @model_validator(mode="after")
    def _one_way(self) -> Fluid:
        numbers = self.density is not None and self.viscosity is not None
        if (self.name is not None) == numbers or (self.density is None) != (self.viscosity is None):
            raise ValueError("give either the 'name' of a fluid of the catalog, or 'density' and 'viscosity'")
        if numbers and self.temperature is not None:
            raise ValueError("temperature: has no effect on a fluid given by density and viscosity; leave it out")
        if numbers and self.shear is not None and self.shear.measured_at is not None:
            raise ValueError("shear.measured_at: has no effect on a fluid given by density and viscosity; leave it out")
        if self.shear is not None and self.lag in ("modes", "full"):
            raise ValueError(
                f"lag: given {self.lag!r}, which is for constant viscosity; with 'shear' use 'auto', without secondary flow"
            )
        return self
