"""Measured viscosities over the rate of shear."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from autobalancer.machine.balancer.fluid import ShearLaw
from autobalancer.machine.part import Listed, Positive, ShearRate, key

WIDEST = 30.0
"""Greatest step from one rate of shear to the next; a wider one is a hole in the measurement."""


class TableShear(ShearLaw):
    """Measured shares of the viscosity at rest over rates of shear, a monotone cubic of their logarithms in between.

    Below the first rate the fluid has its viscosity at rest, so the first share must be 1; beyond the last one the share is kept.
    """

    law: Literal["table"] = "table"
    interface: ClassVar[int] = 1
    rates: Annotated[tuple[ShearRate, ...], Field(min_length=2), Listed] = key("of shear; must increase")
    shares: Annotated[tuple[Positive, ...], Field(min_length=2), Listed] = key(
        "viscosity over that at rest, as many as rates; the first one is 1"
    )

    @model_validator(mode="after")
    def _measured(self) -> TableShear:
        rates, shares = np.array(self.rates), np.array(self.shares)
        if rates.size != shares.size:
            raise ValueError(f"shares: given {shares.size} for {rates.size} rates of shear; give as many")
        steps = rates[1:] / rates[:-1]
        for wrong, what in (
            (steps <= 1.0, "must increase"),
            (steps > WIDEST, "that is a hole; give points in between"),
        ):
            if wrong.any():
                i = int(np.argmax(wrong))
                raise ValueError(f"rates: given {rates[i + 1]:g} 1/s after {rates[i]:g} 1/s; {what}")
        if abs(shares[0] - 1.0) > 1e-9:
            raise ValueError(
                f"shares: the first is {shares[0]:g}; must be 1, because below the first rate the fluid has its viscosity at "
                "rest; give that viscosity for the fluid"
            )
        return self

    @cached_property
    def _curve(self) -> Any:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(np.log(self.rates), np.log(self.shares))

    def share(self, rate: Any) -> Any:
        """See the class."""
        inside = np.clip(np.asarray(rate), self.rates[0], self.rates[-1])
        return np.exp(self._curve(np.log(inside)))

    @property
    def highest(self) -> float:
        """The last rate."""
        return float(self.rates[-1])
