"""How balls touch each other and the walls."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, model_validator

from autobalancer.machine.part import Offset, Part, Positive, Ratio, quantity


def _between(low: float, high: float, *, without_low: bool = False) -> PlainValidator:
    """Validator of a number in an interval."""

    def read(value: Any) -> float:
        number = float(quantity("").func(value))  # type: ignore[call-arg]
        if not low <= number <= high or (without_low and number == low):
            bounds = f"greater than {low:g} and at most {high:g}" if without_low else f"between {low:g} and {high:g}"
            raise ValueError(f"given {number:g}; must be {bounds}")
        return number

    return PlainValidator(read)


Fraction = Annotated[float, _between(0.0, 1.0, without_low=True)]
Coefficient = Annotated[float, _between(0.0, 5.0)]
Modulus = Annotated[float, quantity("Pa", positive=True)]
HertzStiffness = Annotated[float, quantity("N/m^1.5", positive=True)]
SlowSpeed = Annotated[float, quantity("m/s", positive=True)]


class _Elastic(Part):
    """Stiffness k of F = k d^1.5: one for all contacts, or by Hertz from the material of balls and walls."""

    stiffness: HertzStiffness | None = None
    youngs_modulus: Modulus | None = None
    poisson_ratio: Ratio = 0.3
    restitution: Fraction
    friction: Coefficient
    rolling_arm: Offset = 0.0
    slow: SlowSpeed = 1e-3

    @model_validator(mode="after")
    def _one_stiffness(self) -> _Elastic:
        if (self.stiffness is None) == (self.youngs_modulus is None):
            raise ValueError("give either 'stiffness' (of all contacts) or 'youngs_modulus'")
        if self.poisson_ratio > 0.5:
            raise ValueError(f"poisson_ratio: given {self.poisson_ratio:g}; must be at most 0.5")
        return self


class RestitutionContact(_Elastic):
    """Pakuła (2021): k d^1.5 in approach, R^2 k d^1.5 in separation; sliding friction at all times.

    ``slow`` is the sliding speed below which friction falls to zero in proportion.
    """

    law: Literal["restitution"] = "restitution"


class HistoryContact(_Elastic):
    """Hertz with viscous damping and a tangential spring that remembers, so that balls can stick.

    ``shear_ratio`` is the tangential over the normal stiffness; by default that of Mindlin, 2 (1 - nu)/(2 - nu).
    """

    law: Literal["history"] = "history"
    shear_ratio: Positive | None = None


ChamberContact = Annotated[RestitutionContact | HistoryContact, Field(discriminator="law")]
