"""A smooth change from the viscosity at rest to a power of the rate of shear."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import model_validator

from autobalancer.machine.balancer.fluid import ShearLaw
from autobalancer.machine.part import Duration, Positive, Quantity, key

Share = Annotated[float, Quantity("", non_negative=True, most=1.0)]


class Carreau(ShearLaw):
    """Carreau (1972), with Yasuda's width of the change: 1 at rest, a power of the rate of shear at high rates.

    share = high + (1 - high) (1 + (time rate)^width)^((exponent - 1)/width); an exponent above 1 thickens.
    """

    law: Literal["carreau"] = "carreau"
    interface: ClassVar[int] = 1
    time: Duration = key("inverse of the rate of shear at which the viscosity changes", symbol=r"\lambda")
    exponent: Positive = key("of the stress over the rate of shear: below 1 thinning, above 1 thickening", symbol="n")
    width: Positive = key("of the change; 2 is Carreau's own law", 2.0, symbol="a")
    high: Share = key("share of the viscosity that remains at high rates of shear, of thinning fluids", 0.0)

    @model_validator(mode="after")
    def _bounded(self) -> Carreau:
        if self.exponent > 1.0 and self.high != 0.0:
            raise ValueError(
                "high: a fluid that thickens (exponent above 1) has no such share; leave it out, or use 'cross'"
            )
        return self

    def share(self, rate: Any) -> Any:
        """See the class."""
        grown = np.log1p((float(self.time) * np.asarray(rate)) ** self.width)
        return self.high + (1.0 - self.high) * np.exp((self.exponent - 1.0) / self.width * grown)
