"""A power of the rate of shear between two rates."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from autobalancer.machine.balancer.fluid import ShearLaw
from autobalancer.machine.part import Positive, ShearRate, key


class PowerLaw(ShearLaw):
    """Ostwald and de Waele's power law from one rate of shear to another; below and above the viscosity is constant.

    share = (rate/lowest)^(exponent - 1). Without the ``lowest`` rate the viscosity at rest would be infinite, or zero.
    """

    law: Literal["power_law"] = "power_law"
    interface: ClassVar[int] = 1
    exponent: Positive = key("of the stress over the rate of shear: below 1 thinning, above 1 thickening", symbol="n")
    lowest: ShearRate | None = key("rate of shear up to which the fluid has its viscosity at rest", None)
    highest_rate: ShearRate | None = key("rate of shear beyond which the viscosity is constant again", None)

    @model_validator(mode="after")
    def _finite(self) -> PowerLaw:
        if self.exponent == 1.0:
            raise ValueError("exponent: given 1, which is a fluid of constant viscosity; leave out 'shear'")
        if self.lowest is None:
            end = "infinite" if self.exponent < 1.0 else "zero"
            raise ValueError(
                f"lowest: missing; with an exponent of {self.exponent:g} down to rest the viscosity at rest would be {end}. Give "
                "the rate of shear up to which the fluid has the viscosity given for it, such as lowest = '1 1/s'"
            )
        if self.highest_rate is not None and self.highest_rate <= self.lowest:
            raise ValueError(
                f"highest_rate: given {self.highest_rate:g} 1/s; must be more than 'lowest', {self.lowest:g} 1/s"
            )
        return self

    def share(self, rate: Any) -> Any:
        """See the class."""
        low = float(self.lowest or 0.0)
        high = np.inf if self.highest_rate is None else float(self.highest_rate)
        return (np.clip(np.asarray(rate), low, high) / low) ** (self.exponent - 1.0)
