"""A smooth change between two viscosities."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import numpy as np

from autobalancer.machine.balancer.fluid import ShearLaw
from autobalancer.machine.part import Duration, Positive, Ratio, key


class Cross(ShearLaw):
    """Cross (1965): from the viscosity at rest to another share at high rates; above 1 the fluid thickens.

    share = high + (1 - high) / (1 + (time rate)^power).
    """

    law: Literal["cross"] = "cross"
    interface: ClassVar[int] = 1
    time: Duration = key("inverse of the rate of shear at which half of the change has happened", symbol=r"\lambda")
    power: Positive = key("of the rate of shear in the change", symbol="m")
    high: Ratio = key("share of the viscosity at rest that a fast sheared fluid has; above 1 it thickens")

    def share(self, rate: Any) -> Any:
        """See the class."""
        return self.high + (1.0 - self.high) / (1.0 + (float(self.time) * np.asarray(rate)) ** self.power)
